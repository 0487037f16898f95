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

"""The table of tests: what a norm requires, and what a run, or all runs, show of it."""

from __future__ import annotations

from typing import Callable, Mapping, Sequence

from heading_intercompare.core.decision.guarded import Guarded
from heading_intercompare.core.decision.norm_presets import list_required
from heading_intercompare.core.diagnostics.by_motion import ByMotion
from heading_intercompare.core.diagnostics.run_columns import RunColumns
from heading_intercompare.core.required_tests import KINDS, RequiredTest
from heading_intercompare.core.runs.run_series import RunSeries
from heading_intercompare.core.statistics.variance_uncertainty import MEAN_DOF

from .dynamic_error import measure_dynamic_error, measure_fast_dynamic_error
from .follow_up_error import measure_follow_up
from .judged_test import judge_measurement, JudgedTest, Measurement, merge_runs, TestRisks
from .repeatability import judge_starts, measure_start
from .resolution_error import measure_resolution
from .rms_of_ten import measure_rms_of_ten
from .settle_point import measure_settle_point
from .settling_time import measure_settling_time
from .static_error import measure_static_error
from .tested_run import TestedRun

MEASURES: Mapping[str, Callable[[TestedRun, float], Measurement]] = {
    'resolution': measure_resolution,
    'static_error': measure_static_error,
    'dynamic_error': measure_dynamic_error,
    'fast_dynamic_error': measure_fast_dynamic_error,
    'settling_time': measure_settling_time,
    'settle_point': measure_settle_point,
    'rms_of_ten': measure_rms_of_ten,
    'repeatability': measure_start,
}
"""What measures each kind of test on one run; the follow-up error has rates of turn besides."""

MERGES: Mapping[str, Callable[[Sequence[JudgedTest], TestRisks], JudgedTest]] = {
    'repeatability': judge_starts}
"""What judges a kind of test on all runs together, not on the run that decides."""


def judge_tests(columns: RunColumns, mean_deg: float | None, guarded: Guarded,
                by_motion: ByMotion | None, run: RunSeries) -> tuple[JudgedTest, ...]:
    """
    Return the table of tests of a run.

    Parameters
    ----------
    columns
        Its analysed pairs.
    mean_deg, guarded
        Its mean difference, degrees, and its guarded decision, which knows the uncertainty of it.
    by_motion
        Its differences by heading and by rate of turn.
    run
        The run itself, with its start.

    """
    required = list_required(columns.settings.norms)
    risks = TestRisks.of(columns.settings.risk, len(required))
    tested = TestedRun(columns, mean_deg, guarded.bias_u_deg, MEAN_DOF, by_motion, risks, run)
    return tuple(_judge(test, tested) for test in required)


def _judge(required: RequiredTest, tested: TestedRun) -> JudgedTest:
    limit = required.limit_at(tested.settings.norms.latitude_deg)
    return judge_measurement(required, limit, _measure(required, limit, tested), tested.risks)


def _measure(required: RequiredTest, limit: float, tested: TestedRun) -> Measurement:
    if not KINDS[required.kind].is_judged:
        return Measurement(record='a record of headings does not decide it')
    if required.rates_deg_s is not None and required.least_rate_deg_s is not None:
        return measure_follow_up(tested, limit, required.rates_deg_s, required.least_rate_deg_s)
    measure = MEASURES.get(required.kind)
    return Measurement() if measure is None else measure(tested, limit)


def merge_tables(tables: Sequence[tuple[int, Sequence[JudgedTest]]],
                 risks: TestRisks) -> tuple[JudgedTest, ...]:
    """
    Return one table from those of several runs; see `merge_runs`.

    The tests of `MERGES` need all runs together.
    """
    rows = zip(merge_runs(tables, risks), *(table for _, table in tables))
    return tuple(MERGES[row.kind](of_runs, risks) if row.kind in MERGES else row
                 for row, *of_runs in rows)
