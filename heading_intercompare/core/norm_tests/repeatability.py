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

"""The repeatability of the settle point: how far it differs from start to start."""

from __future__ import annotations

from dataclasses import replace
import math
from typing import Sequence

from heading_intercompare.core.count_words import count_words

from .judged_test import JudgedTest, Measurement, SettlePoint, TestRisks
from .sets_of_ten import is_one_heading, pool_variances, READINGS
from .settling import find_settling
from .tested_run import exceeding, NO_SETS, reach, TestedRun

LEAST_STARTS = 3
"""Starts that show the repeatability."""


def measure_start(tested: TestedRun, limit: float) -> Measurement:
    """
    Return the settle point of a run that begins with a start; all runs together are judged.

    Notes
    -----
    A run that the clock cut off, or that begins settled, is no start.

    """
    del limit
    settling = find_settling(tested.run.stamp_ns.values, tested.run.x_deg.values) \
        if tested.run.holds_start else None
    if settling is None or settling.first_min in (0, None):
        return Measurement(record='the run does not begin with a start')
    if not tested.sets_of_ten:
        return Measurement(record=NO_SETS)
    ten = tested.sets_of_ten[0]
    return Measurement(
        record='one start', settle_point=SettlePoint(ten.mean_deg, ten.variance_deg2,
                                                     ten.heading_deg))


def judge_starts(tests: Sequence[JudgedTest], risks: TestRisks) -> JudgedTest:
    """
    Return the test of all starts on one heading.

    Parameters
    ----------
    tests
        The rows of the runs.
    risks
        Of the test for all runs.

    Notes
    -----
    The figure is the largest difference of two settle points. The pairs of starts share the risk
    of a false rejection. The RS is taken to repeat its own settle point.

    References
    ----------
    A.821(19) 4.1.3.

    """
    points = [test.settle_point for test in tests if test.settle_point is not None]
    groups = ([point for point in points if is_one_heading(point.heading_deg, first.heading_deg)]
              for first in points)
    starts = max(groups, key=len, default=[])
    row = replace(tests[0], settle_point=None, run=None, record=(
        f'{count_words(len(starts), "start")} on one heading, '
        f'{count_words(len(tests), "run")}'))
    if len(starts) < 2:
        return row.judge(risks)
    variance, nu = pool_variances([start.variance_deg2 for start in starts])
    means = [start.mean_deg for start in starts]
    largest, u = max(means) - min(means), math.sqrt(2.0 * variance / READINGS)
    pairs = math.comb(len(starts), 2)
    risk = float(largest <= row.limit) if u == 0.0 else min(
        1.0, pairs * exceeding((largest - row.limit) / u, nu))
    return replace(
        row, value=largest, low=max(0.0, largest - reach(risks.not_met / pairs, nu) * u),
        high=largest + reach(risks.met, nu) * u, risk_not_met=risk,
        sailed=len(starts) >= LEAST_STARTS).judge(risks)
