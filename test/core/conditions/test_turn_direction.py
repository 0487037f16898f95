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

"""The direction of turn: by hand, in the yaw on a steady course, at any skew, with noise."""

from __future__ import annotations

import numpy as np
import pytest

from heading_intercompare.core.angles import wrap180
from heading_intercompare.core.conditions.conventions import find_turn_direction


def found_of(t_s, ts_deg, rs_deg):
    return find_turn_direction(np.rint(t_s * 1e9).astype(np.int64), wrap180(ts_deg - rs_deg),
                               rs_deg % 360.0)


def test_the_direction_by_hand():
    """RS turns by 1 deg/s, TS by the same the other way: TS + RS does not change."""
    t = 0.25 * np.arange(40)
    assert found_of(t, -t, t) == ('against', 9.75, 0.0)
    assert found_of(t, t, t) == ('with', 9.75, None)


@pytest.mark.parametrize('yaw_deg', [0.1, 0.5, 2.0])
@pytest.mark.parametrize('sign, word', [(1.0, 'with'), (-1.0, 'against')])
def test_the_yaw_of_a_steady_course_tells(yaw_deg, sign, word, rng):
    """20 min near 45 deg, where TS + RS stays near 90, with noise of 0.1 and 0.05 deg."""
    t = np.arange(12_000) / 10.0
    yaw = yaw_deg * np.sin(2.0 * np.pi * t / 8.0)
    found = found_of(t, 45.0 + sign * yaw + 0.1 * rng.standard_normal(t.size),
                     45.0 + yaw + 0.05 * rng.standard_normal(t.size))
    assert found.word == word


def test_a_single_small_turn_tells(rng):
    t = np.arange(36_000) / 10.0
    turn = 2.0 * np.clip((t - 1000.0) / 20.0, 0.0, 1.0)
    noise = 0.1 * rng.standard_normal((2, t.size))
    assert found_of(t, 50.0 - turn + noise[0], 40.0 + turn + noise[1]).word == 'against'


def yawing(rng):
    """Return a heading by time that yaws at one frequency or a band of them, and may turn."""
    period_s, band = rng.uniform(5.0, 15.0), rng.choice([0.0, 0.1, 0.3])
    size = 10.0 ** rng.uniform(-1.5, 0.7)
    f = np.clip((1.0 + band * rng.standard_normal(8)) / period_s, 0.02, 0.2)
    phase = rng.uniform(0.0, 2.0 * np.pi, 8)
    turn, slow = rng.choice([0.0, 0.0, 3.0, 30.0]), rng.uniform(100.0, 900.0)

    def heading(t_s):
        return turn * np.sin(t_s / slow) + size / 2.0 * np.sin(
            2.0 * np.pi * f * t_s[:, np.newaxis] + phase).sum(axis=1)
    return heading


@pytest.mark.slow
def test_no_skew_makes_a_sound_pair_look_mirrored(rng):
    """None of 400 with skews up to 2 s, yaw periods from 5 s, and white or slower noise."""
    for k in range(400):
        span, hz = rng.choice([300.0, 1200.0]), (1.0, 2.0, 5.0)[k % 3]
        t = np.arange(0.0, span, 1.0 / hz)
        heading = yawing(rng)
        noise = rng.standard_normal((2, t.size))
        if k % 2:
            noise = np.cumsum(noise - noise.mean(axis=1, keepdims=True), axis=1) / t.size ** 0.5
        assert found_of(t, heading(t - rng.uniform(-2.0, 2.0)) + 0.1 * noise[0],
                        heading(t) + 0.05 * noise[1]).word != 'against'


@pytest.mark.slow
def test_noise_alone_tells_nothing(rng):
    """None of 200, white or a random walk."""
    for k in range(200):
        noise = 0.2 * rng.standard_normal((2, 3000))
        if k % 2:
            noise = 0.1 * np.cumsum(noise, axis=1)
        t = np.arange(3000) / 5.0
        assert found_of(t, *noise).word == 'not_testable'


@pytest.mark.parametrize('n', [0, 1, 2, 7])
def test_too_few_pairs_have_no_direction(n):
    t = np.arange(float(n))
    assert found_of(t, -t, t) == ('not_testable', 0.0, None)
