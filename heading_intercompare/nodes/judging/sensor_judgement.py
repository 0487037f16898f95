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

"""What is published of a tested sensor: figures, alarms, verdicts and reports."""

from __future__ import annotations

from typing import Any, Mapping

from rclpy.node import Node

from heading_intercompare.core.pipeline import Compliance
from heading_intercompare.core.records import Pairs
from heading_intercompare.nodes.alarms.comparison_alarms import ComparisonAlarms
from heading_intercompare.nodes.interface.places import name_place, place_files
from heading_intercompare.nodes.presence.health import Health
from heading_intercompare.nodes.settings import ComplianceNode

from .accounts import Account
from .figures import Figures
from .heard_actions import HeardActions
from .heard_recorders import HeardRecorders
from .reporting import Reporting
from .trial_journal import TrialJournal


class SensorJudgement:
    """
    Publishes what a judge says of a tested sensor.

    Parameters
    ----------
    node, health
        The node that publishes, and its state.
    label
        Of the sensor; its topics and files begin with it.
    compliance
        Judges the pairs of the sensor with the reference.
    own
        Settings.
    account
        The fate of every reading.
    journal
        Says what it lacks.
    actions
        What operators did while the nodes ran.
    recorders
        What was recorded meanwhile.

    Attributes
    ----------
    alarms : ComparisonAlarms
    compliance : Compliance
    reporting : Reporting

    """

    def __init__(self, node: Node, health: Health, label: str, compliance: Compliance,
                 own: ComplianceNode, account: Account, journal: TrialJournal,
                 actions: HeardActions, recorders: HeardRecorders) -> None:
        self.compliance = compliance
        place, of_sensor = name_place(label), health.of_sensor(label)
        self.alarms = ComparisonAlarms(node, of_sensor, compliance.settings)
        self.reporting = Reporting(node, place, compliance, place_files(own, label), of_sensor,
                                   account, journal, actions, recorders)
        self._figures = Figures(node, place, compliance, own.scalars_hz, of_sensor.owner)

    def take(self, pairs: Pairs) -> None:
        """Take pairs that have been judged."""
        self.alarms.take(pairs)
        self._figures.publish(pairs)
        self.reporting.look()

    def look(self) -> Mapping[str, Any]:
        """Look for alarms and publish all figures, once a second; return the rolling ones."""
        self.alarms.look()
        self.reporting.look()  # After a restart the runs of before count, too.
        self.compliance.forget()
        return self._figures.compute()
