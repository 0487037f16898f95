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

"""The trend as a picture."""

from __future__ import annotations

import re
from xml.etree import ElementTree

import pytest

from heading_intercompare.web.bridge.bridge_records import TrendView
from heading_intercompare.web.drawing.trend_picture import draw_trend, Stretch
from heading_intercompare.web.figures.trend import TrendColumn

T0_NS = 1_700_000_000 * 10 ** 9
COLUMNS = (TrendColumn(1700.0, -0.2, 0.3), TrendColumn(5.0, 0.1, 0.1))


def parse(*trends, **options):
    """Return the picture as elements; it is well-formed."""
    return ElementTree.fromstring(draw_trend(trends, **options))


def bars(root):
    """Return top and bottom of each column in the picture."""
    path = root.find('svg/path').get('d')
    return [(float(top), float(low)) for top, low in re.findall(
        r'M[-\d.]+ ([-\d.]+)h1\.8V([-\d.]+)h', path)]


@pytest.mark.parametrize('trend, bands', [
    (TrendView(), 0), (TrendView(COLUMNS), 0), (TrendView(COLUMNS, limit_deg=0.5), 1)])
def test_a_picture_has_a_bar_per_column_and_a_band_for_the_limits(trend, bands):
    root = parse(trend)
    assert len(root.findall("svg/rect[@class='band']")) == bands
    assert len(bars(root)) == len(trend.columns)


def test_data_and_limits_are_inside_the_picture():
    root = parse(TrendView((TrendColumn(9.0, -1.0, 3.0),), center_deg=1.0, limit_deg=2.0))
    (top, bottom), = bars(root)
    assert 0.0 < top < bottom < 100.0
    labels = [label.text for label in root.findall("span[@class='degrees']")]
    assert labels == ['-1.00°', '+3.00°', '+1.00°']
    assert root.find("span[@class='edge top']") is None


def test_a_fault_leaves_the_sound_part_readable_and_an_edge_says_how_far_it_goes():
    sound = TrendColumn(900.0, 0.1, 0.3)
    root = parse(TrendView((sound, TrendColumn(9.0, 90.0, 90.2)), center_deg=0.2, limit_deg=0.5))
    (top, bottom), (fault_top, _) = bars(root)
    assert bottom - top > 5.0 and fault_top <= 0.0
    assert root.find("span[@class='edge top']").text == 'to +90.2°'


def test_the_picture_names_no_colour_so_the_palette_decides():
    assert '#' not in draw_trend([TrendView(COLUMNS, limit_deg=0.5)])


def test_several_sensors_have_a_line_each_about_their_own_usual_difference():
    trends = [TrendView((TrendColumn(9.0, value, value), TrendColumn(6.0, value, value)),
                        center_deg=value, limit_deg=limit, sensor=name)
              for name, value, limit in (('gyro', 5.0, 0.6), ('ins', -3.0, 0.3))]
    root = parse(*trends, named=['ins'], numbers=[0, 2])
    lines = root.findall('svg/path')
    assert [line.get('class') for line in lines] == ['trace s0 line', 'trace s2 thick line']
    assert all(re.search(r' 50\.00L', line.get('d')) for line in lines)
    assert lines[0].get('stroke-dasharray') == lines[1].get('stroke-dasharray') == 'none'
    assert [label.text for label in root.findall("span[@class='degrees']")] == [
        '-0.60°', '+0.60°', '+0.00°']


def test_a_gap_breaks_a_line():
    ages_s = [100.0, 97.0, 94.0, 10.0, 7.0]
    trend = TrendView(tuple(TrendColumn(age_s, 0.0, 0.1) for age_s in ages_s))
    root = parse(trend, TrendView(sensor='b'))
    assert re.sub(r'[^ML]', '', root.find('svg/path').get('d')) == 'MLLML'


def test_a_stretch_shows_its_columns_and_its_times():
    trend = TrendView(tuple(TrendColumn(60.0 * minute, 0.0, 0.1) for minute in range(30)),
                      newest_ns=T0_NS)
    times = [label.text for label in parse(trend).findall("span[@class='time']")]
    assert times[:2] == ['21:45', '21:50']
    root = parse(trend, stretch=Stretch(1800.0, 0.5, 1.0))
    assert len(bars(root)) == 16
    long = TrendView(COLUMNS, longer=((21600.0, (TrendColumn(20000.0, 0.0, 0.1),)),))
    assert len(bars(parse(long, stretch=Stretch(21600.0)))) == 1


def test_stretches_without_a_comparison_are_hatched():
    root = parse(TrendView(COLUMNS, doubtful=((900.0, 0.0), (99999.0, 98000.0))))
    hatched, = root.findall("svg/rect[@class='doubtful']")
    assert (hatched.get('x'), hatched.get('width')) == ('500.0', '500.0')
