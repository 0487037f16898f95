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

"""A verdict draws its figures in a notebook: all of them, or one by its name."""

from __future__ import annotations

from dataclasses import replace
import pickle
import sys

import numpy as np
import pytest

from heading_intercompare import analyze, Headings, Settings, Verdict
from heading_intercompare.report.figures.gallery import NAMES
from heading_intercompare.report.figures.notebook import Plotter
from heading_intercompare.report.series_sketch import SeriesSketch

pytest.importorskip('matplotlib')

SETTINGS = Settings.of(sigma_max_deg=0.3, sigma_ref_max_deg=0.1)


def readings(rng, start_s=1_700_000_000):
    """Return the readings of a TS and an RS."""
    stamps = (np.arange(600) + start_s) * 10 ** 9
    true = 180.0 + 170.0 * np.sin(np.arange(600) / 40.0)
    return Headings.of(stamps, true + rng.normal(0.0, 0.2, 600)), Headings.of(stamps, true)


def test_one_figure_by_its_name_is_a_figure_of_matplotlib(rng):
    verdict = analyze(*readings(rng), SETTINGS)
    figure = verdict.plot('histogram')
    assert figure.axes[0].get_title(loc='left').startswith('Run 1: size of the differences')
    assert figure._repr_svg_().count('</svg>') == 1


def test_without_a_name_all_figures_come_with_their_captions(rng):
    figures = analyze(*readings(rng), SETTINGS).plot()
    assert len(figures) == len(NAMES) - 1
    shown = figures._repr_html_()
    assert shown.count('<figcaption>') == shown.count('</svg>') == len(figures)
    assert 'Left out: the record has no positions.' in shown


def test_two_inputs_give_a_figure_each(rng):
    ts, rs = zip(readings(rng), readings(rng, 1_700_100_000))
    figures = analyze(ts, rs, SETTINGS).plot('differences')
    assert [figure.axes[0].get_title(loc='left')[:6] for figure in figures] == ['Run 1:', 'Run 2:']


def test_an_unknown_or_absent_figure_is_one_clear_line(rng):
    verdict = analyze(*readings(rng), SETTINGS)
    with pytest.raises(ValueError, match=r"plot\('histo'\): must be one of headings, differences"):
        verdict.plot('histo')
    with pytest.raises(ValueError, match=r"plot\('track'\): the record has no positions"):
        verdict.plot('track')
    with pytest.raises(ValueError, match='there is no difference to draw'):
        Plotter((SeriesSketch(),))(verdict)


def test_without_matplotlib_the_error_says_what_to_install(rng, monkeypatch):
    verdict = analyze(*readings(rng), SETTINGS)
    monkeypatch.delitem(sys.modules, 'heading_intercompare.report.figures.style', raising=False)
    monkeypatch.setitem(sys.modules, 'matplotlib', None)
    # The package remembers the module, too.
    import heading_intercompare.report.figures as room
    monkeypatch.delattr(room, 'style', raising=False)
    with pytest.raises(ValueError, match=r'pip install .heading_intercompare\[report\]'):
        verdict.plot()


def test_a_verdict_that_was_read_back_says_why_it_draws_nothing(rng):
    verdict = analyze(*readings(rng), SETTINGS)
    assert 'plotter' not in verdict.to_dict()
    read = Verdict.from_dict({**verdict.to_dict(), 'plotter': 3})
    assert read.plotter is None and read.to_dict() == verdict.to_dict()
    assert replace(verdict, plotter=None) == verdict
    with pytest.raises(ValueError, match='this verdict knows no readings to draw; judge them'):
        read.plot()


def test_a_verdict_with_figures_travels_between_processes(rng):
    verdict = pickle.loads(pickle.dumps(analyze(*readings(rng), SETTINGS)))
    assert len(verdict.plot()) == len(NAMES) - 1
