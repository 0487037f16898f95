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

"""The variance of a run and how well it is known, from the figures of its verdict."""

from __future__ import annotations

import math

from heading_intercompare.core.statistics.variance_uncertainty import Spread

from .verdict_document import RunVerdict

#: Half-periods in the slow part of a variance, S.8.
_LOW_MODES = 4


def spread_of_run(run: RunVerdict) -> Spread | None:
    """Return the variance of a run and how well it is known; None if it is not known."""
    guarded, order = run.guarded, max(0, len(run.drift_coefficients_deg) - 1)
    if guarded.d_hat_deg2 is None or guarded.nu is None or guarded.f is None:
        return None
    ratio, slow = guarded.r_slow or 0.0, guarded.slow_variance_deg2 or 0.0
    # Only the ratio and the difference of these two count, and only if there is a slow part.
    middle = slow / _LOW_MODES / (ratio - 1.0) if slow > 0.0 and 1.0 < ratio < math.inf else 0.0
    u_deg = guarded.bias_u_deg or 0.0
    return Spread(
        n=run.n, order=order, d_deg2=guarded.d_hat_deg2, mean_variance_deg2=u_deg ** 2,
        s_deg2=guarded.d_hat_deg2 * math.sqrt(2.0 / guarded.nu) if guarded.nu else math.inf,
        nu=guarded.nu, f=guarded.f,
        corner_j=math.inf if guarded.corner_j is None else guarded.corner_j,
        low_deg2=middle + slow / _LOW_MODES, middle_deg2=middle)
