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

"""The settle-point error: the mean of ten readings after the TS has settled."""

from __future__ import annotations

import math

from heading_intercompare.core.count_words import count_words

from .judged_test import Measurement
from .sets_of_ten import pool_variances, READINGS
from .static_error import measure_mean
from .tested_run import NO_SETS, TestedRun


def measure_settle_point(tested: TestedRun, limit: float) -> Measurement:
    """
    Return the size of the settle-point error of the worst set of ten readings.

    Notes
    -----
    Each set has a settle point of its own, for the limit holds at any heading. The sets share the
    variance of their readings, and the risk of a false rejection.

    References
    ----------
    A.821(19) 2.5 and 4.1.2.

    """
    sets = tested.sets_of_ten
    if not sets:
        return Measurement(record=NO_SETS)
    variance, nu = pool_variances([ten.variance_deg2 for ten in sets])
    worst = max(sets, key=lambda ten: abs(ten.mean_deg))
    u = math.hypot(math.sqrt(variance / READINGS), tested.settings.installation_offset_u_deg)
    record = (f'the worst of {count_words(len(sets), "set")} of ten readings, on a heading of '
              f'{worst.heading_deg:.0f} deg')
    return measure_mean(tested, worst.mean_deg, u, nu, limit, record, len(sets))
