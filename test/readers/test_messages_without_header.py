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

"""Messages without a header have the times that the bag keeps beside them."""

from __future__ import annotations

from command_line import analyze_json, NORMS, refusal
import numpy as np
import pytest

pytest.importorskip('rosbags', reason='rosbags is not installed')

from driver_bags import HEADINGS, N, read, S, STORAGES, T0, write
from mcap.writer import Writer

LATE_NS = 7
LOGGED = [T0 + at * (S // 10) + LATE_NS for at in range(N)]
RECORDED = 'the stamps are the times at which the messages were recorded, later than the headings'
PUBLISHED = 'the stamps are the times at which the messages were published'
SCALARS = [
    ('std_msgs/msg/Float64', '/compass_hdg', 'data', lambda deg: deg),
    ('std_msgs/msg/Float32', '/heading', 'data@rad', np.radians),
    ('std_msgs/msg/UInt16', '/gyro/heading', 'data@0.01deg', lambda deg: round(deg * 100.0)),
    ('geometry_msgs/msg/Vector3', '/euler', 'z@rad@enu', lambda deg: np.radians(90.0 - deg)),
    ('ublox_msgs/msg/NavRELPOSNED9', '/navrelposned', 'rel_pos_heading',
     lambda deg: round(deg * 1e5)),
]


@pytest.mark.parametrize('storage', STORAGES)
@pytest.mark.parametrize('kind, topic, part, tell', SCALARS)
def test_a_number_without_a_header_has_the_log_time_and_a_note(tmp_path, storage, kind, topic,
                                                               part, tell):
    bag = write(tmp_path / 'a.bag', storage, {
        topic: (kind, lambda at: {part.partition('@')[0]: tell(HEADINGS[at])})})
    asked = f'{topic}.{part}'
    headings, oddities = read(bag, asked)
    assert headings.stamp_ns.tolist() == LOGGED
    assert np.abs(np.mod(headings.heading_deg - HEADINGS + 180.0, 360.0) - 180.0).max() < 5e-3
    assert oddities == [f'{asked}: {RECORDED}']


@pytest.mark.parametrize('storage', STORAGES)
@pytest.mark.parametrize('kind, part', [
    ('geometry_msgs/msg/Quaternion', ''), ('geometry_msgs/msg/Pose', 'orientation')])
def test_a_quaternion_without_a_header_is_asked_for_by_its_field(tmp_path, capsys, storage, kind,
                                                                part):
    """A message that is a quaternion itself has no field that holds one."""
    path = f'{part}.' if part else ''
    bag = write(tmp_path / 'a.bag', storage, {'/pose': (kind, lambda at: {
        f'{path}z': float(np.sin(np.radians(90.0 - HEADINGS[at]) / 2.0)),
        f'{path}w': float(np.cos(np.radians(90.0 - HEADINGS[at]) / 2.0))})})
    if part:
        headings, _ = read(bag, f'pose.{part}')
        assert headings.stamp_ns.tolist() == LOGGED
        assert headings.heading_deg == pytest.approx(HEADINGS)
    else:
        assert 'is geometry_msgs/msg/Quaternion; a heading is' in refusal(
            capsys, 'analyze', bag, '--ts', 'pose', '--rs', 'pose', *NORMS)


@pytest.mark.parametrize('storage', STORAGES)
def test_the_log_time_may_replace_the_stamp_of_a_header(tmp_path, storage):
    """A driver that leaves its stamps zero."""
    bag = write(tmp_path / 'a.bag', storage, {'/gps': ('novatel_oem7_msgs/msg/INSPVA', lambda at: {
        'azimuth': HEADINGS[at], 'header.stamp.sec': 0, 'header.stamp.nanosec': 0})})
    headings, oddities = read(bag, 'gps.azimuth@log_time')
    assert headings.stamp_ns.tolist() == LOGGED
    assert oddities == [f'gps.azimuth@log_time: {RECORDED}']
    assert not read(bag, 'gps.azimuth')[0].stamp_ns.any()


def write_published(path, publish_ns, kind='std_msgs/msg/Float64', text='float64 data'):
    """Write numbers as mcap does, each with its publish time."""
    with path.open('wb') as file:
        writer = Writer(file)
        writer.start()
        schema = writer.register_schema(kind, 'ros2msg', text.encode())
        channel = writer.register_channel('/heading', 'cdr', schema)
        for at, ns in enumerate(publish_ns):
            writer.add_message(channel, LOGGED[at], b'\0\1\0\0' + np.float64(
                HEADINGS[at]).tobytes(), ns, at + 1)
        writer.finish()
    return path


def test_a_publish_time_is_taken_where_it_is_asked_for(tmp_path):
    """A message without one is an invalid reading at its log time."""
    published = [ns - 1000 for ns in LOGGED]
    published[3], published[5] = 0, 2**64 - 1
    bag = write_published(tmp_path / 'a.mcap', published)
    headings, oddities = read(bag, 'heading.data@publish_time')
    assert headings.stamp_ns.tolist() == [
        ns - 1000 * (at not in (3, 5)) for at, ns in enumerate(LOGGED)]
    assert np.flatnonzero(np.isnan(headings.heading_deg)).tolist() == [3, 5]
    assert oddities == [f'heading.data@publish_time: {PUBLISHED}; 2 messages have no publish time '
                        'and count as invalid readings']
    assert read(bag, 'heading.data')[0].stamp_ns.tolist() == LOGGED


@pytest.mark.parametrize('storage', ['sqlite', 'ros1'])
def test_a_bag_without_publish_times_is_one_line(tmp_path, capsys, storage):
    bag = write(tmp_path / 'a.bag', storage, {
        '/heading': ('std_msgs/msg/Float64', lambda at: {'data': HEADINGS[at]})})
    said = refusal(capsys, 'analyze', bag, '--ts', 'heading.data@publish_time', '--rs', 'heading',
                   *NORMS)
    assert 'topic /heading: SQLite and ROS 1 keep no publish time; leave @publish_time out' in said


@pytest.mark.parametrize('asked, wrong', [
    ('heading', 'topic /heading is std_msgs/msg/Float64; a heading is sensor_msgs/msg/Imu, '),
    ('heading.gone', "gone: std_msgs/Float64 has no field 'gone'; it has data"),
    ('heading.data@receive_time', 'or one of enu, ned, log_time, publish_time'),
    ('heading.data@log_time@publish_time', 'states both log_time and publish_time; leave one')])
def test_a_number_that_nobody_asked_for_well_is_one_line(tmp_path, capsys, asked, wrong):
    bag = write_published(tmp_path / 'a.mcap', LOGGED)
    assert wrong in refusal(capsys, 'analyze', bag, '--ts', asked, '--rs', 'heading.data', *NORMS)


def test_a_cut_number_is_an_invalid_reading(tmp_path):
    """The type in the bag is longer than what its messages hold."""
    bag = write_published(tmp_path / 'a.mcap', LOGGED, text='float64 data\nfloat64 more')
    headings, oddities = read(bag, 'heading.more')
    assert headings.stamp_ns.tolist() == LOGGED and np.isnan(headings.heading_deg).all()
    assert f'{N} messages cannot be read and count as invalid readings' in oddities[0]


@pytest.mark.parametrize('storage', STORAGES)
def test_numbers_without_headers_are_judged(tmp_path, capsys, storage):
    rng = np.random.default_rng(3)
    ship = 90.0 + 20.0 * np.sin(np.arange(6000) / 900.0)
    bag = write(tmp_path / 'a.bag', storage, {
        '/compass_hdg': ('std_msgs/msg/Float64', lambda at: {
            'data': ship[at] + 0.1 * rng.standard_normal()}),
        '/gps': ('novatel_oem7_msgs/msg/INSPVA', lambda at: {'azimuth': ship[at]})}, 6000)
    verdict, notes = analyze_json(capsys, bag, '--ts', '/compass_hdg.data', '--rs', 'gps.azimuth')
    run, = verdict['runs']
    assert run['n'] > 5900 and 0.09 < run['std_deg'] < 0.11
    assert any(f'/compass_hdg.data: {RECORDED}' in note for note in notes)
