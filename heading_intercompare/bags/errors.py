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

"""The one error for bags and csv files, and checks on text from outside."""

from __future__ import annotations

import os

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


class BagError(ValueError):
    """
    A bag, a message in it, or a csv file of pairs cannot be used.

    Parameters
    ----------
    problem
        What is wrong, and what is allowed.
    path
        The file.
    offset
        Byte of the file at which the problem begins.

    """

    def __init__(self, problem: str, path: str | os.PathLike[str] = '',
                 offset: int | None = None) -> None:
        place = f'{os.fspath(path)}: ' if os.fspath(path) else ''
        suffix = '' if offset is None else f' (at byte {offset})'
        super().__init__(f'{place}{problem}{suffix}')
        self.problem = problem
        self.path = os.fspath(path)
        self.offset = offset

    def locate(self, path: str | os.PathLike[str], offset: int | None = None) -> 'BagError':
        """Return the same error with a path and an offset."""
        return BagError(self.problem, path, offset)
