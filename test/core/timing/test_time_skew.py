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

"""The skew from pairs: by hand, on real logs, by simulation with known truth, by symmetries."""

from __future__ import annotations

import math

import numpy as np
import pytest

from heading_intercompare.core.angles import unwrap_deg, wrap180
from heading_intercompare.core.records import Headings
from heading_intercompare.core.statistics.blocking import block_means
from heading_intercompare.core.timing import skew_instrument
from heading_intercompare.core.timing.heading_track import Track
from heading_intercompare.core.timing.time_skew import estimate_skew, regress_on_rate

PAIRS = ['gyr1-s330', 'gyr1-seap', 's330-gyr1', 'seap-gyr1', 's330-seap', 'adcp-gyr1',
         'adcp-s330', 'lgyr-lsep', 'lsep-lgyr']


def stamps(n, rate_hz=10.0):
    return 10 ** 18 + np.arange(n) * round(1e9 / rate_hz)


def seconds(n, rate_hz=10.0):
    return np.arange(n) / rate_hz


# --- a heading in time ---

def test_a_track_interpolates_over_north():
    track = Track(Headings.as_sent([0, 2_000_000_000], [359.0, 3.0]))
    assert track.at(np.array([0.0, 0.5, 2.0])).tolist() == [359.0, 360.0, 363.0]
    assert track.rate(np.array([1.0]), 0.5).tolist() == [2.0]


def test_a_track_leaves_out_what_has_no_place_on_it():
    track = Track(Headings.as_sent([10, 10, 5, 20, 30], [1.0, 2.0, 3.0, math.nan, 4.0]), 10)
    assert track.t_s.tolist() == [0.0, 2e-8]
    assert track.heading_deg.tolist() == [1.0, 4.0]


@pytest.mark.parametrize('lo, hi, good', [(0.0, 1.0, True), (0.5, 1.5, False), (1.5, 2.5, False),
                                          (2.0, 9.0, False), (9.0, 10.0, True),
                                          (-0.1, 0.5, False), (9.5, 10.1, False),
                                          (1.0, 1.0, True), (9.0, 9.0, True)])
def test_a_track_covers_no_span_over_a_gap_or_beyond_its_ends(lo, hi, good):
    track = Track(Headings.as_sent(np.array([0, 1, 9, 10]) * 10 ** 9, [0.0] * 4))
    assert track.covers(np.array([lo]), np.array([hi]), 3.0).tolist() == [good]


def test_an_empty_track_covers_nothing():
    assert not Track(Headings.empty()).covers(np.zeros(2), np.zeros(2)).any()


# --- regression ---

def regress(stamp_ns, x, rs):
    """Regress the differences inside the readings of the RS on its rate over a second."""
    track = Track(rs, int(rs.stamp_ns[0]))
    t = (np.asarray(stamp_ns) - int(rs.stamp_ns[0])) / 1e9
    inside = track.covers(t - 0.5, t + 0.5)
    return regress_on_rate(np.asarray(x)[inside], track.rate(t[inside], 0.5))


def test_regression_by_hand():
    """RS turns at 1, 2, 3 deg/s about 0.5, 1.5, 2.5 s; x = 0.5 - 0.2 w exactly."""
    rs = Headings.as_sent(np.arange(4) * 10 ** 9, [0.0, 1.0, 3.0, 6.0])
    skew_s, u_s = regress(np.array([5, 15, 25]) * 10 ** 8, [0.3, 0.1, -0.1], rs)
    assert skew_s == pytest.approx(0.2) and u_s == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize('name', PAIRS)
def test_regressions_of_real_logs_agree_with_independent_programs(name, real, golden, logs):
    pairs, x = real(name)
    expected = golden['pairs'][name]['skew_reg']
    assert regress(pairs.stamp_ns, x, logs[name.split('-')[1]]) == pytest.approx(
        (expected['lag'], expected['se_naive']), rel=1e-9)


def test_no_regression_without_turning_or_samples():
    rs = Headings.as_sent(np.arange(10) * 10 ** 9, np.full(10, 5.0))
    assert regress(np.arange(10) * 10 ** 9, np.arange(10.0), rs) is None
    assert regress_on_rate(np.zeros(0), np.zeros(0)) is None
    assert regress_on_rate(np.ones(2), np.arange(2.0)) is None


# --- instrument ---

def test_a_skew_without_noise_is_found_to_a_millisecond(yaw):
    """Linear interpolation of a yaw of five seconds, read ten times a second, is left."""
    t = seconds(6000)
    rs = yaw(t)
    found = estimate_skew(stamps(6000), yaw(t - 0.4) - rs, rs)
    assert found.skew_s == pytest.approx(0.4, abs=1e-3)
    assert found.well_determined
    assert found.significant
    assert found.std_aligned_deg < 0.01 * found.std_deg


def test_noise_attenuates_least_squares_but_not_the_instrument(yaw, rng):
    """Truth 0.25 s, noise of 0.1 and 0.05 deg: six standard uncertainties."""
    n, t = 20_000, seconds(20_000)
    rs = yaw(t) + 0.05 * rng.standard_normal(n)
    found = estimate_skew(stamps(n), yaw(t - 0.25) + 0.1 * rng.standard_normal(n) - rs, rs,
                          half_span_s=0.1)
    assert abs(found.skew_s - 0.25) < 6.0 * found.u_s
    assert found.u_s < 0.002
    assert found.ols_s < 0.25 - 6.0 * found.ols_u_s


@pytest.mark.slow
@pytest.mark.parametrize('tau', [1.0, 40.0])
def test_the_uncertainty_of_the_skew_survives_correlation(tau, ar1, yaw, rng):
    """Errors over their uncertainty, 60 times: spread 1 within six standard errors."""
    n, t = 4000, seconds(4000)
    truth = yaw(t)
    late = yaw(t - 0.25)
    z = []
    for _ in range(60):
        rs = truth + 0.05 * rng.standard_normal(n)
        found = estimate_skew(stamps(n), late + 0.1 * ar1(n, tau) - rs, rs)
        z.append((found.skew_s - 0.25) / found.u_s)
    assert np.std(z) == pytest.approx(1.0, abs=6.0 / math.sqrt(120.0))
    assert abs(np.mean(z)) < 6.0 / math.sqrt(60.0)


@pytest.mark.parametrize('name', PAIRS)
def test_the_skew_of_real_logs_is_that_of_the_scan(name, real, golden):
    """
    Two estimates of one skew: within four of their joint uncertainty, and 0.02 s.

    Interpolating an RS that comes once a second shifts either by up to a hundredth.
    """
    pairs, x = real(name)
    found = estimate_skew(pairs.stamp_ns, x, pairs.rs_deg)
    expected = golden['pairs'][name]['skew_scan']['L_star']
    assert found.well_determined
    assert abs(found.skew_s - expected) < 4.0 * found.u_s + 0.02


def test_the_skew_turns_sign_with_the_sensors(yaw, rng):
    n, t = 5000, seconds(5000)
    ts, rs = yaw(t - 0.3), yaw(t) + 0.05 * rng.standard_normal(n)
    there, back = estimate_skew(stamps(n), ts - rs, rs), estimate_skew(stamps(n), rs - ts, ts)
    assert back.skew_s == pytest.approx(-there.skew_s, abs=6.0 * there.u_s)


def test_turning_all_headings_or_mounting_the_ts_askew_changes_nothing(yaw, rng):
    n, t = 3000, seconds(3000)
    rs = yaw(t)
    x = yaw(t - 0.2) - rs + 0.05 * rng.standard_normal(n)
    a = estimate_skew(stamps(n), x, rs)
    b = estimate_skew(stamps(n), (x + 178.0 + 180.0) % 360.0 - 180.0, (rs + 263.0) % 360.0)
    assert b.skew_s == pytest.approx(a.skew_s, abs=1e-6)
    assert b.u_s == pytest.approx(a.u_s, rel=1e-6)


def test_frequent_pairs_are_averaged_to_the_same_skew(yaw, rng):
    """100 Hz in averages of eight."""
    n, t = 60_000, seconds(60_000, 100.0)
    rs = yaw(t) + 0.05 * rng.standard_normal(n)
    found = estimate_skew(stamps(n, 100.0), yaw(t - 0.25) + 0.1 * rng.standard_normal(n) - rs, rs)
    assert n // 8 - 20 < found.n <= n // 8
    assert abs(found.skew_s - 0.25) < 6.0 * found.u_s


def test_a_ship_that_does_not_turn_shows_no_skew(rng):
    n = 5000
    rs = 90.0 + 0.05 * rng.standard_normal(n)
    found = estimate_skew(stamps(n), 90.0 + 0.1 * rng.standard_normal(n) - rs, rs)
    assert found.well_determined is False
    assert found.skew_s is None
    assert found.strength < 10.0
    assert found.largest_variance_deg2(2.0) == pytest.approx((2.0 * found.rs_rate_std_deg_s) ** 2)


def test_a_skew_beyond_the_range_is_not_reported(yaw):
    t = seconds(3000)
    found = estimate_skew(stamps(3000), yaw(t - 1.0) - yaw(t), yaw(t), range_s=0.5)
    assert found.skew_s is None
    assert found.well_determined is False


def test_no_rate_is_taken_over_a_silence(yaw, rng):
    """An hour of silence in which the ship turns by 90 degrees leaves the skew as it was."""
    n, t = 4000, seconds(4000)
    rs = yaw(t)
    x = yaw(t - 0.25) - rs + 0.05 * rng.standard_normal(n)
    late = np.arange(n) >= n // 2
    turned = np.where(late, rs + 90.0, rs)
    a = estimate_skew(stamps(n), x, rs)
    b = estimate_skew(stamps(n) + late * 3_600_000_000_000, x, turned)
    assert abs(b.skew_s - a.skew_s) < a.u_s
    assert a.n - 15 < b.n < a.n


@pytest.mark.parametrize('n', [0, 1, 63, 66])
def test_too_few_pairs_give_no_skew(n, rng):
    found = estimate_skew(stamps(n), rng.standard_normal(n), np.full(n, 3.0))
    assert (found.n, found.skew_s, found.largest_variance_deg2(2.0)) == (0, None, None)


@pytest.mark.parametrize('x', [0.0, 0.3])
def test_a_frozen_pair_gives_no_skew(x):
    found = estimate_skew(stamps(200), np.full(200, x), np.full(200, 3.0))
    assert found.skew_s is None
    assert found.well_determined is False


@pytest.mark.parametrize('late_s', [-1.9, -1.3, 1.3, 1.9])
@pytest.mark.parametrize('period_s', [5.0, 6.0, 9.0])
def test_a_skew_of_any_part_of_the_yaw_period_is_found(late_s, period_s, rng):
    """Within six standard uncertainties and 5 ms of interpolation, once a turn tells periods."""
    n, t = 12_000, seconds(12_000)

    def heading(at_s):
        return 5.0 * np.sin(at_s / 60.0) + np.sin(2.0 * np.pi * at_s / period_s)
    rs = heading(t) + 0.05 * rng.standard_normal(n)
    found = estimate_skew(stamps(n), heading(t - late_s) + 0.1 * rng.standard_normal(n) - rs, rs)
    assert found.kind == 'found' and found.well_determined
    assert abs(found.skew_s - late_s) < 6.0 * found.u_s + 5e-3


@pytest.mark.parametrize('late_s', [-40.0, 2.2, 17.0])
def test_a_skew_beyond_the_range_has_its_size(late_s, rng):
    n, t = 12_000, seconds(12_000)

    def heading(at_s):
        return 20.0 * np.sin(at_s / 60.0) + np.sin(2.0 * np.pi * at_s / 7.0)
    rs = heading(t) + 0.05 * rng.standard_normal(n)
    found = estimate_skew(stamps(n), heading(t - late_s) + 0.1 * rng.standard_normal(n) - rs, rs)
    assert (found.kind, found.skew_s) == ('beyond', None)
    assert found.beyond_s == pytest.approx(late_s, abs=0.05)


def test_a_ship_that_moves_is_told_from_one_that_does_not(yaw, rng):
    """The TS stays at one heading: no skew fits."""
    n, t = 6000, seconds(6000)
    noise = 0.05 * rng.standard_normal((2, n))
    moved = estimate_skew(stamps(n), 90.0 + noise[0] - yaw(t) - noise[1], yaw(t) + noise[1])
    still = estimate_skew(stamps(n), noise[0] - noise[1], 90.0 + noise[1])
    assert (moved.kind, still.kind) == ('no_fit', 'not_turned')
    assert 'the ship moved' in moved.why_not(2.0) and 'did not turn' in still.why_not(2.0)


@pytest.mark.parametrize('most, block_s', [(1 << 18, 0.08), (4000, 0.16), (100, 0.16)])
def test_more_averages_than_enough_make_longer_ones(rng, monkeypatch, most, block_s):
    """At 100 Hz a block of 0.1 s holds 8 pairs, one of a quarter of a second 16."""
    monkeypatch.setattr(skew_instrument, '_MANY', most)
    n = 70_001
    stamps = 10 ** 18 + 10 ** 7 * np.arange(n)
    rs = np.cumsum(rng.normal(0.0, 3.0, n)) + 359.0
    x = rng.normal(0.0, 0.1, n)
    ts_track, rs_track = skew_instrument.common_tracks(stamps, wrap180(x), rs % 360.0)
    size = round(block_s * 100.0)
    expected = block_means(unwrap_deg(rs % 360.0), size)
    assert rs_track.heading_deg == pytest.approx(expected, rel=1e-12)
    assert ts_track.heading_deg - rs_track.heading_deg == pytest.approx(
        block_means(x, size), abs=1e-9)
    assert rs_track.step_s == pytest.approx(block_s) and ts_track.t_s is rs_track.t_s
