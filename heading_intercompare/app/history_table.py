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

"""The runs of histories as a table: CSV, or Parquet, by the suffix of the file."""

from __future__ import annotations

import csv
from importlib.util import find_spec
from typing import Mapping, Sequence, TextIO

from heading_intercompare.logbook.history import History
from heading_intercompare.logbook.logbook_file import to_cells
from heading_intercompare.logbook.row_chain import ChainHead
from heading_intercompare.logbook.run_row import RunRow
from heading_intercompare.replaced_file import ReplacedFile

LIMITS = ('mean_low_deg', 'mean_high_deg', 'sd_low_deg', 'sd_high_deg')
"""The columns of the limits, which follow those of `RunRow`; then comes ``outside``."""
SUFFIXES = '.csv', '.parquet'


def check_table(path: str) -> None:
    """Raise ValueError if the library for the form of a table is not installed."""
    if path.endswith('.parquet') and find_spec('pyarrow') is None:
        raise ValueError(f'{path}: writing Parquet needs pyarrow: install '
                         'heading_intercompare[parquet]')


def write_table(histories: Sequence[History], path: str, since_ns: int | None,
                heads: Mapping[str, ChainHead | None]) -> None:
    """
    Write a row per run with its limits: as Parquet if the suffix says so, otherwise as csv.

    Parameters
    ----------
    histories
        The runs, in their order.
    path
        The file.
    since_ns
        Only runs that end at or after this stamp.
    heads
        The newest entry of the chain of each logbook; only Parquet holds them.

    Raises
    ------
    OSError
        If the file cannot be written.

    """
    if path.endswith('.parquet'):
        from .history_parquet import write_parquet

        write_parquet(histories, path, since_ns, heads)
        return
    with ReplacedFile(path, 'w', encoding='utf-8', newline='') as file:
        write_csv(histories, file, since_ns)


def write_csv(histories: Sequence[History], file: TextIO, since_ns: int | None) -> None:
    """Write a row per run with its limits; several figures are JSON."""
    table = csv.writer(file, lineterminator='\n')
    table.writerow([*RunRow.columns(), *LIMITS, 'outside'])
    for history in histories:
        for point in history.list_since(since_ns):
            table.writerow([*to_cells(point.row), *(getattr(point, name) for name in LIMITS),
                            ' '.join(point.outside)])
