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

"""Angles and quaternions in messages of any type, in bags of each kind that hold definitions."""

from __future__ import annotations

from command_line import analyze_json, NORMS, refusal
import numpy as np
import pytest

pytest.importorskip('rosbags', reason='rosbags is not installed')

from driver_bags import build, HEADER, HEADINGS, make_store, N, read, S, STORAGES, T0, write
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import get_types_from_msg


def turned(path, at, convention='enu'):
    """Return a quaternion with the heading of a reading."""
    yaw = np.radians(HEADINGS[at] if convention == 'ned' else 90.0 - HEADINGS[at])
    return {f'{path}.z': float(np.sin(yaw / 2.0)), f'{path}.w': float(np.cos(yaw / 2.0))}


QUATERNIONS = [
    ('geometry_msgs/msg/PoseStamped', 'pose.orientation', ''),
    ('geometry_msgs/msg/PoseWithCovarianceStamped', 'pose.pose.orientation', ''),
    ('geometry_msgs/msg/TransformStamped', 'transform.rotation', ''),
    ('nav_msgs/msg/Odometry', 'pose.pose.orientation', ''),
    ('sensor_msgs/msg/Imu', 'orientation', '@ned'),
    ('sbg_driver/msg/SbgEkfQuat', 'quaternion', '@ned'),
    ('maker_msgs/msg/Attitude', 'imu.orientation', ''),
    ('maker_msgs/msg/Vessel', 'turn', '@enu'),
]


@pytest.mark.parametrize('storage', STORAGES)
@pytest.mark.parametrize('kind, path, axes', QUATERNIONS)
def test_a_quaternion_anywhere_in_a_message_is_a_heading(tmp_path, storage, kind, path, axes):
    bag = write(tmp_path / 'a.bag', storage, {
        '/pose': (kind, lambda at: turned(path, at, axes[1:]))})
    headings, oddities = read(bag, f'pose.{path}{axes}')
    assert headings.stamp_ns.tolist() == [T0 + at * (S // 10) for at in range(N)]
    assert np.abs(np.mod(headings.heading_deg - HEADINGS + 180.0, 360.0) - 180.0).max() < 1e-4
    assert not oddities


@pytest.mark.parametrize('storage', STORAGES)
@pytest.mark.parametrize('kind, path', [
    ('nav_msgs/msg/Odometry', 'pose.pose.orientation'), ('sensor_msgs/msg/Imu', 'orientation')])
def test_a_named_quaternion_is_to_the_bit_that_of_the_type(tmp_path, storage, kind, path):
    bag = write(tmp_path / 'a.bag', storage, {'/pose': (kind, lambda at: turned(path, at))})
    for convention in ('enu', 'ned'):
        assert read(bag, f'pose.{path}', convention)[0] == read(bag, 'pose', convention)[0]


@pytest.mark.parametrize('kind, path', [
    ('sensor_msgs/msg/Imu', 'orientation'), ('maker_msgs/msg/Attitude', 'imu.orientation')])
def test_a_quaternion_that_is_called_unknown_or_is_zero_is_no_heading(tmp_path, kind, path):
    """REP-145: the first covariance is -1."""
    def tell(at):
        fields = turned(path, at) if at != 3 else {}
        return {**fields, f'{path}_covariance': np.array([-1.0 * (at == 5)] + [0.0] * 8)}
    headings, _ = read(write(tmp_path / 'bag', 'mcap', {'/pose': (kind, tell)}), f'pose.{path}')
    assert np.flatnonzero(np.isnan(headings.heading_deg)).tolist() == [3, 5]


ANGLES = [
    ('ixblue_ins_msgs/msg/Ins', 'heading', '', lambda deg: deg),
    ('novatel_oem7_msgs/msg/INSPVA', 'azimuth', '', lambda deg: deg),
    ('septentrio_gnss_driver/msg/AttEuler', 'heading', '@enu', lambda deg: 90.0 - deg),
    ('septentrio_gnss_driver/msg/AttEuler', 'heading', '@ned', lambda deg: deg),
    ('sbg_driver/msg/SbgEkfEuler', 'angle.z', '@rad@enu',
     lambda deg: np.radians(np.mod(270.0 - deg, 360.0) - 180.0)),
    ('ublox_ubx_msgs/msg/UBXNavRelPosNED', 'rel_pos_heading', '', lambda deg: round(deg * 1e5)),
    ('microstrain_inertial_msgs/msg/FilterHeading', 'heading_deg', '', lambda deg: deg),
    ('microstrain_inertial_msgs/msg/FilterHeading', 'heading_rad', '', np.radians),
    ('maker_msgs/msg/Attitude', 'yaw', '@enu', lambda deg: 90.0 - deg),
    ('maker_msgs/msg/Attitude', 'heading', '@0.01deg', lambda deg: round(deg * 100.0)),
    ('maker_msgs/msg/Attitude', 'rpy[2]', '@deg@ned', lambda deg: np.array([1.0, 2.0, deg])),
]


@pytest.mark.parametrize('storage', STORAGES)
@pytest.mark.parametrize('kind, path, words, tell', ANGLES)
def test_an_angle_is_read_in_its_unit_and_sense(tmp_path, storage, kind, path, words, tell):
    bag = write(tmp_path / 'a.bag', storage, {
        '/gps': (kind, lambda at: {path.partition('[')[0]: tell(HEADINGS[at])})})
    headings, oddities = read(bag, f'gps.{path}{words}')
    assert np.abs(np.mod(headings.heading_deg - HEADINGS + 180.0, 360.0) - 180.0).max() < 5e-5
    assert not oddities


@pytest.mark.parametrize('unit, scale', [('deg', 1.0), ('rad', np.pi / 180.0), ('rev', 1 / 360.0)])
def test_a_setting_states_the_unit_of_a_field(tmp_path, unit, scale):
    """It had no say in a bag."""
    bag = write(tmp_path / 'bag', 'mcap', {
        '/gps': ('ixblue_ins_msgs/msg/Ins', lambda at: {'heading': HEADINGS[at] * scale})})
    headings, _ = read(bag, '/gps.heading', unit=unit)
    assert np.abs(np.mod(headings.heading_deg - HEADINGS + 180.0, 360.0) - 180.0).max() < 5e-5


@pytest.mark.parametrize('topic, kind, part', [
    ('/yaw', 'geometry_msgs/msg/PoseStamped', 'pose.orientation'),
    ('/yaw', 'ixblue_ins_msgs/msg/Ins', 'heading')])
def test_what_lies_nearest_to_the_field_says_what_it_is(tmp_path, topic, kind, part):
    """A quaternion of a topic called yaw has its axes, and a heading is one."""
    bag = write(tmp_path / 'bag', 'mcap', {topic: (kind, lambda at: (
        {'heading': HEADINGS[at]} if part == 'heading' else turned(part, at)))})
    headings, oddities = read(bag, f'{topic}.{part}')
    assert headings.heading_deg == pytest.approx(HEADINGS) and not oddities


@pytest.mark.parametrize('storage', STORAGES)
def test_a_field_that_no_name_calls_a_heading_is_said(tmp_path, storage):
    bag = write(tmp_path / 'a.bag', storage, {
        '/euler': ('geometry_msgs/msg/Vector3Stamped', lambda at: {'vector.z': HEADINGS[at]})})
    headings, oddities = read(bag, 'euler.vector.z')
    assert headings.heading_deg.tolist() == HEADINGS.tolist()
    assert oddities == [
        'euler.vector.z: neither the field nor its topic is named a heading; it is read as deg '
        'clockwise from true north: vector.z@ned states that, vector.z@enu the contrary']


@pytest.mark.parametrize('storage', STORAGES)
@pytest.mark.parametrize('kind, part, wrong', [
    ('septentrio_gnss_driver/msg/AttEuler', 'heading',
     'heading: the driver turns angles to ENU by its parameter use_ros_axis_orientation: write '
     'heading@ned if it turns from north over east, heading@enu if from east over north'),
    ('sbg_driver/msg/SbgEkfQuat', 'quaternion', 'by its parameter use_enu: write quaternion@ned'),
    ('maker_msgs/msg/Attitude', 'yaw', 'yaw: a yaw may turn either way: write yaw@ned'),
    ('maker_msgs/msg/Attitude', 'heading', 'is an integer of 32 bits, whose unit nobody states'),
    ('maker_msgs/msg/Attitude', 'imu', 'imu is a message; choose one of its fields: header, '),
    ('maker_msgs/msg/Attitude', 'devices', 'devices is a list; choose a single value'),
    ('nav_msgs/msg/Odometry', 'child_frame_id', 'is a text; name a sentence in it, as in '
     'child_frame_id.HDT'),
    ('std_msgs/msg/String', '', '; name a field: /pose.data.HDT'),
    ('geometry_msgs/msg/PoseStamped', '', 'is geometry_msgs/msg/PoseStamped; a heading is '
     'sensor_msgs/msg/Imu, '),
    ('geometry_msgs/msg/PoseStamped', '', '; name a field: /pose.pose.orientation'),
    ('maker_msgs/msg/Attitude', '', '; name a field: /pose.imu.orientation or /pose.yaw or '
     '/pose.heading'),
    ('std_msgs/msg/Float64', '', '; name a field: /pose.data'),
    ('std_msgs/msg/Float32MultiArray', '', 'of any other type name a field, as in /pose.heading'),
])
def test_what_nobody_states_is_one_line(tmp_path, capsys, storage, kind, part, wrong):
    bag = write(tmp_path / 'a.bag', storage, {'/pose': (kind, lambda at: {})}, 3)
    topic = f'pose.{part}'.rstrip('.')
    said = refusal(capsys, 'analyze', bag, '--ts', topic, '--rs', topic, *NORMS)
    assert wrong in said and said.startswith(f'{bag}: topic /pose')


def test_bags_without_definitions_have_those_of_ros(tmp_path, capsys):
    """Humble and earlier wrote none into SQLite."""
    bag = write(tmp_path / 'bag', 'sqlite', {
        '/pose': ('geometry_msgs/msg/PoseStamped', lambda at: turned('pose.orientation', at)),
        '/gps': ('ixblue_ins_msgs/msg/Ins', lambda at: {'heading': HEADINGS[at]})})
    import sqlite3
    file, = bag.glob('*.db3')
    with sqlite3.connect(file) as connection:
        connection.execute('DELETE FROM message_definitions')
    connection.close()
    assert read(bag, 'pose.pose.orientation')[0].heading_deg == pytest.approx(HEADINGS)
    said = refusal(capsys, 'analyze', bag, '--ts', 'gps.heading', '--rs', 'pose.pose.orientation',
                   *NORMS)
    assert 'topic /gps: the bag holds no definition of ixblue_ins_msgs/msg/Ins; write it' in said
    said = refusal(capsys, 'analyze', bag, '--ts', 'gps', '--rs', 'pose', *NORMS)
    assert 'topic /gps is ixblue_ins_msgs/msg/Ins; a heading is' in said


IDL = f"""\
{"=" * 80}
IDL: maker_msgs/msg/Compass
module maker_msgs {{ module msg {{
  struct Compass {{ std_msgs::msg::Header header; string<8> maker; double heading; }}; }}; }};
{"=" * 80}
IDL: std_msgs/msg/Header
module std_msgs {{ module msg {{
  struct Header {{ builtin_interfaces::msg::Time stamp; string frame_id; }}; }}; }};
{"=" * 80}
IDL: builtin_interfaces/msg/Time
module builtin_interfaces {{ module msg {{
  struct Time {{ int32 sec; uint32 nanosec; }}; }}; }};
"""


@pytest.mark.parametrize('text, wrong', [
    (IDL, ''),
    (IDL.replace('struct Compass', 'struct'), 'the definition of maker_msgs/msg/Compass cannot'),
    ('float64 heading\n' + '#' * 2**18, 'its definition has more than 262144 letters'),
    ('] no definition', 'the definition of maker_msgs/msg/Compass cannot be read')])
def test_a_definition_may_be_idl_and_a_wrong_one_is_one_line(tmp_path, capsys, text, wrong):
    store = make_store('sqlite')
    store.register(get_types_from_msg(HEADER + 'string maker\nfloat64 heading\n',
                                      'maker_msgs/msg/Compass'))
    kind = 'maker_msgs/msg/Compass'
    with Writer(tmp_path / 'bag', version=9, storage_plugin=StoragePlugin.SQLITE3) as writer:
        topic = writer.add_connection('/compass', kind, msgdef=text, rihs01='RIHS01_' + '0' * 64)
        for at in range(N):
            writer.write(topic, T0 + at, store.serialize_cdr(build(store, kind, {
                'header.stamp.sec': at, 'maker': 'm' * (at % 5), 'heading': HEADINGS[at]}), kind))
    if wrong:
        assert wrong in refusal(capsys, 'analyze', tmp_path / 'bag', '--ts', 'compass.heading',
                                '--rs', 'compass.heading', *NORMS)
    else:
        assert read(tmp_path / 'bag', 'compass.heading')[0].heading_deg.tolist() == (
            HEADINGS.tolist())


@pytest.mark.parametrize('storage', STORAGES)
def test_fields_are_judged(tmp_path, capsys, storage):
    rng = np.random.default_rng(3)
    ship = 90.0 + 20.0 * np.sin(np.arange(6000) / 900.0)
    noisy = np.radians(90.0 - ship - 0.1 * rng.standard_normal(6000)) / 2.0
    bag = write(tmp_path / 'a.bag', storage, {
        '/pose': ('geometry_msgs/msg/PoseStamped', lambda at: {
            'pose.orientation.z': float(np.sin(noisy[at])),
            'pose.orientation.w': float(np.cos(noisy[at]))}),
        '/gps': ('novatel_oem7_msgs/msg/INSPVA', lambda at: {'azimuth': ship[at]})}, 6000)
    verdict, _ = analyze_json(capsys, bag, '--ts', 'pose.pose.orientation', '--rs', '/gps.azimuth',
                              '--rs-unit', 'deg')
    run, = verdict['runs']
    assert run['n'] > 5900 and 0.09 < run['std_deg'] < 0.11
