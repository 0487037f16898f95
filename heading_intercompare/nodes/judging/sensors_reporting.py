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

"""Publishing of the verdict on all of several sensors."""

from __future__ import annotations

import os
from typing import Iterator, Mapping

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.node import Node
from std_msgs.msg import String

from heading_intercompare.bags.rosbag2.provenance import SENSORS_REPORT_TOPIC
from heading_intercompare.core.sensors.comparison import SensorsComparison
from heading_intercompare.core.sensors.judging import judge_sensors
from heading_intercompare.core.sensors.pair_names import Names
from heading_intercompare.core.sensors.pair_settings import settings_of_tested
from heading_intercompare.core.sensors.sensors_verdict import SensorsVerdict
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.verdict.all_runs import join
from heading_intercompare.journal.journal_reading import describe_restarts
from heading_intercompare.messages.status_messages import encode_text, OK
from heading_intercompare.messages.verdict_messages import (
    encode_no_verdict,
    NO_VERDICT,
    verdict_level,
)
from heading_intercompare.nodes.interface import qos
from heading_intercompare.nodes.presence.health import Health
from heading_intercompare.nodes.sending.publishing import await_acknowledgement
from heading_intercompare.nodes.settings import ComplianceNode
from heading_intercompare.nodes.spinning.clocks import stamp_or_now
from heading_intercompare.report.json import render

from .report_files import write_report
from .sensor_judgement import SensorJudgement
from .sensors_messages import encode_sensors_verdict, SENSORS_VERDICT_TOPIC
from .trial_journal import TrialJournal


class SensorsReporting:
    """
    Judges several sensors when one of their pairs has been judged.

    Parameters
    ----------
    node, health
        The node, and its state.
    settings
        With `sensors`.
    own
        Settings of the node.
    comparison
        Has the pairs.
    judgements
        Have the verdicts on the tested sensors, by name.
    journal
        Says what was missed.

    Attributes
    ----------
    verdict
        The last verdict; None before the first.

    """

    def __init__(self, node: Node, health: Health, settings: Settings, own: ComplianceNode,
                 comparison: SensorsComparison, judgements: Mapping[str, SensorJudgement],
                 journal: TrialJournal) -> None:
        self._node, self._health, self._settings, self._own = node, health, settings, own
        self._comparison, self._judgements, self._journal = comparison, judgements, journal
        self._n_finished, self._is_due, self._said = 0, False, ''
        self.verdict: SensorsVerdict | None = None
        if own.report_dir is not None:
            os.makedirs(own.report_dir, exist_ok=True)
        self._verdict = node.create_publisher(DiagnosticArray, SENSORS_VERDICT_TOPIC, qos.STATE)
        self._verdict.publish(encode_no_verdict(stamp_or_now(node, None), health.owner))
        health.note('verdict', OK, NO_VERDICT)
        self._report = node.create_publisher(String, SENSORS_REPORT_TOPIC, qos.REPORT)

    def look(self, newest_ns: int | None) -> None:
        """Judge a second after the last run has ended; call it once a second."""
        n_finished = sum(pair.compliance.finished_runs for pair in self._comparison.pairs.values())
        if n_finished != self._n_finished:
            # The runs of other pairs end with their next pairs.
            self._n_finished, self._is_due = n_finished, True
        elif self._is_due:
            self._conclude(newest_ns)

    def _conclude(self, newest_ns: int | None) -> None:
        """Judge, publish and write, unless nothing has changed."""
        self._is_due = False
        verdict = judge_sensors(
            self._settings,
            {name: judgement.reporting.verdict
             or join([], settings_of_tested(self._settings, name))
             for name, judgement in self._judgements.items()},
            {names: pair.results() for names, pair in self._comparison.others.items()},
            problems={names: [*self._find_problems(names)] for names in self._comparison.others})
        report = render(verdict)
        if report == self._said:
            return
        self.verdict, self._said = verdict, report
        self._health.note('verdict', verdict_level(verdict.outcome, verdict.validity_effect),
                          verdict.headline, log=False)
        self._node.get_logger().info(f'verdict on {len(verdict.sensors)} sensors: '
                                     f'{verdict.headline}')
        self._verdict.publish(encode_sensors_verdict(
            verdict, stamp_or_now(self._node, newest_ns), self._health.owner))
        self._report.publish(encode_text(report))
        write_report(self._own.report_dir, 'sensors', newest_ns,
                     {'.json': report, '.txt': f'{verdict}\n'}, self._health)

    def _find_problems(self, names: Names) -> Iterator[str]:
        """Yield what the pairs of two sensors missed, in plain sentences."""
        yield from describe_restarts(self._journal.kept, names)
        yield from self._journal.describe_dropped()

    def close(self, newest_ns: int | None) -> None:
        """Judge all runs, and wait until the verdict has been received."""
        self._conclude(newest_ns)
        await_acknowledgement([self._verdict, self._report], 1.0)
