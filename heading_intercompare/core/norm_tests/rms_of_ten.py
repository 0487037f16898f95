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

"""The rms of ten readings about their mean, pooled over the sets of a run."""

from __future__ import annotations

import math

from heading_intercompare.core import lazy_scipy as scipy
from heading_intercompare.core.count_words import count_words

from .judged_test import Measurement
from .sets_of_ten import pool_variances
from .tested_run import NO_SETS, TestedRun


def measure_rms_of_ten(tested: TestedRun, limit: float) -> Measurement:
    """
    Return the standard deviation of the readings about the mean of their set.

    Notes
    -----
    Each set adds nine degrees of freedom; chi-square bounds the variance. The part of the RS is
    taken out of the bounds as in GK: in squares, its most from the lower, its least from the
    upper. The bounds hold for readings that do not depend on each other after 20 min.

    References
    ----------
    A.821(19) 4.1.2.

    """
    sets = tested.sets_of_ten
    if not sets:
        return Measurement(record=NO_SETS)
    variance, nu = pool_variances([ten.variance_deg2 for ten in sets])
    most, least = (tested.reference_deg(upper) ** 2 for upper in (True, False))
    low, high = (variance * nu / float(scipy.special.chdtri(nu, share))
                 for share in (tested.risks.not_met, 1.0 - tested.risks.met))
    at_limit = limit ** 2 + most
    return Measurement(
        math.sqrt(variance), math.sqrt(max(0.0, low - most)), math.sqrt(max(0.0, high - least)),
        float(scipy.special.chdtrc(nu, variance * nu / at_limit)), True,
        f'{count_words(len(sets), "set")} of ten readings')
