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

"""What is wrong with the graph itself is an alarm of the node that keeps the alarms."""

from __future__ import annotations

import time

from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import TwistStamped
from nodes.inside_nodes import judgement_of, panel_of
import pytest
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import Imu
from std_msgs.msg import String

from heading_intercompare.bags.recording.bag_writer import BagWriter
from heading_intercompare.core.alarms.alarm import AlarmState
from heading_intercompare.core.records import Headings
from heading_intercompare.messages.heading_messages import imu_messages
from heading_intercompare.messages.heartbeat_messages import HEARTBEAT_TOPIC
from heading_intercompare.nodes.compliance import Compliance
from heading_intercompare.nodes.interface import qos
from heading_intercompare.nodes.presence.health import Health
from heading_intercompare.nodes.recorder import Recorder
from heading_intercompare.nodes.synchronizer import Synchronizer

T0_NS = 1_700_000_000_000_000_000


def raised(keeper, name):
    """Return whether an alarm is active on the panel of a node; False if it is not known."""
    return name in panel(keeper) and panel(keeper)[name].state.active


def panel(keeper):
    """Return the alarms of a node by name."""
    return {alarm.rule.name: alarm for alarm in panel_of(keeper)._table.alarms}


def times(keeper):
    """Return how often each alarm about the graph was raised, of those that were."""
    return {name: alarm.times for name, alarm in panel(keeper).items() if alarm.times}


def headings(first, last):
    """Return headings as messages, one a second."""
    return imu_messages(Headings.of([T0_NS + at * 10 ** 9 for at in range(first, last)],
                                    [90.0] * (last - first)), 'x')


def test_a_full_disk_raises_an_alarm_until_it_is_written_again(ros, tmp_path, monkeypatch):
    keeper = ros.ours(Compliance)
    ros.ours(Recorder, output=str(tmp_path / 'bag'))
    sensor = ros.plain.create_publisher(Imu, 'ts/heading', qos.HEADINGS_OUT)
    ros.spin_until(lambda: sensor.get_subscription_count() == 1)

    def fail(bag, now_s):
        raise OSError(28, 'No space left on device', 'bag_0.mcap')
    with monkeypatch.context() as patch:
        patch.setattr(BagWriter, 'flush_if_due', fail)
        for message in headings(0, 20):
            sensor.publish(message)
        ros.spin_until(lambda: raised(keeper, 'not_recorded') and panel(
            keeper)['not_recorded'].words == 'recorder: bag_0.mcap: No space left on device')
    ros.spin_until(lambda: not raised(keeper, 'not_recorded'))
    assert panel(keeper)['not_recorded'].state is AlarmState.RECTIFIED
    assert times(keeper) == {'not_recorded': 1}, 'once, although each try to write fails anew'
    # Times about the graph are those of day, also while the data are of another year.
    assert abs(panel(keeper)['not_recorded'].raised_ns - time.time_ns()) < 600e9


def test_a_journal_that_cannot_be_written_is_an_alarm(ros, tmp_path):
    place = tmp_path / 'file'
    place.touch()
    keeper = ros.ours(Compliance, journal=str(place / 'trial.journal'))
    ros.spin_until(lambda: raised(keeper, 'not_written'))
    assert 'the run in progress is not kept' in panel(keeper)['not_written'].words


def test_a_report_that_cannot_be_written_is_an_alarm_until_one_is(ros, tmp_path):
    keeper = ros.ours(Compliance, report_dir=str(tmp_path / 'reports'), journal='-')
    (tmp_path / 'reports').rmdir()
    judgement_of(keeper).reporting._write('{}')
    ros.spin_until(lambda: raised(keeper, 'not_written'))
    (tmp_path / 'reports').mkdir()
    judgement_of(keeper).reporting._write('{}')
    ros.spin_until(lambda: not raised(keeper, 'not_written'))


def test_two_publishers_of_a_sensor_are_an_alarm_until_one_goes(ros):
    keeper = ros.ours(Compliance)
    ros.ours(Synchronizer)
    others = [ros.add(Node, name) for name in ('gyro', 'rival')]
    publishers = [node.create_publisher(Imu, 'ts/heading', qos.HEADINGS_OUT) for node in others]
    ros.spin_until(lambda: raised(keeper, 'two_publishers'))
    assert 'gyro, rival' in panel(keeper)['two_publishers'].words
    others[1].destroy_publisher(publishers[1])
    ros.spin_until(lambda: not raised(keeper, 'two_publishers'))


def test_a_mismatch_of_the_qos_is_an_alarm_until_it_is_mended(ros):
    """A volatile publisher of marks, which a subscription for late marks does not hear."""
    keeper = ros.ours(Compliance)
    marks = ros.plain.create_publisher(DiagnosticArray, 'compliance/marker', QoSProfile(depth=1))
    ros.spin_until(lambda: raised(keeper, 'mismatch'))
    assert 'QoS mismatch on compliance/marker: DURABILITY' in panel(keeper)['mismatch'].words
    ros.plain.destroy_publisher(marks)
    ros.spin_until(lambda: not raised(keeper, 'mismatch'))


@pytest.mark.parametrize('kind, profile', [
    (String, QoSProfile(depth=1)),
    (TwistStamped, QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT,
                              durability=DurabilityPolicy.TRANSIENT_LOCAL))])
def test_a_publisher_of_pairs_that_compliance_cannot_hear_is_an_alarm(ros, kind, profile):
    keeper = ros.ours(Compliance)
    ros.plain.create_publisher(kind, 'pairs', profile)
    ros.spin_until(lambda: raised(keeper, 'mismatch'))


def test_readings_lost_on_the_way_are_an_alarm_that_passes(ros, monkeypatch):
    monkeypatch.setattr('heading_intercompare.nodes.taking.intake._LOSING_S', 2.0)
    keeper = ros.ours(Compliance)
    synchronizer = ros.ours(Synchronizer, subscribers=0, startup_wait_s=0.0)
    sensor = ros.plain.create_publisher(Imu, 'ts/heading', QoSProfile(
        depth=1, reliability=ReliabilityPolicy.BEST_EFFORT))
    ros.spin_until(lambda: sensor.get_subscription_count() == 1)
    intake = synchronizer._headings.intakes['ts']
    sensor.publish(headings(0, 1)[0])
    ros.spin_until(lambda: intake.received == 1)
    ros.plain.destroy_publisher(sensor)
    missing = iter((7, 7, 7))
    monkeypatch.setattr(type(intake), 'lost', property(lambda self: next(missing, 7)
                                                       if self is intake else 0))
    ros.spin_until(lambda: raised(keeper, 'lost_on_the_way'))
    assert 'synchronizer: 7 messages lost on the way' in panel(keeper)['lost_on_the_way'].words
    ros.spin_until(lambda: not raised(keeper, 'lost_on_the_way'))


def test_a_sound_graph_raises_nothing_and_its_heartbeats_come_every_second(ros, tmp_path):
    beats = ros.listen(DiagnosticArray, HEARTBEAT_TOPIC, qos.DIAGNOSTICS_IN)
    keeper, synchronizer = ros.ours(Compliance), ros.ours(Synchronizer)
    recorder = ros.ours(Recorder, output=str(tmp_path / 'bag'))
    ros.spin_until(lambda: len(beats) >= 24)
    assert {s.name for m in beats for s in m.status} == {'compliance', 'synchronizer', 'recorder'}
    assert all(s.hardware_id.startswith(f'/{s.name} ') and m.header.stamp.sec > 0
               for m in beats for s in m.status)
    assert times(keeper) == times(synchronizer) == times(recorder) == {}
    assert {'recorder_silent', 'synchronizer_silent'} <= panel(keeper).keys()
    assert panel(recorder).keys() == {'compliance_silent'}
    ros.end(recorder)
    began_s = time.monotonic()
    ros.spin_until(lambda: time.monotonic() > began_s + 8.0)
    assert times(keeper) == {}


def test_a_message_that_is_no_heartbeat_does_no_harm(ros):
    keeper = ros.ours(Compliance)
    stranger = ros.plain.create_publisher(DiagnosticArray, HEARTBEAT_TOPIC, qos.STATUS)
    ros.spin_until(lambda: stranger.get_subscription_count() == 1)
    stranger.publish(DiagnosticArray())
    Health(ros.add(Node, 'ts_driver'))
    ros.spin_until(lambda: 'ts_driver_silent' in panel(keeper))
    assert times(keeper) == {}


def test_a_node_that_gives_way_to_another_graph_is_not_missed(ros):
    """It was heard, and ends at once, with exit code 2."""
    keeper = ros.ours(Compliance)
    node = ros.add(Node, 'ts_driver')
    health = Health(node)
    ros.spin_until(lambda: 'ts_driver_silent' in panel(keeper))
    health.mute()
    ros.spin_until(lambda: ros.executor.spin_once(0.2) is None)
    ros.executor.remove_node(node)
    began_s = time.monotonic()
    ros.spin_until(lambda: time.monotonic() > began_s + 7.0)
    assert times(keeper) == {}
