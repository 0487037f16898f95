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

"""Bags of each kind that holds definitions, with messages of drivers' types, for tests."""

from __future__ import annotations

import numpy as np
from rosbags.rosbag1 import Writer as Ros1Writer
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import get_types_from_msg, get_typestore, Stores

from heading_intercompare.core.records import Headings
from heading_intercompare.readers.registry import open_recording
from heading_intercompare.readers.stream_recording import StreamOptions

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
    'ublox_msgs/msg/NavRELPOSNED9':
        'uint8 version\nuint8 reserved1\nuint16 ref_station_id\nuint32 i_tow\n'
        'int32 rel_pos_heading\nuint8[4] reserved2\n',
    'tf2_msgs/msg/TFMessage': 'geometry_msgs/msg/TransformStamped[] transforms\n',
    'tf/msg/tfMessage': 'geometry_msgs/msg/TransformStamped[] transforms\n',
    'nmea_msgs/msg/Sentence': HEADER + 'string sentence\n',
    'maker_msgs/msg/Text': 'string source\nstring text\n',
    'maker_msgs/msg/Line': HEADER + 'maker_msgs/msg/Text line\n',
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
        if name not in store.fielddefs:
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
            (inner_kind, base), size = content
            values[name] = ([] if inner_kind == 2 or base[0] == 'string' else
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
                fields = {} if 'header' not in dict(store.fielddefs[kind][1]) else {
                    'header.stamp.sec': ns // S, 'header.stamp.nanosec': ns % S,
                          'header.frame_id': 'x' * (at % 5)}
                writer.write(connections[topic], ns + 7,
                             serialize(build(store, kind, {**fields, **tell(at)}), kind))
    return path


def read(path, topic, convention='enu', unit='auto'):
    """Return the headings of a topic, and what is odd about the bag."""
    reader = open_recording(path, options=StreamOptions(unit_of=lambda name: unit))
    return Headings.concatenate([chunk[topic] for chunk in reader.headings({topic: convention})]
                                ), reader.oddities
