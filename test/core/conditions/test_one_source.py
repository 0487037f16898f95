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

"""Signs of one source together: for it, against it, and inconclusive."""

from __future__ import annotations

import numpy as np
import pytest

from heading_intercompare.core.conditions.common_glitches import CommonGlitches
from heading_intercompare.core.conditions.common_noise import CommonNoise, FollowedNoise
from heading_intercompare.core.conditions.one_source import find_one_source, OneSource, SameSource

N = 12_000
T_S = np.arange(N) / 10.0
STAMPS = np.rint(T_S * 1e9).astype(np.int64)


def signs(ts, rs, **more):
    return find_one_source(STAMPS, ts - rs, rs % 360.0, **more)


@pytest.fixture
def true():
    """Return the heading of a ship that turns and yaws, degrees."""
    return 90.0 + 40.0 * np.sin(2.0 * np.pi * T_S / 600.0) + np.sin(2.0 * np.pi * T_S / 8.0)


@pytest.mark.parametrize('rounding, noise, glitches, kind', [
    (True, 'common', 'independent', 'common'), (False, 'independent', 'common', 'common'),
    (True, 'independent', 'not_testable', 'independent'),
    (True, 'of the RS', 'not_testable', 'not_testable'),
    (False, 'unsure', 'independent', 'unsure'),
    (True, 'not_testable', 'independent', 'independent'),
    (True, 'not_testable', 'not_testable', 'suspected'),
    (False, 'not_testable', 'not_testable', 'not_testable'),
    (None, 'not_testable', 'not_testable', 'not_testable')])
def test_what_the_signs_say_together(rounding, noise, glitches, kind):
    of_rs = FollowedNoise('independent' if noise == 'of the RS' else noise)
    of_ts = FollowedNoise('not_testable' if noise == 'of the RS' else noise)
    assert OneSource(SameSource(rounding, 0.01, 0.01), CommonNoise(of_rs=of_rs, of_ts=of_ts),
                     CommonGlitches(glitches)).kind == kind


@pytest.mark.parametrize('decimals', [1, 2, 9])
def test_two_perfect_sensors_are_suspected_not_convicted(true, decimals):
    """As is a copy of a sensor without noise: no pair of headings tells them apart."""
    both = np.round(true, decimals)
    assert signs(both, both).kind == 'suspected'


def test_a_coarse_sensor_without_noise_is_its_own(true, rng):
    """The differences are those of rounding to 0.1 deg, but hold no noise of the RS."""
    ts, rs = np.round(true, 1), true + 0.01 * rng.standard_normal(N)
    found = signs(ts, rs)
    assert not found.readings.suspected and found.noise.of_rs.kind == 'independent'


def test_glitches_alone_show_one_source(true):
    rs = np.round(true, 2)
    rs[[900, 2500, 4100, 6000]] += [3.0, -4.0, 5.0, 3.5]
    found = signs(np.concatenate((rs[:7], rs[:-7])), rs)
    assert (found.noise.kind, found.kind) == ('not_testable', 'common')


def test_steps_and_interpolation_follow_from_the_pairs(true, rng):
    """Rounding to 0.1 deg at the same stamps is no noise of the RS, whatever steps are passed."""
    rs = true + 0.05 * rng.standard_normal(N)
    assert signs(rs, rs, factor=np.ones(N)).kind == 'common'
    found = signs(rs, rs, factor=np.full(N, 0.625), interpolates_ts=True)
    assert found.noise.of_rs == signs(rs, rs).noise.of_rs and found.kind == 'common'


def test_too_few_pairs_tell_nothing():
    none = np.empty(0)
    assert find_one_source(none.astype(np.int64), none, none).kind == 'not_testable'
