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

"""The condition that no error is removed as a drift."""

from __future__ import annotations

import numpy as np

from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.validity.condition import Condition, DOUBTFUL, Finding, HOLDS
from heading_intercompare.core.validity.examined import Examined


def _judge(e: Examined) -> Finding | None:
    c = e.columns
    if c.residual_deg is None:
        return None
    range_deg = float(np.ptp(c.x_deg - c.residual_deg))
    words = f'a drift over {range_deg:.2g} deg is removed (drift_order)'
    if range_deg <= c.limits.sigma_max_deg:
        return DRIFT_REMOVED.find(HOLDS, '', f'{words}, less than sigma_max')
    left_in = e.decide(c.stamp_ns, c.x_deg, drift_order=0)
    words = f'{words}, with it left in {left_in.words}'
    if left_in is e.outcome or e.outcome is Outcome.INDETERMINATE:
        return DRIFT_REMOVED.find(HOLDS, words, words)
    return DRIFT_REMOVED.find(DOUBTFUL, words, words)


DRIFT_REMOVED = Condition(
    name='drift_removed',
    holds='no error is removed as a drift',
    doubtful_when='`drift_order` removes a drift over more than σ_max, and with that left in the '
                  'outcome would differ',
    judge=_judge, also_said='always')
