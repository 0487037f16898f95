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

"""The verdict on several sensors: from the reports of their compliance nodes, and own pairs."""

from __future__ import annotations

from datetime import datetime, timezone
from functools import partial
import os
from pathlib import Path
import time

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.node import Node
from std_msgs.msg import String

from heading_intercompare.bags.recording.disk_sync import replace_file
from heading_intercompare.bags.rosbag2.provenance import SENSORS_REPORT_TOPIC
from heading_intercompare.core.alarms.graph_watch import NOT_WRITTEN
from heading_intercompare.core.sensor_table import list_tested
from heading_intercompare.core.sensors.comparison import SensorsComparison
from heading_intercompare.core.sensors.judging import judge_sensors
from heading_intercompare.core.sensors.pair_settings import settings_of_tested
from heading_intercompare.core.sensors.sensors_verdict import SensorsVerdict
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.typed_reader import VerdictError
from heading_intercompare.core.verdict.all_runs import join
from heading_intercompare.core.verdict.verdict_document import Verdict
from heading_intercompare.messages.errors import MessageError
from heading_intercompare.messages.status_messages import decode_text, encode_text, ERROR, OK
from heading_intercompare.messages.verdict_messages import (
    encode_no_verdict,
    NO_VERDICT,
    verdict_level,
)
from heading_intercompare.nodes.ros import qos
from heading_intercompare.nodes.ros.health import Health
from heading_intercompare.nodes.runtime.publishing import await_acknowledgement
from heading_intercompare.nodes.settings import SensorsNode
from heading_intercompare.nodes.taking.raw_subscription import subscribe
from heading_intercompare.report.json import parse, render

from .pair_journals import PairJournals
from .sensors_intake import SensorsIntake
from .sensors_messages import encode_sensors_verdict, SENSORS_VERDICT_TOPIC


class SensorsReporting:
    """
    Judges several sensors when one of their pairs has been judged.

    Parameters
    ----------
    node, health
        The node, and its state.
    settings
        With `sensors`.
    comparison
        Has the pairs without the reference.
    journals
        Have the runs of these pairs, and what they missed.
    headings
        Have the newest stamp.

    Attributes
    ----------
    verdict
        The last verdict; None before the first.

    """

    def __init__(self, node: Node, health: Health, settings: Settings, own: SensorsNode,
                 comparison: SensorsComparison, journals: PairJournals,
                 headings: SensorsIntake) -> None:
        self._node, self._health, self._settings, self._own = node, health, settings, own
        self._comparison, self._journals, self._headings = comparison, journals, headings
        self._tested = [sensor.name for sensor in list_tested(comparison.sensors)]
        self._reports: dict[str, Verdict] = {}
        self._finished = 0
        self._due_s: float | None = None
        self._said = ''
        self.verdict: SensorsVerdict | None = None
        if own.report_dir is not None:
            os.makedirs(own.report_dir, exist_ok=True)
        self._verdict = node.create_publisher(DiagnosticArray, SENSORS_VERDICT_TOPIC, qos.STATE)
        self._verdict.publish(encode_no_verdict(self._now_ns(), health.owner))
        health.note('verdict', OK, NO_VERDICT)
        self._report = node.create_publisher(String, SENSORS_REPORT_TOPIC, qos.REPORT)
        for name in self._tested:
            subscribe(node, String, f'{name}/compliance/report', qos.REPORT, health, _decode,
                      partial(self._take, name))

    def _take(self, name: str, report: Verdict) -> None:
        """Take the report of a compliance node; those of other sensors may be under way."""
        self._reports[name] = report
        self._due_s = time.monotonic() + self._own.settle_s

    @property
    def awaited(self) -> list[str]:
        """Return the sensors whose compliance node is there, so that a report may yet come."""
        return [name for name in self._tested
                if self._node.count_publishers(f'{self._node.get_namespace().rstrip("/")}/{name}'
                                               '/compliance/report')]

    def look(self) -> None:
        """Judge if a pair was judged and the others had time; call it once a second."""
        finished = sum(pair.compliance.finished_runs for pair in self._comparison.others.values())
        if finished != self._finished:
            self._finished = finished
            self._due_s = time.monotonic() + self._own.settle_s
        if self._due_s is not None and time.monotonic() >= self._due_s:
            self.conclude()

    def conclude(self) -> None:
        """Judge, publish and write, unless nothing has changed."""
        self._due_s = None
        verdict = judge_sensors(
            self._settings,
            {name: self._reports.get(name) or join([], settings_of_tested(self._settings, name))
             for name in self._tested},
            self._journals.results(), problems=self._journals.problems())
        report = render(verdict)
        if report == self._said:
            return
        self.verdict, self._said = verdict, report
        self._health.note('verdict', verdict_level(verdict.outcome, verdict.validity_effect),
                          verdict.headline, log=False)
        self._node.get_logger().info(f'verdict on {len(verdict.sensors)} sensors: '
                                     f'{verdict.headline}')
        self._verdict.publish(encode_sensors_verdict(verdict, self._now_ns(),
                                                     self._health.owner))
        self._report.publish(encode_text(report))
        self._write(verdict, report)

    def close(self) -> None:
        """Judge all runs, and wait until the verdict has been received."""
        self.conclude()
        await_acknowledgement([self._verdict, self._report], 1.0)

    def _now_ns(self) -> int:
        """Return the newest stamp; before the first one the time of the node."""
        newest_ns = self._headings.newest_ns
        return self._node.get_clock().now().nanoseconds if newest_ns is None else newest_ns

    def _write(self, verdict: SensorsVerdict, report: str) -> None:
        if self._own.report_dir is None:
            return
        newest_ns = self._headings.newest_ns
        moment = datetime.fromtimestamp(time.time() if newest_ns is None else newest_ns / 1e9,
                                        timezone.utc)
        path = Path(self._own.report_dir, f'sensors_{moment:%Y%m%dT%H%M%S}Z.json')
        try:
            replace_file(path, report)
            replace_file(path.with_suffix('.txt'), f'{verdict}\n')
        except OSError as error:
            self._health.note('report', ERROR, f'{path}: {error.strerror}', latch=True,
                              alarm=NOT_WRITTEN)
        else:
            self._health.note('report', OK, f'written to {path}')


def _decode(data: bytes) -> Verdict:
    """Return the verdict in a report; MessageError if there is none."""
    try:
        return parse(decode_text(data))
    except VerdictError as error:
        raise MessageError(str(error)) from error
