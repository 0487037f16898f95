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

"""The settling time: how long after its start a TS settles."""

from __future__ import annotations

from .judged_test import Measurement
from .settling import APART_MIN, find_settling
from .tested_run import TestedRun


def measure_settling_time(tested: TestedRun, limit: float) -> Measurement:
    """
    Return the time from the first reading to the third that shows the TS settled, hours.

    Notes
    -----
    The figure has no risk: its bounds are the first and the third of the three readings. A norm
    that counts to the first one is met if this figure keeps the limit, and not met only if the
    first reading came too late.

    References
    ----------
    A.821(19) 4.1.1; draft of ISO 22090-1, 3.10.

    """
    if not tested.run.holds_start:
        return Measurement(record='the run does not begin with a start: the clock cut it off, or '
                                  'runs.stabilization_s leaves the start out')
    settling = find_settling(tested.run.stamp_ns.values, tested.run.x_deg.values)
    if settling is None:
        return Measurement(record='less than an hour of differences')
    if settling.first_min == 0:
        return Measurement(record='settled from the first reading on, so it shows no start')
    if settling.first_min is None or settling.third_min is None:
        span_h = settling.span_min / 60.0
        low = span_h - 2.0 * APART_MIN / 60.0
        return Measurement(span_h, low, None, float(low <= limit), True,
                           f'not settled in {span_h:.1f} h')
    low, high = settling.first_min / 60.0, settling.third_min / 60.0
    return Measurement(high, low, high, float(low <= limit), True,
                       f'settled at the readings from {low:.1f} to {high:.1f} h')
