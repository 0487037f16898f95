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

"""A few wild values flatten no figure, and limits stand where the norm puts them."""

from __future__ import annotations

import re

import numpy as np
import pytest
from trials import make_settings

from heading_intercompare import analyze, Headings, pair
from heading_intercompare.report import SeriesSketch
from heading_intercompare.report.figures.drawing import fit_axis, Subject
from heading_intercompare.report.figures.gallery import collect

pytest.importorskip('matplotlib')

from heading_intercompare.report.figures.style import to_figure  # noqa: E402

N = 300


def record(errors, rng, **settings):
    """Return the verdict and the sketch of one record of runs, each with its errors added."""
    rules = make_settings(**settings)
    t = np.concatenate([np.arange(N) + 1500 * run for run in range(len(errors))])
    ship_deg = 180.0 + 170.0 * np.sin(t / 40.0)
    stamps = (1_700_000_000 + t) * 10 ** 9
    error_deg = np.concatenate(errors) + 0.1 * rng.standard_normal(len(t))
    ts = Headings.of(stamps, np.mod(ship_deg + error_deg, 360.0))
    rs = Headings.of(stamps, np.mod(ship_deg + 0.02 * rng.standard_normal(len(t)), 360.0))
    sketch = SeriesSketch()
    sketch.update(pair(ts, rs, rules)[0], rules)
    return analyze(ts, rs, rules), sketch


def good():
    return np.zeros(N)


def wild():
    return np.where(np.arange(N) == 100, 60.0, 0.0)


def stepped():
    return np.where(np.arange(N) >= 120, 4.0, 0.0)


def draw(verdict, sketch, name):
    """Return a figure, and its axes."""
    (drawing,) = collect(sketch, verdict, name)
    return drawing, to_figure(drawing).axes[0]


RECORDS = {'a void run among thirty': lambda: [good()] * 29 + [good() + 90.0],
           'a single outlier': lambda: [wild()]}


@pytest.mark.parametrize('errors', RECORDS.values(), ids=RECORDS)
@pytest.mark.parametrize('name, tallest_deg', [
    ('differences', 8.0), ('histogram', 8.0), ('quantiles', 2.0), ('rate', 30.0),
    ('heading', 30.0)])
def test_wild_values_do_not_flatten_a_figure_and_it_says_how_far_they_go(
        errors, name, tallest_deg, rng):
    drawing, axes = draw(*record(errors(), rng), name)
    low, up = axes.get_xlim() if name == 'histogram' else axes.get_ylim()
    assert up - low < tallest_deg
    legend = ' '.join(str(line.get_label()) for line in axes.lines)
    assert 'eyond the axis: as far as ' in drawing.caption + legend


@pytest.mark.parametrize('name, words, n_lines', [
    ('heading', 'harmonics A to E of each run', 3),
    ('rate', 'latency or clock offset of each run', 3)])
@pytest.mark.parametrize('void, remark', [
    (1, 'The void run has no line here'), (2, 'The 2 void runs have no line here')])
def test_a_void_run_beside_others_has_no_line(name, words, n_lines, void, remark, rng):
    drawing, axes = draw(*record([good()] * 3 + [good() + 90.0] * void, rng), name)
    first = [str(line.get_label()) for line in axes.lines].index(words)
    curves = axes.lines[first:first + n_lines + 1]
    assert len([line for line in curves if line.get_color() == curves[0].get_color()]) == n_lines
    assert max(np.abs(line.get_ydata()).max() for line in curves) < 1.0
    assert remark in drawing.caption


@pytest.mark.parametrize('name', ['heading', 'rate'])
def test_void_runs_alone_keep_their_lines(name, rng):
    drawing, axes = draw(*record([good() + 90.0] * 2, rng), name)
    assert len([line for line in axes.lines if line.get_linestyle() == '--']) >= 2
    assert 'void' not in drawing.caption


def test_the_mark_stands_at_the_time_and_side_of_what_is_beyond_the_axis(rng):
    verdict, sketch = record([wild()], rng)
    _, axes = draw(verdict, sketch, 'differences')
    (mark,) = (line for line in axes.lines if line.get_marker() == '^')
    assert not [line for line in axes.lines if line.get_marker() == 'v']
    assert re.fullmatch(r'beyond the axis: as far as (60|59\.\d|60\.\d) deg', mark.get_label())
    assert mark.get_ydata() == pytest.approx([axes.get_ylim()[1]])


def test_a_sound_record_has_no_mark(rng):
    verdict, sketch = record([good()] * 2, rng)
    for name in ('differences', 'histogram', 'quantiles', 'rate', 'heading', 'skew_scan'):
        drawing, axes = draw(verdict, sketch, name)
        legend = ' '.join(str(line.get_label()) for line in axes.lines)
        assert 'beyond the axis' not in (drawing.caption + legend + drawing.title).lower()
        assert 'stand about' not in drawing.caption


def test_a_fault_of_a_good_part_of_the_record_is_on_the_axis(rng):
    """Three fifths of the run are off by 4 deg: that is the message of the figure."""
    drawing, axes = draw(*record([stepped()], rng), 'differences')
    assert axes.get_ylim()[1] > 4.0 and 'eyond' not in drawing.caption


@pytest.mark.parametrize('errors, settings, center_deg, words', [
    (good, {}, None, ''),
    (lambda: good() + 0.5, {}, None, ''),
    (stepped, {}, 0.0, 'first quarter'),
    (lambda: stepped() + 2.0, {}, 2.0, 'first quarter'),
    (lambda: good() + 90.0, {}, 0.0, 'installation angle as set'),
    (lambda: good() + 90.0, {'installation_offset_deg': 90.0}, None, ''),
    (stepped, {'variant': 'A'}, 0.0, '')])
def test_limits_stand_about_the_mean_unless_a_fault_moved_it(
        errors, settings, center_deg, words, rng):
    verdict, sketch = record([errors()], rng, **settings)
    subject = Subject.of(sketch, verdict)
    (band,) = subject.bands
    run = verdict.runs[0]
    assert band.center_deg == (run.mean_deg if center_deg is None else
                               pytest.approx(center_deg, abs=0.05))
    levels = sorted(level for level, _, _ in band.lines())
    assert levels[-1] - band.center_deg == pytest.approx(run.count_criterion.limit_deg)
    assert words in subject.moved and bool(words) == bool(subject.moved)
    for name in ('differences', 'histogram'):
        assert subject.moved in draw(verdict, sketch, name)[0].caption


@pytest.mark.parametrize('low, up, scale, ends', [
    (-1.0, 1.0, (-1.0, 1.0), (-1.12, 1.12)), (-0.5, 2.5, (-1.0, 1.0), (-1.21, 2.71)),
    (-90.0, 1.0, (-1.0, 1.0), (-3.0, 1.24)), (-90.0, 90.0, (-1.0, 1.0), (-3.0, 3.0)),
    (0.0, 0.0, (0.0, 0.0), (-0.001, 0.001))])
def test_an_axis_reaches_one_width_beyond_what_it_must_show(low, up, scale, ends):
    axis_low, axis_up, words = fit_axis(low, up, scale)
    assert (axis_low, axis_up) == pytest.approx(ends)
    assert bool(words) == (low < axis_low or up > axis_up)
