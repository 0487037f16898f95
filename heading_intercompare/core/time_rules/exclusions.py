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

"""Stretches of time that a person takes out of the judgement, each with a reason."""

from __future__ import annotations

from dataclasses import dataclass
import re
from typing import Iterator, Sequence, TYPE_CHECKING

from heading_intercompare.core.text_rows import split_rows

if TYPE_CHECKING:
    # The settings import this module, and the Tab key needs them without numpy.
    import numpy as np
    from numpy.typing import NDArray


_TIME = re.compile(r'\d{4}-\d\d-\d\d[T ]\d\d:\d\d(?::\d\d(?:\.\d{1,9})?)?Z?', re.ASCII)
_STAMP = re.compile(r'\d{1,19}', re.ASCII)
_HEADER = ['start', 'end', 'reason']
_LONGEST_REASON = 200
_NEWEST_NS = 2 ** 63 - 1


@dataclass(frozen=True, slots=True)
class Exclusion:
    """
    A stretch that is taken out.

    Attributes
    ----------
    start_ns, end_ns
        Differences with start_ns <= stamp < end_ns are taken out.
    reason
        Why, in the words of the person who took it out.

    """

    start_ns: int
    end_ns: int
    reason: str

    def __str__(self) -> str:
        from heading_intercompare.core.utc_text import utc
        return f'{utc(self.start_ns)} to {utc(self.end_ns)} UTC ({self.reason})'


def read_exclusions(text: str | None) -> tuple[Exclusion, ...]:
    """
    Return the exclusions in a table.

    Parameters
    ----------
    text
        Rows ``start, end, reason``, separated by line ends or ``;``. Times are ISO UTC or integer
        nanoseconds. A header ``start, end, reason`` is skipped.

    Returns
    -------
    tuple of Exclusion
        By their start.

    Raises
    ------
    ValueError
        If a row has no reason or ends before it starts, or two overlap; the message names the row.

    Examples
    --------
    >>> print(*read_exclusions('2026-05-01T10:00Z, 2026-05-01T10:20Z, RS in dock mode'))
    2026-05-01 10:00:00.000 to 2026-05-01 10:20:00.000 UTC (RS in dock mode)

    """
    rows = list(_read_rows(text or ''))
    ordered = sorted(rows, key=lambda row: (row[1].start_ns, row[1].end_ns))
    for (_, first), (at, second) in zip(ordered, ordered[1:]):
        if second.start_ns < first.end_ns:
            raise ValueError(f'row {at}: {second} overlaps {first}; join them to one row')
    return tuple(exclusion for _, exclusion in ordered)


def _read_rows(text: str) -> Iterator[tuple[int, Exclusion]]:
    for at, row in enumerate(split_rows(text), 1):
        parts = [part.strip() for part in row.split(',', 2)]
        if at == 1 and [part.lower() for part in parts] == _HEADER:
            continue
        if len(parts) < 3 or not parts[2]:
            raise ValueError(f'row {at}: {row!r:.80}: must be start, end, reason; a stretch is '
                             'taken out only with its reason')
        if len(parts[2]) > _LONGEST_REASON:
            raise ValueError(f'row {at}: the reason has {len(parts[2])} characters, must have at '
                             f'most {_LONGEST_REASON}')
        try:
            start_ns, end_ns = _read_time(parts[0]), _read_time(parts[1])
        except ValueError as error:
            raise ValueError(f'row {at}: {error}') from error
        if end_ns <= start_ns:
            raise ValueError(f'row {at}: end {parts[1]} is not after start {parts[0]}')
        yield at, Exclusion(start_ns, end_ns, parts[2])


def _read_time(text: str) -> int:
    """Return a time, ISO UTC or integer nanoseconds, as a stamp."""
    if _STAMP.fullmatch(text) and int(text) <= _NEWEST_NS:
        return int(text)
    # Years that fit into nanoseconds.
    if _TIME.fullmatch(text) and 1970 <= int(text[:4]) < 2200:
        # Only now: most settings have no exclusion.
        import numpy as np
        try:
            return int(np.datetime64(text.rstrip('Z'), 'ns').astype(np.int64))
        except ValueError:
            pass
    raise ValueError(f'{text!r} is neither ISO UTC (2026-05-01T10:00:00.5Z) nor integer '
                     'nanoseconds')


def find_excluded(stamp_ns: 'NDArray[np.int64]',
                  exclusions: Sequence[Exclusion]) -> 'NDArray[np.int64]':
    """
    Return the number of the exclusion that holds each stamp; -1 for none.

    Parameters
    ----------
    stamp_ns : ndarray of int64, shape (n,)
        Stamps in ascending order, nanoseconds.
    exclusions
        Where two overlap, the later one in this order counts.

    Returns
    -------
    ndarray of int64, shape (n,)

    """
    numbers = stamp_ns * 0 - 1
    for at, exclusion in enumerate(exclusions):
        begin = stamp_ns.searchsorted(exclusion.start_ns)
        numbers[begin:stamp_ns.searchsorted(exclusion.end_ns)] = at
    return numbers
