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

"""The scan of the skew: on real logs, against a plain loop, by simulation and by symmetries."""

from __future__ import annotations

import math

import numpy as np
import pytest

from heading_intercompare.core.angles import unwrap_deg, wrap180
from heading_intercompare.core.records import Headings
from heading_intercompare.core.timing import skew_scan
from heading_intercompare.core.timing.skew_scan import scan_skew

PAIRS = ['gyr1-s330', 'gyr1-seap', 's330-gyr1', 'seap-gyr1', 's330-seap', 'seap-s330',
         'adcp-gyr1', 'adcp-s330', 'adcp-seap', 'lgyr-lsep', 'lsep-lgyr']


def headings(yaw, n, rate_hz=10.0, late_s=0.0, noise=0.0, rng=None, phase_s=0.0):
    t = np.arange(n) / rate_hz + phase_s
    h = yaw(t - late_s)
    if noise:
        h = h + noise * rng.standard_normal(n)
    return Headings.as_sent(10 ** 18 + np.rint(t * 1e9).astype(np.int64), h % 360.0)


@pytest.mark.parametrize('name', PAIRS)
def test_scans_of_real_logs_agree_with_independent_programs(name, logs, golden):
    ts, rs = (logs[part] for part in name.split('-'))
    found = scan_skew(ts, rs)
    expected = golden['pairs'][name]['skew_scan']
    assert found.n == expected['n']
    assert found.skew_s == pytest.approx(expected['L_star'], abs=1e-9)
    got = {'sd_star': found.std_deg, 'mean_star': found.mean_deg,
           'sd_zero': found.std_zero_deg, 'mean_zero': found.mean_zero_deg}
    assert got == pytest.approx({key: expected[key] for key in got}, rel=1e-9)
    assert found.well_determined
    assert not found.at_edge


def test_the_scan_agrees_with_a_plain_loop(yaw, rng):
    ts = headings(yaw, 120, late_s=0.07, noise=0.1, rng=rng)
    rs = headings(yaw, 31, rate_hz=2.5, phase_s=0.02)
    line, t, t_ref = unwrap_deg(rs.heading_deg), ts.stamp_ns / 1e9, rs.stamp_ns / 1e9
    t, t_ref = (ts.stamp_ns - ts.stamp_ns[0]) / 1e9, (rs.stamp_ns - ts.stamp_ns[0]) / 1e9
    inside = [i for i in range(120) if t[i] - 0.5 >= t_ref[0] and t[i] + 0.5 <= t_ref[-1]]
    deviations = []
    for k in range(-10, 11):
        x = [float(wrap180(ts.heading_deg[i] - np.interp(t[i] - 0.05 * k, t_ref, line)))
             for i in inside]
        deviations.append(np.std(x, ddof=1))
    found = scan_skew(ts, rs, 0.5, 0.05)
    assert found.n == len(inside)
    assert found.curve_s == pytest.approx([0.05 * k for k in range(-10, 11)])
    assert found.curve_std_deg == pytest.approx(deviations, rel=1e-9)
    assert abs(found.skew_s - 0.05 * (int(np.argmin(deviations)) - 10)) <= 0.025


def test_the_parabola_finds_the_minimum_between_grid_points():
    """A heading of constant acceleration: x(L) is quadratic, v a parabola about its minimum."""
    def turn(t):
        return 10.0 + 0.02 * (t - 50.0) ** 2
    t = np.arange(1001) / 10.0
    stamps = 10 ** 18 + np.arange(1001) * 10 ** 8
    rs = Headings.as_sent(stamps, turn(t) % 360.0)
    ts = Headings.as_sent(stamps, turn(t - 0.234) % 360.0)
    assert scan_skew(ts, rs, 1.0, 0.1).skew_s == pytest.approx(0.234, abs=1e-3)


def test_the_uncertainty_of_the_scan_is_that_of_its_errors(yaw, rng):
    """Errors over their uncertainty, 40 times, RS without noise: 1 within six errors."""
    rs = headings(yaw, 3100, rate_hz=10.0)
    z = []
    for _ in range(40):
        found = scan_skew(headings(yaw, 3000, late_s=0.25, noise=0.1, rng=rng), rs, 0.5, 0.05)
        z.append((found.skew_s - 0.25) / found.u_s)
    assert np.std(z) == pytest.approx(1.0, abs=6.0 / math.sqrt(80.0))


def test_sensors_that_keep_step_draw_the_minimum_between_the_readings(yaw, rng):
    """The bias of a noisy RS is seen, and it is within the bound given."""
    slow = Headings.as_sent(np.arange(4000) * 10 ** 9 + 10 ** 18,
                       90.0 + 0.3 * np.sin(np.arange(4000) / 9.0))
    noisy = Headings.as_sent(slow.stamp_ns, slow.heading_deg + 0.1 * rng.standard_normal(4000))
    found = scan_skew(slow, noisy, 2.0, 0.05)
    assert abs(found.skew_s) > 6.0 * found.u_s
    assert abs(found.skew_s) <= found.bias_s + 6.0 * found.u_s
    assert not found.well_determined


def test_a_skew_beyond_the_range_is_at_its_edge(yaw):
    found = scan_skew(headings(yaw, 1500, late_s=1.0), headings(yaw, 1500), 0.3, 0.05)
    assert found.at_edge
    assert found.skew_s == pytest.approx(0.3)
    assert not found.well_determined
    assert scan_skew(headings(yaw, 1500, late_s=1.0), headings(yaw, 1500), 1.5,
                     0.05).skew_s == pytest.approx(1.0, abs=5e-3)


def test_turning_all_headings_changes_nothing(yaw, rng):
    ts, rs = headings(yaw, 900, late_s=0.2, noise=0.1, rng=rng), headings(yaw, 900)
    turned = [Headings.as_sent(h.stamp_ns, (h.heading_deg + 257.0) % 360.0) for h in (ts, rs)]
    a, b = scan_skew(ts, rs, 0.5), scan_skew(*turned, 0.5)
    assert (b.skew_s, b.std_deg) == pytest.approx((a.skew_s, a.std_deg), rel=1e-7)
    assert b.mean_deg == pytest.approx(a.mean_deg, abs=1e-9)


def test_differences_about_180_degrees_are_wrapped(rng):
    """The seam of the difference adds its jumps to the variance, as in the definition."""
    n = 600
    stamps = np.arange(n) * 10 ** 8 + 10 ** 18
    rs = Headings.as_sent(stamps, np.full(n, 10.0))
    noise = rng.standard_normal(n)
    found = scan_skew(Headings.as_sent(stamps, 190.0 + noise), rs, 0.2, 0.1)
    assert found.std_zero_deg > 100.0
    assert found.std_zero_deg == pytest.approx(
        wrap180(180.0 + noise[2:-2]).std(ddof=1), rel=1e-9)


def test_long_streams_are_searched_on_some_and_settled_on_all(yaw, rng, monkeypatch):
    ts, rs = headings(yaw, 5000, late_s=0.25, noise=0.3, rng=rng), headings(yaw, 5000)
    every = scan_skew(ts, rs, 0.5)
    monkeypatch.setattr(skew_scan, '_SEARCHED', 300)
    assert scan_skew(ts, rs, 0.5).skew_s == every.skew_s


def test_of_a_long_stream_an_even_subset_is_compared(yaw, rng, monkeypatch):
    """The uncertainty grows with the noise that is left, here to the root of ten."""
    ts, rs = headings(yaw, 30_000, late_s=0.2, noise=0.1, rng=rng), headings(yaw, 30_000)
    whole = scan_skew(ts, rs)
    monkeypatch.setattr(skew_scan, '_COMPARED', 3000)
    part = scan_skew(ts, rs)
    assert (whole.n > 29_000, part.n) == (True, 2996)
    assert part.skew_s == pytest.approx(0.2, abs=5.0 * part.u_s)
    assert part.u_s / whole.u_s == pytest.approx(math.sqrt(10.0), rel=0.4)
    assert part.bias_s == pytest.approx(whole.bias_s, abs=0.002)


def test_a_ship_that_does_not_turn_determines_no_skew(rng):
    stamps = np.arange(3000) * 10 ** 8
    ts, rs = (Headings.as_sent(stamps, 90.0 + s * rng.standard_normal(3000)) for s in (0.1, 0.05))
    found = scan_skew(ts, rs, 1.0)
    assert not found.well_determined
    assert found.u_s is None


def test_readings_within_reach_of_a_silence_can_be_left_out(yaw):
    ts = headings(yaw, 1000)
    rs = headings(yaw, 1000)
    rs = rs[(np.arange(1000) < 400) | (np.arange(1000) >= 500)]
    whole, parts = scan_skew(ts, rs, 0.5), scan_skew(ts, rs, 0.5, max_gap_s=3.0)
    assert (whole.n, parts.n) == (990, 880)


@pytest.mark.parametrize('n', [0, 1, 2, 30])
def test_too_few_readings_give_no_scan(n):
    """Thirty readings are three seconds; the range takes four."""
    some = Headings.as_sent(np.arange(n) * 10 ** 8, np.zeros(n))
    assert scan_skew(some, some) is None
    assert scan_skew(some, Headings.empty()) is None


def test_equal_readings_give_a_scan_without_a_finding():
    some = Headings.as_sent(np.arange(200) * 10 ** 8, np.full(200, 5.0))
    found = scan_skew(some, some, 1.0)
    assert (found.std_deg, found.u_s, found.well_determined) == (0.0, None, False)


@pytest.mark.parametrize('range_s, step_s', [(0.0, 0.01), (1.0, 0.0), (0.1, 0.2),
                                             (math.inf, 0.1), (math.nan, 0.1)])
def test_a_range_or_step_that_makes_no_grid_is_refused(range_s, step_s):
    with pytest.raises(ValueError, match='range_s = '):
        scan_skew(Headings.empty(), Headings.empty(), range_s, step_s)
