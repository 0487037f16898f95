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

"""Means of groups: against a plain loop, and their intervals against known errors."""

from __future__ import annotations

import numpy as np
import pytest

from heading_intercompare.core.statistics.group_means import estimate_group_means


def legs(leg, turn, count):
    """Return the group of each second on legs of eight groups, with turns between."""
    return np.concatenate([np.concatenate((np.full(leg, at % 8), np.full(turn, -1)))
                           for at in range(count)])


def estimate(x, group, systematic=0.0):
    return estimate_group_means(x, group, np.ones(x.size), 8, systematic + np.zeros(x.size))


def test_means_and_weights_by_hand():
    """Group 0: (1 + 2 * 4) / 3; group 1 is empty; -1 is in no group."""
    means = estimate_group_means(np.array([1.0, 4.0, 50.0, np.nan]), np.array([0, 0, 2, -1]),
                                 np.array([1.0, 2.0, 1.0, 0.0]), 3, np.zeros(4))
    assert means.n.tolist() == [3.0, 0.0, 1.0]
    assert means.mean_deg.tolist() == pytest.approx([3.0, np.nan, 50.0], nan_ok=True)
    assert np.isnan(means.half_width_deg).all()


def test_white_errors_give_the_interval_of_independent_values(rng):
    x, group = rng.standard_normal(8000), legs(90, 10, 80)
    half_width = estimate(x, group).half_width_deg
    assert half_width == pytest.approx(1.96 / np.sqrt(900.0), rel=0.15)


@pytest.mark.slow
@pytest.mark.parametrize(('leg', 'turn', 'count'), [(600, 60, 16), (120, 30, 32), (60, 30, 80)])
@pytest.mark.parametrize('tau', [0.5, 5.0, 20.0])
def test_19_of_20_intervals_hold_the_mean(ar1, leg, turn, count, tau):
    """White and AR(1); 300 trials of eight means: 95 % within 3 % and some for one estimate."""
    group = legs(leg, turn, count)
    holds, known = 0, 0
    for _ in range(300):
        means = estimate(ar1(group.size, tau), group)
        known += int(np.isfinite(means.half_width_deg).sum())
        holds += int((np.abs(means.mean_deg) < means.half_width_deg).sum())
    assert known > 0.95 * 2400
    assert 0.92 < holds / known < 0.98


def test_many_short_visits_are_worth_more_than_one_long_one(ar1):
    """Errors of a minute: sixteen visits a group against one of the same time."""
    x = ar1(16 * 8 * 100, 60.0)
    visits, stay = estimate(x, legs(80, 20, 128)), estimate(x, np.repeat(np.arange(8), 1600))
    assert (visits.half_width_deg < stay.half_width_deg).all()


def test_errors_as_slow_as_the_visits_have_no_interval(ar1):
    means = estimate(ar1(8 * 600, 600.0), np.repeat(np.arange(8), 600))
    assert np.isfinite(means.mean_deg).all()
    assert np.isnan(means.half_width_deg).all()


def test_a_systematic_part_stays_in_the_means_alone(rng):
    x, group = rng.standard_normal(8000), legs(90, 10, 80)
    wave = np.sin(np.arange(8000) / 500.0)
    means, plain = estimate(x + wave, group, wave), estimate(x, group)
    assert means.half_width_deg == pytest.approx(plain.half_width_deg)
    assert means.mean_deg == pytest.approx(estimate(x + wave, group).mean_deg)
    assert not np.allclose(means.mean_deg, plain.mean_deg)


def test_a_group_that_scatters_more_has_a_wider_interval(rng):
    x, group = rng.standard_normal(8000), legs(90, 10, 80)
    x[group == 3] *= 3.0
    half_width = estimate(x, group).half_width_deg
    assert half_width[3] > 2.0 * half_width[0]


def test_values_that_never_differ_have_no_interval():
    assert np.isnan(estimate(np.full(800, 0.1), legs(90, 10, 8)).half_width_deg).all()
