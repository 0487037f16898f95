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

"""The correction card for the bridge: what to add to the TS on eight headings, as page or csv."""

from __future__ import annotations

import csv
from dataclasses import dataclass
import math
from pathlib import Path

from heading_intercompare.core.angles import wrap180
from heading_intercompare.core.utc_text import utc
from heading_intercompare.core.validity.condition import VOID
from heading_intercompare.core.verdict.verdict_document import RunVerdict, Verdict
from heading_intercompare.replaced_file import replace_file, ReplacedFile

from . import check_form
from .contents.tables import Table
from .formatting import ABSENT, number

COLUMNS = ('heading_deg', 'c_minus_o_deg', 'c_minus_o_low_deg', 'c_minus_o_high_deg', 'n',
           'duration_s', 'recording', 'run', 'start_utc', 'end_utc')
"""The columns of the csv."""
_HEAD = 'heading [deg]', 'C - O [deg]', '95 % +/- [deg]', 'measured for [s]'


@dataclass(frozen=True, slots=True)
class CardRow:
    """
    The correction on one heading; without differences or interval its figures are None.

    Attributes
    ----------
    heading_deg
        Middle of the sector of the RS.
    add_to_ts_deg
        To be added to the TS: minus the mean of TS - RS as measured, with the installation offset.
    half_width_deg
        Half of its 95 % interval.
    n, duration_s
        Differences on steady headings in the sector, and their time.

    """

    heading_deg: float
    add_to_ts_deg: float | None
    half_width_deg: float | None
    n: int
    duration_s: float


def list_card(run: RunVerdict, installation_offset_deg: float) -> list[CardRow]:
    """Return the rows of a run; none if it is void, or has fewer than 64 differences."""
    if run.validity_effect == VOID or run.by_motion is None:
        return []
    sectors = run.by_motion.sectors
    return [CardRow(heading_deg,
                    None if mean is None else float(wrap180(-(mean + installation_offset_deg))),
                    None if mean is None or low is None else mean - low, n, duration_s)
            for heading_deg, mean, low, n, duration_s in zip(
                sectors.heading_deg, sectors.mean_deg, sectors.low_deg, sectors.n,
                sectors.duration_s)]


def check_card(path: str) -> None:
    """Reject, before any work, a card that cannot be written; ValueError in one line."""
    form = Path(path).suffix.lower()
    if form not in ('.csv', '.html', '.pdf'):
        raise ValueError(f'--card {path}: a card must end in .csv, .html or .pdf')
    if form != '.csv':
        check_form(path)


def write_card(verdict: Verdict, path: str | Path) -> None:
    """
    Write the card of each run of a verdict, in the form that the suffix names.

    Parameters
    ----------
    verdict
        On one sensor.
    path
        F.csv with `COLUMNS`, where a figure that is missing is an empty cell; F.html or F.pdf, a
        page for each run.

    Raises
    ------
    OSError
        If the file cannot be written.

    """
    place = Path(path)
    offset_deg = verdict.settings.installation_offset_deg
    cards = [(run, list_card(run, offset_deg)) for run in verdict.runs]
    if place.suffix.lower() == '.csv':
        _write_table(place, cards)
        return
    text = _compose(verdict, cards)
    if place.suffix.lower() == '.pdf':
        from .pdf import print_page
        print_page(text, place)
    else:
        replace_file(place, text)


def _write_table(place: Path, cards: list[tuple[RunVerdict, list[CardRow]]]) -> None:
    with ReplacedFile(place, 'w', newline='', encoding='utf-8',
                      errors='backslashreplace') as file:
        table = csv.writer(file, lineterminator='\n')
        table.writerow(COLUMNS)
        for run, rows in cards:
            for row in rows:
                add, half = row.add_to_ts_deg, row.half_width_deg
                ends = (add - half, add + half) if add is not None and half is not None \
                    else (None, None)
                table.writerow([f'{row.heading_deg:g}', *map(_to_cell, (add, *ends)), row.n,
                                f'{row.duration_s:g}', run.source, run.run, utc(run.start_ns),
                                utc(run.end_ns)])


def _to_cell(angle_deg: float | None) -> str:
    # Zero has no sign.
    return '' if angle_deg is None else f'{round(angle_deg, 4) + 0.0:.4f}'


def _compose(verdict: Verdict, cards: list[tuple[RunVerdict, list[CardRow]]]) -> str:
    """Return the page."""
    from .html import load_template
    pages = [(run, utc(run.start_ns), utc(run.end_ns), Table(_HEAD, [*map(_to_words, rows)]))
             for run, rows in cards if rows]
    without = [run.run for run, rows in cards if not rows]
    return load_template('card.html').render(
        trial=verdict.settings.trial, verdict=verdict, pages=pages, without=without,
        offset_deg=verdict.settings.installation_offset_deg)


def _to_words(row: CardRow) -> list[str]:
    """Return a row for the bridge, in hundredths; an interval is rounded up."""
    add, half = row.add_to_ts_deg, row.half_width_deg
    missing = ABSENT if row.n else ''
    return [f'{row.heading_deg:03.0f}', '' if add is None else f'{round(add, 2) + 0.0:+.2f}',
            missing if half is None else f'{math.ceil(100.0 * half) / 100.0:.2f}',
            number(row.duration_s)]
