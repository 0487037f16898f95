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

"""The node `compliance`: pairs to figures, verdicts and reports."""

from __future__ import annotations

from functools import partial
import math
import time
from typing import Any, Sequence

from diagnostic_msgs.msg import DiagnosticArray
from std_srvs.srv import Trigger

from heading_intercompare.core.alarms.graph_watch import estimate_judging_s
from heading_intercompare.core.decision.coverage import least_duration_words
from heading_intercompare.core.pipeline import Compliance as PureCompliance
from heading_intercompare.core.sensors.pair_settings import settings_of_tested
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.verdict.verdict_document import Verdict
from heading_intercompare.messages.ledger_messages import decode_ledger
from heading_intercompare.messages.status_messages import decode_marks, encode_mark, MARKER_TOPIC
from heading_intercompare.nodes.alarms.comparison_alarms import ComparisonAlarms
from heading_intercompare.nodes.alarms.graph_alarms import GraphAlarms
from heading_intercompare.nodes.judging.pair_intake import PairIntake
from heading_intercompare.nodes.judging.reporting import Reporting
from heading_intercompare.nodes.judging.trial_journal import open_spool, TrialJournal
from heading_intercompare.nodes.ros.batches import Arrivals
from heading_intercompare.nodes.ros.graph_node import GraphNode
from heading_intercompare.nodes.ros.health import Health
from heading_intercompare.nodes.ros.parameters import declare
from heading_intercompare.nodes.ros.process import run
from heading_intercompare.nodes.ros.steady_timer import every
from heading_intercompare.nodes.runtime.figures import Figures
from heading_intercompare.nodes.runtime.sole_node import SoleNode
from heading_intercompare.nodes.sensors.places import called, place_files
from heading_intercompare.nodes.taking.mark_intake import explain_mark, MarkIntake
from heading_intercompare.nodes.taking.motion_intake import MotionIntake
from heading_intercompare.nodes.taking.raw_subscription import subscribe

from .ros import qos
from .settings import ComplianceNode, Taking

# How long the last messages of a synchronizer that has ended, and of a batch, may be under way.
_ALONE_S, _HOLD_OFF_S = 0.3, 0.002


class Compliance(GraphNode):
    """Publish figures of the run in progress, and the verdict and report at the end of each."""

    done, _alone_s, _end_s = False, math.inf, math.inf

    def __init__(self, **kwargs: Any) -> None:
        super().__init__('compliance', **kwargs)
        settings, taking, node_settings = declare(
            self, Settings, Taking, ComplianceNode, followed=('window_s', 'stale_s'))
        self._settings, self._own = (settings_of_tested(settings, node_settings.sensor),
                                     place_files(node_settings))
        self.health = Health(self, called(self, node_settings.sensor), keeper=True)
        self._compliance = PureCompliance(self._settings, source='live',
                                          keeper=lambda: open_spool(self.health))
        self.get_logger().info(least_duration_words(self._settings.risk))
        self._pairs = PairIntake(self, self.health, taking, self._settings.pairing,
                                 Arrivals(self, self._drain, _HOLD_OFF_S))
        self.alarms = ComparisonAlarms(self, self.health, self._settings)
        GraphAlarms(self, self.health, self.alarms.panel, [node_settings.sensor or ''])
        self._journal = TrialJournal(self, self._compliance, self._own, self.health)
        self._pairs.go_on(self._journal.kept.numbers, self._compliance.newest_ns)
        self._motion = MotionIntake(self, self.health, taking, self._settings.motion, (
            self._journal, self._compliance, self.alarms), self._journal.kept.motion_ns)
        self._marks = MarkIntake(self.health, self._journal.kept.marks)
        self._reporting = Reporting(self, self._compliance, self._own, self.health, self._pairs,
                                    self._journal)
        self.sole = SoleNode(self, ['compliance/report'], self.health)
        self._marker = self.create_publisher(DiagnosticArray, MARKER_TOPIC, qos.MARKER)
        self._figures = Figures(self, self._compliance, self._own.scalars_hz,
                                self.health.owner)
        subscribe(self, DiagnosticArray, MARKER_TOPIC, qos.MARKER, self.health, decode_marks,
                  self._mark)
        subscribe(self, DiagnosticArray, 'pairs/ledger', qos.LEDGER, self.health, decode_ledger,
                  self._reporting.book)
        for name in ('start', 'stop'):
            self.create_service(Trigger, f'~/{name}_run', partial(self._command, name))
        self.create_service(Trigger, '~/acknowledge', self._acknowledge)
        every(self, 1.0, self._beat)

    @property
    def n_pairs(self) -> int:
        """Return the number of pairs taken."""
        return self._pairs.received

    @property
    def verdict(self) -> Verdict | None:
        """Return the verdict of the last report; None before the first."""
        return self._reporting.verdict

    def _drain(self) -> None:
        if self.ended:
            return
        pairs = self._pairs.read()
        self._motion.pass_on()  # What was sent before these pairs is there by now.
        self._journal.add(pairs, self._pairs.numbers_by_name)
        self._compliance.update(pairs)
        self._journal.tick(self.sole.clear)
        self.alarms.take(pairs)
        self._figures.publish(pairs)
        self._reporting.look(self._pairs.last_sequence)
        if self._end_s < math.inf:
            self._finish_if_complete()

    def _beat(self) -> None:
        self.alarms.look()
        self._compliance.motion.forget(self._compliance.run_start_ns)
        self._figures.compute()
        self.health.judging_s = estimate_judging_s(self._compliance.n_in_run)

    def _mark(self, marks: Sequence[tuple[str, int]]) -> None:
        for kind, stamp_ns in marks:
            if self._marks.take(kind, stamp_ns):
                self._journal.mark(kind, stamp_ns)
                self._compliance.mark(kind, stamp_ns)
                self.alarms.start_run()
        self._journal.tick(self.sole.clear)

    def _command(self, kind: str, _: Trigger.Request,
                 response: Trigger.Response) -> Trigger.Response:
        """Set a mark after the newest pair; pairs up to it belong to the run before."""
        self._drain()
        did = explain_mark(kind, self._compliance.keep().cutter)
        stamp_ns = self._compliance.newest_ns or 0
        self._mark([(kind, stamp_ns)])
        self._marker.publish(encode_mark(kind, stamp_ns))
        response.success, response.message = True, f'{kind} after the pair of {stamp_ns} ns: {did}'
        self._reporting.look(self._pairs.last_sequence)
        return response

    def _acknowledge(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        n = self.health.acknowledge() + self.alarms.acknowledge_everywhere()
        response.success, response.message = True, f'{n} alerts acknowledged'
        return response

    def end(self) -> None:
        """Take the last pairs and the final ledger, then end the run and report on it."""
        self.alarms.panel.muted = True
        self._end_s = time.monotonic() + self._own.end_wait_s

    def _finish_if_complete(self) -> None:
        self._pairs.look()
        now_s, reporting = time.monotonic(), self._reporting
        complete = reporting.final and self._pairs.last_sequence >= reporting.paired
        # Since the first look: what has come is served before the second.
        self._alone_s = math.inf if self._pairs.publishers else min(self._alone_s, now_s)
        alone = now_s > self._alone_s + _ALONE_S
        if (complete or alone) and not self._pairs.waiting or now_s > self._end_s:
            self._compliance.finish()
            reporting.close(complete)
            self.ended = True


def main(args: Sequence[str] | None = None) -> int:
    """Run the node."""
    return run('compliance', Compliance, args)
