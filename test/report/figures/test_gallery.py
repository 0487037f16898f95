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

"""Every figure is there in its order, or left out with a reason; and the page stays small."""

from __future__ import annotations

import numpy as np
import pytest

from heading_intercompare import Pairs, Settings
from heading_intercompare.report import SeriesSketch
from heading_intercompare.report.figures.drawing import Drawing, LeftOut
from heading_intercompare.report.figures.gallery import collect, draw_figures, NAMES

pytest.importorskip('matplotlib')


def test_every_figure_is_drawn_with_caption_units_and_number_or_left_out_with_a_reason(made):
    verdict, (sketch,) = made(1)
    found = list(collect(sketch, verdict))
    assert tuple(one.name for one in found) == NAMES
    for one in found:
        assert one.title.startswith('Run 1: ') and ', n = ' in one.title
        if isinstance(one, Drawing):
            assert one.caption.endswith('.')
            assert '[' in one.x_label or one.is_time and 'UTC' in one.x_label
            assert '[' in one.y_label or one.name in ('autocorrelation', 'histogram')
    assert [one for one in found if isinstance(one, LeftOut)] == [
        LeftOut('track', 'Run 1: track, n = 0', 'the record has no positions')]


def test_a_page_gets_id_title_caption_and_svg(made):
    verdict, (sketch,) = made(1)
    found = draw_figures(sketch, verdict, 'input1')
    assert [one.id for one in found] == [f'input1-{name}' for name in NAMES]
    assert all(one.svg.startswith('<svg ') for one in found[:-1])
    assert found[-1].svg == '' and found[-1].caption == (
        'Left out: the record has no positions.')


def test_a_sketch_without_a_difference_has_no_figure(made):
    assert draw_figures(SeriesSketch(), made(1)[0], 'x') == []


def test_a_single_difference_leaves_out_what_it_cannot_show(made):
    verdict, (sketch,) = made(1, n=1)
    left_out = {one.name for one in collect(sketch, verdict) if isinstance(one, LeftOut)}
    assert left_out == {'running_variance', 'rate', 'skew_scan', 'quantiles', 'autocorrelation',
                        'spectrum', 'allan', 'track'}


@pytest.mark.slow
def test_equal_differences_are_drawn(made):
    verdict, sketches = made(1, noise_deg=0.0)
    assert sum(bool(one.svg) for one in draw_figures(sketches[0], verdict, 'x')) >= 5


@pytest.mark.slow
def test_the_size_does_not_grow_with_the_record(made, rng):
    """12 h at 10 Hz, from a sketch alone; a page has to stay below 3 MB."""
    verdict, _ = made(1)
    sketch, stamps = SeriesSketch(), verdict.runs[0].start_ns + np.arange(3600) * 10 ** 8
    for k in range(120):
        rs = 180.0 + 170.0 * np.sin((np.arange(3600) + 3600 * k) / 400.0)
        sketch.update(Pairs.of(stamps + k * 360 * 10 ** 9, rs + rng.normal(0.0, 0.1, 3600), rs),
                      Settings())
    assert sketch.n == 432_000
    assert sum(len(one.svg) for one in draw_figures(sketch, verdict, 'x')) < 1_000_000
