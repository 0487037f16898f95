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

"""Autocorrelation, spectrum and Allan deviation show the errors that were put in."""

from __future__ import annotations

import numpy as np
import pytest
import scipy
from scipy.integrate import trapezoid

from heading_intercompare import analyze, Headings, pair, Settings
from heading_intercompare.report import SeriesSketch
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


@pytest.fixture(scope='module')
def slow():
    """Return the verdict on errors with a correlation time of 20 s at 2 Hz, and the sketch."""
    rng, n = np.random.default_rng(8), 40_000
    settings = Settings.of(sigma_max_deg=0.3, sigma_ref_max_deg=0.1)
    keep = np.exp(-0.5 / 20.0)
    x = scipy.signal.lfilter([np.sqrt(1.0 - keep ** 2) * 0.2], [1.0, -keep], rng.normal(size=n))
    stamps = 1_700_000_000 * 10 ** 9 + np.arange(n) * 5 * 10 ** 8
    ts, rs = Headings.of(stamps, 100.0 + x), Headings.of(stamps, np.full(n, 100.0))
    sketch = SeriesSketch()
    sketch.update(pair(ts, rs, settings)[0], settings)
    return analyze(ts, rs, settings), sketch


def test_the_autocorrelation_falls_with_the_correlation_time(slow):
    """It is exp(-lag / 20 s); 20 000 s hold 500 correlation times, so 0.15 is three errors."""
    lag_s, r = line(axes_of(slow[1], slow[0], 'autocorrelation'), 'autocorrelation')
    near = lag_s < 60.0
    assert np.abs(r[near] - np.exp(-lag_s[near] / 20.0)).max() < 0.15
    assert lag_s[0] == 0.5 and lag_s[-1] > 1000.0
    assert np.all(np.diff(lag_s) > 0.0)


def test_the_area_below_the_spectrum_is_the_variance(slow):
    f, density = line(axes_of(slow[1], slow[0], 'spectrum'), 'density')
    assert np.all(np.diff(f) > 0.0) and f[-1] <= 1.0
    # From the lowest frequency on; 4 % of the variance lies below 5e-4 Hz.
    assert trapezoid(density, f) == pytest.approx(0.04, rel=0.25)
    level = density[(f > 0.2) & (f < 0.4)]
    expected = 4.0 * 20.0 * 0.04 / (1.0 + (2.0 * np.pi * 0.3 * 20.0) ** 2)
    assert np.median(level) == pytest.approx(expected, rel=0.3)


def test_the_allan_deviation_is_that_of_the_verdict_within_its_bounds(slow):
    axes, run = axes_of(slow[1], slow[0], 'allan'), slow[0].runs[0]
    tau, deviation = line(axes, 'run 1')
    assert deviation.tolist() == list(run.allan.deviation_deg)
    (band,) = axes.collections
    vertices = band.get_paths()[0].vertices
    for at in (0, len(tau) - 1):
        y = vertices[np.isclose(vertices[:, 0], tau[at]), 1]
        assert y.min() < deviation[at] < y.max()
