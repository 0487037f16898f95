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

"""Bars, density and quantiles agree with the differences."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import trapezoid

from heading_intercompare.report.figures.gallery import collect

pytest.importorskip('matplotlib')

from heading_intercompare.report.figures.style import to_figure  # noqa: E402


def axes_of(sketch, verdict, name):
    """Return the axes of a figure."""
    (drawing,) = collect(sketch, verdict, name)
    return to_figure(drawing).axes[0]


def test_the_bars_hold_all_differences_and_the_density_has_their_area(made):
    verdict, sketches = made(1)
    axes = axes_of(sketches[0], verdict, 'histogram')
    counts, edges, _ = axes.patches[0].get_data()
    assert counts.sum() == 600
    (model,) = (line for line in axes.lines if str(line.get_label()).startswith('model NN'))
    area = trapezoid(model.get_ydata(), model.get_xdata())
    assert area == pytest.approx(600 * (edges[1] - edges[0]), rel=1e-3)


@pytest.mark.parametrize('model', ['NN', 'UU'])
def test_normal_quantiles_lie_on_the_line_of_the_normal_model_only(made, model):
    verdict, sketches = made(1, n=3000, model=model)
    axes = axes_of(sketches[0], verdict, 'quantiles')
    (points,) = (line for line in axes.lines if line.get_marker() == 'o')
    expected, found = np.array(points.get_xdata()), np.array(points.get_ydata())
    # The extreme of 3000 normal values is near 3.4 standard deviations, of two uniform near 2.2.
    off = np.abs(found - expected).max() / verdict.runs[0].std_deg
    assert off < 0.5 if model == 'NN' else off > 0.7


def test_an_outlier_is_the_last_quantile(made):
    verdict, sketches = made(1)
    sketches[0].histogram.update(np.array([1.7]))
    sketches[0].n += 1
    sketches[0].time.bins.up_deg[0] = 1.7
    axes = axes_of(sketches[0], verdict, 'quantiles')
    (points,) = (line for line in axes.lines if line.get_marker() == 'o')
    assert max(points.get_ydata()) == pytest.approx(1.7, abs=0.01)


@pytest.mark.slow
def test_several_runs_show_their_outermost_limits(made):
    verdict, sketches = made(2)
    sketches[0].newest_ns = verdict.runs[1].end_ns
    axes = axes_of(sketches[0], verdict, 'histogram')
    (upper,) = (line for line in axes.lines if str(line.get_label()).startswith('outermost'))
    assert upper.get_xdata()[0] == pytest.approx(
        max(run.mean_deg + run.count_criterion.limit_deg for run in verdict.runs))
