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

"""The chart by hand, by Monte Carlo of its rate of false alarms, and its properties."""

from __future__ import annotations

import json
import math

from hypothesis import given, strategies as st
import numpy as np
import pytest

from heading_intercompare.logbook import control_chart
from heading_intercompare.logbook.control_chart import (
    Change,
    design_chart,
    estimate_correlation,
    LEAST_BASELINE,
    make_chart,
)

N = 370.0


def walk(rng, shape, rho):
    """Return stationary normal series of unit variance along the last axis, step by step."""
    x = rng.standard_normal(shape)
    for i in range(1, shape[-1]):
        x[..., i] = rho * x[..., i - 1] + math.sqrt(1.0 - rho ** 2) * x[..., i]
    return x


def test_center_and_scale_by_hand():
    """
    Baseline 1 to 8: median 4.5, median deviation 2, s = 1.482602 · 2 · 8 / 7.2 = 3.294672.

    With u = 1: between² = 3.294672² - 1 = 9.854861, so sigma is s where u is 1, and
    sqrt(9.854861 + 9) = 4.342218 where u is 3.
    """
    x, u = np.array([1.0, 5, 3, 7, 2, 6, 4, 8, 4.5, 4.5]), np.array([1.0] * 9 + [3.0])
    chart = make_chart(x, u, baseline=8)
    assert (chart.center, chart.between) == (4.5, pytest.approx(math.sqrt(9.854861)))
    width = (chart.high - chart.low) / 2.0
    first, second = design_chart(8, 2, math.ceil(20 * chart.correlation) / 20, N).factors
    assert width[8] == pytest.approx(first * 3.294672, rel=1e-6)
    # The ninth run lies on the center: v = 10.854861 (1 - 1/9), between² = v - 1.
    assert width[9] == pytest.approx(second * math.sqrt(9.648765 - 1.0 + 9.0), rel=1e-6)


def test_the_sums_by_hand():
    """
    Baseline ±1, s = 1.4826 · 20 / 19.2 = 1.544377, then 0, 0, and 30 for ever, which count as 3.

    So each run adds 2.5 from the third on, the sum exceeds H at run floor(H / 2.5) + 1 of these,
    and the change began with the first of them.
    """
    x = np.array([-1.0, 1.0] * 10 + [0.0, 0.0] + [30.0] * 30)
    chart = make_chart(x, np.zeros(len(x)), baseline=20)
    threshold = design_chart(20, 32, math.ceil(20 * chart.correlation) / 20, N).threshold
    assert chart.changes == (Change(22, 22 + math.floor(threshold / 2.5), None),)


def test_what_a_chart_learns_by_hand():
    """
    Baseline ±1 as before, then 0, 1, 0.

    After 0: c = 0, v = 2.385100 · 20/21 = 2.271524. After 1: z = 1 / sqrt(2.271524) = 0.663496,
    c = 1/22, v = 2.271524 (1 + (0.663496² / 0.92054 - 1) / 22) = 2.217653.
    """
    x = np.array([-1.0, 1.0] * 10 + [0.0, 1.0, 0.0])
    chart = make_chart(x, np.zeros(len(x)), baseline=20)
    factors = np.array(design_chart(20, 3, math.ceil(20 * chart.correlation) / 20, N).factors)
    assert (chart.high + chart.low)[20:] / 2.0 == pytest.approx([0.0, 0.0, 1.0 / 22.0])
    assert ((chart.high - chart.low)[20:] / 2.0 / factors) ** 2 == pytest.approx(
        [2.385100, 2.271524, 2.217653], rel=1e-5)


def test_limits_and_sums_stay_as_they_were_before_a_change(rng):
    x = rng.standard_normal(200)
    x[120:] += 20.0
    chart = make_chart(x, np.zeros(200))
    since = chart.lasting.since
    center = (chart.low + chart.high) / 2.0
    assert np.all(center[chart.lasting.noticed + 1:] == center[since])
    assert 117 <= since <= 120 and chart.outside[120:].all()


def test_a_false_alarm_does_not_hide_a_later_shift(rng):
    """Before, the first change was the only one: hourly runs, an alarm on the second day."""
    x = rng.standard_normal(1000)
    x[30:36] += 6.0
    x[500:] += 2.0
    early, late = make_chart(x, np.zeros(1000)).changes[0], make_chart(x, np.zeros(1000)).lasting
    assert abs(early.since - 30) <= 3 and 35 <= early.until < 60
    assert abs(late.since - 500) <= 12 and late.noticed < 530


def test_a_sensor_that_was_repaired_does_not_differ(rng):
    x = rng.standard_normal(300)
    x[100:150] -= 5.0
    change, = make_chart(x, np.zeros(300), runs_between=1e5).changes
    assert abs(change.since - 100) <= 3 and abs(change.until - 149) <= 3


@pytest.mark.parametrize('ahead, charts', [(340, 200), (980, 200)])
def test_a_fleet_of_a_year_finds_a_shift_of_two_sigma_within_a_month(ahead, charts):
    """A chance of 5 % of a false alarm in 200 charts; before, the threshold was above 250."""
    runs_between = -1.0 / math.expm1(math.log(0.95) / (charts * ahead))
    assert design_chart(20, ahead, 0.0, runs_between).threshold < 30 * (2.0 - 0.5)


def test_a_correlation_by_hand():
    """R of 1, 1, -1, -1, ... is n/2 - 1 steps up, n/2 down: near 0; of ±1 in turns it is -1."""
    assert estimate_correlation(np.array([1.0, -1.0] * 10)) == 0.0
    z = np.array([1.0, 1.0, -1.0, -1.0] * 5)
    r = (10 - 9) / 20
    assert estimate_correlation(z) == pytest.approx(r + (1 + 3 * r) / 20 + 1 / math.sqrt(20))
    assert estimate_correlation(np.zeros(20)) == 0.0
    assert estimate_correlation(np.repeat([5.0, -5.0], 50)) == 0.8


@pytest.mark.parametrize('baseline, ahead, rho', [(8, 30, 0.0), (20, 60, 0.0), (20, 60, 0.5)])
def test_limits_and_threshold_have_the_stated_rates(baseline, ahead, rho):
    """
    Monte Carlo with other numbers and other code, six standard errors.

    Of unchanged runs 1 in 370 is outside; of charts 1 - (1 - 1/370)^n show a lasting change. The
    threshold is itself a quantile of 4000 paths, whose standard error counts too.
    """
    rng, paths = np.random.default_rng(77), 20_000
    design = design_chart(baseline, ahead, rho, N)
    factors = design.factors_of(baseline + ahead, baseline)
    x = walk(rng, (paths, baseline + ahead), rho)
    learned = np.sort(x[:, :baseline], axis=1)
    half = baseline // 2
    center = (learned[:, half - 1] + learned[:, half]) / 2.0
    deviations = np.sort(np.abs(x[:, :baseline] - center[:, None]), axis=1)
    sigma = (deviations[:, half - 1] + deviations[:, half]) / 2.0 * 1.4826022
    sigma *= baseline / (baseline - 0.8)
    mean, square, z = center.copy(), sigma ** 2, np.zeros((paths, ahead))
    for n in range(baseline, baseline + ahead):
        s = square ** 0.5
        z[:, n - baseline] = (x[:, n] - mean) / s
        part = np.minimum(2.0, np.maximum(-2.0, z[:, n - baseline]))
        mean += part * s / (n + 1)
        square += (part ** 2 / 0.920540 - 1.0) * square / (n + 1)
    # Far enough from the baseline to be independent of it: that is what K states.
    outside = np.mean((np.abs(z) > factors[baseline:])[:, ahead // 2:], axis=1)
    error = math.hypot(1.0, math.sqrt(paths / 4000)) * outside.std() / math.sqrt(paths)
    assert abs(outside.mean() - 1.0 / N) < 6.0 * error
    alarms = np.zeros(paths, bool)
    for sign in (1.0, -1.0):
        total = np.zeros(paths)
        for i in range(ahead):
            total = np.maximum(0.0, total + np.clip(sign * z[:, i], -3.0, 3.0) - 0.5)
            alarms |= total > design.threshold
    stated = 1.0 - (1.0 - 1.0 / N) ** ahead
    error = math.sqrt(stated * (1.0 - stated) * (1.0 / paths + 1.0 / 4000))
    assert abs(alarms.mean() - stated) < 6.0 * error


@pytest.mark.slow
@pytest.mark.parametrize('rho, own', [(0.0, 0.0), (0.0, 0.6), (0.0, 1.0), (0.5, 0.0), (0.5, 0.6)])
def test_unchanged_sensors_raise_no_more_than_the_stated_alarms(rho, own):
    """Whole charts of 20 + 60 runs, correlated and with uncertainties of their own."""
    rng, charts = np.random.default_rng(78), 800
    x = math.sqrt(1.0 - own ** 2) * walk(rng, (charts, 80), rho)
    x += own * rng.standard_normal(x.shape)
    made = [make_chart(row, np.full(80, own), baseline=20) for row in x]
    outside = np.array([np.mean(chart.outside[20:]) for chart in made])
    assert outside.mean() < 1.0 / N + 6.0 * outside.std() / math.sqrt(charts)
    stated = 1.0 - (1.0 - 1.0 / N) ** 60
    error = math.sqrt(stated * (1.0 - stated) * (1.0 / charts + 1.0 / 4000))
    assert np.mean([chart.changes != () for chart in made]) < stated + 6.0 * error


def test_a_shift_is_found_and_dated():
    """A shift of 2 standard deviations at run 50: found in most charts, dated within 5 runs."""
    rng, charts = np.random.default_rng(79), 200
    x = rng.standard_normal((charts, 100))
    x[:, 50:] += 2.0
    made = [make_chart(row, np.zeros(100), baseline=20) for row in x]
    found = np.array([chart.lasting.since for chart in made if chart.lasting])
    assert len(found) > 0.8 * charts
    assert abs(np.median(found) - 50) <= 2
    assert np.mean(np.abs(found - 50) <= 5) > 0.7


def test_one_wild_run_is_outside_but_no_lasting_change(rng):
    x = rng.standard_normal(60)
    x[40] = 1000.0
    chart = make_chart(x, np.zeros(60))
    assert chart.outside[40] and chart.changes == ()


def test_a_wild_run_in_the_baseline_does_not_hide_a_shift(rng):
    x = rng.standard_normal(60)
    x[3], x[11] = 1000.0, -500.0
    x[40:] += 6.0
    chart = make_chart(x, np.zeros(60))
    assert chart.lasting.since == 40 and chart.outside[40:].any()


@pytest.mark.slow
@given(st.lists(st.floats(-100, 100), min_size=12, max_size=30), st.floats(-50, 50),
       st.sampled_from([0.25, 0.5, 2.0, 8.0]))
def test_shifted_and_scaled_figures_give_the_same_chart(x, shift, scale):
    x = np.round(np.array(x), 3)
    u = np.full(len(x), 0.5)
    one = make_chart(x, u, baseline=8)
    other = make_chart(scale * x, scale * u, baseline=8)
    assert one.changes == other.changes
    assert one.outside.tolist() == other.outside.tolist()
    assert other.low == pytest.approx(scale * one.low)
    moved = make_chart(x + shift, u, baseline=8)
    assert moved.low == pytest.approx(one.low + shift, abs=1e-9)


@given(st.integers(9, 40))
def test_runs_after_do_not_change_the_limits_of_the_baseline(n):
    """The limits rest on the baseline and the number of runs; the past stays as it was drawn."""
    x = np.cos(np.arange(60) * 2.3)
    u = np.full(60, 0.1)
    assert make_chart(x[:n], u[:n], baseline=8).center == make_chart(x, u, baseline=8).center
    assert make_chart(x[:n], u[:n], baseline=8).high[0] == pytest.approx(
        make_chart(x, u, baseline=8).high[0], rel=0.05)


def test_equal_figures_without_uncertainty_differ_as_soon_as_one_does():
    chart = make_chart(np.array([1.0] * 20 + [1.0, 1.1]), np.zeros(22))
    assert chart.outside.tolist() == [False] * 21 + [True]


@pytest.mark.parametrize('n, baseline, why', [
    (20, 20, '20 runs: a chart needs more than its baseline of 20'),
    (20, LEAST_BASELINE - 1, 'baseline = 7: must be at least 8 runs')])
def test_too_few_runs_are_refused(n, baseline, why):
    with pytest.raises(ValueError, match=why):
        make_chart(np.zeros(n), np.zeros(n), baseline=baseline)


def test_a_design_is_simulated_once_and_read_to_the_bit(tmp_path, monkeypatch):
    monkeypatch.setenv('XDG_CACHE_HOME', str(tmp_path))
    arguments = 8, 3, 0.35, N
    simulated = design_chart.__wrapped__(*arguments)
    place, = tmp_path.glob('heading_intercompare/charts/*.json')
    monkeypatch.setattr(control_chart, '_simulate', None)
    assert design_chart.__wrapped__(*arguments) == simulated
    numbers = json.loads(place.read_text())
    place.write_text(json.dumps([*numbers[:2], 9.0]))
    assert design_chart.__wrapped__(*arguments).threshold == 9.0


def test_a_design_of_other_code_is_not_read(tmp_path, monkeypatch):
    monkeypatch.setenv('XDG_CACHE_HOME', str(tmp_path))
    design_chart.__wrapped__(8, 3, 0.35, N)
    for module in (control_chart, control_chart.root_finding):
        other = tmp_path / f'{module.__name__}.py'
        other.write_text('other')
        monkeypatch.setattr(module, '__file__', str(other))
        design_chart.__wrapped__(8, 3, 0.35, N)
    assert len([*tmp_path.glob('heading_intercompare/charts/*.json')]) == 3


@pytest.mark.parametrize('text', ['', '[1]', '[1, 2, 3]', 'null', '[1, ["x"], 3]', '\udcff'])
def test_a_damaged_design_is_simulated(text, tmp_path, monkeypatch):
    monkeypatch.setenv('XDG_CACHE_HOME', str(tmp_path))
    simulated = design_chart.__wrapped__(8, 3, 0.35, N)
    place, = tmp_path.glob('heading_intercompare/charts/*.json')
    place.write_bytes(text.encode('utf-8', 'surrogateescape'))
    assert design_chart.__wrapped__(8, 3, 0.35, N) == simulated
    assert json.loads(place.read_text())[2] == simulated.threshold


@pytest.mark.parametrize('folder', ['not/absolute', 'file/below'])
def test_charts_need_no_folder_for_their_designs(folder, tmp_path, monkeypatch):
    (tmp_path / 'file').touch()
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv('XDG_CACHE_HOME', folder if folder.startswith('not') else
                       str(tmp_path / folder))
    assert design_chart.__wrapped__(8, 3, 0.35, N).threshold > 0.0
    assert [*tmp_path.iterdir()] == [tmp_path / 'file']
