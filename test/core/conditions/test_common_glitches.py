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

"""Glitches: a copy follows those of the RS, a separate sensor has its own or none."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.ndimage import median_filter
from scipy.signal import lfilter

from heading_intercompare.core.conditions.common_glitches import (
    _subtract_medians,
    find_common_glitches,
)

RATE = 10.0
N = 12_000
T_S = np.arange(N) / RATE
STAMPS = np.rint((T_S + 1000.0) * 1e9).astype(np.int64)
PLACES = np.array([900, 2500, 4100, 6000, 8200, 10_500])


def swell(t):
    return 350.0 + 0.1 * t + 1.2 * np.sin(2.0 * np.pi * t / 7.3)


def glitched(heading, places=PLACES, size=3.0, n=1):
    """Return a heading with glitches of alternating sign and growing size."""
    heading = heading.copy()
    for k, at in enumerate(places):
        heading[at:at + n] += size * (1.0 + 0.2 * k) * (-1.0) ** k
    return heading


def found(ts, rs, stamps=STAMPS):
    return find_common_glitches(stamps, ts - rs, rs % 360.0)


@pytest.mark.parametrize('n', [1, 2, 3])
@pytest.mark.parametrize('decimals', [2, 9])
def test_a_copy_without_noise_follows_all_glitches(n, decimals):
    rs = np.round(glitched(swell(T_S), n=n), decimals)
    sign = found(rs, rs)
    assert (sign.kind, sign.count, sign.followed) == ('common', 6, 6)
    assert sign.delay_s == 0.0 and sign.chance < 1e-12


def test_a_late_copy_is_known_by_its_delay():
    rs = glitched(swell(T_S))
    sign = found(np.concatenate((rs[:23], rs[:-23])), rs)
    assert (sign.kind, sign.followed) == ('common', 6)
    assert sign.delay_s == pytest.approx(2.3)


@pytest.mark.parametrize('tau_s', [1.0, 5.0])
def test_a_filtered_copy_jumps_by_a_constant_share(tau_s):
    rs = glitched(swell(T_S))
    phi = np.exp(-1.0 / RATE / tau_s)
    ts = lfilter([1.0 - phi], [1.0, -phi], rs - rs[0]) + rs[0]
    assert (found(ts, rs).kind, found(ts, rs).followed) == ('common', 6)


def test_a_sensor_with_no_glitches_or_its_own_is_independent(rng):
    rs = glitched(swell(T_S))
    own = glitched(swell(T_S), np.sort(rng.choice(np.arange(20, N - 20), 12, replace=False)))
    for ts in (swell(T_S), own):
        sign = found(ts, rs)
        assert (sign.kind, sign.count) == ('independent', 6)
        assert sign.followed < 3 and sign.delay_s is None and sign.chance is None


def test_chance_by_hand():
    """Without other jumps: 1 / (2401 - 11 + ...) each, all six followed, 6 x 111 choices."""
    rs = glitched(np.round(swell(T_S), 9))
    sign = found(rs, rs)
    places = 2 * 1200 + 1
    inside = [min(p + 1200, N - 1) - max(p - 1200, 0) + 1 for p in PLACES]
    assert max(inside) == places
    expected = 6 * 111 / np.prod([1.0 + i for i in inside])
    assert sign.chance == pytest.approx(expected, rel=1e-9)


def test_what_a_ship_can_do_is_no_glitch():
    """Blows of 1.3 deg in 1.2 s (18 deg/s^2), and a turn of 3 deg/s that begins at once."""
    true = swell(T_S) + 3.0 * np.clip(T_S - 300.0, 0.0, 40.0)
    for at in (100.0, 200.0, 500.0, 700.0, 900.0):
        true += 0.65 * (1.0 - np.cos(2.0 * np.pi * np.clip((T_S - at) / 1.2, 0.0, 1.0)))
    sign = found(true, true)
    assert (sign.kind, sign.count) == ('not_testable', 0)


def test_a_hiccup_of_the_clock_in_a_turn_is_no_glitch():
    """Both were read late at the same times, as the stamps show."""
    stamps, at_s = STAMPS.copy(), T_S.copy()
    stamps[PLACES] += 5 * 10 ** 7
    at_s[PLACES] += 2.0
    heading = 3.0 * at_s
    assert found(heading, heading, stamps).count == 0
    assert found(heading, heading).count == 6


def test_two_glitches_and_a_filter_that_hides_them_tell_nothing(rng):
    two = glitched(swell(T_S), PLACES[:2])
    assert (found(two, two).kind, found(two, two).count) == ('not_testable', 2)
    rs = glitched(swell(T_S))
    rough = swell(T_S) + 0.5 * rng.standard_normal(N)
    assert (found(rough, rs).kind, found(rough, rs).count) == ('not_testable', 6)


@pytest.mark.parametrize('n', [0, 1, 2, 199])
def test_too_few_pairs_tell_nothing(n):
    assert found(np.zeros(n), np.zeros(n), STAMPS[:n]).kind == 'not_testable'


def test_turning_all_headings_and_shifting_the_time_change_nothing():
    rs = glitched(swell(T_S))
    here, there = found(rs, rs), found(rs + 77.0, rs + 77.0, STAMPS + 10 ** 15)
    assert (here.kind, here.count, here.followed, here.delay_s) == (
        there.kind, there.count, there.followed, there.delay_s)
    assert there.chance == pytest.approx(here.chance, rel=1e-6)


def test_a_glitch_at_either_end_is_left_out():
    rs = glitched(swell(T_S), np.array([0, 1, N - 2, N - 1]))
    assert found(rs, rs).count == 0


def test_the_median_of_seven_is_that_of_scipy(rng):
    """Also across the pieces, at both ends, and with equal values."""
    for heading in (rng.standard_normal(20_000), rng.integers(0, 5, 20_000) / 2.0, np.ones(9)):
        expected = heading - median_filter(heading, 7, mode='nearest')
        assert (_subtract_medians(heading, 0, heading.size) == expected).all()
        part = _subtract_medians(heading, 3, heading.size // 2)
        assert (part == expected[3:heading.size // 2]).all()
