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

"""The verdict on the last runs of a sensor in a logbook, together: by the rule `sensor`."""

from __future__ import annotations

from dataclasses import replace
from pathlib import PurePath
from typing import Sequence

from heading_intercompare.core.count_words import count_words
from heading_intercompare.core.decision.coverage import least_apart_s, span_words
from heading_intercompare.core.decision.sequential import risk_at_the_end
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.typed_reader import VerdictError
from heading_intercompare.core.utc_text import utc
from heading_intercompare.core.validity.condition import VOID
from heading_intercompare.core.verdict.chosen_runs import (
    ChosenRuns,
    describe_left_out,
    LeftOutRun,
)
from heading_intercompare.core.verdict.consistency import ContradictionError, judge_kept_runs
from heading_intercompare.core.verdict.verdict_document import Verdict
from heading_intercompare.core.version import RULE_VERSION

from .logbook_file import Logbook, LogbookError
from .run_record import decode_record, RunRecord
from .run_row import RunKey, RunRow

_RowOfBook = tuple[RunRow, Logbook]


def judge_last_runs(books: Sequence[Logbook], asked: int, ship: str | None = None) -> Verdict:
    """
    Judge the last runs of a sensor together, by the rule `sensor`.

    Parameters
    ----------
    books
        The logbooks that hold the runs.
    asked
        The number of runs, chosen before their outcomes are known.
    ship
        Only runs of this ship, or SHIP/SENSOR.

    Returns
    -------
    Verdict
        With `chosen`; its settings are those of the newest run, with the rule `sensor`.

    Raises
    ------
    LogbookError
        If a logbook cannot be read, or its runs are those of several sensors or too few.

    Notes
    -----
    Runs are taken from the newest back, whatever their outcomes. A run is left out if it is void,
    or was judged by other settings or by another version of the decision rule, if its row has no
    record, or if the next one begins too soon after it for their means to be independent: within
    the slowest error stated, or 600 s. In variants A and C, whose means differ, it must not
    overlap.

    References
    ----------
    S.12, S.13 of ``docs/risk.md``.

    """
    rows = _read_rows(books, ship)
    newest_first = sorted(rows.values(), key=lambda of_book: (
        -of_book[0].end_ns, of_book[0].start_ns))
    usable = next((of_book for of_book in newest_first if not _say_unusable(of_book[0])), None)
    chosen: list[_RowOfBook] = []
    left_out: list[LeftOutRun] = []
    if usable is not None:
        settings = _read_record(*usable).settings
        chosen, left_out = _choose(newest_first, asked, usable[0].settings_sha256,
                                   _least_gap_s(settings))
    else:
        left_out = [_leave_out(row, _say_unusable(row)) for row, _ in newest_first]
    if len(chosen) < asked or usable is None:
        why = ''.join(f'; {line}' for line in describe_left_out(left_out))
        raise LogbookError(f'{_name(books)}: {count_words(asked, "run")} are asked for, and '
                           f'{len(chosen)} can be judged together{why}')
    records = [_read_record(*of_book) for of_book in reversed(chosen)]
    inputs = {(entry.path, entry.sha256): entry for record in records for entry in record.inputs}
    by_sensor = replace(settings, campaign=replace(settings.campaign, rule='sensor'))
    try:
        verdict = judge_kept_runs([record.run for record in records], by_sensor,
                                  [*inputs.values()])
    except ContradictionError as error:
        raise LogbookError(f'{_name(books)}: {error}') from error
    return replace(verdict, chosen=ChosenRuns(
        asked=asked, ship=usable[0].ship, left_out=tuple(left_out), logbooks=_list_heads(books)))


def _list_heads(books: Sequence[Logbook]) -> dict[str, str | None]:
    """Return the newest hash of each logbook by its name, which has no path."""
    heads: dict[str, str | None] = {}
    for book in books:
        name, head = PurePath(book.path).name, book.read_head()
        n_before = sum(PurePath(earlier.path).name == name for earlier in books[:len(heads)])
        heads[f'{name} ({n_before + 1})' if n_before else name] = head and head.sha256
    return heads


def _name(books: Sequence[Logbook]) -> str:
    return ', '.join(book.path for book in books)


def _read_rows(books: Sequence[Logbook], ship: str | None) -> dict[RunKey, _RowOfBook]:
    """Return the rows of one sensor, each with its logbook; one with a record counts."""
    rows: dict[RunKey, _RowOfBook] = {}
    for book in books:
        for row in book.read(ship=ship):
            if row.key not in rows or row.record_sha256 is not None:
                rows[row.key] = row, book
    names = sorted({row.ship for row, _ in rows.values()})
    if len(names) > 1:
        raise LogbookError(f'{_name(books)}: holds runs of '
                           f'{", ".join(name or "(no ship)" for name in names)}; choose one with '
                           '--ship')
    return rows


def _choose(newest_first: Sequence[_RowOfBook], asked: int, settings_sha256: str,
            gap_s: float) -> tuple[list[_RowOfBook], list[LeftOutRun]]:
    """Return the last runs, the newest first, and those between them that are left out."""
    chosen: list[_RowOfBook] = []
    left_out: list[LeftOutRun] = []
    for row, book in newest_first:
        if len(chosen) == asked:
            break
        why = _say_unusable(row) or _say_other(row, settings_sha256)
        if not why and chosen and chosen[-1][0].start_ns - row.end_ns <= gap_s * 1e9:
            why = ('overlaps the next' if not gap_s else
                   f'not more than {span_words(gap_s)} before the next')
        if why:
            left_out.append(_leave_out(row, why))
        else:
            chosen.append((row, book))
    return chosen, left_out[::-1]


def _least_gap_s(settings: Settings) -> float:
    """Return the time that two runs must lie apart; only the means of runs ask for any."""
    return least_apart_s(risk_at_the_end(settings)) if settings.variant == 'B' else 0.0


def _leave_out(row: RunRow, why: str) -> LeftOutRun:
    return LeftOutRun(row.start_ns, row.end_ns, why)


def _say_unusable(row: RunRow) -> str:
    """Return why a row cannot be judged together with others; empty if it can."""
    if row.validity_effect == VOID:
        return f'void by {row.reason.partition(".")[2]}'
    if row.record_sha256 is None:
        return 'without a record, as an older version wrote the row: analyze its recording again'
    if row.rule_version != RULE_VERSION:
        return (f'judged by version {row.rule_version} of the decision rule, and this is '
                f'{RULE_VERSION}: analyze its recording again')
    return ''


def _say_other(row: RunRow, settings_sha256: str) -> str:
    return '' if row.settings_sha256 == settings_sha256 else (
        f'judged by other settings ({row.settings_sha256[:8]})')


def _read_record(row: RunRow, book: Logbook) -> RunRecord:
    """Return the record of a run; LogbookError if it cannot be read."""
    row, = book.read_records([row])
    try:
        return decode_record(row.record or b'', row.settings_sha256)
    except VerdictError as error:
        raise LogbookError(f'{book.path}: the record of the run of {utc(row.start_ns)} UTC: '
                           f'{error}; analyze its recording again') from error
