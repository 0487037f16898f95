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

"""One source: copies of every kind are found, sensors that only share the motion are not."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter

from heading_intercompare.core.angles import wrap180
from heading_intercompare.core.conditions.common_noise import find_common_noise
from heading_intercompare.core.conditions.standstill import find_coarse_resolution
from heading_intercompare.core.pairing.difference import subtract
from heading_intercompare.core.pairing.pairer import pair
from heading_intercompare.core.records import Headings
from heading_intercompare.core.settings import Settings

RATE = 5.0
N = 6000


def stamps_of(t):
    return np.rint((np.asarray(t) + 1000.0) * 1e9).astype(np.int64)


def swell(t):
    """Return a heading in swell, with a turn of a minute."""
    u = np.clip((t - 400.0) / 60.0, 0.0, 1.0)
    return (350.0 + 40.0 * (u - np.sin(2.0 * np.pi * u) / (2.0 * np.pi))
            + 1.2 * np.sin(2.0 * np.pi * t / 7.3) + 0.7 * np.sin(2.0 * np.pi * t / 11.1))


def judged(ts, rs, t=None, **more):
    """Return what is found for pairs of one stamp each."""
    t = np.arange(ts.size) / RATE if t is None else t
    return find_common_noise(stamps_of(t), wrap180(ts - rs), rs % 360.0, **more)


@pytest.fixture
def rs(rng):
    """Return the true heading, and that of an RS with white noise of 0.05 deg."""
    true = swell(np.arange(N) / RATE)
    return true, np.round(true + 0.05 * rng.standard_normal(N), 2)


def test_the_coherence_of_a_noisy_copy_by_hand(rs, rng):
    """Half the noise of the RS on top: 1 / (1 + 0.5^2) = 0.8. Standard error below 0.02."""
    ts = rs[1] + 0.025 * rng.standard_normal(N)
    found = judged(ts, rs[1])
    assert (found.kind, found.reason) == ('common', '')
    assert found.of_rs.coherence == pytest.approx(0.8, abs=0.06)
    assert found.of_rs.noise_deg == pytest.approx(0.05, rel=0.05)
    assert found.of_rs.band_hz[0] < 0.5 and found.of_rs.band_hz[1] == pytest.approx(2.5, rel=0.01)


def copies(rs, rng):
    yield 'exact', rs
    yield 'rounded', np.round(rs, 1)
    yield 'late', np.concatenate((rs[:8], rs[:-8]))
    for tau in (1.0, 5.0):
        phi = np.exp(-1.0 / RATE / tau)
        yield f'filter of {tau} s', lfilter([1.0 - phi], [1.0, -phi], rs - rs[0]) + rs[0]
    yield 'half the noise', rs + 0.025 * rng.standard_normal(N)


def test_copies_of_every_kind_are_found(rs, rng):
    for name, ts in copies(rs[1], rng):
        assert judged(ts, rs[1], rs_step_deg=0.01).kind == 'common', name


@pytest.mark.parametrize('sigma', [0.0, 0.02, 0.2])
@pytest.mark.parametrize('step', [0.0, 0.01, 0.1])
def test_sensors_of_their_own_are_independent(sigma, step, rs, rng):
    """Even a TS that follows the motion without any error."""
    ts = rs[0] + sigma * rng.standard_normal(N)
    ts = np.round(ts / step) * step if step else ts
    noise = judged(ts, rs[1], rs_step_deg=0.01, ts_step_deg=step or None)
    assert noise.of_rs.kind == 'independent' and abs(noise.of_rs.coherence) < 0.1
    # A TS without noise of its own cannot show whether the RS repeats it.
    assert noise.of_ts.kind == ('independent' if sigma > 0.5 * step else 'not_testable')


def test_correlated_errors_are_independent_and_their_copies_are_not(rng, ar1):
    t = np.arange(12_000) / 10.0
    true = swell(t)
    rs = true + 0.1 * ar1(t.size, 20.0)
    ts = true + 0.1 * ar1(t.size, 5.0)
    assert judged(ts, rs, t).kind == 'independent'
    assert judged(rs + 0.02 * rng.standard_normal(t.size), rs, t).kind == 'common'


@pytest.mark.parametrize('noise', [0.0, 0.001])
def test_without_noise_of_the_rs_it_is_not_testable(noise, rng):
    """Two that follow the motion exactly, rounded or not, and a quantised steady heading."""
    true = swell(np.arange(N) / RATE) + noise * rng.standard_normal(N)
    for one in (swell(np.arange(N) / RATE), np.round(true, 2), np.round(true, 1)):
        step_deg = find_coarse_resolution(one)
        found = judged(one, one, rs_step_deg=step_deg, ts_step_deg=step_deg)
        assert (found.kind, found.reason) == ('not_testable', '')
    steady = np.full(N, 12.3)
    assert judged(steady, steady).kind == 'not_testable'
    assert judged(np.round(true, 1), steady).kind == 'not_testable'


@pytest.mark.parametrize('ts_hz, rs_hz', [(5.0, 1.0), (10.0, 5.0), (1.0, 5.0), (7.0, 5.0)])
@pytest.mark.parametrize('method', ['auto', 'interpolate'])
def test_any_rates_may_meet(method, ts_hz, rs_hz, rng):
    """The RS is interpolated for a faster TS; copies sent at its own rate are found."""
    t_rs = np.arange(0.0, 2400.0, 1.0 / rs_hz)
    rs = np.round(swell(t_rs) + 0.05 * rng.standard_normal(t_rs.size), 2)
    t = np.arange(1.03, 2398.0, 1.0 / ts_hz)
    own = swell(t - 0.4) + 0.05 * rng.standard_normal(t.size)
    copy = np.interp(t, t_rs, rs)
    settings = Settings.from_mapping({'pairing': {'method': method}})

    def found(ts):
        pairs, _ = pair(Headings.as_sent(stamps_of(t), ts % 360.0),
                        Headings.as_sent(stamps_of(t_rs), rs % 360.0), settings)
        return find_common_noise(pairs.stamp_ns, subtract(pairs).x_deg, pairs.rs_deg,
                                 factor=pairs.rs_variance_factor).kind
    assert found(own) != 'common'
    assert found(copy) == 'common'


@pytest.mark.parametrize('share', [0.3, 1.0])
def test_an_rs_that_repeats_the_ts_with_noise_of_its_own_is_found(share, rng, ar1):
    """Coherence s²/(1 + s²) = 0.08 and 0.5, and more where slow errors show: they cancel in x."""
    true = swell(np.arange(N) / RATE)
    ts = true + 0.3 * ar1(N, 120.0 * RATE) + share * 0.05 * rng.standard_normal(N)
    rs = ts + 0.05 * rng.standard_normal(N)
    noise = judged(ts, rs)
    assert noise.kind == 'common' if share == 1.0 else noise.kind in ('unsure', 'common')
    assert noise.strongest.coherence > 0.9 * share ** 2 / (1.0 + share ** 2)


def test_uneven_stamps_make_no_common_noise(rng):
    """Both sensors are seen at the same uneven times, which in swell looks like noise of both."""
    t = np.arange(N) / RATE + 0.01 * rng.standard_normal(N)
    assert judged(swell(t), swell(t), t).kind == 'not_testable'
    rs = swell(t) + 0.05 * rng.standard_normal(N)
    assert judged(swell(t) + 0.01 * rng.standard_normal(N), rs, t).kind == 'independent'


@pytest.mark.parametrize('name', ['gyr1-s330', 's330-gyr1', 'seap-s330', 's330-seap',
                                  'gyr1-seap', 'adcp-gyr1', 'lgyr-lsep', 'lsep-lgyr'])
def test_real_sensors_have_no_common_noise(name, real):
    pairs, x = real(name)
    found = find_common_noise(pairs.stamp_ns, x, pairs.rs_deg, factor=pairs.rs_variance_factor,
                              rs_step_deg=0.1 if 'lgyr' in name.split('-')[1] else 0.01)
    assert found.kind != 'common'


@pytest.mark.parametrize('name', ['s330', 'seap'])
def test_copies_of_a_real_sensor_are_found(name, logs):
    """Once a second, in a sea: its noise shows at the highest eighth of a hertz only."""
    rs = logs[name]
    for ts in (rs, Headings.as_sent(rs.stamp_ns + 7 * 10 ** 8, rs.heading_deg)):
        pairs, _ = pair(ts, rs)
        assert find_common_noise(pairs.stamp_ns, subtract(pairs).x_deg, pairs.rs_deg,
                                 factor=pairs.rs_variance_factor,
                                 rs_step_deg=0.01).kind == 'common'


def test_rounding_a_smooth_copy_does_not_make_it_a_slow_sensor(rng):
    """10 Hz through a filter of 4 s: 0.05 deg of noise leaves steps that repeat most values."""
    t = np.arange(12_000) / 10.0
    rs = np.round(swell(t) + 0.05 * rng.standard_normal(t.size), 2)
    phi = np.exp(-0.1 / 4.0)
    ts = np.round(lfilter([1.0 - phi], [1.0, -phi], rs - rs[0]) + rs[0], 2)
    found = judged(ts, rs, t, rs_step_deg=0.01, ts_step_deg=0.01)
    assert found.kind == 'common' and found.strongest.coherence > 0.4
    assert found.strongest.band_hz[1] == pytest.approx(5.0)


def test_a_reference_faster_than_the_pairs_shares_only_the_motion():
    """
    Ten a second, put onto the 5 a second of a TS without error: its noise is white in the pairs.

    Taken for that of readings as slow as the pairs, it would seem to rise with the frequency,
    and the motion below half a hertz to be noise.
    """
    rng = np.random.default_rng(0)
    t_rs, t = np.arange(0.0, 3600.0, 0.1), np.arange(0.5, 3598.0, 0.2 / 1.003)
    lines = [(rng.uniform(0.0, 0.5), rng.uniform(0.0, 2.0 * np.pi)) for _ in range(400)]

    def heading(at_s):
        return 90.0 + sum(0.0063 * np.sin(2.0 * np.pi * f * at_s + p) for f, p in lines)
    rs = heading(t_rs) + 0.2 * rng.standard_normal(t_rs.size)
    pairs, _ = pair(Headings.as_sent(stamps_of(t), heading(t)),
                    Headings.as_sent(stamps_of(t_rs), rs))
    assert find_common_noise(pairs.stamp_ns, subtract(pairs).x_deg, pairs.rs_deg,
                             factor=pairs.rs_variance_factor).of_rs.kind == 'independent'


def test_blows_that_both_sensors_see_are_not_noise(rng):
    """A yaw of up to 1.4 deg there and back in 1.2 s, thirty times, seen by a perfect TS."""
    t = np.arange(6000) / RATE
    true = swell(t)
    for at in rng.uniform(10.0, 1190.0, 30):
        true += 0.7 * (1.0 - np.cos(2.0 * np.pi * np.clip((t - at) / 1.2, 0.0, 1.0)))
    assert judged(true, true + 0.05 * rng.standard_normal(t.size), t).kind != 'common'
    assert judged(true, true, t).kind == 'not_testable'


def test_turning_all_headings_and_shifting_the_time_change_nothing(rs, rng):
    ts = rs[0] + 0.05 * rng.standard_normal(N)
    here, there = judged(ts, rs[1]), judged(ts + 77.0, rs[1] + 77.0)
    late = judged(ts, rs[1], np.arange(N) / RATE + 1e6)
    for other in (there, late):
        assert (other.kind, other.segments) == (here.kind, here.segments)
        for noise, same in ((other.of_rs, here.of_rs), (other.of_ts, here.of_ts)):
            assert noise.coherence == pytest.approx(same.coherence, abs=1e-6)


def test_too_few_and_too_slow_pairs_are_not_testable(rng):
    noise = rng.standard_normal(100)
    for n in (0, 1, 2, 3, 50, 100):
        assert judged(noise[:n], noise[:n]).reason == 'too_short'
    long = rng.standard_normal(4000)
    assert judged(long, long, np.arange(4000) * 2.0).reason == 'too_slow'
