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

"""The figures against heading, rate of turn and skew show what was put into the data."""

from __future__ import annotations

import numpy as np
import pytest

from heading_intercompare import analyze, Headings, Motion, pair, Settings
from heading_intercompare.report import SeriesSketch
from heading_intercompare.report.figures.drawing import LeftOut
from heading_intercompare.report.figures.gallery import collect

pytest.importorskip('matplotlib')

from heading_intercompare.report.figures.style import to_figure  # noqa: E402


def axes_of(sketch, verdict, name):
    """Return the axes of a figure."""
    (drawing,) = collect(sketch, verdict, name)
    return to_figure(drawing).axes[0]


def line(axes, words):
    """Return the values of the line with a label."""
    (found,) = (one for one in axes.lines if str(one.get_label()).startswith(words))
    return np.array(found.get_xdata()), np.array(found.get_ydata())


@pytest.fixture
def late(rng):
    """Return the verdict on a TS that is 0.4 s late, and its sketch."""
    settings = Settings.of(sigma_max_deg=0.3, sigma_ref_max_deg=0.1)
    t = np.arange(6000) / 5.0
    stamps = 1_700_000_000 * 10 ** 9 + (t * 1e9).astype(np.int64)

    def true(at):
        return 180.0 + 20.0 * np.sin(at / 20.0)

    ts = Headings.of(stamps, true(t - 0.4) + rng.normal(0.0, 0.02, t.size))
    rs = Headings.of(stamps, true(t) + rng.normal(0.0, 0.02, t.size))
    sketch = SeriesSketch()
    sketch.update(pair(ts, rs, settings)[0], settings)
    return analyze(ts, rs, settings), sketch


def test_the_slope_against_the_rate_of_turn_is_minus_the_skew(late):
    axes = axes_of(late[1], late[0], 'rate')
    rate, mean = line(axes, 'mean in each')
    assert np.polyfit(rate, mean, 1)[0] == pytest.approx(-0.4, abs=0.02)
    x, y = line(axes, 'latency or clock offset of')
    assert (y[1] - y[0]) / (x[1] - x[0]) == pytest.approx(-0.4, abs=0.01)


def test_the_scatter_is_least_at_the_skew(late):
    axes = axes_of(late[1], late[0], 'skew_scan')
    skew_s, std_deg = line(axes, 'standard deviation')
    assert skew_s[np.argmin(std_deg)] == pytest.approx(0.4, abs=0.05)
    assert line(axes, 'as the verdict estimates')[0][0] == pytest.approx(0.4, abs=0.01)


def test_a_scan_of_the_verdict_goes_before_that_of_the_sketch(late):
    settings = Settings.of(sigma_max_deg=0.3, sigma_ref_max_deg=0.1, alignment_skew='apply')
    t = np.arange(3000) / 5.0
    stamps = 1_700_000_000 * 10 ** 9 + (t * 1e9).astype(np.int64)
    ts = Headings.of(stamps, 100.0 + 20.0 * np.sin((t - 0.4) / 20.0))
    rs = Headings.of(stamps, 100.0 + 20.0 * np.sin(t / 20.0))
    verdict, sketch = analyze(ts, rs, settings), SeriesSketch()
    sketch.update(pair(ts, rs, settings)[0], settings)
    skew_s, _ = line(axes_of(sketch, verdict, 'skew_scan'), 'standard deviation')
    assert skew_s.tolist() == list(verdict.runs[0].skew.scan.curve_s)


def test_the_harmonics_are_those_of_the_verdict(late, rng):
    settings = Settings.of(sigma_max_deg=0.3, sigma_ref_max_deg=0.1)
    true = np.mod(np.arange(7200) * 1.0, 360.0)
    stamps = 1_700_000_000 * 10 ** 9 + np.arange(7200) * 10 ** 9
    wave = 0.2 * np.sin(np.radians(true)) + rng.normal(0.0, 0.05, 7200)
    ts, rs = Headings.of(stamps, np.mod(true + wave, 360.0)), Headings.of(stamps, true)
    sketch = SeriesSketch()
    sketch.update(pair(ts, rs, settings)[0], settings)
    x, y = line(axes_of(sketch, analyze(ts, rs, settings), 'heading'), 'harmonics A to E')
    assert np.interp([90.0, 270.0], x, y) == pytest.approx([0.2, -0.2], abs=0.02)


def bars(axes, words):
    """Return the values of the means with intervals whose label begins so."""
    container, = (c for c in axes.containers if str(c.get_label()).startswith(words))
    return np.array(container.lines[0].get_xydata())


def test_the_means_with_intervals_are_those_of_the_verdict(late):
    """The TS is 0.4 s late on a ship that turns all the time: bands of the rate, and no sector."""
    verdict, sketch = late
    turns = verdict.runs[0].by_motion.turns
    drawn = bars(axes_of(sketch, verdict, 'rate'), 'bands of the verdict')
    known = [at for at, low in enumerate(turns.low_deg) if low is not None]
    assert drawn[:, 0].tolist() == [turns.rate_deg_s[at] for at in known] and len(known) > 1
    assert drawn[:, 1] == pytest.approx(-0.4 * drawn[:, 0], abs=0.02)


def test_the_mean_of_a_heading_that_was_held_is_drawn_with_its_interval(made):
    verdict, sketches = made(1)
    sectors = verdict.runs[0].by_motion.sectors
    known = [at for at, low in enumerate(sectors.low_deg) if low is not None]
    assert [containers.get_label() for containers in
            axes_of(sketches[0], verdict, 'heading').containers] == [
                'steady headings: mean, 95 % interval'] * bool(known)


def test_the_norm_and_the_limit_are_drawn_against_the_heading(made):
    verdict, sketches = made(1, norms__total_error_max_deg=0.75)
    axes, run = axes_of(sketches[0], verdict, 'heading'), verdict.runs[0]
    assert line(axes, 'norm of the total error')[1] == pytest.approx([0.75, 0.75])
    sigma = run.variance_criterion.limit_deg2 ** 0.5
    assert line(axes, 'mean +/- root')[1][0] == pytest.approx(run.mean_deg + sigma)


def test_a_ship_that_does_not_turn_has_no_figure_of_its_rate(made, rng):
    settings = Settings.of(sigma_max_deg=0.3, sigma_ref_max_deg=0.1)
    stamps = 1_700_000_000 * 10 ** 9 + np.arange(600) * 10 ** 9
    ts = Headings.of(stamps, 100.0 + rng.normal(0.0, 0.1, 600))
    rs = Headings.of(stamps, np.full(600, 100.0))
    sketch = SeriesSketch()
    sketch.update(pair(ts, rs, settings)[0], settings)
    (found,) = collect(sketch, analyze(ts, rs, settings), 'rate')
    assert isinstance(found, LeftOut) and 'does not turn' in found.reason


def test_the_figure_says_whose_rate_of_turn_it_shows(late):
    verdict, sketch = late
    (drawing,) = collect(sketch, verdict, 'rate')
    assert drawing.x_label == 'rate of turn of the RS, over 2 s [deg/s]'
    t = np.arange(1200)
    rates = Motion.of_rates(1_700_000_000 * 10 ** 9 + t * 10 ** 9, np.cos(t / 20.0))
    measured = SeriesSketch()
    measured.take_motion(rates)
    stamps = 1_700_000_000 * 10 ** 9 + np.arange(6000) * 2 * 10 ** 8
    true = 180.0 + 20.0 * np.sin(np.arange(6000) / 100.0)
    headings = Headings.of(stamps, true - 0.4 * np.cos(np.arange(6000) / 100.0))
    measured.update(pair(headings, Headings.of(stamps, true), verdict.settings)[0],
                    verdict.settings)
    (drawing,) = collect(measured, verdict, 'rate')
    assert drawing.x_label == 'rate of turn as reported [deg/s]'
    assert 'The rate of turn is that of a sensor of its own' in drawing.caption
    rate, mean = line(axes_of(measured, verdict, 'rate'), 'mean in each')
    assert np.polyfit(rate, mean, 1)[0] == pytest.approx(-0.4, abs=0.02)
