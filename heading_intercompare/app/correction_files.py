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

"""The corrections of the heading as files for survey programs and current profilers."""

from __future__ import annotations

import csv
from typing import Sequence

from heading_intercompare.bags.csv.ensembles_csv import find_year
from heading_intercompare.core.utc_text import DAY_NS, utc
from heading_intercompare.logbook.correction import HeadingCorrection
from heading_intercompare.replaced_file import replace_file, ReplacedFile

_TERMS = 'abcde'
COLUMNS = (
    'ship', 'settings_sha256', 'start_utc', 'end_utc', 'n', 'outcome', 'validity',
    'add_to_ts_deg', 'add_to_ts_low_deg', 'add_to_ts_high_deg', 'installation_offset_deg',
    *(f'add_to_ts_{term}_deg' for term in _TERMS), *(f'u_{term}_deg' for term in _TERMS))
"""The columns of the csv; the correction is added to the heading of the TS."""
SUFFIXES = '.csv', '.ang'


def write_corrections(corrections: Sequence[HeadingCorrection], path: str) -> None:
    """
    Write a row per run, in the form that the suffix names.

    Parameters
    ----------
    corrections
        In the order of time, of any sensors for a csv.
    path
        A csv with `COLUMNS`; or, for ``.ang``, the times and angles of UHDAS.

    Raises
    ------
    OSError
        If the file cannot be written.
    ValueError
        If it is to be a file of UHDAS, which can hold one sensor, and the runs are of several, or
        overlap.

    """
    if path.endswith('.ang'):
        replace_file(path, ''.join(_list_angles(corrections, path)))
        return
    with ReplacedFile(path, 'w', encoding='utf-8', newline='') as file:
        table = csv.writer(file, lineterminator='\n')
        table.writerow(COLUMNS)
        table.writerows(map(_to_cells, corrections))


def _to_cells(correction: HeadingCorrection) -> list[str | int]:
    row = correction.row
    angles = (correction.add_to_ts_deg, correction.low_deg, correction.high_deg,
              row.installation_offset_deg,
              *(correction.coefficients_deg or [None] * len(_TERMS)),
              *(correction.u_deg or [None] * len(_TERMS)))
    return [row.ship, row.settings_sha256, utc(row.start_ns), utc(row.end_ns), row.n, row.outcome,
            row.validity_effect, *map(_to_cell, angles)]


def _to_cell(angle_deg: float | None) -> str:
    # Zero has no sign.
    return '' if angle_deg is None else f'{round(angle_deg, 4) + 0.0:.4f}'


def _list_angles(corrections: Sequence[HeadingCorrection], path: str) -> list[str]:
    """Return day of the year and TS - RS, at the beginning and at the end of each run."""
    in_order = sorted(corrections, key=lambda correction: correction.row.start_ns)
    lines = []
    for before, after in zip(in_order, in_order[1:]):
        if before.row.ship != after.row.ship or before.row.end_ns >= after.row.start_ns:
            raise ValueError(f'{path}: can hold the runs of one sensor, one after the other; '
                             'choose the sensor with --ship, or write a .csv')
    for correction in in_order:
        lines += [f'{(stamp_ns - find_year(in_order[0].row.start_ns)) / DAY_NS:.7f} '
                  f'{_to_cell(-correction.add_to_ts_deg)}\n'
                  for stamp_ns in (correction.row.start_ns, correction.row.end_ns)]
    return lines
