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

"""The resolution of headings: of real sensors, of made-up steps, and of none."""

from __future__ import annotations

import math

import numpy as np
import pytest

from heading_intercompare.core.statistics.resolution import find_resolution


@pytest.mark.parametrize('name, step_deg', [('gyr1', 0.01), ('s330', 0.01), ('adcp', 0.1),
                                            ('lgyr', 0.1), ('lsep', 0.01)])
def test_steps_of_real_sensors(name, step_deg, logs):
    assert find_resolution(logs[name].heading_deg).step_deg == pytest.approx(step_deg, rel=1e-9)


def test_values_of_the_gould_gyro_repeat_as_they_do_in_the_log(logs):
    heading = logs['lgyr'].heading_deg
    assert find_resolution(heading).repeated_share == pytest.approx(np.mean(np.diff(
        heading) == 0.0))


@pytest.mark.parametrize('step_deg', [1.0, 0.1, 0.01, math.degrees(1e-4), 360.0 / 4096])
def test_any_step_is_found_also_over_north(step_deg, rng):
    heading = np.cumsum(rng.standard_normal(3000))
    found = find_resolution(np.rint(heading / step_deg) * step_deg % 360.0)
    assert found.step_deg == pytest.approx(step_deg, rel=1e-6)
    assert found.variance_deg2 == pytest.approx(step_deg ** 2 / 12.0, rel=1e-5)


def test_rounding_of_a_sum_does_not_hide_the_step(rng):
    """The TS heading of pairs is RS + difference: off by some 1e-14."""
    heading = np.round(100.0 + 3.0 * np.sin(np.arange(2000) / 7.0), 2)
    rs = rng.uniform(0.0, 360.0, 2000)
    found = find_resolution(rs + (heading - rs))
    assert found.step_deg == pytest.approx(0.01, rel=1e-9)
    assert found.repeated_share == pytest.approx(np.mean(np.diff(heading) == 0.0))


def test_continuous_headings_have_no_step(rng):
    for n in (30, 1000, 30_000):
        assert find_resolution(np.cumsum(rng.standard_normal(n)) % 360.0).step_deg is None


@pytest.mark.parametrize('heading, share', [([], None), ([5.0], None), ([5.0] * 30, 1.0),
                                            ([1.0, 2.0], 0.0)])
def test_too_few_changes_show_no_step(heading, share):
    found = find_resolution(heading)
    assert (found.n, found.step_deg, found.repeated_share) == (len(heading), None, share)
    assert found.variance_deg2 == 0.0


def test_rounding_adds_a_twelfth_of_the_step_squared(rng):
    """Sheppard: sd at least half a step; six standard errors of a sample variance."""
    x = 0.1 * rng.standard_normal(200_000)
    added = np.round(x, 1).var() - x.var()
    assert added == pytest.approx(0.1 ** 2 / 12.0, abs=6.0 * 0.01 * math.sqrt(2.0 / x.size))
