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

"""The track of a record: runs, legs and outliers where they were, north up."""

from __future__ import annotations

import numpy as np
import pytest

from heading_intercompare import analyze, Headings, Motion, pair, Settings
from heading_intercompare.report import SeriesSketch
from heading_intercompare.report.figures.drawing import LeftOut
from heading_intercompare.report.figures.gallery import collect

pytest.importorskip('matplotlib')

from heading_intercompare.report.figures.style import to_figure, to_svg  # noqa: E402

S, N = 10 ** 9, 1200
START_NS = 1_700_000_000 * S
STAMPS = START_NS + np.arange(N) * S
M_PER_DEG = 111_195.0


def sailed(latitude=54.0, longitude=10.0):
    """Return 10 minutes to the east and 10 to the north, at 10 m/s."""
    t = np.arange(N)
    east = 10.0 * np.minimum(t, 600.0)
    north = 10.0 * np.maximum(t - 600.0, 0.0)
    across = np.cos(np.radians(latitude))
    longitudes = (longitude + east / M_PER_DEG / across + 180.0) % 360.0 - 180.0
    courses = np.where(t < 600, 90.0, 0.0)
    return courses, (Motion.of_positions(STAMPS, latitude + north / M_PER_DEG, longitudes)
                     + Motion.of_courses(STAMPS, courses, np.full(N, 19.4)))


@pytest.fixture
def record(rng):
    """Return a function that makes a verdict and its sketch; one difference is far out."""
    def make(*, where=(54.0, 10.0), gap=False, **given):
        settings = Settings.of(sigma_max_deg=0.3, sigma_ref_max_deg=0.1, **given)
        courses, motion = sailed(*where)
        ts, rs = (courses + 0.05 * rng.standard_normal(N) for _ in range(2))
        ts[300] += 5.0
        keep = ~((np.arange(N) > 500) & (np.arange(N) < 700)) if gap else np.ones(N, bool)
        ts, rs = (Headings.of(STAMPS[keep], np.mod(one[keep], 360.0)) for one in (ts, rs))
        sketch = SeriesSketch()
        sketch.take_motion(motion)
        sketch.update(pair(ts, rs, settings)[0], settings)
        return analyze(ts, rs, settings, motion=motion), sketch
    return make


def axes_of(made):
    """Return drawing and axes of the track."""
    verdict, sketch = made
    (drawing,) = collect(sketch, verdict, 'track')
    assert not isinstance(drawing, LeftOut)
    return drawing, to_figure(drawing).axes[0]


def lines(axes, words):
    """Return the values of the lines with a label that begins so."""
    return [(np.array(one.get_xdata()), np.array(one.get_ydata())) for one in axes.lines
            if str(one.get_label()).startswith(words)]


@pytest.mark.parametrize('where', [(54.0, 10.0), (-60.0, 179.99)])
def test_a_run_lies_where_the_ship_was(record, where):
    drawing, axes = axes_of(record(where=where))
    ((east, north),) = lines(axes, 'run 1')
    assert (east[0], north[0]) == (0.0, 0.0) and '[km]' in drawing.x_label
    assert east[-1] == pytest.approx(6.0, rel=0.002) and north[-1] == pytest.approx(6.0, rel=0.01)
    assert axes.get_aspect() == 1.0
    assert 'North is up' in drawing.caption and drawing.title == 'Run 1: track, n = 1200'


def test_the_legs_of_the_verdict_and_the_outlier_are_on_it(record):
    verdict, sketch = record()
    assert len(verdict.runs[0].motion.legs) == 2
    _, axes = axes_of((verdict, sketch))
    ((east, north),) = lines(axes, 'straight legs')
    assert np.ptp(east) > 5.0 and np.ptp(north) < 0.01
    ((east, north),) = lines(axes, 'outlying')
    assert east == pytest.approx([3.0], abs=0.03) and north == pytest.approx([0.0], abs=0.01)


def test_runs_differ_without_colour_and_carry_their_numbers(record):
    _, axes = axes_of(record(gap=True))
    styles = [one.get_linestyle() for one in axes.lines
              if str(one.get_label()).startswith('run ')]
    assert len(styles) == 2 and styles[0] != styles[1]
    assert {'1', '2', 'N'} <= {text.get_text() for text in axes.texts}


def test_the_bar_has_a_round_length(record):
    _, axes = axes_of(record())
    bar = next(one for one in axes.lines if one.get_linewidth() == 2.5)
    assert np.ptp(np.array(bar.get_xdata())) == pytest.approx(1.0)
    assert '1 km' in {text.get_text() for text in axes.texts}


def test_a_short_way_is_in_metres(record):
    verdict, _ = record()
    sketch = SeriesSketch()
    sketch.take_motion(Motion.of_positions(STAMPS[:9], 54.0 + 1e-6 * np.arange(9), [10.0] * 9))
    courses, _ = sailed()
    both = [Headings.of(STAMPS, courses + 0.01 * np.arange(N) % 2) for _ in range(2)]
    sketch.update(pair(*both, verdict.settings)[0], verdict.settings)
    drawing, axes = axes_of((verdict, sketch))
    assert '[m]' in drawing.x_label and '20 cm' not in str(axes.texts)
    assert to_svg(drawing, 'x').startswith('<svg ')


def test_without_positions_it_is_left_out_with_the_reason(record):
    verdict, _ = record()
    sketch = SeriesSketch()
    courses, motion = sailed()
    sketch.take_motion(motion.velocities())
    headings = Headings.of(STAMPS, courses)
    sketch.update(pair(headings, headings, verdict.settings)[0], verdict.settings)
    (found,) = collect(sketch, verdict, 'track')
    assert isinstance(found, LeftOut) and found.reason == 'the record has no positions'
    verdict, sketch = record(motion_compare=False)
    (found,) = collect(sketch, verdict, 'track')
    assert found.reason == 'motion.compare is false, so no positions are read'


def test_a_notebook_draws_it(rng):
    courses, motion = sailed()
    ts, rs = (Headings.of(STAMPS, courses + 0.1 * rng.random(N)) for _ in range(2))
    verdict = analyze(ts, rs, Settings.of(sigma_max_deg=0.3, sigma_ref_max_deg=0.1),
                      motion=motion)
    assert verdict.plot('track').axes[0].get_title(loc='left') == 'Run 1: track, n = 1200'
