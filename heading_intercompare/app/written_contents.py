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

"""What a file that this program wrote holds, in lines."""

from __future__ import annotations

from typing import Iterator, Mapping

import numpy as np

from heading_intercompare.bags.csv.csv_rows import CsvRows
from heading_intercompare.core.records import Pairs
from heading_intercompare.core.utc_text import utc
from heading_intercompare.logbook.logbook_file import Logbook
from heading_intercompare.readers.written_files import WrittenFile

from .config import load_config
from .sources.csv_source import find_pairs_reader


def describe_contents(path: str, written: WrittenFile) -> list[str]:
    """
    Return what a file holds, in lines.

    Raises
    ------
    OSError
        If the file cannot be read.
    ValueError
        If it is damaged.

    """
    return list(_DESCRIPTIONS[written.contents](path)) if written.contents else []


def describe_pairs(path: str) -> Iterator[str]:
    """Yield the number of pairs in a table, their span and their rate."""
    reader = find_pairs_reader(path)(path)
    pairs = Pairs.concatenate(reader)
    yield f'pairs: {len(pairs)}'
    if len(pairs):
        begin_ns, end_ns = int(pairs.stamp_ns.min()), int(pairs.stamp_ns.max())
        span_s = (end_ns - begin_ns) / 1e9
        yield f'span: {utc(begin_ns)} to {utc(end_ns)} UTC, {span_s:.1f} s'
        if span_s:
            yield f'rate: {(len(pairs) - 1) / span_s:.2f} per second'
        for name in ('ts_deg', 'rs_deg'):
            heading_deg = getattr(pairs, name)
            yield f'{name}: {np.nanmin(heading_deg):.2f} to {np.nanmax(heading_deg):.2f}'
    if reader.ignored:
        yield f'other columns: {", ".join(reader.ignored)}'
    if reader.cut:
        yield f'note: {reader.cut}'


def _describe_table(path: str) -> Iterator[str]:
    with CsvRows(path, '') as rows:
        yield f'columns: {", ".join(rows.names)}'
        yield f'rows: {sum(1 for _ in rows)}'


def _describe_logbook(path: str) -> Iterator[str]:
    runs, head = Logbook(path).read_with_head()
    yield f'runs: {len(runs)}'
    yield ('chain: none, an older version wrote it' if head is None else
           f'chain: entry {head.entry} is the newest, SHA-256 {head.sha256}')
    if runs:
        yield f'ships: {", ".join(sorted({run.ship or "(unnamed)" for run in runs}))}'
        yield (f'span: {utc(min(run.start_ns for run in runs))} to '
               f'{utc(max(run.end_ns for run in runs))} UTC')


def _describe_parameters(path: str) -> Iterator[str]:
    config = load_config(path)
    sections: Mapping[str, Mapping[str, object]] = {'/**': config.shared, **config.sections}
    for name, values in sections.items():
        if values:
            yield f'{name}:'
        yield from (f'  {key}: {value}' for key, value in values.items())


def _describe_verdict(path: str) -> Iterator[str]:
    from heading_intercompare.report.json import read_any
    yield from str(read_any(path)).splitlines()


_DESCRIPTIONS = {'verdict': _describe_verdict, 'table': _describe_table, 'pairs': describe_pairs,
                 'logbook': _describe_logbook, 'parameters': _describe_parameters}
