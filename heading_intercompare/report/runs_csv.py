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

"""The runs of a verdict as a table for spreadsheets, CSV: a row per run."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Iterable, Iterator, Sequence

from heading_intercompare.core.declared_figures import find_figure
from heading_intercompare.core.sensors.sensors_verdict import SensorsVerdict
from heading_intercompare.core.typed_reader import make_plain
from heading_intercompare.core.utc_text import utc
from heading_intercompare.core.verdict.verdict_document import Verdict
from heading_intercompare.replaced_file import ReplacedFile

Cell = str | int | float | None

COLUMNS = {
    'recording': 'source', 'run': 'run', 'start_utc': 'start_ns', 'end_utc': 'end_ns',
    'start_ns': 'start_ns', 'end_ns': 'end_ns', 'duration_s': 'duration_s',
    'pairs': 'pairing.paired', 'n': 'n', 'nu': 'guarded.nu', 'mean_deg': 'mean_deg',
    'max_abs_deg': 'max_abs_deg', 'sd_deg': 'std_deg', 'variance_deg2': 'variance_deg2',
    'lower_bound_deg2': 'guarded.lower_bound_deg2',
    'upper_bound_deg2': 'guarded.upper_bound_deg2',
    'acceptance_limit_deg2': 'guarded.acceptance_limit_deg2',
    'rejection_limit_deg2': 'guarded.rejection_limit_deg2', 'n_plus': 'count_criterion.n_plus',
    'n_plus_plus': 'count_criterion.n_plus_plus', 'outcome': 'outcome',
    'validity': 'validity_effect', 'conditions': 'conditions_in_doubt', 'reason': 'reason',
    'outcome_as_printed': 'paper_outcome', 'headline': 'headline',
}
"""The columns, each with the dotted key of its figure."""


def write_runs(verdict: Verdict | SensorsVerdict, path: str | Path) -> None:
    """
    Write a row per run, and a row with only name and reason for a recording without a run.

    Parameters
    ----------
    verdict
        On one recording or several; rows of several sensors have the name of the sensor first.
    path
        The file, UTF-8; a figure that is missing or not finite is an empty cell.

    Raises
    ------
    OSError
        If the file cannot be written.

    """
    if isinstance(verdict, Verdict):
        _write(path, [*COLUMNS], _list_rows(verdict))
        return
    _write(path, ('sensor', *COLUMNS), (
        [name, *row] for name, of_sensor in verdict.verdicts.items()
        for row in _list_rows(of_sensor)))


def _list_rows(verdict: Verdict) -> Iterator[list[Cell]]:
    for run in verdict.runs:
        yield [utc(find_figure(run, key)) if name.endswith('_utc') else
               make_plain(find_figure(run, key)) for name, key in COLUMNS.items()]
    for recording in verdict.inputs:
        if recording.why_no_run:
            row: dict[str, Cell] = dict.fromkeys(COLUMNS, '')
            yield [*(row | {'recording': recording.path, 'reason': recording.why_no_run}).values()]


def _write(path: str | Path, names: Sequence[str], rows: Iterable[list[Cell]]) -> None:
    with ReplacedFile(path, 'w', newline='', encoding='utf-8',
                      errors='backslashreplace') as file:
        table = csv.writer(file, lineterminator='\n')
        table.writerow(names)
        table.writerows(rows)
