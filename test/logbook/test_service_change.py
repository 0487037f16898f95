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

"""Runs before a service against runs after it."""

from __future__ import annotations

import math

from logbook.made_up_rows import DAY_NS, make_row, T0_NS
import numpy as np
import pytest

from heading_intercompare.logbook.service_change import compare_service


def rows_of(means, sds=None, **given):
    """Return a run a day with these means and standard deviations."""
    sds = np.full(len(means), 0.2) if sds is None else sds
    return [make_row(day, mean_deg=float(mean), sd_deg=float(sd), **given)
            for day, (mean, sd) in enumerate(zip(means, sds))]


def test_the_interval_by_hand():
    """
    Means 0.1, 0.2, 0.3 before and 0.6, 0.7, 0.8 after, u negligible.

    Each side has s = 0.1 and the variance 0.01 / 3; together u = sqrt(0.02 / 3) = 0.0816497, with
    4 degrees of freedom: 0.5 ± 2.776445 · 0.0816497 = 0.5 ± 0.226696.
    """
    mean, sd = compare_service(rows_of([0.1, 0.2, 0.3, 0.6, 0.7, 0.8], mean_u_deg=1e-6),
                               T0_NS + 3 * DAY_NS)
    assert (mean.before, mean.after, mean.left_out) == (3, 3, 0)
    assert mean.change == pytest.approx(0.5)
    assert (mean.low, mean.high) == pytest.approx((0.5 - 0.226696, 0.5 + 0.226696), abs=1e-5)
    assert mean.differs and mean.p < 0.05
    assert sd.change == pytest.approx(1.0) and not sd.differs


def test_one_run_on_a_side_has_only_its_own_uncertainty():
    """0.1 ± 0.03 and 0.2 ± 0.04: 0.1 ± 1.959964 · 0.05."""
    mean, _ = compare_service([make_row(0, mean_deg=0.1, mean_u_deg=0.03),
                               make_row(1, mean_deg=0.2, mean_u_deg=0.04)], T0_NS + DAY_NS)
    assert (mean.low, mean.high) == pytest.approx((0.1 - 0.0979982, 0.1 + 0.0979982), abs=1e-6)
    assert mean.one_run and 'a side has one run' in mean.words


def test_the_factor_of_the_standard_deviation_by_hand():
    """ln(0.4 / 0.2) ± 1.959964 sqrt(2 / (2 · 200)): 2 exp(± 0.138590)."""
    rows = [make_row(0, sd_deg=0.2, nu=200.0), make_row(1, sd_deg=0.4, nu=200.0)]
    sd = compare_service(rows, T0_NS + DAY_NS)[1]
    assert sd.change == pytest.approx(2.0)
    assert sd.high == pytest.approx(2.0 * math.exp(0.138590), rel=1e-5)
    assert sd.differs and 'by the factor 2.000' in sd.words


def test_runs_over_the_service_and_void_ones_are_left_out():
    rows = rows_of([0.1] * 5)
    rows[1] = make_row(1, validity_effect='void')
    mean, _ = compare_service(rows, T0_NS + 2 * DAY_NS + DAY_NS // 2)
    assert (mean.before, mean.after, mean.left_out) == (1, 2, 2)


@pytest.mark.parametrize('at_day', [-1, 9])
def test_without_runs_on_both_sides_nothing_is_decided(at_day):
    for change in compare_service(rows_of([0.1] * 5), T0_NS + at_day * DAY_NS):
        assert change.change is None and change.words.startswith('cannot decide: the ')
    assert [c.differs for c in compare_service([], T0_NS)] == [None, None]


@pytest.mark.parametrize('before, after, r', [(3, 3, 0.0), (10, 5, 0.0), (20, 10, 0.4)])
def test_an_unchanged_sensor_differs_in_five_percent_of_trials_at_most(rng, before, after, r):
    """1000 trials; six standard errors at 5 % are 0.041. Runs may be correlated."""
    trials, n, wrong = 1000, before + after, 0
    noise = rng.standard_normal((trials, n))
    for k in range(1, n):
        noise[:, k] = r * noise[:, k - 1] + math.sqrt(1.0 - r * r) * noise[:, k]
    for row in noise:
        wrong += bool(compare_service(rows_of(0.1 + 0.05 * row, mean_u_deg=0.01),
                                      T0_NS + before * DAY_NS)[0].differs)
    assert wrong / trials <= 0.05 + 0.041


def test_runs_with_their_own_uncertainty_do_not_agree_better_than_that(rng):
    """Equal means by chance do not make the interval narrow."""
    mean, _ = compare_service(rows_of([0.1] * 4, mean_u_deg=0.1), T0_NS + 2 * DAY_NS)
    assert mean.high - mean.low > 0.2
