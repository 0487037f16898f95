# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Lines and bars agree with the axes, and nothing is drawn where nothing was measured."""

from __future__ import annotations

import re
from xml.etree import ElementTree

import numpy as np
import pytest

from heading_intercompare import Pairs, Settings
from heading_intercompare.report import SeriesSketch

pytest.importorskip('matplotlib')

from heading_intercompare.report import graphs  # noqa: E402

SVG, XLINK = '{http://www.w3.org/2000/svg}', '{http://www.w3.org/1999/xlink}'


class Graph:
    """A graph read back: its words, and its lines in the units of the axes."""

    def __init__(self, svg: str) -> None:
        self.root = ElementTree.fromstring(svg)
        self.words = [element.text for element in self.root.iter(f'{SVG}text')]
        self._x, self._y = (self._scale(axis) for axis in 'xy')

    def _scale(self, axis):
        """Return the function from pixels to units, from the first and the last tick."""
        ticks = []
        for group in self.root.iter(f'{SVG}g'):
            if re.search(rf'-{axis}tick_\d+$', group.get('id', '')):
                uses = list(group.iter(f'{SVG}use'))
                ticks.append((float(uses[0].get(axis)),
                              float(next(group.iter(f'{SVG}text')).text)))
        (p0, v0), (p1, v1) = ticks[0], ticks[-1]
        return lambda pixel: v0 + (pixel - p0) * (v1 - v0) / (p1 - p0)

    def lines(self, dash):
        """Return the ends of the lines with a dash, without those of the legend."""
        found = []
        legend = {*next(g for g in self.root.iter(f'{SVG}g')
                        if g.get('id', '').endswith('legend_1')).iter()}
        for path in self.root.iter(f'{SVG}path'):
            if path in legend or dash not in self._dash(path):
                continue
            values = [float(v) for v in re.findall(r'-?[\d.]+', path.get('d'))]
            found.append([(self._x(x), self._y(y)) for x, y in zip(values[::2], values[1::2])])
        return found

    @staticmethod
    def _dash(path):
        """Return the dashes of a line as multiples of its width."""
        style = path.get('style', '')
        dash = re.search(r'stroke-dasharray: ([\d.,]+)', style)
        width = float((re.search(r'stroke-width: ([\d.]+)', style) or ('', '1'))[1])
        return [tuple(round(float(v) / width, 1) for v in dash[1].split(','))] if dash else []


def drawn(verdict, sketch):
    """Return the graphs of a sketch."""
    return [Graph(svg) for svg in graphs.draw_graphs(sketch, verdict, 'x')]


def test_title_units_and_limits_are_in_every_graph(made):
    verdict, sketches = made(1)
    found = drawn(verdict, sketches[0])
    assert len(found) == 3
    for graph in found:
        assert any('Run 1' in words and 'n = 600' in words for words in graph.words)
        assert sum('[deg]' in words for words in graph.words) >= 1
        assert any('GK (' in words for words in graph.words)


def test_a_limit_is_drawn_at_its_level_over_its_run(made):
    verdict, sketches = made(1)
    time, size, _ = drawn(verdict, sketches[0])
    run = verdict.runs[0]
    for dash, limit in (((9.0, 4.0), run.count_criterion.limit_deg),
                        ((2.0, 2.5), run.count_criterion.tightened_limit_deg)):
        levels = [run.mean_deg - limit, run.mean_deg + limit]
        lines = sorted(time.lines(dash), key=lambda line: line[0][1])
        assert [y for line in lines for _, y in line] == pytest.approx(
            np.repeat(levels, 2), abs=2e-3)
        assert [x for x, _ in lines[0]] == pytest.approx([0.0, 599.0], abs=1.0)
        upright = sorted(line[0][0] for line in size.lines(dash))
        assert upright == pytest.approx(levels, abs=2e-3)


def test_the_norm_is_drawn_against_the_heading(made):
    verdict, sketches = made(1, norms__total_error_max_deg=0.75)
    heading = drawn(verdict, sketches[0])[2]
    assert sorted(line[0][1] for line in heading.lines((16.0, 4.0))) == pytest.approx(
        [-0.75, 0.75], abs=2e-3)
    run = verdict.runs[0]
    sigma = run.variance_criterion.limit_deg2 ** 0.5
    assert sorted(line[0][1] for line in heading.lines((9.0, 3.0, 2.0, 3.0))) == pytest.approx(
        [run.mean_deg - sigma, run.mean_deg + sigma], abs=2e-3)


@pytest.mark.slow
@pytest.mark.parametrize('span_s, unit', [(500, 's'), (700, 'min'), (11000, 'h')])
def test_the_axis_of_time_has_the_unit_that_fits(made, span_s, unit):
    verdict, sketches = made(1, n=span_s)
    assert any(words.endswith(f'UTC [{unit}]') for words in drawn(verdict, sketches[0])[0].words)


@pytest.mark.slow
def test_runs_in_one_input_are_told_apart(made):
    """The second run begins 10 000 s, 2.78 h, after the first."""
    verdict, parts = made(2)
    whole, settings = SeriesSketch(), verdict.settings
    for part in parts:
        start = part.time.start_ns
        whole.update(Pairs.of(start + np.arange(600) * 10 ** 9, np.full(600, 10.2),
                              np.full(600, 10.0)), settings)
    time, size, heading = drawn(verdict, whole)
    for graph in (time, size, heading):
        assert any(words.startswith('Runs 1 and 2: ') for words in graph.words)
    assert 'start of a run' in time.words
    assert sorted(line[0][0] for line in time.lines((1.0, 3.0))) == pytest.approx(
        [0.0, 10_000 / 60.0], abs=0.5)
    assert len(time.lines((9.0, 4.0))) == 4
    assert 'outermost limits of GK (*) of the runs' in size.words
    assert len(size.lines((9.0, 4.0))) == 2


def test_no_line_leads_over_a_gap(made, rng):
    verdict, _ = made(1)
    x = rng.normal(0.1, 0.05, 600)
    stamps = 1_700_000_000 * 10 ** 9 + np.arange(600) * 10 ** 9
    for gap_s, joined in ((1, True), (1000, False)):
        sketch = SeriesSketch()
        later = stamps + np.where(np.arange(600) < 300, 0, gap_s * 10 ** 9)
        sketch.update(Pairs.of(later, 100.0 + x, np.full(600, 100.0)), Settings())
        svg = next(graphs.draw_graphs(sketch, verdict, 'x'))
        mean = [path.get('d') for path in ElementTree.fromstring(svg).iter(f'{SVG}path')
                if 'stroke: #1b4f8a' in path.get('style', '') and path.get('d').count('L') > 9]
        assert mean and all((path.count('M') == 1) is joined for path in mean)


def test_a_single_difference_is_a_dot(made):
    verdict, sketches = made(1, n=1)
    time = drawn(verdict, sketches[0])[0]
    assert 'Run 1: difference against time, n = 1' in time.words
    dots = [use for use in time.root.iter(f'{SVG}use')
            if 'fill: #1b4f8a' in use.get('style', '')]
    assert len(dots) == 1


@pytest.mark.slow
def test_the_bars_hold_all_differences(made):
    """The outline of the bars, whose area is n times their width."""
    verdict, sketches = made(1)
    size = drawn(verdict, sketches[0])[1]
    (label,) = (words for words in size.words if words.startswith('number in '))
    width = float(label.split()[2])
    filled = next(path for path in size.root.iter(f'{SVG}path')
                  if 'fill: #c3d3e6' in path.get('style', ''))
    values = [float(v) for v in re.findall(r'-?[\d.]+', filled.get('d'))]
    x = np.array([size._x(v) for v in values[::2]])
    y = np.array([size._y(v) for v in values[1::2]])
    area = abs(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))) / 2.0
    assert area / width == pytest.approx(600.0, rel=5e-3)


def test_a_sketch_without_a_difference_has_no_graph(made):
    assert drawn(made(1)[0], SeriesSketch()) == []
