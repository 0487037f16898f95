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

"""The table of an observer."""

from __future__ import annotations

import numpy as np
import pytest

from heading_intercompare.app.observations.observation_table import read_observation_table
from heading_intercompare.app.observations.targets import Target

QUAY = Target('bearing', (73.42,))


@pytest.fixture
def write(tmp_path):
    """Return a function that writes a table and returns its path."""
    def write(*lines):
        path = tmp_path / 'table.csv'
        path.write_text('\n'.join(lines) + '\n', 'utf-8')
        return str(path)
    return write


def test_each_form_of_observation_gives_the_true_heading(write):
    """
    A quay at 73.42 deg.

    Bow 0.4 m further off over 80 m, port side to: + 0.28648. A mark at 100 deg seen 30 deg on
    the bow: 70. The other ship sees us at 250, so we see it at 70; 10 deg on the bow: 60.
    """
    table = read_observation_table(write(
        'time,true_heading_deg,true_bearing_deg,reciprocal_bearing_deg,relative_bearing_deg,'
        'fore_m,aft_m,base_m,side,ts_bearing_deg,ts_heading_deg',
        '2026-03-10 10:00:00,73.5,,,,,,,,,',
        '2026-03-10T10:01:00Z,,,,,1.9,1.5,80,port,,',
        '2026-03-10 10:02:00,,,,,1.9,1.5,80,Starboard,,',
        '2026-03-10 10:03:00,,100,,30,,,,,,',
        '2026-03-10 10:04:00,,,250,10,,,,,,61.5',
        '2026-03-10 10:05:00,,,,,,,,,74.0,'), QUAY)
    assert table.observations.true_deg == pytest.approx(
        [73.5, 73.70648, 73.13352, 70.0, 60.0, 73.42], abs=1e-5)
    assert table.observations.ts_deg.tolist() == pytest.approx(
        [np.nan] * 4 + [61.5, 74.0], nan_ok=True)
    assert table.observations.stamp_ns[1] == 1_773_136_860_000_000_000
    assert table.ts_step_deg == pytest.approx(0.1)


def test_a_table_of_a_spreadsheet_with_semicolons_and_decimal_commas(write):
    table = read_observation_table(write(
        'stamp_utc;relative_bearing_deg;u_deg;time_u_s;common_u_deg;note;weather',
        '2026-03-10 10:00:00;0,12;0,03;2;0,05;first;rain',
        '2026-03-10 10:01:00;0,13;;;0,07;;'), QUAY, u_deg=0.1, time_u_s=0.5)
    assert table.observations.true_deg == pytest.approx([73.30, 73.29])
    assert table.observations.u_deg.tolist() == [0.03, 0.1]
    assert table.observations.time_u_s.tolist() == [2.0, 0.5]
    assert (table.common_u_deg, table.notes, table.ignored) == (0.07, ('first', ''), ('weather',))
    assert table.ts_step_deg is None


@pytest.mark.parametrize('lines, says', [
    (['time,note'], 'has a header and no observation'),
    (['true_heading_deg', '1'], 'has no column of times'),
    (['time,true_heading_deg', '10:05:30,73'], "line 2: time = '10:05:30' must be a time such"),
    (['time,true_heading_deg', '2026-03-10 10:05,73'], 'with date and seconds'),
    (['time,true_heading_deg', '2026-03-10 10:05:00,N'], "true_heading_deg = 'N' must be a num"),
    (['time,true_heading_deg', '2026-03-10 10:05:00,400'], 'from -360 to 360'),
    (['time,true_heading_deg,u_deg', '2026-03-10 10:05:00,40,-1'], 'u_deg'),
    (['time,true_heading_deg', '2026-03-10 10:05:00,'], 'has no observation: give one of'),
    (['time,true_heading_deg,relative_bearing_deg', '2026-03-10 10:05:00,1,2'],
     'has true_heading_deg and relative_bearing_deg: give one'),
    (['time,true_bearing_deg,reciprocal_bearing_deg,relative_bearing_deg',
      '2026-03-10 10:05:00,1,2,3'], 'true_bearing_deg and reciprocal_bearing_deg'),
    (['time,ts_bearing_deg,ts_heading_deg', '2026-03-10 10:05:00,1,2'],
     'ts_heading_deg and ts_bearing_deg'),
    (['time,fore_m,side', '2026-03-10 10:05:00,1,port'], 'fore_m, aft_m, base_m and side'),
    (['time,fore_m,aft_m,base_m,side', '2026-03-10 10:05:00,1,1,50,left'],
     "line 2: side = 'left'"),
    (['time,true_heading_deg,time', '2026-03-10 10:05:00,1,2'], 'stands twice'),
    (['time,true_heading_deg', '2026-03-10 10:05:00,73,5'], 'more than the header'),
])
def test_what_is_wrong_is_said_in_one_line_with_its_place(write, lines, says):
    with pytest.raises(ValueError, match=r'table\.csv: ') as caught:
        read_observation_table(write(*lines), QUAY)
    assert says in str(caught.value) and '\n' not in str(caught.value)


@pytest.mark.parametrize('target, says', [
    (Target(), 'has no true bearing: give the column true_bearing_deg'),
    (Target('mark', (54.0, 10.0)), 'has no position')])
def test_a_row_without_a_bearing_says_how_to_give_one(write, target, says):
    path = write('time,relative_bearing_deg', '2026-03-10 10:00:00,1')
    with pytest.raises(ValueError, match=says):
        read_observation_table(path, target)


def test_a_sun_below_the_horizon_is_a_wrong_time_or_place(write):
    pytest.importorskip('ephem')
    path = write('time,ts_bearing_deg', '2026-03-10 10:00:00,150', '2026-03-10 22:00:00,150')
    with pytest.raises(ValueError, match='line 3: the sun is below the horizon'):
        read_observation_table(path, Target('sun'), position=(54.0, 10.0))


def test_positions_of_rows_come_before_that_of_all(write):
    target = Target('mark', (54.4, 10.2), 1.0)
    table = read_observation_table(write(
        'time,relative_bearing_deg,latitude_deg,longitude_deg',
        '2026-03-10 10:00:00,0,,', '2026-03-10 10:01:00,0,54.5,10.2'), target,
        position=(54.3, 10.2))
    assert (table.observations.true_deg + 90.0) % 360.0 == pytest.approx([90.0, 270.0], abs=1e-6)
    assert table.target_u_deg > 0.0
