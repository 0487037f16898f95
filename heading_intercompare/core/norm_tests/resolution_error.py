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

"""The resolution error: half of the step in which the TS reports."""

from __future__ import annotations

import math
from typing import Mapping, Sequence

import numpy as np

from heading_intercompare.core.angles import wrap180
from heading_intercompare.core.raw_streams.decimal_steps import DECIMAL_STEPS, find_decimal_step

from .judged_test import JudgedTest, Measurement, TestRisks
from .tested_run import TestedRun

#: Changes of value that are multiples of none are of a finer step than the least one.
_FINEST_STEP_DEG = DECIMAL_STEPS[-1] / 100.0
#: A step shows among this number of changes of the reading.
_LEAST_CHANGES = 30
#: Without a common step few changes can be smaller than the step.
_SMALL_SHARE = 0.05


_HIDDEN = 'the TS is interpolated, which hides its step'


def measure_resolution(tested: TestedRun, limit: float) -> Measurement:
    """
    Return half of the step in which the TS reports.

    A step is no estimate: it has no uncertainty. Where none shows, the small changes of the
    reading bound it, because a reading never changes by less than its step.

    References
    ----------
    MSC.116(73) 3.5: an output in steps of 1/6 degree has an error by its coding.

    """
    resolution = tested.columns.steps[0]
    ts_deg = tested.columns.ts_deg[:resolution.n]
    changes = np.abs(wrap180(np.diff(ts_deg)))
    changes = changes[changes > 0.0]
    if changes.size < _LEAST_CHANGES:
        return Measurement(record=f'the TS changed its reading {changes.size} times')
    if tested.columns.interpolates_ts:
        return Measurement(record=_HIDDEN)
    if resolution.step_deg is not None:
        return _measure_step(resolution.step_deg, limit)
    bound = float(np.quantile(changes, _SMALL_SHARE))
    return Measurement(0.5 * bound, 0.0, 0.5 * bound, 1.0, True,
                       f'no step shows; the small changes are {bound:.2g} deg')


def _measure_step(step_deg: float, limit: float) -> Measurement:
    # A step is found from differences of readings, so it is known to their rounding.
    half = limit if math.isclose(0.5 * step_deg, limit) else 0.5 * step_deg
    return Measurement(half, half, half, 0.0 if half > limit else 1.0, True,
                       f'the TS reports in steps of {step_deg:.4g} deg')


def settle_resolution(tests: Sequence[JudgedTest], changes: Mapping[int, int],
                      risks: TestRisks) -> tuple[JudgedTest, ...]:
    """
    Return the tests of a run with the resolution of a TS that was interpolated.

    Parameters
    ----------
    tests
        As its pairs show them.
    changes
        Changes of value of the TS as sent, by step; see `find_decimal_step`.
    risks
        Of each test.

    """
    if sum(changes.values()) < _LEAST_CHANGES:
        return tuple(tests)
    step_deg = find_decimal_step(changes) or _FINEST_STEP_DEG
    return tuple(
        test.with_measurement(_measure_step(step_deg, test.limit), risks)
        if test.kind == 'resolution' and test.record == _HIDDEN else test for test in tests)
