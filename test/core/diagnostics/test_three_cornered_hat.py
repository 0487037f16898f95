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

"""Three-cornered hats: by hand, on real logs, by simulation, and turned or renamed."""

from __future__ import annotations

import math

import numpy as np
import pytest

from heading_intercompare.core.diagnostics.three_cornered_hat import (
    at_common_stamps,
    three_cornered_hat,
)
from heading_intercompare.core.records import Headings


@pytest.mark.parametrize('kind, aligned, order', [('raw', False, 0), ('aligned', True, 0),
                                                  ('aligned_detrended', True, 1)])
def test_hats_of_the_palmer_agree_with_independent_programs(kind, aligned, order, logs, golden):
    expected = golden['hats'][0]
    sensors = [logs[expected[which]] for which in 'ABC']
    skew_s = (0.0, expected['LB'], expected['LC']) if aligned else None
    found = three_cornered_hat(*reversed(at_common_stamps(sensors, skew_s)), order)
    expected = expected[kind]
    assert found.n == expected['n']
    assert found.pairs == ((0, 1), (0, 2), (1, 2))
    assert found.pair_variance_deg2 == pytest.approx(
        [expected[k] for k in ('V_AB', 'V_AC', 'V_BC')], rel=1e-9)
    assert found.variance_deg2 == pytest.approx(
        [expected[k] for k in ('s2_A', 's2_B', 's2_C')], rel=1e-9)
    assert found.std_deg == tuple(s if s is None else pytest.approx(s, rel=1e-9)
                                  for s in expected['sigma'])


def test_a_hat_by_hand():
    """
    Differences 1-2: -1, 1, 0; 1-3: 1, -1, 0; 2-3: 2, -2, 0; variances 1, 1, 4.

    (1 + 1 - 4)/2 = -1 and (1 + 4 - 1)/2 = 2, twice; not negative: D_23 = 4 = 2 + 2 alone pulls
    both others to (1 + 4)/3 by least squares with s_1 = 0.
    """
    found = three_cornered_hat([[0.0, 0.0, 0.0], [1.0, -1.0, 0.0], [-1.0, 1.0, 0.0]])
    assert found.pair_variance_deg2 == pytest.approx((1.0, 1.0, 4.0))
    assert found.variance_deg2 == pytest.approx((-1.0, 2.0, 2.0))
    assert found.std_deg == (None, pytest.approx(math.sqrt(2.0)), pytest.approx(math.sqrt(2.0)))
    assert found.point_deg2 == pytest.approx((0.0, 5.0 / 3.0, 5.0 / 3.0))
    assert found.interval_deg2 is None


def test_the_variance_is_the_covariance_of_two_differences(rng):
    heading = rng.standard_normal((3, 500))
    found = three_cornered_hat(heading)
    x, y = heading[0] - heading[1], heading[0] - heading[2]
    assert found.variance_deg2[0] == pytest.approx(np.cov(x, y)[0, 1], rel=1e-9)


@pytest.mark.parametrize('sigma', [(0.1, 0.2, 0.05), (0.1, 0.2, 0.05, 0.3)])
def test_intervals_hold_the_truth(sigma, ar1):
    """Of 150 intervals at 95 %, 126 are six standard errors too few."""
    n = 3000
    truth = np.array(sigma) ** 2
    held = np.zeros(len(sigma))
    for _ in range(150):
        heading = 359.9 + np.array([s * ar1(n, 5.0) for s in sigma])
        found = three_cornered_hat(heading % 360.0)
        low, up = np.array(found.interval_deg2).T
        held += (low <= truth) & (truth <= up)
    assert (held >= 126).all()


def test_the_heading_of_the_ship_cancels(rng, yaw):
    noise = 0.1 * rng.standard_normal((3, 400))
    a = three_cornered_hat(noise)
    b = three_cornered_hat((noise + yaw(np.arange(400) / 10.0) + 200.0) % 360.0)
    assert b.variance_deg2 == pytest.approx(a.variance_deg2, rel=1e-9)


def test_sensors_may_change_places(rng):
    heading = rng.standard_normal((4, 300)) * [[1.0], [2.0], [3.0], [4.0]]
    a, b = three_cornered_hat(heading), three_cornered_hat(heading[::-1])
    assert b.variance_deg2[::-1] == pytest.approx(a.variance_deg2, rel=1e-9)


def test_common_stamps_are_those_within_all_sensors():
    one = Headings.as_sent(np.arange(0, 100, 10) * 10 ** 9, np.arange(0, 100, 10) % 360.0)
    two = Headings.as_sent(np.arange(15, 85, 5) * 10 ** 9, np.arange(15, 85, 5) + 1.0)
    stamps, heading = at_common_stamps([one, two], (0.0, 2.0))
    assert (stamps // 10 ** 9).tolist() == [20, 30, 40, 50, 60, 70, 80]
    assert heading[1] - heading[0] == pytest.approx(-1.0)
    stamps, heading = at_common_stamps([Headings.empty(), two])
    assert (stamps.size, heading.shape) == (0, (2, 0))


@pytest.mark.parametrize('shape', [(2, 10), (3, 1), (3,)])
def test_too_few_sensors_or_readings_are_refused(shape):
    with pytest.raises(ValueError, match='at least 3 sensors'):
        three_cornered_hat(np.zeros(shape))


def test_a_polynomial_needs_stamps():
    with pytest.raises(ValueError, match='order = 1'):
        three_cornered_hat(np.zeros((3, 10)), order=1)


def test_equal_sensors_have_no_variance():
    found = three_cornered_hat(np.full((3, 50), 7.0))
    assert found.variance_deg2 == (0.0, 0.0, 0.0)
    assert found.std_deg == (0.0, 0.0, 0.0)
