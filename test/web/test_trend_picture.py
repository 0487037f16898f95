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
from heading_intercompare.web.figures.trend import TrendColumn
from heading_intercompare.web.palettes import draw_trend

COLUMNS = (TrendColumn(1700.0, -0.2, 0.3), TrendColumn(5.0, 0.1, 0.1))


@pytest.mark.parametrize('trend, lines', [
    (TrendView(), 1), (TrendView(COLUMNS), 1), (TrendView(COLUMNS, limit_deg=0.5), 3)])
def test_a_picture_is_xml_with_a_line_per_limit(trend, lines):
    root = ElementTree.fromstring(draw_trend(trend))
    assert len(root.findall('line')) == lines
    assert root.find('path').get('d').count('M') == len(trend.columns)


def test_data_and_limits_are_inside_the_picture():
    text = draw_trend(TrendView((TrendColumn(9.0, -7.0, 9.0),), center_deg=1.0, limit_deg=2.0))
    tops = [float(y) for y in re.findall(r'y1="([-\d.]+)"', text)]
    tops += [float(y) for y in re.findall(r'[V ]([\d.]+)h', text)]
    assert tops and all(0.0 < y < 140.0 for y in tops)
    assert '+3.00°' in text and '-1.00°' in text


def test_the_picture_names_no_colour_so_the_palette_decides():
    assert '#' not in draw_trend(TrendView(COLUMNS, limit_deg=0.5))
