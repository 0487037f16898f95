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

"""Times, lengths and texts of messages as page and terminal say them."""

from __future__ import annotations

import math

from heading_intercompare.core.decision.coverage import span_words
from heading_intercompare.core.utc_text import utc

__all__ = ['age_words', 'clock', 'integer', 'lacking_words', 'real', 'shorten', 'size_words']


def shorten(text: str, most: int) -> str:
    r"""
    Return a text in one line of at most this number of letters.

    Examples
    --------
    >>> shorten('a long\ntext', 8)
    'a long …'

    """
    line = ' '.join(text.split())
    return line if len(line) <= most else f'{line[:most - 1]}…'


def integer(text: str | None) -> int | None:
    """Return the integer in a value of a message; None if it is absent or no integer."""
    try:
        return None if text is None else int(text)
    except ValueError:
        return None


def real(text: str | None) -> float | None:
    """Return the figure in a value of a message; None if it is absent, no figure, or nan."""
    try:
        value = math.nan if text is None else float(text)
    except ValueError:
        return None
    return None if math.isnan(value) else value


def clock(stamp_ns: int | None) -> str:
    """
    Return the time of day of a stamp.

    Examples
    --------
    >>> clock(1_700_000_000_000_000_000), clock(None)
    ('22:13 UTC', '-')

    """
    return '-' if stamp_ns is None else f'{utc(stamp_ns)[11:16]} UTC'


def age_words(age_s: float | None) -> str:
    """
    Return an age.

    Examples
    --------
    >>> age_words(0.24), age_words(75.0), age_words(None)
    ('0.2 s', '75 s', 'never')

    """
    if age_s is None:
        return 'never'
    return f'{age_s:.1f} s' if age_s < 10.0 else span_words(age_s)


def lacking_words(n: int, needed_s: float | None) -> str:
    """
    Return what a run in progress lacks.

    Examples
    --------
    >>> lacking_words(5000, 1560.0)
    '26 min more if it goes on like this'

    """
    if needed_s is None:
        return f'too few differences to tell ({n})'
    if math.isinf(needed_s):
        return 'more time alone does not decide'
    if needed_s <= 0.0:
        return 'long enough if it goes on like this'
    return f'{span_words(needed_s)} more if it goes on like this'


def size_words(size: int | None) -> str:
    """
    Return a number of bytes.

    Examples
    --------
    >>> size_words(81_234_567_890), size_words(None)
    ('81.2 GB', 'not known')

    """
    if size is None:
        return 'not known'
    return f'{size / 1e9:.1f} GB' if size >= 10 ** 9 else f'{size / 1e6:.0f} MB'
