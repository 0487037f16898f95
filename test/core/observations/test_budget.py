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

"""The uncertainty budget of a mean correction."""

from __future__ import annotations

import math

from core.observations.make_corrections import corrections
import numpy as np
import pytest

from heading_intercompare.core.observations.systematic_error import make_budget


def component(budget, name):
    """Return a component by its name; None without it."""
    return next((c for c in budget.components if c.name == name), None)


def test_the_budget_by_hand():
    """
    C - O of 0.1, 0.2, 0.3: s = 0.1, s / sqrt(3) = 0.057735 with 2 degrees of freedom.

    Shared: 0.05, and steps of 0.1 deg give 0.1 / sqrt(12) = 0.028868. Together
    sqrt(0.0033333 + 0.0025 + 0.00083333) = 0.081650. Effective degrees of freedom:
    0.0816497^4 / (0.0577350^4 / 2) = 8.
    """
    budget = make_budget(corrections([0.1, 0.2, 0.3], step_deg=0.1), common_u_deg=0.05)
    assert [c.name for c in budget.components] == ['observations', 'common', 'rounding']
    assert component(budget, 'observations').u_deg == pytest.approx(0.0577350)
    assert budget.u_deg == pytest.approx(0.0816497)
    assert budget.u_shared_deg == pytest.approx(math.hypot(0.05, 0.0288675))
    assert budget.nu == pytest.approx(8.0)


def test_a_shared_error_is_not_averaged_away():
    """With 10 000 observations nothing but the shared 0.2 deg is left."""
    x = np.tile([-0.3, 0.3], 5000)
    assert make_budget(corrections(x), common_u_deg=0.2).u_deg == pytest.approx(0.2, rel=2e-4)


def test_a_stated_uncertainty_only_widens():
    """0.3 stated of each of 4: 0.15 instead of the smaller scatter; 1e-6 changes nothing."""
    x = [0.1, 0.11, 0.1, 0.09]
    wide = component(make_budget(corrections(x, u_deg=0.3), common_u_deg=0.0), 'observations')
    assert wide.u_deg == pytest.approx(0.15) and wide.nu == 3.0 and 'stated' in wide.words
    small = make_budget(corrections(x, u_deg=1e-6), common_u_deg=0.0)
    assert small.u_deg == pytest.approx(np.std(x, ddof=1) / 2.0)


def test_a_slow_clock_counts_by_the_mean_rate_of_turn():
    """All observations at -0.1 deg/s and a clock known to 2 s: 0.2 deg, however many."""
    found = make_budget(corrections(np.zeros(50), rate_deg_s=-0.1), common_u_deg=0.0,
                        clock_u_s=2.0)
    assert component(found, 'clock').u_deg == pytest.approx(0.2)


def test_slow_errors_have_the_variance_of_the_mean_of_an_ar_1_process(rng):
    """Simulated: ten instants of 20 min, tau = 40 min; the plain loop sums exp(-|dt| / tau)."""
    sigma, tau_s, step_s, n = 0.25, 2400.0, 1200.0, 10
    phi = math.exp(-step_s / tau_s)
    e = rng.standard_normal((n, 40_000))
    for k in range(1, n):
        e[k] = phi * e[k - 1] + math.sqrt(1.0 - phi ** 2) * e[k]
    simulated = sigma * e.mean(axis=0).std()
    found = make_budget(corrections(np.zeros(n), step_s=step_s), common_u_deg=0.0,
                        slow=(sigma, tau_s))
    assert component(found, 'slow_errors').u_deg == pytest.approx(simulated, rel=0.025)


def test_the_installation_angle_is_shared():
    found = make_budget(corrections([0.0, 0.1]), common_u_deg=0.0, offset_u_deg=0.4)
    assert component(found, 'installation').u_deg == 0.4
    assert component(found, 'common') is None
