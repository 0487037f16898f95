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

"""The deviation of a magnetic compass as a table: heading of the compass, deviation there."""

from __future__ import annotations

import re
from typing import Iterator

_FILE = 'file:'
_ROW = re.compile(r'(\d+\.?\d*)[\s,]+([+-]?\d+\.?\d*)\s*([EeWw]?)', re.ASCII)
_HEADER = re.compile(r'heading\w*[\s,]+deviation\w*', re.IGNORECASE)
_MOST_DEVIATION_DEG = 90.0
#: Between headings farther apart the deviation is anybody's guess.
_MOST_GAP_DEG = 90.0


def _rows(text: str) -> Iterator[tuple[str, str]]:
    """Yield the rows of a table, each with the place where it stands."""
    if not text.startswith(_FILE):
        yield from ((f'row {at}', row) for at, row in enumerate(
            filter(None, map(str.strip, text.split(';'))), 1))
        return
    with open(text.removeprefix(_FILE), encoding='utf-8-sig') as file:
        for at, line in enumerate(file, 1):
            row = line.partition('#')[0].strip()
            if row and not _HEADER.fullmatch(row):
                yield f'line {at}', row


def read_deviations(text: str) -> tuple[tuple[float, float], ...]:
    """
    Return the rows of a table, by rising heading.

    Parameters
    ----------
    text
        Rows separated by ``;``: heading of the compass and deviation, degrees. The deviation is
        positive to the east, or has E or W after it. Or ``file:PATH`` of a file with a row per
        line.

    Raises
    ------
    OSError
        If the file cannot be read.
    ValueError
        If a row is wrong or comes twice, or if the rows lie farther apart than 90 degrees.

    Examples
    --------
    >>> read_deviations('0 1.5; 90 2W; 180 -1; 270 2')
    ((0.0, 1.5), (90.0, -2.0), (180.0, -1.0), (270.0, 2.0))

    """
    deviations: dict[float, float] = {}
    for place, row in _rows(text):
        match = _ROW.fullmatch(row)
        if match is None:
            raise ValueError(f'{place} ({row:.40}): must be a heading and its deviation in '
                             'degrees, such as 90 -2.5 or 90 2.5W')
        heading_deg, deviation_deg = float(match[1]), float(match[2])
        if heading_deg > 360.0 or abs(deviation_deg) > _MOST_DEVIATION_DEG:
            raise ValueError(f'{place} ({row:.40}): a heading is 0 to 360, a deviation -90 to 90')
        if match[3] and match[2][0] in '+-':
            raise ValueError(f'{place} ({row:.40}): give a sign, or E or W')
        deviation_deg = -deviation_deg if match[3] in ('W', 'w') else deviation_deg
        if deviations.setdefault(heading_deg % 360.0, deviation_deg) != deviation_deg:
            raise ValueError(f'{place} ({row:.40}): this heading has another deviation already')
    headings_deg = sorted(deviations)
    for low_deg, high_deg in zip(headings_deg, [*headings_deg[1:], *headings_deg[:1]]):
        if not 0.0 < (high_deg - low_deg) % 360.0 <= _MOST_GAP_DEG:
            raise ValueError(f'no row from {low_deg:g} to {high_deg:g}: rows lie at most 90 '
                             'degrees apart, around the whole circle')
    if not deviations:
        raise ValueError('has no row')
    return tuple((heading_deg, deviations[heading_deg]) for heading_deg in headings_deg)


def write_deviations(deviations: tuple[tuple[float, float], ...]) -> str:
    """Return the text of the rows, without a file."""
    return '; '.join(f'{heading_deg!r} {deviation_deg!r}'
                     for heading_deg, deviation_deg in deviations)
