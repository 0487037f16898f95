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

"""Lines agree with the axes of time, and nothing is drawn where nothing was measured."""

from __future__ import annotations

import numpy as np
import pytest

from heading_intercompare import Pairs, Settings
from heading_intercompare.report import SeriesSketch
from heading_intercompare.report.figures.drawing import days, LeftOut, LIMIT, START
from heading_intercompare.report.figures.gallery import collect

pytest.importorskip('matplotlib')

from heading_intercompare.report.figures.style import to_figure  # noqa: E402

START_NS = 1_700_000_000 * 10 ** 9


def axes_of(sketch, verdict, name):
    """Return the axes of a figure."""
    (drawing,) = collect(sketch, verdict, name)
    return to_figure(drawing).axes[0]


def lines(axes, words):
    """Return the lines with a label."""
    return [line for line in axes.lines if str(line.get_label()).startswith(words)]


def test_a_limit_is_drawn_at_its_level_over_its_run(made):
    verdict, sketches = made(1)
    run = verdict.runs[0]
    axes = axes_of(sketches[0], verdict, 'differences')
    (upper,) = lines(axes, 'limit of GK (*)')
    assert upper.get_ydata() == pytest.approx([run.mean_deg + run.count_criterion.limit_deg] * 2)
    assert upper.get_xdata() == pytest.approx(days(np.array([run.start_ns, run.end_ns])))
    (tightened,) = lines(axes, 'tightened limit of GK (**)')
    assert tightened.get_ydata()[0] == pytest.approx(
        run.mean_deg + run.count_criterion.tightened_limit_deg)


def test_the_axis_of_time_is_utc(made):
    """1 700 000 000 s is 2023-11-14 22:13:20 UTC."""
    verdict, sketches = made(1)
    axes = axes_of(sketches[0], verdict, 'differences')
    axes.figure.canvas.draw()
    shown = [label.get_text() for label in axes.get_xticklabels()]
    assert '22:15' in shown or '22:14' in shown
    assert axes.xaxis.get_offset_text().get_text().startswith('2023-Nov-14')
    assert axes.get_xlabel() == 'time UTC'


def test_an_outlier_is_marked_and_sound_noise_is_not(made, rng):
    verdict, sketches = made(1)
    assert lines(axes_of(sketches[0], verdict, 'differences'), 'outliers') == []
    x = rng.normal(0.05, 0.2, 600)
    x[400] = 2.5
    sketch = SeriesSketch()
    sketch.update(Pairs.of(START_NS + np.arange(600) * 10 ** 9, 50.0 + x, np.full(600, 50.0)),
                  Settings())
    (found,) = lines(axes_of(sketch, verdict, 'differences'), 'outliers')
    assert found.get_ydata() == pytest.approx([2.5, 2.5], abs=1e-6)
    assert found.get_xdata()[0] == pytest.approx(days(START_NS + 400 * 10 ** 9), abs=1e-5)


@pytest.mark.slow
def test_runs_in_one_record_are_told_apart(made):
    verdict, parts = made(2)
    whole = SeriesSketch()
    for part in parts:
        stamps = part.time.start_ns + np.arange(600) * 10 ** 9
        whole.update(Pairs.of(stamps, np.full(600, 10.2), np.full(600, 10.0)), verdict.settings)
    axes = axes_of(whole, verdict, 'differences')
    starts = [line for line in axes.lines if line.get_color() == START['color']]
    assert [line.get_xdata()[0] for line in starts] == pytest.approx(
        [days(run.start_ns) for run in verdict.runs])
    assert axes.get_title(loc='left').startswith('Runs 1 and 2: ')
    dashed = [line for line in axes.lines if line.get_linewidth() == LIMIT['linewidth']]
    assert len(dashed) == 8


def test_no_line_leads_over_a_gap(made, rng):
    verdict, _ = made(1)
    for gap_s, breaks in ((1, 0), (1000, 1)):
        sketch = SeriesSketch()
        later = np.where(np.arange(600) < 300, 0, gap_s * 10 ** 9)
        sketch.update(Pairs.of(START_NS + np.arange(600) * 10 ** 9 + later,
                               100.0 + rng.normal(0.1, 0.05, 600), np.full(600, 100.0)),
                      Settings())
        (mean,) = lines(axes_of(sketch, verdict, 'differences'), 'mean')
        assert np.isnan(mean.get_ydata()).sum() == breaks


def test_a_single_difference_is_a_dot(made):
    verdict, (sketch,) = made(1, n=1)
    axes = axes_of(sketch, verdict, 'differences')
    assert sum(line.get_marker() == 'o' and len(line.get_xdata()) == 1 for line in axes.lines) == 1


def test_headings_turn_through_north_without_a_line_across(made):
    verdict, _ = made(1)
    rs = np.mod(300.0 + np.arange(600) * 0.5, 360.0)
    sketch = SeriesSketch()
    sketch.update(Pairs.of(START_NS + np.arange(600) * 10 ** 9, np.mod(rs + 0.3, 360.0), rs),
                  Settings())
    axes = axes_of(sketch, verdict, 'headings')
    for name, first in (('RS', 300.0), ('TS', 300.3)):
        (line,) = lines(axes, name)
        y = line.get_ydata()
        assert y[0] == pytest.approx(first, abs=0.5)
        assert np.nanmax(np.abs(np.diff(y))) < 5.0
        assert np.isnan(y).sum() == 1


def test_the_growing_variance_ends_at_that_of_the_run(made):
    verdict, sketches = made(1, sequential__plan_s=6000.0, risk__min_duration_s=60.0)
    run = verdict.runs[0]
    axes = axes_of(sketches[0], verdict, 'running_variance')
    (grown,) = lines(axes, 'variance so far')
    assert grown.get_ydata()[-1] == pytest.approx(run.variance_deg2, rel=1e-9)
    (ends,) = lines(axes, 'bounds of the verdict')
    assert ends.get_ydata() == pytest.approx(
        [run.guarded.lower_bound_deg2, run.guarded.upper_bound_deg2])
    looks = [line for line in axes.lines if line.get_marker() in 'oXD' and
             len(line.get_xdata()) == 1]
    assert len(looks) == len(run.looks) > 0


def test_the_growing_variance_leaves_out_the_stabilisation_period(made):
    verdict, sketches = made(1, runs__stabilization_s=200.0)
    (grown,) = lines(axes_of(sketches[0], verdict, 'running_variance'), 'variance so far')
    assert grown.get_xdata()[0] >= days(START_NS + 199 * 10 ** 9)
    assert grown.get_ydata()[-1] == pytest.approx(verdict.runs[0].variance_deg2, rel=0.01)


def test_a_removed_drift_leaves_out_the_growing_variance(made):
    verdict, sketches = made(1, drift_order=1)
    (left_out,) = collect(sketches[0], verdict, 'running_variance')
    assert isinstance(left_out, LeftOut) and 'drift' in left_out.reason


@pytest.mark.parametrize('name', ['headings', 'differences', 'running_variance'])
def test_what_is_taken_out_is_shaded(made, name):
    begin, end = START_NS + 100 * 10 ** 9, START_NS + 200 * 10 ** 9
    verdict, sketches = made(1, exclusions=f'{begin}, {end}, a tug')
    axes = axes_of(sketches[0], verdict, name)
    (shade,) = (patch for patch in axes.patches if patch.get_label() == 'taken out by hand')
    # A rectangle, or a polygon in earlier versions of matplotlib.
    corners = shade.get_path().vertices
    if hasattr(shade, 'get_patch_transform'):
        corners = shade.get_patch_transform().transform(corners)
    assert (corners[:, 0].min(), corners[:, 0].max()) == pytest.approx((days(begin), days(end)))
    assert shade.get_hatch()


def test_the_growing_variance_is_that_of_the_rest(made):
    begin, end = START_NS + 100 * 10 ** 9, START_NS + 200 * 10 ** 9
    verdict, sketches = made(1, exclusions=f'{begin}, {end}, a tug')
    (grown,) = lines(axes_of(sketches[0], verdict, 'running_variance'), 'variance so far')
    assert grown.get_ydata()[-1] == pytest.approx(verdict.runs[0].variance_deg2, rel=0.01)
