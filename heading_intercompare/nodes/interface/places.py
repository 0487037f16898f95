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
Where each sensor has its topics and files.

With the setting `sensors`, the topics and reports of each tested sensor begin with its label,
which is its name: `gyro1/pairs`. Those of the TS of two have no such beginning: its label is ''.
"""

from __future__ import annotations

from dataclasses import replace
import os

from rclpy.node import Node

from heading_intercompare.core.sensors.compared_sensors import list_sensors, pair_with_reference
from heading_intercompare.core.sensors.pair_names import Names
from heading_intercompare.core.settings import Settings
from heading_intercompare.journal.journal_file import name_journal
from heading_intercompare.messages.heading_places import HeadingPlace, locate_headings
from heading_intercompare.messages.quality_messages import quality_topic
from heading_intercompare.nodes.settings import ComplianceNode

from .parameters import resolve_topic


def label_tested(settings: Settings) -> dict[Names, str]:
    """Return the label of each tested sensor, by its name and that of the reference."""
    return {(sensor.name, reference.name): '' if settings.sensors is None else sensor.name
            for sensor, reference in pair_with_reference(settings)}


def name_place(label: str) -> str:
    """Return what the topics of a tested sensor begin with."""
    return f'{label}/' if label else ''


def place_files(own: ComplianceNode, label: str) -> ComplianceNode:
    """Return the settings of a node with the files of a tested sensor."""
    if not label:
        return own
    return replace(
        own, ship=f'{own.ship}/{label}' if own.ship else label,
        report_dir=None if own.report_dir is None else os.path.join(own.report_dir, label),
        journal=own.journal if own.journal in (None, '-') else name_journal(own.journal, label))


def heading_places(settings: Settings) -> dict[str, HeadingPlace]:
    """Return where the headings of all sensors are, by topic."""
    places = (locate_headings(sensor.heading_topic) for sensor in list_sensors(settings))
    return {place.topic: place for place in places}


def quality_topics(node: Node, settings: Settings) -> dict[str, list[str]]:
    """
    Return the sensors that say on a topic how good their readings are, by its full name.

    Two sensors share one if their headings are parts of the same messages.
    """
    sensors: dict[str, list[str]] = {}
    for sensor in list_sensors(settings):
        topic = resolve_topic(node, locate_headings(sensor.heading_topic).topic)
        sensors.setdefault(quality_topic(topic), []).append(sensor.name)
    return sensors


def judging_topics(settings: Settings) -> dict[str, list[str]]:
    """
    Return, for each topic of headings, the topics of pairs.

    The node that publishes the pairs takes the headings. Without a reference nobody publishes
    pairs, so there is no topic.
    """
    pairs = [f'{name_place(label)}pairs' for label in label_tested(settings).values()]
    return dict.fromkeys(heading_places(settings) if pairs else (), pairs)
