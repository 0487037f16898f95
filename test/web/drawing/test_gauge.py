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

"""A figure of the window beside the norm."""

from __future__ import annotations

import re

import pytest

from heading_intercompare.web.drawing.gauge import draw_gauge


@pytest.mark.parametrize('value, norm, width, beyond', [
    (0.1, 0.2, 25.0, False), (0.2, 0.2, 50.0, False), (0.3, 0.2, 75.0, True),
    (9.0, 0.2, 100.0, True), (-0.1, 0.2, 25.0, False)])
def test_full_scale_is_two_norms_and_beyond_the_norm_looks_otherwise(value, norm, width, beyond):
    text = draw_gauge('sd', value, norm)
    assert float(re.search(r'width:([\d.]+)%', text)[1]) == pytest.approx(width)
    assert ('gauge beyond' in text) is ('beyond the norm' in text) is beyond


def test_a_figure_without_a_norm_or_without_a_value_has_no_scale():
    assert 'scale' not in draw_gauge('mean', 0.2, None)
    assert '+0.20°' in draw_gauge('mean', 0.2, None)
    assert '–' in draw_gauge('sd', None, 0.3) and 'scale' not in draw_gauge('sd', None, 0.3)


def test_a_small_norm_has_a_digit_more():
    assert '0.012°' in draw_gauge('sd', 0.0123, 0.05) and '0.12°' in draw_gauge('sd', 0.123, 0.5)
