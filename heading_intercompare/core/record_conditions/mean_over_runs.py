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

"""The condition that in variant B the systematic error is the same in every run."""

from __future__ import annotations

import math

from heading_intercompare.core.diagnostics.assumptions import SMALL_OFFSET
from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.statistics.stationarity import Homogeneity
from heading_intercompare.core.validity.condition import Condition, DOUBTFUL, Finding, HOLDS

MEAN_OVER_RUNS = Condition(
    name='mean_over_runs',
    holds='in variant B the systematic error is the same in every run',
    doubtful_when='in variant B the mean differs from run to run, significantly and by more than '
                  'a third of σ_max (standard deviation): variant C allows that, and the headline '
                  'says what it decides')


def judge_mean_over_runs(runs: Homogeneity, sigma_max_deg: float,
                         in_variant_c: Outcome) -> Finding | None:
    """
    Judge the means of several runs, which variant B takes for one.

    Parameters
    ----------
    runs
        The means and variances of the runs compared.
    sigma_max_deg
        Norm of the TS, degrees.
    in_variant_c
        What variant C decides.

    Returns
    -------
    Finding or None
        None for a single run.

    """
    if runs.m < 2:
        return None
    between_deg = math.sqrt(runs.between_variance_deg2 or 0.0)
    figures = f'{runs.m} runs: equal means have p = {runs.q_p:.2g}'
    if runs.means_equal or between_deg <= SMALL_OFFSET * sigma_max_deg:
        return MEAN_OVER_RUNS.find(HOLDS, '', figures)
    words = (f'the mean differs from run to run by {between_deg:.2g} deg, and variant B takes it '
             f'for the same; by variant C {in_variant_c.words}')
    return MEAN_OVER_RUNS.find(DOUBTFUL, words, f'{figures}; {words}')
