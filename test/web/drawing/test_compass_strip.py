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

"""The strip of the compass."""

from __future__ import annotations

import re
from xml.etree import ElementTree

import pytest

from heading_intercompare.web.bridge.sensors_panel import SensorRow
from heading_intercompare.web.drawing.compass_strip import draw_strip
from heading_intercompare.web.figures.stream_watch import SensorView


def row(name, heading_deg, reference=False, stale=False, **details):
    now = SensorView(None if stale else heading_deg, heading_deg, 0.1, 10.0, 0.0, 0.0, stale)
    return SensorRow(name, reference, now, title=name, **details)


def places(rows):
    """Return where each marker stands, in percent, and what it looks like."""
    root = ElementTree.fromstring(draw_strip(rows))
    return {place.find('em').text: (float(re.search(r'left:([\d.]+)%', place.get('style'))[1]),
                                    place.get('class'), place.find('svg'))
            for place in root.findall('span')}


def numbers(rows):
    return re.findall(r'<b>(\d{3})</b>', draw_strip(rows))


def test_the_strip_is_about_the_mean_heading_and_shows_a_difference():
    shown = places([row('TS', 46.5), row('RS', 43.5, True)])
    assert shown['TS'][0] == pytest.approx(55.0) and shown['RS'][0] == pytest.approx(45.0)
    assert 'above' in shown['TS'][1] and 'below' in shown['RS'][1]
    assert numbers([row('TS', 46.5), row('RS', 43.5)]) == [
        '030', '035', '040', '045', '050', '055', '060']


def test_north_is_inside_the_strip():
    rows = [row('TS', 359.0), row('RS', 1.0, True)]
    shown = places(rows)
    assert shown['TS'][0] < 50.0 < shown['RS'][0]
    assert '355' in numbers(rows) and '000' in numbers(rows) and '360' not in numbers(rows)


@pytest.mark.parametrize('apart_deg', [1.0, 25.0, 60.0, 91.0, 150.0, 179.0])
def test_the_strip_grows_until_all_sensors_are_on_it(apart_deg):
    shown = places([row('TS', 10.0 + apart_deg), row('RS', 10.0, True)])
    assert 0.0 <= shown['RS'][0] < shown['TS'][0] <= 100.0


def test_the_reference_is_filled_and_what_cannot_be_trusted_is_crossed():
    shown = places([row('a', 45.0), row('b', 46.0, stale=True), row('c', 45.0, named=True),
                    row('d', 45.0, True)])
    crossed = {name for name, (_, _, svg) in shown.items() if len(svg) > 1}
    assert crossed == {'b', 'c'}
    assert 'filled' in shown['d'][2].get('class') and 'open' in shown['a'][2].get('class')


def test_names_that_would_cover_each_other_stand_on_different_lines():
    shown = places([row('a', 45.0), row('b', 45.1), row('c', 58.0)])
    assert 'lane0' in shown['a'][1] and 'lane1' in shown['b'][1] and 'lane0' in shown['c'][1]


def test_a_stale_sensor_does_not_move_the_strip():
    shown = places([row('TS', 200.0, stale=True), row('RS', 45.0, True)])
    assert shown['RS'][0] == pytest.approx(50.0)


def test_a_name_cannot_bring_markup():
    assert '<x>' not in draw_strip([row('<x>', 45.0)])


def test_before_any_heading_the_strip_says_so():
    assert 'no heading' in draw_strip([SensorRow('ts', title='TS')])
