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

from heading_intercompare.core.records import Headings
from heading_intercompare.readers.registry import open_recording
from heading_intercompare.readers.stream_recording import StreamOptions

pytest.importorskip('rosbags', reason='rosbags is not installed')

from rosbags.rosbag1 import Writer as Ros1Writer
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import get_types_from_msg, get_typestore, Stores

S = 10 ** 9
T0 = 1_500_000_000 * S
N = 40
HEADINGS = np.mod(350.0 + 0.75 * np.arange(N), 360.0)
HEADER = 'std_msgs/msg/Header header\n'
#: The layout of drivers' types as far as their headings, by name.
TYPES = {
    'sbg_driver/msg/SbgEkfQuat':
        HEADER + 'uint32 time_stamp\ngeometry_msgs/msg/Quaternion quaternion\n',
    'sbg_driver/msg/SbgEkfEuler':
        HEADER + 'uint32 time_stamp\ngeometry_msgs/msg/Vector3 angle\n',
    'ixblue_ins_msgs/msg/Ins':
        HEADER + 'float64 latitude\nfloat64 longitude\nint8 altitude_ref\nfloat32 altitude\n'
        'float64[9] position_covariance\nfloat32 heading\nfloat32 roll\n',
    'novatel_oem7_msgs/msg/Oem7Header':
        'string message_name\nuint16 message_id\nuint8 message_type\nuint32 gps_week_number\n',
    'novatel_oem7_msgs/msg/INSPVA':
        HEADER + 'novatel_oem7_msgs/msg/Oem7Header nov_header\nfloat64 latitude\n'
        'float64 azimuth\n',
    'septentrio_gnss_driver/msg/BlockHeader': 'uint8 sync_1\nuint16 crc\nuint32 tow\n',
    'septentrio_gnss_driver/msg/AttEuler':
        HEADER + 'septentrio_gnss_driver/msg/BlockHeader block_header\nuint8 nr_sv\n'
        'uint8 error\nuint16 mode\nfloat32 heading\n',
    'ublox_ubx_msgs/msg/UBXNavRelPosNED':
        HEADER + 'uint8 version\nuint16 ref_station_id\nuint32 itow\nint32 rel_pos_heading\n',
    'microstrain_inertial_msgs/msg/FilterHeading':
        HEADER + 'float32 heading_deg\nfloat32 heading_rad\nuint16 status_flags\n',
    'maker_msgs/msg/Attitude':
        HEADER + 'string[] devices\nfloat64[3] rpy\nsensor_msgs/msg/Imu imu\nfloat64 yaw\n'
        'int32 heading\n',
    'maker_msgs/msg/Vessel':
        HEADER + 'maker_msgs/msg/Turn turn\n',
    'maker_msgs/msg/Turn': 'float32 w\nfloat32 x\nfloat32 y\nfloat32 z\n',
}
STORAGES = ('sqlite', 'mcap', 'ros1')


def make_store(storage):
    """Return all types, as they are in a bag of a kind."""
    store = get_typestore(Stores.ROS1_NOETIC if storage == 'ros1' else Stores.ROS2_JAZZY)
    for name, text in TYPES.items():
        store.register(get_types_from_msg(text, name))
    return store


def build(store, type_name, fields):
    """Return a message whose fields are given by path; others are zero."""
    values = {}
    for name, (kind, content) in store.fielddefs[type_name][1]:
        inner = {path.partition('.')[2]: value for path, value in fields.items()
                 if path.partition('.')[0] == name}
        if '' in inner:
            values[name] = inner['']
        elif kind == 2:
            values[name] = build(store, content, inner)
        elif kind in (3, 4):
            (_, base), size = content
            values[name] = ([] if base[0] == 'string' else
                            np.zeros(size if kind == 3 else 0, base[0]))
        else:
            values[name] = '' if content[0] == 'string' else 0
    return store.types[type_name](**values)


def write(path, storage, topics, n=N):
    """Write topics, each a type and a function of n that returns fields; return the path."""
    store = make_store(storage)
    if storage == 'ros1':
        writer, serialize = Ros1Writer(path), store.serialize_ros1
    else:
        writer = Writer(path, version=9, storage_plugin=StoragePlugin.MCAP if storage == 'mcap'
                        else StoragePlugin.SQLITE3)
        serialize = store.serialize_cdr
    with writer:
        connections = {topic: writer.add_connection(topic, kind, typestore=store)
                       for topic, (kind, _) in topics.items()}
        for at in range(n):
            ns = T0 + at * (S // 10)
            for topic, (kind, tell) in topics.items():
                fields = {'header.stamp.sec': ns // S, 'header.stamp.nanosec': ns % S,
                          'header.frame_id': 'x' * (at % 5), **tell(at)}
                writer.write(connections[topic], ns + 7,
                             serialize(build(store, kind, fields), kind))
    return path


def read(path, topic, convention='enu', unit='auto'):
    """Return the headings of a topic, and what is odd about the bag."""
    reader = open_recording(path, options=StreamOptions(unit_of=lambda name: unit))
    return Headings.concatenate([chunk[topic] for chunk in reader.headings({topic: convention})]
                                ), reader.oddities


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
    ('nav_msgs/msg/Odometry', 'child_frame_id', 'child_frame_id: is no number'),
    ('geometry_msgs/msg/PoseStamped', '', 'is geometry_msgs/msg/PoseStamped; a heading is '
     'sensor_msgs/msg/Imu, '),
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
