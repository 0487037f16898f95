# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Texts that come from outside: whether they are UTF-8, and numbers in them."""

from __future__ import annotations

from .errors import BagError

__all__ = ['decimal', 'utf8']

#: No count has more.
_DIGITS = 18


def decimal(text: str, digits: int = _DIGITS) -> int | None:
    """Return the number that a text is; None if it is none, or has more digits than allowed."""
    return int(text) if text.isascii() and text.isdecimal() and len(text) <= digits else None


def utf8(text: str, what: str) -> str:
    """Return a text as it is; BagError, with what it is, if its bytes were not UTF-8."""
    try:
        text.encode()
    except UnicodeEncodeError:
        raise BagError(f'{text!r} must be UTF-8', what) from None
    return text
