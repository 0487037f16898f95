# Copyright 2026 The heading_intercompare authors
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.

"""Checks on text from outside: whether it is UTF-8, and numbers in it."""

from __future__ import annotations

from .errors import BagError

__all__ = ['decimal', 'utf8']

#: No count has more digits.
_DIGITS = 18


def decimal(text: str, digits: int = _DIGITS) -> int | None:
    """Return a text as a whole number; None if it is not one or has more than `digits` digits."""
    return int(text) if text.isascii() and text.isdecimal() and len(text) <= digits else None


def utf8(text: str, what: str) -> str:
    """Return the text unchanged; raise BagError, naming `what`, if its bytes were not UTF-8."""
    try:
        text.encode()
    except UnicodeEncodeError:
        raise BagError(f'{text!r} must be UTF-8', what) from None
    return text
