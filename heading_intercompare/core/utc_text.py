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

"""Stamps as people read them."""

from __future__ import annotations

import numpy as np

DAY_NS = 86_400_000_000_000
"""A day, nanoseconds."""

#: Milliseconds at the beginning of the years 1 and 10000.
_FIRST_MS, _END_MS = -62_135_596_800_000, 253_402_300_800_000


def utc(stamp_ns: int | None) -> str:
    """
    Return a stamp as UTC text, rounded down to milliseconds; a dash for None.

    Examples
    --------
    >>> utc(1_700_000_000_123_999_999)
    '2023-11-14 22:13:20.123'

    """
    if stamp_ns is None:
        return '-'
    at_ms = stamp_ns // 1_000_000
    if not _FIRST_MS <= at_ms < _END_MS:
        return f'{stamp_ns} ns'
    return str(np.datetime64(at_ms, 'ms')).replace('T', ' ')


def utc_span(start_ns: int, end_ns: int) -> str:
    """
    Return a span of time as UTC text, to the second.

    Examples
    --------
    >>> utc_span(1_700_000_000_123_999_999, 1_700_001_200_000_000_000)
    'from 2023-11-14 22:13:20 to 22:33:20 UTC'
    >>> utc_span(1_700_000_000_000_000_000, 1_700_020_000_000_000_000)
    'from 2023-11-14 22:13:20 to 2023-11-15 03:46:40 UTC'

    """
    start, end = (utc(stamp_ns).partition('.')[0] for stamp_ns in (start_ns, end_ns))
    (day, _, _), (last_day, _, time) = start.partition(' '), end.partition(' ')
    return f'from {start} to {time if day == last_day and time else end} UTC'
