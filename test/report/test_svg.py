# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Ticks at round figures, and the markup that everything is made of."""

from __future__ import annotations

from xml.etree import ElementTree

from hypothesis import given, strategies as st
import pytest

from heading_intercompare.core.utc_text import utc
from heading_intercompare.report.formatting import exact, interval, number, value
from heading_intercompare.report.markup import element, join, text
from heading_intercompare.report.svg import nice_step, Plot, ticks


@given(st.floats(1e-9, 1e9), st.integers(2, 12))
def test_a_step_is_round_and_cuts_the_span_into_few_parts(span, at_most):
    step = nice_step(span, at_most)
    assert float(f'{step:.3e}'.split('e')[0]) in (1.0, 2.0, 5.0)
    assert span / at_most * (1 - 1e-6) <= step <= 2.5 * span / at_most * (1 + 1e-6)


def test_ticks_by_hand():
    assert [label for _, label in ticks(-0.25, 0.31, 6)] == ['-0.2', '-0.1', '0.0', '0.1',
                                                             '0.2', '0.3']
    assert [label for _, label in ticks(0.0, 360.0, step=90.0)] == ['0', '90', '180', '270',
                                                                    '360']


@given(st.floats(-1e4, 1e4), st.floats(1e-6, 1e4))
def test_a_label_is_where_it_says(low, span):
    for place, label in ticks(low, low + span):
        assert low - 1e-6 * span <= place <= low + span * (1 + 1e-6)
        assert float(label) == pytest.approx(place, abs=1e-3 * span)


@given(st.text())
def test_any_words_come_back_from_the_markup(words):
    back = ElementTree.fromstring(element('p', words, title=words))
    shown = ElementTree.fromstring(element('p', text(words))).text or ''
    assert (back.text or '') == shown
    assert len(shown) <= len(words)
    assert '<' not in text(words) and '"' not in text(words)


def test_markup_is_not_escaped_again():
    assert element('b', element('i', '&'), join(['<', element('u', '')])) == \
        '<b><i>&amp;</i>&lt;<u></u></b>'


@pytest.mark.parametrize('ends', [(1.0, 1.0), (0.0, float('nan')), (2.0, 1.0)])
def test_an_axis_without_extent_is_refused(ends):
    with pytest.raises(ValueError, match='x_range'):
        Plot(ends, (0.0, 1.0), title='', x_label='', y_label='')


def test_a_point_far_beyond_the_axes_stays_a_finite_pixel():
    plot = Plot((0.0, 1.0), (0.0, 1.0), title='', x_label='', y_label='')
    plot.line([(0.0, 0.5), (0.5, 1e300)])
    root = ElementTree.fromstring(plot.svg())
    line = next(e for e in root.iter() if e.tag.endswith('polyline'))
    assert all(abs(float(c)) < 2000 for p in line.get('points').split() for c in p.split(','))


def test_figures_in_words():
    assert [value(v) for v in (None, '', True, float('nan'), 12, 0.1234567, [1, None], [])] == [
        '-', '-', 'yes', '-', '12', '0.123457', '1, -', '-']
    assert (interval(None, None), interval(1.0, None)) == ('-', '1 .. -')
    assert (exact(0.99999901), exact(None), exact('auto')) == ('0.99999901', '-', 'auto')
    assert number(7_200_000) == '7200000'


def test_stamps_in_words():
    assert utc(1_700_000_000_123_999_999) == '2023-11-14 22:13:20.123'
    assert utc(None) == '-'
