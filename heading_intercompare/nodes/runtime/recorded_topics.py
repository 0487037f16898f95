# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""What the recorder takes: topics, types, what a player is to offer; and texts as files."""

from __future__ import annotations

import json
from typing import NamedTuple

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from sensor_msgs.msg import Imu
from std_msgs.msg import String

from heading_intercompare.bags.codec.cdr import decode
from heading_intercompare.bags.errors import BagError
from heading_intercompare.bags.rosbag2.bag_yaml import Qos
from heading_intercompare.bags.rosbag2.provenance import (
    NOTE_TOPIC,
    NOTE_TYPE,
    REPORT_TOPIC,
    TRUTH_TOPIC,
)
from heading_intercompare.core.settings import Settings
from heading_intercompare.nodes.ros import qos
from heading_intercompare.nodes.ros.messages import HEADING_TYPES, PAIRS_TYPES
from heading_intercompare.nodes.ros.parameters import resolve_topic

from .health import Health
from .intake import Intake

__all__ = ['make_intakes', 'Recorded', 'report_files', 'run_table', 'text_of']

_STATUS = {'diagnostic_msgs/msg/DiagnosticArray': DiagnosticArray}
_TEXT = {'std_msgs/msg/String': String}
_TRUTH = {'sensor_msgs/msg/Imu': Imu}


class Recorded(NamedTuple):
    """
    One topic.

    Attributes
    ----------
    offered : Qos
        What a player of the bag is to offer.
    intake : Intake
        Its messages.
    expected : bool
        It belongs to every recording, and at the end its publishers are waited for.

    """

    offered: Qos
    intake: Intake
    expected: bool


def _offer(profile: QoSProfile) -> Qos:
    kept = profile.durability == DurabilityPolicy.TRANSIENT_LOCAL
    return Qos(depth=profile.depth, durability='transient_local' if kept else 'volatile')


def make_intakes(node: Node, settings: Settings, health: Health) -> dict[str, Recorded]:
    """Return the topics by name: those of the graph, the true heading if there is one, notes."""
    rows = [
        (settings.ts_topic, HEADING_TYPES, qos.HEADINGS_IN, qos.HEADINGS_OUT, True),
        (settings.rs_topic, HEADING_TYPES, qos.HEADINGS_IN, qos.HEADINGS_OUT, True),
        ('pairs', PAIRS_TYPES, qos.PAIRS, qos.PAIRS, True),
        ('pairs/ledger', _STATUS, qos.LEDGER, qos.LEDGER, True),
        ('compliance/marker', _STATUS, qos.MARKER, qos.MARKER, True),
        ('compliance/verdict', _STATUS, qos.VERDICT, qos.VERDICT, True),
        (REPORT_TOPIC, _TEXT, qos.REPORT, qos.REPORT, True),
        (NOTE_TOPIC, _TEXT, qos.NOTE, qos.NOTE, False)]
    headings = (settings.ts_topic, settings.rs_topic)
    if resolve_topic(node, TRUTH_TOPIC) not in [resolve_topic(node, topic) for topic in headings]:
        # In front: it is not waited for, but is heard when the headings are.
        rows.insert(0, (TRUTH_TOPIC, _TRUTH, qos.HEADINGS_IN, qos.HEADINGS_OUT, False))
    return {topic: Recorded(_offer(offered), Intake(
        node, topic, types, taken, health, raw=True, sole=False, needed=expected), expected)
        for topic, types, taken, offered, expected in rows}


def text_of(data: bytes) -> str:
    """Return the text of a std_msgs/String as it came; nothing where it is damaged."""
    try:
        return decode(NOTE_TYPE, data)['data']
    except BagError:
        return ''


def run_table(report: str) -> str:
    """Return the runs of a report as the table that `analyze --runs` reads: [start, stop) ns."""
    rows = [f'{run["start_ns"]},{run["end_ns"] + 1}' for run in json.loads(report)['runs']]
    return '\n'.join(['start,stop', *rows]) + '\n'


def report_files(report: str) -> list[tuple[str, str, bytes]]:
    """Return what a report is attached as, each with name and media type: itself, its runs."""
    files = [('report.json', 'application/json', report.encode())]
    try:
        files.append(('runs.csv', 'text/csv', run_table(report).encode()))
    except (ValueError, KeyError, TypeError):
        pass  # What somebody else published there; the bag must be closed all the same.
    return files
