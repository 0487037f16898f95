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

"""Roll and pitch in recordings of other programs."""

from __future__ import annotations

import math

import numpy as np
import pytest

from heading_intercompare.bags.mcap.chunk_writer import Rows
from heading_intercompare.bags.recording.bag_writer import BagWriter
from heading_intercompare.bags.rosbag2.bag_reader import BagReader
from heading_intercompare.core.records import Headings
from heading_intercompare.drivers.settings import DriverSettings
from heading_intercompare.messages.heading_messages import encode_imu, IMU
from heading_intercompare.readers.attitude import (
    attitude_of_bag,
    attitude_of_table,
    find_attitude,
)

STAMPS = 1_700_000_000 * 10**9 + 10**9 * np.arange(3)


def write_bag(path, quaternions):
    """Write Imu messages with these orientations: x, y, z, w."""
    data = encode_imu(Headings(STAMPS, np.zeros(3)), 'imu')
    at = data.shape[1] - 8 * (4 + 9 + 3 + 9 + 3 + 9)
    for row, quaternion in zip(data, quaternions):
        row[at:at + 32] = np.frombuffer(np.array(quaternion, '<f8').tobytes(), np.uint8)
    with BagWriter(path) as bag:
        bag.add_topic('imu', IMU)
        bag.write_rows([Rows('imu', data, STAMPS, None, np.arange(3))])
    return BagReader(path)


def test_a_bag_tells_roll_and_pitch(tmp_path):
    """ENU: ten degrees about x is starboard down, ten degrees about y is bow down."""
    c, s = math.cos(math.radians(5.0)), math.sin(math.radians(5.0))
    bag = write_bag(tmp_path / 'bag', [(s, 0, 0, c), (0, s, 0, c), (0, 0, s, c)])
    rows = attitude_of_bag(bag, 'imu', 'enu')
    assert rows.stamp_ns.tolist() == STAMPS.tolist()
    assert rows.roll_deg == pytest.approx([10.0, 0.0, 0.0], abs=1e-9)
    assert rows.pitch_deg == pytest.approx([0.0, -10.0, 0.0], abs=1e-9)
    assert attitude_of_bag(bag, 'imu', 'ned').pitch_deg[1] == pytest.approx(10.0)


def test_headings_alone_are_no_level_ship(tmp_path):
    """A quaternion of a heading has no roll and no pitch to tell; one of zero has nothing."""
    bag = write_bag(tmp_path / 'bag', [(0, 0, 0.6, 0.8), (0, 0, 1, 0), (0, 0, 0, 0)])
    assert not len(attitude_of_bag(bag, 'imu', 'enu'))


def test_a_csv_tells_roll_and_pitch(tmp_path):
    path = tmp_path / 'a.csv'
    path.write_text('utc,heading_deg,roll_deg,pitch_deg\n2024-05-01T00:00:00Z,5,1.5,-0.5\n'
                    '2024-05-01T00:00:01Z,5,,1\n2024-05-01T00:00:02Z,5,2.5,0.5\n',
                    encoding='ascii')
    rows = find_attitude(path, DriverSettings())
    assert rows.roll_deg.tolist() == [1.5, 2.5]
    assert rows.pitch_deg.tolist() == [-0.5, 0.5]
    assert np.diff(rows.stamp_ns).tolist() == [2 * 10**9]


def test_a_csv_without_both_tells_neither(tmp_path):
    path = tmp_path / 'a.csv'
    path.write_text('utc,heading,roll_deg\n2024-05-01T00:00:00Z,5,1.5\n', encoding='ascii')
    assert not len(attitude_of_table(str(path)))
