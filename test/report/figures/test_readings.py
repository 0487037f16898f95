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

"""Pictures of what was read: lines, gaps and counts, before anything is judged."""

from __future__ import annotations

from xml.etree import ElementTree

import numpy as np
import pytest

pytest.importorskip('matplotlib')

from heading_intercompare.core.records import Headings, Pairs  # noqa: E402
from heading_intercompare.report import check_picture, write_readings  # noqa: E402
from heading_intercompare.report.figures.readings import draw_counts, draw_readings  # noqa: E402
from heading_intercompare.report.figures.style import to_svg  # noqa: E402

S = 10 ** 9
T0 = 1_700_000_000 * S
SVG = '{http://www.w3.org/2000/svg}'
NO_PAIRS = Pairs.empty()


def headings(seconds, offset_deg=0.0):
    """Return the headings of a ship that turns through north."""
    at = np.asarray(seconds, float)
    return Headings.of(T0 + (at * S).astype(np.int64), (350.0 + 0.1 * at + offset_deg) % 360.0)


def words(drawing):
    """Return the words of a figure."""
    root = ElementTree.fromstring(to_svg(drawing, 'x'))
    return [text.text.replace('\u200b', '') for text in root.iter(f'{SVG}text')]


def test_the_gaps_of_each_stream_are_counted_and_added_up():
    ts = headings([*range(100), *range(160, 300)])
    rs = headings([*range(50), *range(70, 200), *range(230, 300)])
    drawing, = draw_readings({'gyro': ts, 'gnss': rs}, NO_PAIRS)
    shown = words(drawing)
    assert 'headings as read: 240 of gyro, 250 of gnss' in shown
    assert 'gyro: 1 gap, 61 s' in shown and 'gnss: 2 gaps, 52 s' in shown


def test_a_silence_of_a_few_steps_is_no_gap():
    drawing, = draw_readings({'gyro': headings([*range(100), *range(105, 200)])}, NO_PAIRS)
    assert not [text for text in words(drawing) if 'gap' in text]


def test_the_difference_stands_below_where_there_are_pairs():
    pairs = Pairs.of(T0 + np.arange(300) * S, np.full(300, 359.9), np.full(300, 0.1))
    streams = {'gyro': headings(range(300)), 'gnss': headings(range(300))}
    _, drawing = draw_readings(streams, pairs)
    assert (drawing.title, drawing.y_label) == ('gyro - gnss: n = 300', 'difference [deg]')
    assert '-0.2' in ' '.join(words(drawing))


def test_readings_that_cannot_be_drawn_are_left_out():
    """A stamp of zero would stretch the axis to 1970."""
    good = headings(range(300))
    bad = Headings.of([0, T0], [10.0, np.nan])
    shown, alone = (words(draw_readings({'gyro': chunk}, NO_PAIRS)[0])
                    for chunk in (Headings.concatenate([good, bad]), good))
    assert shown == [text.replace('300 of', '302 of') for text in alone]
    draw_readings({'gyro': Headings.empty()}, NO_PAIRS)


def test_each_reason_has_a_bar_with_its_count():
    drawing, = draw_counts({'gyro: burst': 3, 'file: bad_checksum': 12})
    shown = words(drawing)
    assert {'gyro: burst', 'file: bad_checksum', 'not taken: 15'} <= {*shown}
    assert {'3', '12'} <= {text.strip() for text in shown}
    assert draw_counts({}) == []


@pytest.mark.parametrize('name', ['$source', 'a$b$c', '$\\frac$', '_private'])
def test_a_name_is_shown_as_it_is(name):
    drawing, = draw_readings({name: headings(range(300))}, NO_PAIRS)
    shown = words(drawing)
    assert f'headings as read: 300 of {name}' in shown
    assert any(text.startswith(name) for text in shown)
    drawing, = draw_counts({name: 1})
    assert name in words(drawing)


@pytest.mark.parametrize('suffix, begin', [('.png', b'\x89PNG'), ('.pdf', b'%PDF'),
                                           ('.svg', b'<?xml'), ('.PNG', b'\x89PNG')])
def test_the_suffix_chooses_the_form(tmp_path, suffix, begin):
    path = tmp_path / f'read{suffix}'
    write_readings(path, {'gyro': headings(range(300))}, NO_PAIRS, {'gyro: burst': 3})
    assert path.read_bytes().startswith(begin)


def test_another_suffix_is_refused():
    with pytest.raises(ValueError, match='a picture must end in .png or .pdf or .svg'):
        check_picture('read.jpg')
