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

"""
What the analysis estimates is what was simulated, within the uncertainty that it states.

Each test looks at `SEEDS` trials of 20 min that differ by their seed only: TS with white and
coloured noise of 0.1 degrees together, RS with 0.05 degrees, a reading each quarter of a second.
An interval that holds the truth with the probability it claims fails `often_enough` once in a
million; six standard errors are left twice in 10^9.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import binom

from heading_intercompare import analyze, Headings, Settings
from heading_intercompare.ahrs.settings import Scenario
from heading_intercompare.ahrs.simulator import Simulation

pytestmark = pytest.mark.slow

SEEDS = 48
DURATION_S = 1200.0
SIGMA_TS_DEG, SIGMA_RS_DEG = 0.1, 0.05
TURNS = '; '.join(f'{60 * i} {60 * (i % 2)} 12' for i in range(20))


def runs(skew='off', legs='0 0 12', **ts):
    """Return the run of each trial as the JSON has it."""
    settings = Settings.from_mapping({
        'norms.sigma_max_deg': 0.3, 'norms.sigma_ref_max_deg': 0.1,
        'norms.sigma_ref_deg': SIGMA_RS_DEG, 'alignment.skew': skew})
    found = []
    for seed in range(SEEDS):
        chunk, *rest = Simulation(Scenario.from_mapping({
            'duration_s': DURATION_S, 'seed': seed, 'legs': legs,
            'ts': {'rate_hz': 4.0, 'white_deg': 0.08, 'markov_deg': 0.06, 'markov_tau_s': 2.0,
                   **ts},
            'rs': {'rate_hz': 4.0, 'white_deg': SIGMA_RS_DEG}})).chunks(DURATION_S)
        assert not rest
        ts_read, rs_read = (Headings.of(read.stamp_ns, read.heading_deg)
                            for read in (chunk.ts, chunk.rs))
        found.append(analyze(ts_read, rs_read, settings).to_dict()['runs'][0])
    return found


def unbiased(estimates, truth):
    """Tell whether the mean of the estimates is the truth within six standard errors."""
    estimates = np.asarray(estimates)
    return abs(estimates.mean() - truth) < 6.0 * estimates.std() / np.sqrt(estimates.size)


def often_enough(hits, probability):
    """Tell whether there are at least as many hits as in all but one case in a million."""
    return np.sum(hits) >= binom.ppf(1e-6, len(hits), probability)


def honest(estimates, uncertainties):
    """Tell whether the stated uncertainty is the scatter, within six standard errors of that."""
    stated = np.sqrt(np.mean(np.square(uncertainties)))
    return abs(np.std(estimates) / stated - 1.0) < 6.0 / np.sqrt(2.0 * SEEDS)


@pytest.fixture(scope='module')
def steady():
    """Return runs of a TS that is off by 0.2 degrees."""
    return runs(offset_deg=0.2)


def test_mean_is_the_offset(steady):
    means = [run['mean_deg'] for run in steady]
    assert unbiased(means, 0.2)
    assert honest(means, [run['guarded']['bias_u_deg'] for run in steady])
    intervals = np.array([run['guarded']['bias_interval_deg'] for run in steady])
    assert often_enough((intervals[:, 0] <= 0.2) & (0.2 <= intervals[:, 1]), 0.95)
    assert np.ptp(intervals, axis=1).max() < 0.05


def test_sigma_of_the_ts_is_what_is_left_of_the_variance(steady):
    """sqrt(D - sigma_ref^2), and both one-sided bounds at 95 %."""
    d = np.array([run['guarded']['d_hat_deg2'] for run in steady])
    assert unbiased(np.sqrt(d - SIGMA_RS_DEG**2), SIGMA_TS_DEG)
    lower, upper = (np.array([run['guarded'][f'sigma_ts_{end}_deg'] for run in steady])
                    for end in ('lower', 'upper'))
    assert often_enough(lower <= SIGMA_TS_DEG, 0.95)
    assert often_enough(upper >= SIGMA_TS_DEG, 0.95)
    assert 0.9 * SIGMA_TS_DEG < lower.mean() < upper.mean() < 1.1 * SIGMA_TS_DEG


def test_slope_is_the_drift():
    lines = [run['drift']['line'] for run in runs(drift_deg_h=0.6)]
    slopes = np.array([line['slope_deg_per_h'] for line in lines])
    stated = np.array([line['u_deg_per_h'] for line in lines])
    assert unbiased(slopes, 0.6)
    assert honest(slopes, stated)
    assert often_enough(np.abs(slopes - 0.6) < 2.0 * stated, 0.95)


def test_skew_is_the_error_of_the_stamps():
    """Turns of 60 degrees each minute; stamps 0.15 s late are a skew of 0.15 s."""
    estimates = [run['skew']['estimate'] for run in runs('report', TURNS, stamp_offset_s=0.15)]
    assert all(estimate['well_determined'] for estimate in estimates)
    skews = [estimate['skew_s'] for estimate in estimates]
    assert unbiased(skews, 0.15)
    assert honest(skews, [estimate['u_s'] for estimate in estimates])
    intervals = np.array([estimate['interval_s'] for estimate in estimates])
    assert often_enough((intervals[:, 0] <= 0.15) & (0.15 <= intervals[:, 1]), 0.95)
