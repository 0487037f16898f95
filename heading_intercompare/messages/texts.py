# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Texts as messages: reports, and the operator's notes."""

from __future__ import annotations

from .cdr import decode, encode

__all__ = ['decode_text', 'encode_text', 'TEXT_TYPE']

TEXT_TYPE = 'std_msgs/msg/String'


def encode_text(text: str) -> bytes:
    """Return a text as std_msgs/msg/String."""
    return encode(TEXT_TYPE, {'data': text})


def decode_text(data: bytes) -> str:
    """Return the text of a std_msgs/msg/String; MessageError if it is damaged."""
    text: str = decode(TEXT_TYPE, data)['data']
    return text
