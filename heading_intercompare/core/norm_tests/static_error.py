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

"""The static error: the mean difference on steady headings."""

from __future__ import annotations

import math

from .judged_test import Measurement
from .tested_run import exceeding, reach, TestedRun


def measure_static_error(tested: TestedRun, limit: float) -> Measurement:
    """
    Return the size of the mean difference.

    The error may exceed its limit on either side, so half of the risk of a false rejection
    belongs to each.

    References
    ----------
    MSC.116(73) 3.6 and 4.3.2.2.

    """
    mean, u, nu = tested.mean_deg, tested.mean_u_deg, tested.mean_nu
    if mean is None or u is None:
        return Measurement(record='too few differences')
    return measure_mean(tested, mean, u, nu, limit, 'the mean difference of the run')


def measure_mean(tested: TestedRun, mean: float, u: float, nu: float, limit: float,
                 record: str) -> Measurement:
    """Return what a mean difference with its standard uncertainty shows of a systematic error."""
    size, risks = abs(mean), tested.risks
    risk = 2.0 * exceeding((size - limit) / u, nu) if u > 0.0 else float(size <= limit)
    unless = '' if tested.is_mounting_stated else (
        f'the sensors are mounted {mean:.2f} deg apart: state installation_offset_deg and '
        'installation_offset_u_deg')
    return Measurement(
        size, max(0.0, size - reach(0.5 * risks.not_met, nu) * u),
        size + reach(risks.met, nu) * u, min(1.0, risk), True,
        record if math.isinf(nu) or u == 0.0 else f'{record}, u = {u:.2g} deg', unless)
