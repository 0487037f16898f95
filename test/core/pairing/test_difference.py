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

"""GK (1): the difference, its wrap and the installation offset."""

from __future__ import annotations

import numpy as np
import pytest

from heading_intercompare.core.pairing.difference import subtract
from heading_intercompare.core.records import Pairs


def pairs(ts, rs):
    return Pairs.of(np.arange(1, len(ts) + 1), ts, rs)


def test_the_difference_goes_through_north():
    assert subtract(pairs([1.0, 359.0], [359.0, 1.0])).x_deg.tolist() == [2.0, -2.0]


@pytest.mark.parametrize('offset, ts, rs, x', [
    (1.5, 12.0, 10.0, 0.5), (179.9, 189.9, 10.0, 0.0), (-179.9, 190.1, 10.0, 0.0),
    (0.0, 190.0, 10.0, -180.0)])
def test_the_installation_offset_is_removed(offset, ts, rs, x):
    assert subtract(pairs([ts], [rs]), offset).x_deg == pytest.approx([x], abs=1e-12)


def test_the_centre_of_the_wrap_moves_the_cut():
    """Two sensors mounted back to back differ by 180 ± a little: no jump about a centre of 180."""
    back = pairs([190.1, 189.9], [10.0, 10.0])
    assert subtract(back, 0.0, 180.0).x_deg == pytest.approx([180.1, 179.9])
    assert subtract(back).x_deg == pytest.approx([-179.9, 179.9])


def test_what_is_not_finite_stays_so_and_nothing_gives_nothing():
    assert np.isnan(subtract(pairs([np.nan, 1.0], [1.0, np.inf])).x_deg).all()
    assert len(subtract(Pairs.empty())) == 0
