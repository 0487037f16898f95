# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The node that plays bags."""

from __future__ import annotations

import time

from diagnostic_msgs.msg import DiagnosticArray
import numpy as np
import pytest
from rclpy.serialization import serialize_message
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import Imu

from heading_intercompare.bags.errors import BagError
from heading_intercompare.bags.heading_messages import encode_imu
from heading_intercompare.bags.writer import BagWriter, Rows
from heading_intercompare.core.records import Headings
from heading_intercompare.core.settings import SettingsError
from heading_intercompare.nodes import qos
from heading_intercompare.nodes.messages import headings_from
from heading_intercompare.nodes.replayer import Replayer
from heading_intercompare.nodes.stamps import stamp_ns
from heading_intercompare.nodes.status_messages import marker_message, marks_from

T0_NS = 1_700_000_000_000_000_000
HEADINGS = Headings.of(T0_NS + np.arange(300) * 10 ** 8, np.arange(300) % 360.0)


def bag_of(path, marks=()):
    """Write 30 s of both sensors at 10 Hz, and marks at the end of the file."""
    with BagWriter(path) as bag:
        rows = []
        for topic in ('/ts/heading', '/rs/heading'):
            bag.add_topic(topic, 'sensor_msgs/msg/Imu')
            rows.append(Rows(topic, encode_imu(HEADINGS, 'gyro'), HEADINGS.stamp_ns + 5))
        bag.write_rows(rows)
        if marks:
            bag.add_topic('/compliance/marker', 'diagnostic_msgs/msg/DiagnosticArray')
        for kind, ns in marks:
            bag.write('/compliance/marker', serialize_message(marker_message(kind, ns)),
                      T0_NS + 10 ** 12)
    return str(path)


def listeners(ros):
    """Return what the topics of both sensors say."""
    return [ros.listen(Imu, f'{role}/heading', qos.PAIRS) for role in ('ts', 'rs')]


def test_headings_come_as_they_were_recorded_and_then_the_node_is_done(ros, tmp_path):
    node = ros.ours(Replayer, bag=bag_of(tmp_path / 'bag'), rate=0.0)
    ts, rs = listeners(ros)
    ros.spin_until(lambda: node.done)
    ros.spin_until(lambda: len(ts) == len(rs) == 300)
    chunk_ns = headings_from(ts, 'enu').stamp_ns.tolist()
    assert chunk_ns == HEADINGS.stamp_ns.tolist()
    assert headings_from(ts, 'enu') == headings_from(rs, 'enu')
    assert node.published == 600


def test_the_rate_is_kept(ros, tmp_path):
    node = ros.ours(Replayer, bag=bag_of(tmp_path / 'bag'), rate=30.0)
    ts, _ = listeners(ros)
    ros.spin_until(lambda: ts)
    began_s = time.monotonic()
    ros.spin_until(lambda: node.done)
    assert time.monotonic() - began_s == pytest.approx(1.0, abs=0.3)


def test_a_part_can_be_replayed(ros, tmp_path):
    node = ros.ours(Replayer, bag=bag_of(tmp_path / 'bag'), rate=0.0, start_s=10.0,
                    duration_s=5.0)
    ts, _ = listeners(ros)
    ros.spin_until(lambda: node.done)
    ros.spin_until(lambda: len(ts) == 50)
    assert headings_from(ts, 'enu') == HEADINGS[100:150] or headings_from(
        ts, 'enu').stamp_ns.tolist() == HEADINGS.stamp_ns[100:150].tolist()


def test_nothing_is_sent_before_both_topics_are_heard(ros, tmp_path):
    node = ros.ours(Replayer, bag=bag_of(tmp_path / 'bag'), rate=0.0)
    ts = ros.listen(Imu, 'ts/heading', qos.PAIRS)
    ros.spin_until(lambda: ros.executor.spin_once(0.3) is None)
    assert (ts, node.done) == ([], False)
    ros.listen(Imu, 'rs/heading', qos.PAIRS)
    ros.spin_until(lambda: node.done)


def test_marks_come_before_any_heading_wherever_they_stand_in_the_bag(ros, tmp_path):
    marks = [('start', T0_NS + 10 ** 9), ('stop', T0_NS + 2 * 10 ** 9)]
    order = []
    for kind, topic, profile in ((DiagnosticArray, 'compliance/marker', qos.MARKER),
                                 (Imu, 'ts/heading', qos.PAIRS), (Imu, 'rs/heading', qos.PAIRS)):
        for _ in range(2):
            ros.plain.create_subscription(kind, topic, lambda m: order.append(m), profile)
    node = ros.ours(Replayer, bag=bag_of(tmp_path / 'bag', marks), rate=0.0)
    ros.spin_until(lambda: node.done)
    ros.spin_until(lambda: len(order) == 2 * 602)
    first = [m for m in order if isinstance(m, DiagnosticArray)]
    assert order[:4] == first
    assert {mark for m in first for mark in marks_from(m)} == set(marks)


def test_the_clock_of_the_recording_can_be_published(ros, tmp_path):
    heard = ros.listen(Clock, '/clock', qos.CLOCK)
    node = ros.ours(Replayer, bag=bag_of(tmp_path / 'bag'), rate=30.0, clock=True)
    listeners(ros)
    ros.spin_until(lambda: node.done)
    shown = [stamp_ns(m.clock) for m in heard]
    assert len(shown) > 10 and shown == sorted(shown)
    assert T0_NS <= shown[0] and shown[-1] - T0_NS == pytest.approx(30e9, rel=0.1)


def test_without_being_asked_no_clock_is_published(ros, tmp_path):
    ros.ours(Replayer, bag=bag_of(tmp_path / 'bag'))
    assert ros.plain.count_publishers('/clock') == 0


def test_a_loop_begins_again(ros, tmp_path):
    node = ros.ours(Replayer, bag=bag_of(tmp_path / 'bag'), rate=0.0, loop=True,
                    duration_s=1.0)
    ts, _ = listeners(ros)
    ros.spin_until(lambda: len(ts) >= 25)
    assert not node.done
    assert headings_from(ts[:20], 'enu').stamp_ns.tolist() == 2 * HEADINGS.stamp_ns[:10].tolist()


@pytest.mark.parametrize('values, error, message', [
    ({}, SettingsError, 'bag is required'),
    ({'bag': 'no/such/bag'}, OSError, 'No such file'),
    ({'rate': -1.0}, SettingsError, 'rate = -1.0'),
])
def test_a_mistake_ends_the_node_before_it_begins(ros, values, error, message):
    with pytest.raises(error) as raised:
        ros.ours(Replayer, **values)
    assert message in str(raised.value)


def test_a_bag_without_the_topics_is_refused_with_those_it_has(ros, tmp_path):
    with pytest.raises(BagError, match="has no topic 'gyro'; it has /rs/heading"):
        ros.ours(Replayer, bag=bag_of(tmp_path / 'bag'), ts_topic='gyro')
