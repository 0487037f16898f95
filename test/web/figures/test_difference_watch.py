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

"""The difference of a tested sensor from the reference."""

from __future__ import annotations

import numpy as np
import pytest

from heading_intercompare.core.records import Pairs
from heading_intercompare.core.settings import Settings
from heading_intercompare.web.figures.difference_watch import DifferenceWatch

S = 10 ** 9


def watch_of(x_deg, variant='B'):
    """Return a watch that took a difference each second."""
    made = DifferenceWatch(Settings(variant=variant, installation_offset_deg=1.0))
    x_deg = np.asarray(x_deg, float)
    stamps = np.arange(1, len(x_deg) + 1) * S
    made.take(Pairs.of(stamps, np.mod(1.0 + x_deg, 360.0), np.zeros(len(x_deg))), 5.0)
    return made


def test_the_newest_difference_has_its_stamp_and_age():
    made = watch_of([0.5, -0.25])
    assert made.x_deg == pytest.approx(-0.25) and made.stamp_ns == 2 * S
    assert made.age_s(7.5) == 2.5
    assert DifferenceWatch(Settings()).age_s(7.5) is None


@pytest.mark.parametrize('variant, center', [('A', 0.0), ('B', 0.2)])
def test_the_centre_is_known_or_the_median(variant, center):
    made = watch_of([0.2] * 600 + [50.0] * 300, variant)
    assert made.follow_center(made.columns(), True, 10.0) == pytest.approx(center)


def test_the_centre_stays_while_the_comparison_is_not_sound():
    made = watch_of([0.2] * 100)
    assert made.follow_center(made.columns(), True, 10.0) == pytest.approx(0.2)
    late = watch_of([9.0] * 100).columns()
    assert made.follow_center(late, False, 60.0) == pytest.approx(0.2)
    assert made.follow_center(late, True, 60.0) == pytest.approx(9.0)


def test_long_trends_are_x_every_ten_seconds():
    made = watch_of([0.2] * 100)
    first = made.longer_columns(10.0)
    made.take(Pairs.of([10 ** 12], [1.3], [0.0]), 12.0)
    assert made.longer_columns(12.0) is first
    assert len(made.longer_columns(20.0)[0][1]) > len(first[0][1])
