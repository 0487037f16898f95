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

"""The node `sensors_watch`: all pairs of several sensors, the vote, and the verdict on all."""

from __future__ import annotations

from functools import partial
import time
from typing import Any, Sequence

from diagnostic_msgs.msg import DiagnosticArray
from std_msgs.msg import String
from std_srvs.srv import Trigger

from heading_intercompare.bags.rosbag2.provenance import SENSORS_REPORT_TOPIC
from heading_intercompare.core.alarms.graph_watch import estimate_judging_s
from heading_intercompare.core.sensors.comparison import SensorsComparison
from heading_intercompare.core.sensors.sensors_verdict import SensorsVerdict
from heading_intercompare.core.settings import Settings
from heading_intercompare.messages.status_messages import (
    decode_marks,
    encode_mark,
    encode_text,
    MARKER_TOPIC,
)
from heading_intercompare.nodes.alarms.alarm_panel import ACKNOWLEDGE_TOPIC, ALL
from heading_intercompare.nodes.alarms.graph_alarms import GraphAlarms
from heading_intercompare.nodes.ros.graph_node import GraphNode
from heading_intercompare.nodes.ros.health import Health
from heading_intercompare.nodes.ros.parameters import declare
from heading_intercompare.nodes.ros.process import run
from heading_intercompare.nodes.ros.steady_timer import every
from heading_intercompare.nodes.runtime.awake_clock import AwakeClock
from heading_intercompare.nodes.runtime.sole_node import SoleNode
from heading_intercompare.nodes.sensors.now_publisher import NowPublisher
from heading_intercompare.nodes.sensors.pair_journals import PairJournals
from heading_intercompare.nodes.sensors.sensors_intake import SensorsIntake
from heading_intercompare.nodes.sensors.sensors_reporting import SensorsReporting
from heading_intercompare.nodes.taking.mark_intake import MarkIntake
from heading_intercompare.nodes.taking.motion_intake import MotionIntake
from heading_intercompare.nodes.taking.raw_subscription import subscribe

from .ros import qos
from .settings import HeadingTypes, SensorsNode, Taking

# Nobody waits for the pairs, and few large batches cost less than many small ones.
_DRAIN_S = 0.25
# A mark reaches every node before the readings at its stamp do, so all runs begin at one stamp.
_AHEAD_NS = 10 ** 9
# How long the last messages of a publisher that has ended may still be under way, and how long to
# take headings from publishers that continue.
_QUIET_S, _HEADINGS_S = 0.3, 1.0


class SensorsWatch(GraphNode):
    """Publish what all pairs of sensors say, and name the wrong one; judge when a run ends."""

    done = ended = _finished = False

    def __init__(self, **kwargs: Any) -> None:
        super().__init__('sensors_watch', **kwargs)
        settings, taking, types, node_settings = declare(
            self, Settings, Taking, HeadingTypes, SensorsNode, followed=('stale_s',))
        self.health = Health(self, keeper=True)
        self._comparison = SensorsComparison(settings, source='live', only_others=True)
        self._headings = SensorsIntake(self, self.health, taking, types, self._comparison)
        self._journals = PairJournals(self, self.health, settings, node_settings, self._comparison,
                                      self._headings.heard)
        self._motion = MotionIntake(self, self.health, taking, settings.motion, (self._journals,))
        self._now = NowPublisher(self, self.health, settings, self._comparison, taking.stale_s)
        self._reporting = SensorsReporting(self, self.health, settings, node_settings,
                                           self._comparison, self._journals, self._headings)
        self.alarms = self._now
        GraphAlarms(self, self.health, self._now.panel)
        self.sole = SoleNode(self, [SENSORS_REPORT_TOPIC], self.health)
        self._marks = MarkIntake(self.health, self._journals.marks)
        self._marker = self.create_publisher(DiagnosticArray, MARKER_TOPIC, qos.MARKER)
        self._acknowledged = self.create_publisher(String, ACKNOWLEDGE_TOPIC, qos.ACKNOWLEDGE)
        subscribe(self, DiagnosticArray, MARKER_TOPIC, qos.MARKER, self.health, decode_marks,
                  self._mark)
        # The names are those of a graph of two sensors, so the page calls the same ones.
        for name in ('start', 'stop'):
            self.create_service(Trigger, f'compliance/{name}_run', partial(self._command, name))
        self.create_service(Trigger, 'compliance/acknowledge', self._acknowledge)
        self._awake, self._end_wait_s = AwakeClock(), node_settings.end_wait_s
        self._end_s: float | None = None
        self._seen_s = self._headings_s = 0.0
        every(self, max(taking.drain_period_s, _DRAIN_S), self._drain)
        every(self, 1.0, self._beat)

    @property
    def verdict(self) -> SensorsVerdict | None:
        """Return the last verdict; None before the first."""
        return self._reporting.verdict

    def _drain(self) -> None:
        if self._finished:
            return
        headings = self._headings.take()
        self._motion.pass_on()
        self._comparison.update(headings, self._awake.now_s())
        self._journals.tick(self.sole.clear)
        if self._end_s is not None:
            self._finish_if_quiet(self._end_s)

    def _beat(self) -> None:
        self._comparison.forget_earlier()
        verdict = self._reporting.verdict
        self._now.look(self._headings.view(), self._headings.newest_ns,
                       None if verdict is None else verdict.vote)
        self._journals.look(self._headings.newest_ns)
        self.health.judging_s = estimate_judging_s(sum(
            pair.compliance.n_in_run for pair in self._comparison.others.values()))
        if self._end_s is None:
            self._reporting.look()

    def _mark(self, marks: Sequence[tuple[str, int]]) -> None:
        for kind, stamp_ns in marks:
            if self._marks.take(kind, stamp_ns):
                self._journals.mark(kind, stamp_ns)
                self._comparison.mark(kind, stamp_ns)
        self._journals.tick(self.sole.clear)

    def _command(self, kind: str, _: Trigger.Request,
                 response: Trigger.Response) -> Trigger.Response:
        """Set a mark that acts on the runs of all pairs, a second after the newest reading."""
        self._drain()
        newest_ns = self._headings.newest_ns
        stamp_ns = 0 if newest_ns is None else newest_ns + _AHEAD_NS
        self._mark([(kind, stamp_ns)])
        self._marker.publish(encode_mark(kind, stamp_ns))
        response.success, response.message = True, f'{kind} after {stamp_ns} ns, for all sensors'
        return response

    def _acknowledge(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        self._acknowledged.publish(encode_text(ALL))
        n = self.health.acknowledge() + self._now.panel.acknowledge()
        response.success, response.message = True, f'{n} alerts acknowledged, those of other ' \
                                                   'nodes too'
        return response

    def end(self) -> None:
        """Take the last headings and reports, until their publishers are gone or time is up."""
        self._now.panel.muted = True
        self._seen_s = time.monotonic()
        self._headings_s = self._seen_s + _HEADINGS_S
        self._end_s = self._seen_s + self._end_wait_s

    def _finish_if_quiet(self, end_s: float) -> None:
        now_s = time.monotonic()
        if self._reporting.awaited or (now_s < self._headings_s
                                        and self._headings.heard.count_publishers()):
            self._seen_s = now_s
        if now_s < min(end_s, self._seen_s + _QUIET_S):
            return
        self._finished = True
        headings = self._headings.take(last=True)
        self._motion.pass_on()
        self._comparison.update(headings)
        self._comparison.finish()
        self._beat()
        self._reporting.close()
        self._journals.close()
        self.ended = True


def main(args: Sequence[str] | None = None) -> int:
    """Run the node."""
    return run('sensors_watch', SensorsWatch, args)
