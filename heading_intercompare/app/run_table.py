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

"""The tables that a person gives: of runs, and of stretches to take out."""

from __future__ import annotations

import csv
from datetime import datetime, timezone
from io import TextIOWrapper
import os
from pathlib import Path
from typing import Iterable, Mapping, Sequence

from heading_intercompare.bags.csv.csv_rows import split_rows, StrayQuote
from heading_intercompare.core.time_rules.exclusions import read_exclusions
from heading_intercompare.core.verdict.verdict_document import RunVerdict
from heading_intercompare.special_files import open_once

#: Start and stop in nanoseconds, and the source.
Run = tuple[int, int, str]
RunTable = Sequence[Run]


def read_run_table(path: str) -> list[Run]:
    """
    Read a table of runs: ``start,stop[,source]``, ISO UTC or integer nanoseconds.

    Raises
    ------
    OSError, ValueError
        If the file cannot be read, or a row is wrong; the message names file and line.

    """
    # Spreadsheets put a byte order mark before the header.
    with TextIOWrapper(open_once(path), newline='', encoding='utf-8-sig') as file:
        rows = csv.DictReader(file)
        try:
            names = [name.strip() for name in rows.fieldnames or ()]
            if 'start' not in names or 'stop' not in names:
                raise ValueError('the header must be start,stop[,source], '
                                 f'not {",".join(names) or "empty"}')
            rows.fieldnames = names
            return sorted(map(_run, rows))
        except UnicodeDecodeError:
            raise ValueError(f'{path}: is not UTF-8; save it as UTF-8') from None
        except (csv.Error, ValueError) as error:
            raise ValueError(f'{path}, line {rows.line_num}: {error}') from error


def _run(row: Mapping[str, str | None]) -> Run:
    start_ns, stop_ns = parse_stamp(row['start']), parse_stamp(row['stop'])
    if stop_ns <= start_ns:
        raise ValueError(f'stop {row["stop"]} is not after start {row["start"]}')
    return start_ns, stop_ns, (row.get('source') or '').strip()


def assign_runs(table: RunTable, paths: Sequence[str]) -> tuple[list[Run], list[str]]:
    """
    Return the table with sources replaced by input paths, and the sources that match no input.

    A source matches the inputs with the same path, however it is written; if there is none, the
    input with that file name.

    Raises
    ------
    ValueError
        If several inputs have that file name.

    """
    places = {path: os.path.abspath(path) for path in paths}
    meant: dict[str, list[str]] = {'': ['']}
    for source in {source for _, _, source in table} - {''}:
        place = os.path.abspath(source)
        meant[source] = ([path for path in places if places[path] == place]
                         or [path for path in places if Path(places[path]).name == source])
        if len({places[path] for path in meant[source]}) > 1:
            raise ValueError(f'source = {source!r} in the table of runs is '
                             f'{" and ".join(meant[source])}; write the path instead')
    return ([(start, stop, path) for start, stop, source in table for path in meant[source]],
            sorted(source for source, matches in meant.items() if not matches))


def parse_stamp(text: str | None) -> int:
    """Return a time, ISO UTC or integer nanoseconds, as a stamp; ValueError for others."""
    text = (text or '').strip()
    if text.lstrip('-').isdigit():
        return int(text)
    try:
        moment = datetime.fromisoformat(text[:19].replace('Z', ''))
        fraction = text[19:].rstrip('Z').lstrip('.')
        ns = int((fraction or '0').ljust(9, '0')) if len(fraction) <= 9 else None
    except ValueError:
        ns = None
    if ns is None:
        raise ValueError(f'{text!r} is neither ISO UTC (2014-08-01T00:00:00.5Z) nor integer '
                         'nanoseconds')
    return int(moment.replace(tzinfo=timezone.utc).timestamp()) * 1_000_000_000 + ns


def read_exclusion_table(path: str) -> str:
    """
    Return the text of the setting `exclusions` from a file with ``start,end,reason``.

    Raises
    ------
    OSError, ValueError
        If the file cannot be read, or a row is wrong; the message names the file.

    """
    with TextIOWrapper(open_once(path), newline='', encoding='utf-8-sig') as file:
        try:
            rows = [row for row in split_rows(file, 3, skipinitialspace=True) if any(row)]
        except StrayQuote as error:
            raise ValueError(f'{path}: {error}') from None
        except (csv.Error, UnicodeDecodeError) as error:
            raise ValueError(f'{path}: is not csv in UTF-8: {error}') from error
    # Rows of the setting end with a semicolon, and the reason holds any other sign.
    text = '; '.join(' '.join(', '.join(row).replace(';', ',').split()) for row in rows)
    try:
        exclusions = read_exclusions(text)
    except ValueError as error:
        raise ValueError(f'{path}, {error}') from error
    if not exclusions:
        raise ValueError(f'{path}: has no row start,end,reason')
    return text


def name_unused(runs: Iterable[RunVerdict], exclusions: str | None) -> list[str]:
    """Return a note on each exclusion that takes nothing out of any run."""
    used = {(stretch.start_ns, stretch.end_ns) for run in runs
            if run.taken_out is not None for stretch in run.taken_out.stretches if stretch.n}
    return [f'exclusions: {exclusion} takes out nothing: no analysed difference is in it'
            for exclusion in read_exclusions(exclusions)
            if (exclusion.start_ns, exclusion.end_ns) not in used]
