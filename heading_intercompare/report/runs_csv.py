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
import math
from pathlib import Path
from typing import Callable, Iterable, Iterator, Sequence

from heading_intercompare.core.sensors.sensors_verdict import SensorsVerdict
from heading_intercompare.core.utc_text import utc
from heading_intercompare.core.validity.condition import DOUBTFUL, VOID
from heading_intercompare.core.verdict.verdict_document import RunVerdict, Verdict

__all__ = ['COLUMNS', 'write_runs']

Cell = str | int | float | None


def _list_conditions(run: RunVerdict) -> str:
    return ','.join(f'{finding.condition}={finding.effect}' for finding in run.validity
                    if finding.effect in (DOUBTFUL, VOID))


def _finite(value: float | None) -> float | None:
    return value if value is not None and math.isfinite(value) else None


#: Column and the cell of a run; docs/howto/judge_many.md explains them.
_COLUMNS: dict[str, Callable[[RunVerdict], Cell]] = {
    'recording': lambda run: run.source,
    'run': lambda run: run.run,
    'start_utc': lambda run: utc(run.start_ns),
    'end_utc': lambda run: utc(run.end_ns),
    'start_ns': lambda run: run.start_ns,
    'end_ns': lambda run: run.end_ns,
    'duration_s': lambda run: run.duration_s,
    'pairs': lambda run: run.pairing.paired,
    'n': lambda run: run.n,
    'nu': lambda run: _finite(run.guarded.nu),
    'mean_deg': lambda run: _finite(run.mean_deg),
    'max_abs_deg': lambda run: _finite(run.max_abs_deg),
    'sd_deg': lambda run: _finite(run.std_deg),
    'variance_deg2': lambda run: _finite(run.variance_deg2),
    'lower_bound_deg2': lambda run: _finite(run.guarded.lower_bound_deg2),
    'upper_bound_deg2': lambda run: _finite(run.guarded.upper_bound_deg2),
    'acceptance_limit_deg2': lambda run: run.guarded.acceptance_limit_deg2,
    'rejection_limit_deg2': lambda run: run.guarded.rejection_limit_deg2,
    'n_plus': lambda run: run.count_criterion.n_plus,
    'n_plus_plus': lambda run: run.count_criterion.n_plus_plus,
    'outcome': lambda run: run.outcome.value,
    'validity': lambda run: run.validity_effect,
    'conditions': _list_conditions,
    'reason': lambda run: run.reason,
    'outcome_as_printed': lambda run: run.paper_outcome.value,
    'headline': lambda run: run.headline,
}
COLUMNS = tuple(_COLUMNS)
"""Names of the columns."""


def write_runs(verdict: Verdict | SensorsVerdict, path: str | Path) -> None:
    """
    Write a row per run, and a row with only name and reason for a recording without a run.

    Parameters
    ----------
    verdict : Verdict or SensorsVerdict
        On one recording or several; rows of several sensors have the name of the sensor first.
    path : path
        The file, UTF-8; a figure that is missing or not finite is an empty cell.

    Raises
    ------
    OSError
        If the file cannot be written.

    """
    if isinstance(verdict, Verdict):
        _write(path, COLUMNS, _list_rows(verdict))
        return
    _write(path, ('sensor', *COLUMNS), (
        [name, *row] for name, of_sensor in verdict.verdicts.items()
        for row in _list_rows(of_sensor)))


def _list_rows(verdict: Verdict) -> Iterator[list[Cell]]:
    for run in verdict.runs:
        yield [_COLUMNS[name](run) for name in COLUMNS]
    for recording in verdict.inputs:
        if recording.why_no_run:
            row: dict[str, Cell] = dict.fromkeys(COLUMNS, '')
            yield [*(row | {'recording': recording.path, 'reason': recording.why_no_run}).values()]


def _write(path: str | Path, names: Sequence[str], rows: Iterable[list[Cell]]) -> None:
    with open(path, 'w', newline='', encoding='utf-8', errors='backslashreplace') as file:
        table = csv.writer(file, lineterminator='\n')
        table.writerow(names)
        table.writerows(rows)
