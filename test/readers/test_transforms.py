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


"""Headings of one frame in another, from the transforms of TF in bags of each kind."""

from __future__ import annotations

from command_line import analyze_json, NORMS, refusal
import numpy as np
import pytest

from heading_intercompare.core.records import Headings
from heading_intercompare.messages.byte_columns import FieldColumn, join_messages, read_sound
from heading_intercompare.messages.cdr import encode
from heading_intercompare.messages.errors import MessageError
from heading_intercompare.messages.transform_messages import TRANSFORMS, TransformTopic
from heading_intercompare.readers import topic_decoding

pytest.importorskip('rosbags', reason='rosbags is not installed')

from driver_bags import build, HEADINGS, make_store, N, read, S, STORAGES, T0, write
from rosbags.rosbag2 import StoragePlugin, Writer

STAMPED = 'geometry_msgs/msg/TransformStamped'


def rotation(heading_deg, convention='enu'):
    """Return the rotation with a heading."""
    half = np.radians(heading_deg if convention == 'ned' else 90.0 - heading_deg) / 2.0
    return {'z': float(np.sin(half)), 'w': float(np.cos(half))}


def transform(ns, parent, child, heading_deg, convention='enu'):
    """Return a transform as the fields of a message."""
    return {'header': {'stamp': {'sec': ns // S, 'nanosec': ns % S}, 'frame_id': parent},
            'child_frame_id': child, 'transform': {'rotation': rotation(heading_deg, convention)}}


def flat(fields, prefix=''):
    """Return nested fields by path."""
    paths = {}
    for name, value in fields.items():
        paths |= flat(value, f'{prefix}{name}.') if isinstance(value, dict) else {
            f'{prefix}{name}': value}
    return paths


def write_transforms(path, storage, tell, n=N, more=None, kind=TRANSFORMS):
    """Write messages of TF, each with the transforms that `tell` returns."""
    store = make_store(storage)

    def message(at):
        return {'transforms': [build(store, STAMPED, flat(fields)) for fields in tell(at)]}
    return write(path, storage, {'/tf': (kind, message), **(more or {})}, n)


def several(at):
    """Return no, one, two or three transforms, in any turn."""
    ns = T0 + at * S
    ship = [transform(ns, 'map', 'base_link', HEADINGS[at])]
    return [
        ship, [transform(ns, 'map', 'odom', 5.0), *ship],
        [*ship, transform(ns, 'base_link', 'imu_link_of_the_ship' + 'x' * at, 7.0)],
        [transform(ns, 'base_link', 'map', 9.0), *ship, transform(ns, 'map', 'base_link_2', 8.0)],
        [], [transform(ns, 'odom', 'base_link', 5.0)],
    ][at % 6]


PRESENT = [at for at in range(N) if at % 6 < 4]


@pytest.fixture(params=[1, 7, 4000])
def at_once(request, monkeypatch):
    """Decode so many messages at once: nothing may depend on it."""
    monkeypatch.setattr(topic_decoding, '_MESSAGES', request.param)


@pytest.mark.parametrize('storage', STORAGES)
@pytest.mark.parametrize('asked', ['tf.map:base_link', '/tf./map:/base_link'])
def test_the_transforms_of_two_frames_are_headings_with_their_stamps(tmp_path, at_once, storage,
                                                                     asked):
    bag = write_transforms(tmp_path / 'a.bag', storage, several)
    headings, oddities = read(bag, asked)
    assert headings.stamp_ns.tolist() == [T0 + at * S for at in PRESENT]
    assert headings.heading_deg == pytest.approx(HEADINGS[PRESENT])
    assert not oddities


@pytest.mark.parametrize('storage', STORAGES)
def test_frames_of_early_ros_begin_with_a_slash_and_axes_may_be_stated(tmp_path, storage):
    bag = write_transforms(tmp_path / 'a.bag', storage, lambda at: [
        transform(T0 + at * S, '/local_ned', '/ship.main', HEADINGS[at], 'ned')],
        kind='tf/msg/tfMessage' if storage == 'ros1' else TRANSFORMS)
    headings, _ = read(bag, 'tf.local_ned:ship.main@ned')
    assert headings.heading_deg == pytest.approx(HEADINGS)
    assert headings == read(bag, 'tf.local_ned:ship.main', 'ned')[0]


def test_one_message_may_hold_many_headings(tmp_path, at_once):
    bag = write_transforms(tmp_path / 'bag', 'mcap', lambda at: [
        transform(T0 + at * S + late, 'map', 'base_link', HEADINGS[at]) for late in range(at % 4)])
    headings, _ = read(bag, 'tf.map:base_link')
    assert headings.stamp_ns.tolist() == [
        T0 + at * S + late for at in range(N) for late in range(at % 4)]


def test_a_zero_rotation_is_an_invalid_reading(tmp_path):
    def tell(at):
        fields = transform(T0 + at * S, 'map', 'base_link', HEADINGS[at])
        return [fields if at != 3 else {**fields, 'transform': {'rotation': {'w': 0.0}}}]
    headings, _ = read(write_transforms(tmp_path / 'bag', 'sqlite', tell), 'tf.map:base_link')
    assert np.flatnonzero(np.isnan(headings.heading_deg)).tolist() == [3]


def test_a_cut_message_is_an_invalid_reading_at_its_log_time(tmp_path, at_once):
    store = make_store('mcap')
    with Writer(tmp_path / 'bag', version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        topic = writer.add_connection('/tf', TRANSFORMS, typestore=store)
        for at in range(N):
            data = encode(TRANSFORMS, {'transforms': several(at)})
            writer.write(topic, T0 + at * S + 7, data[:-5] if at in (0, 8) else data)
    headings, oddities = read(tmp_path / 'bag', 'tf.map:base_link')
    assert headings.stamp_ns.tolist() == [T0 + at * S + 7 * (at in (0, 8)) for at in PRESENT]
    assert headings.stamp_ns[np.isnan(headings.heading_deg)].tolist() == [T0 + 7, T0 + 8 * S + 7]
    assert oddities == ['2 messages cannot be read and count as invalid readings; the first: '
                        'tf2_msgs/msg/TFMessage message ends within a transform']


def test_every_cut_of_a_message_and_every_impossible_length_is_refused():
    data = encode(TRANSFORMS, {'transforms': several(3)})
    topic = TransformTopic('map:base_link', 'enu')
    assert len(topic.decode(*join_messages([data])).values[0]) == 1
    for end in range(len(data)):
        with pytest.raises(MessageError):
            topic.decode(*join_messages([data[:end]]))
    for at in (4, 16):
        spoiled = data[:at] + b'\xff\xff\xff\x7f' + data[at + 4:]
        with pytest.raises(MessageError):
            topic.decode(*join_messages([spoiled]))
    column, refused = read_sound(topic.decode, [data, data[:30], data], FieldColumn)
    assert [*map(len, column.values)] == [1, 1] and len(refused) == 1


def test_big_endian_messages_are_read_beside_others():
    little = encode(TRANSFORMS, {'transforms': [transform(T0, 'map', 'ship', 30.0)]})
    # Each value turned round; the frames are names of four letters with the zero.
    big = b'\0\0\0\0' + b''.join(
        little[4 + begin:4 + end][::step] for begin, end, step in [
            (0, 4, -1), (4, 8, -1), (8, 12, -1), (12, 16, -1), (16, 20, 1), (20, 24, -1),
            (24, 29, 1), (29, 32, 1), *((at, at + 8, -1) for at in range(32, 88, 8))])
    topic = TransformTopic('map:ship', 'enu')
    headings = Headings.concatenate(topic.decode(*join_messages([big, little])).values)
    assert headings.heading_deg == pytest.approx([30.0, 30.0])
    assert headings.stamp_ns.tolist() == [T0, T0]


@pytest.mark.parametrize('storage', STORAGES)
@pytest.mark.parametrize('asked, wrong', [
    ('tf', 'a heading is sensor_msgs/msg/Imu, '),
    ('tf', 'name two frames, parent and child, as in /tf.map:base_link'),
    ('tf.map', 'topic /tf: map: must be two frames of TF, parent and child, as in map:base_link'),
    ('tf.map:', 'map:: must be two frames of TF'),
    ('tf.:base_link', ':base_link: must be two frames of TF'),
    ('tf.map:base_link@log_time', 'each transform has a stamp of its own; leave @log_time out'),
    ('tf.map:ship', 'no transform from map to ship; the topic has '),
    ('tf.base_link:base_link_2', 'no transform from base_link to base_link_2; the topic has '
     'map:base_link, '),
])
def test_frames_that_are_not_there_are_one_line(tmp_path, capsys, storage, asked, wrong):
    bag = write_transforms(tmp_path / 'a.bag', storage, several)
    assert wrong in refusal(capsys, 'analyze', bag, '--ts', asked, '--rs', 'tf.map:base_link',
                            *NORMS)


@pytest.mark.parametrize('storage', STORAGES)
def test_transforms_are_judged(tmp_path, capsys, storage):
    rng = np.random.default_rng(3)
    ship = 90.0 + 20.0 * np.sin(np.arange(6000) / 900.0)
    bag = write_transforms(tmp_path / 'a.bag', storage, lambda at: [
        transform(T0 + at * (S // 10), 'odom', 'map', 3.0),
        transform(T0 + at * (S // 10), 'map', 'base_link',
                  ship[at] + 0.1 * rng.standard_normal())], 6000,
        {'/gps': ('novatel_oem7_msgs/msg/INSPVA', lambda at: {'azimuth': ship[at]})})
    verdict, _ = analyze_json(capsys, bag, '--ts', '/tf.map:base_link', '--rs', 'gps.azimuth')
    run, = verdict['runs']
    assert run['n'] > 5900 and 0.09 < run['std_deg'] < 0.11


@pytest.mark.parametrize('change, problem', [
    ({'z': 0.0, 'w': 0.5}, 'a quaternion of norm 0.5: must be 1'),
    (None, 'a stamp with 1000000000 nanoseconds')])
@pytest.mark.parametrize('child, is_asked', [('base_link', True), ('odom', False)])
def test_a_transform_that_is_none_is_refused_if_it_is_asked_for(change, problem, child, is_asked):
    odd, sound = transform(T0, 'map', child, 10.0), transform(T0, 'map', 'base_link', 20.0)
    if change is None:
        odd['header']['stamp']['nanosec'] = S
    else:
        odd['transform']['rotation'] = change
    messages = [encode(TRANSFORMS, {'transforms': [fields]}) for fields in (odd, sound)]
    column, refused = read_sound(TransformTopic('map:base_link', 'enu').decode, messages,
                                 FieldColumn)
    assert [len(headings) for headings in column.values] == ([1] if is_asked else [0, 1])
    assert all(problem in words for words in refused) and len(refused) == is_asked
