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

"""Columns of tables that tell the motion of the ship."""

from __future__ import annotations

import numpy as np
import pytest

from heading_intercompare.readers.motion_columns import find_motion_columns, make_motion


@pytest.mark.parametrize('names, found', [
    (['t', 'latitude', 'longitude'], [('fix', ('latitude', 'longitude'), 1.0)]),
    (['cog', 'sog'], []), (['cog_deg', 'sog_mps'], [('velocity', ('cog_deg', 'sog_mps'), 1.0)]),
    (['COG', 'SOG_kts'], [('velocity', ('COG', 'SOG_kts'), 1852 / 3600)]), (['rot'], []),
    (['rot_deg_min'], [('rate', ('rot_deg_min',), 1 / 60)]), (['lat'], []), ([], [])])
def test_a_unit_that_is_not_named_is_not_guessed(names, found):
    assert [tuple(one) for one in find_motion_columns(names)] == [
        (what, of, pytest.approx(factor)) for what, of, factor in found]


def test_rows_without_a_value_are_left_out_and_wrong_ones_counted():
    (column,) = find_motion_columns(['lat', 'lon'])
    rows, wrong = make_motion(column, np.arange(4), [np.array([1.0, np.nan, 91.0, 2.0]),
                                                     np.array([0.0, 0.0, 0.0, -180.0])])
    assert (rows.stamp_ns.tolist(), rows.longitude_deg.tolist(), wrong) == (
        [0, 3], [0.0, -180.0], 1)


def test_no_row_is_no_motion():
    (column,) = find_motion_columns(['rot_deg_s'])
    assert make_motion(column, np.array([], np.int64), [np.array([])])[1] == 0
