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

"""A second graph in one namespace is refused; a dead node is in nobody's way."""

from __future__ import annotations

import time

from deadlines import Stopwatch
from diagnostic_msgs.msg import DiagnosticArray
from nodes.lines import free_port
import pytest
from rclpy.node import Node
from sensor_msgs.msg import Imu
from std_msgs.msg import String

from heading_intercompare.core.declared_settings import SettingsError
from heading_intercompare.nodes.compliance import Compliance
from heading_intercompare.nodes.interface import qos
from heading_intercompare.nodes.nmea_driver import NmeaDriver
from heading_intercompare.nodes.sensor_simulator import SensorSimulator
from heading_intercompare.nodes.synchronizer import Synchronizer


def spin_for(ros, span_s):
    """Spin for a time in which something must not happen."""
    end_s = time.monotonic() + span_s
    ros.spin_until(lambda: time.monotonic() > end_s)


@pytest.mark.parametrize('make, topic', [(Compliance, '/compliance/report'),
                                         (Synchronizer, '/pairs')])
def test_a_second_graph_is_refused_in_one_line_that_names_the_first(ros, make, topic):
    """Before, both judged the pairs of both, and the verdict was wrong."""
    first = ros.ours(make)
    spin_for(ros, 0.3)
    ros.ours(make)
    with pytest.raises(SettingsError) as refused:
        ros.spin_until(lambda: False)
    name = first.get_fully_qualified_name()
    assert f'{name}, started at 20' in str(refused.value)
    assert f'also publishes {topic}: end it, or start' in str(refused.value)
    assert 'namespace:=/NAME' in str(refused.value) and '\n' not in str(refused.value)


@pytest.mark.parametrize('kind, name', [(NmeaDriver, 'ts_driver'), (NmeaDriver, 'another')])
def test_a_second_driver_on_one_topic_is_refused_and_publishes_nothing(ros, kind, name):
    ports = [free_port(), free_port()]
    for port, called in zip(ports, ('ts_driver', name)):
        ros.ours(kind, name=called, topic='ts/heading', source=f'udp://127.0.0.1:{port}')
        spin_for(ros, 0.1)
    with pytest.raises(SettingsError, match='/ts_driver, started at .* publishes /ts/heading'):
        ros.spin_until(lambda: False)
    assert not ros.nodes[-1]._audience.sole.clear


def test_a_simulator_beside_a_driver_is_refused(ros):
    ros.ours(NmeaDriver, name='ts_driver', topic='ts/heading',
             source=f'udp://127.0.0.1:{free_port()}')
    spin_for(ros, 0.1)
    ros.ours(SensorSimulator, name='sensor_simulator')
    with pytest.raises(SettingsError, match='/ts_driver'):
        ros.spin_until(lambda: False)


def test_one_that_was_killed_holds_nobody_up_for_longer_than_it_takes_to_be_sure(ros):
    """A publisher that is listed but says nothing, as DDS shows a killed process for 20 s."""
    ghost = ros.add(Node, 'compliance')
    ghost.create_publisher(String, 'compliance/report', qos.REPORT)
    node = ros.ours(Compliance)
    assert not node.sole.clear
    watch = Stopwatch()
    ros.spin_until(lambda: node.sole.clear)
    assert watch.passed_s < 12.0
    spin_for(ros, 3.5)


def test_a_stranger_on_the_topic_of_a_driver_does_not_stop_it(ros):
    ros.plain.create_publisher(Imu, 'ts/heading', qos.HEADINGS_OUT)
    driver = ros.ours(NmeaDriver, name='ts_driver', topic='ts/heading',
                      source=f'udp://127.0.0.1:{free_port()}')
    ros.spin_until(lambda: driver._audience.sole.clear)


def test_a_node_that_runs_shows_the_other_one_and_goes_on(ros, monkeypatch):
    """When a network that was cut comes together, nobody gives way."""
    monkeypatch.setattr('heading_intercompare.nodes.presence.sole_node._STARTING_S', 0.0)
    shown = ros.listen(DiagnosticArray, '/diagnostics', qos.STATUS)
    first, second = ros.ours(Compliance), ros.ours(Compliance)
    ros.spin_until(lambda: any('also publishes /compliance/report: end one of the two'
                               in status.message for m in shown for status in m.status))
    ros.end(second)
    ros.spin_until(lambda: [status.level for status in shown[-1].status
                            if status.name == 'compliance: graph'] == [b'\0'])
    assert first.sole.clear
