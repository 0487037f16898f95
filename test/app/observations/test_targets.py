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

"""What bearings are taken of."""

from __future__ import annotations

import numpy as np
import pytest

from heading_intercompare.app.observations.targets import parse_position, Target

NOWHERE = np.full(2, np.nan)
STAMPS = np.array([1_773_136_800, 1_773_137_800]) * 1_000_000_000


def test_points_are_read_with_spaces_and_commas():
    assert parse_position('54.3 10.2', 'position') == (54.3, 10.2)
    assert parse_position('-54.3, 10.2; 54.4,-10.3', 'line', 2) == (-54.3, 10.2, 54.4, -10.3)


@pytest.mark.parametrize('text', ['54.3', '54.3 10.2 3', '91 10', '54 181', "54°18' 10", 'nan 1',
                                  ''])
def test_what_is_no_point_is_named(text):
    with pytest.raises(ValueError, match=r'--mark .*must be LATITUDE LONGITUDE in decimal'):
        parse_position(text, 'mark')


def test_a_fixed_bearing_needs_no_position():
    found = Target('bearing', (73.42,)).find_bearings(STAMPS, NOWHERE, NOWHERE)
    assert found.bearing_deg.tolist() == [73.42, 73.42] and not found.turn_deg_s.any()
    assert np.isnan(Target().find_bearings(STAMPS, NOWHERE, NOWHERE).bearing_deg).all()


def test_a_line_follows_the_ship_if_its_position_is_known():
    target = Target('line', (54.4, 10.2, 54.41, 10.2), 0.5)
    found = target.find_bearings(STAMPS, NOWHERE, np.array([np.nan, 10.1]))
    # One line north; a tenth of a degree further west it is -0.1 sin(54.4 deg) = -0.0813.
    assert (found.bearing_deg + 180.0) % 360.0 == pytest.approx([180.0, 179.9187], abs=1e-4)
    # sqrt(2) 0.5 m / 1113.3 m = 0.03639 deg
    assert found.common_u_deg == pytest.approx(0.03639, abs=2e-5)
    assert '1113.' in found.words


def test_a_mark_is_seen_from_each_position_and_the_nearest_is_the_least_certain():
    target = Target('mark', (54.4, 10.2), 1.0)
    found = target.find_bearings(STAMPS, np.array([54.39, 54.3]), np.array([10.2, 10.2]))
    assert (found.bearing_deg + 180.0) % 360.0 == pytest.approx([180.0, 180.0], abs=1e-6)
    assert found.common_u_deg == pytest.approx(np.degrees(2 ** 0.5 / 1113.0), rel=1e-3)
    assert np.isnan(target.find_bearings(STAMPS, NOWHERE, NOWHERE).bearing_deg).all()


def test_the_sun_moves_and_sets():
    pytest.importorskip('ephem')
    # 10:00 and 22:00 UTC on 10 March at 54 N 10 E.
    stamps = np.array([1_773_136_800, 1_773_180_000]) * 1_000_000_000
    found = Target('sun').find_bearings(stamps, np.full(2, 54.0), np.full(2, 10.0))
    assert found.below_horizon.tolist() == [False, True]
    # About 15 deg an hour: a little more on the southern side.
    assert 0.0035 < found.turn_deg_s[0] < 0.006
