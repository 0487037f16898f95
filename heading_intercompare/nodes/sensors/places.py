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

"""
Where the nodes of each sensor are: their namespaces, topics, names and files.

Each tested sensor has a synchronizer and a compliance node of its own, in a namespace with its
name. They are those of two sensors. The topics that all of them share are in the namespace above.
"""

from __future__ import annotations

from dataclasses import replace
import os

from rclpy.node import Node

from heading_intercompare.bags.recording.journal import name_journal
from heading_intercompare.bags.rosbag2.motion_topics import motion_topics
from heading_intercompare.core.sensor_table import (
    find_reference,
    find_tested,
    list_tested,
    read_sensors,
    Sensor,
)
from heading_intercompare.core.settings import MotionRule, Settings
from heading_intercompare.messages.heartbeat_messages import HEARTBEAT_TOPIC
from heading_intercompare.messages.status_messages import MARKER_TOPIC
from heading_intercompare.nodes.settings import ComplianceNode

SHARED_TOPICS = (MARKER_TOPIC, HEARTBEAT_TOPIC, 'compliance/alarms', 'compliance/acknowledge')
"""Topics that the nodes of all sensors have in common, beside the headings."""


def choose_streams(settings: Settings, sensor: str | None) -> Settings:
    """Return settings with the streams of a sensor and the reference; as given for None."""
    if sensor is None:
        return settings
    ts, rs = find_tested(read_sensors(settings.sensors), sensor)
    return replace(settings, ts_topic=ts.heading_topic, rs_topic=rs.heading_topic,
                   ts_convention=ts.convention, rs_convention=rs.convention)


def list_watched(settings: Settings, sensor: str | None) -> list[str]:
    """
    Return the places in which a synchronizer watches the nodes that keep alarms.

    Of several sensors, the synchronizer of the first one also watches those of the whole graph.
    """
    tested = list_tested(read_sensors(settings.sensors))
    if sensor is None:
        return ['']
    return [sensor, ''] if tested[0].name == sensor else [sensor]


def called(node: Node, sensor: str | None) -> str:
    """Return what to call a node on /diagnostics: its name, after that of its sensor."""
    name: str = node.get_name()
    return name if sensor is None else f'{sensor}/{name}'


def place_files(own: ComplianceNode) -> ComplianceNode:
    """Return the settings of a node with the files of its sensor, if it has one."""
    sensor = own.sensor
    if sensor is None:
        return own
    return replace(
        own, ship=f'{own.ship}/{sensor}' if own.ship else sensor,
        report_dir=None if own.report_dir is None else os.path.join(own.report_dir, sensor),
        journal=own.journal if own.journal in (None, '-') else name_journal(own.journal, sensor))


def remap_rules(sensors: tuple[Sensor, ...], namespace: str,
                motion: MotionRule | None = None) -> dict[str, str]:
    """
    Return the topics that the nodes of a sensor find in the namespace of the graph.

    Parameters
    ----------
    sensors
        The sensors of the settings.
    namespace
        Namespace of the graph.
    motion
        Names the topics of the motion of the ship, unless they are those of the defaults.

    Returns
    -------
    dict of str to str
        Rules for topics only: a service of the same name stays where it is.

    """
    topics = [*(sensor.heading_topic for sensor in sensors),
              *motion_topics(motion or MotionRule()).values()]
    return {f'rostopic://{topic}': f'{namespace.rstrip("/")}/{topic}'
            for topic in (*topics, *SHARED_TOPICS) if topic[0] not in '/~'}


def count_subscribers(sensors: tuple[Sensor, ...], recorded: bool) -> int:
    """Return how many subscriptions the headings of a tested sensor have in a graph."""
    # Synchronizer or sensors_watch, and the recorder; with a reference, both of the first.
    return 1 + recorded + bool(list_tested(sensors))


def count_motion_subscribers(sensors: tuple[Sensor, ...], recorded: bool) -> int:
    """Return how many subscriptions each topic of the motion of the ship has in a graph."""
    return recorded + (1 + len(list_tested(sensors)) if sensors else 1)


def heading_topics(settings: Settings) -> list[str]:
    """Return the topics of the headings of all sensors, or of TS and RS."""
    return ([sensor.heading_topic for sensor in read_sensors(settings.sensors)]
            or [settings.ts_topic, settings.rs_topic])


def judging_topics(settings: Settings) -> dict[str, list[str]]:
    """Return, for each topic of headings, the topics of the nodes that judge the headings."""
    sensors = read_sensors(settings.sensors)
    if not sensors:
        return {topic: ['pairs'] for topic in heading_topics(settings)}
    pairs = {sensor.heading_topic: [f'{sensor.name}/pairs'] for sensor in list_tested(sensors)}
    every = [topic for topics in pairs.values() for topic in topics]
    return {sensor.heading_topic: ['sensors/vote', *pairs.get(sensor.heading_topic, every)]
            for sensor in sensors}


def count_judges(settings: Settings) -> int:
    """Return how many nodes of a graph take the marks of runs."""
    sensors = read_sensors(settings.sensors)
    # A synchronizer and a compliance node for each tested sensor, and sensors_watch.
    return 2 * len(list_tested(sensors)) + 1 if sensors else 2


def further_subscribers(settings: Settings) -> dict[str, int]:
    """Return how many subscriptions more than others the topic of the reference has."""
    sensors = read_sensors(settings.sensors)
    reference = find_reference(sensors)
    return {} if reference is None else {reference.heading_topic: len(list_tested(sensors)) - 1}
