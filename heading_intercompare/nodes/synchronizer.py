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

"""The node `synchronizer`: headings of two sensors to pairs, with a ledger."""

from __future__ import annotations

import math
import time
from typing import Any, Sequence

from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import TwistStamped

from heading_intercompare.core.pairing.ledger import LedgerKey
from heading_intercompare.core.pairing.pairer import Pairer
from heading_intercompare.core.records import Losses, Pairs
from heading_intercompare.messages.heading_messages import pair_messages
from heading_intercompare.messages.ledger_messages import encode_ledger
from heading_intercompare.messages.status_messages import decode_marks, MARKER_TOPIC
from heading_intercompare.nodes.alarms.graph_alarms import GraphAlarms
from heading_intercompare.nodes.alarms.stream_alarms import StreamAlarms
from heading_intercompare.nodes.ros.batches import Arrivals
from heading_intercompare.nodes.ros.endpoints import count_subscribed
from heading_intercompare.nodes.ros.graph_node import GraphNode
from heading_intercompare.nodes.ros.health import Health
from heading_intercompare.nodes.ros.parameters import declare
from heading_intercompare.nodes.ros.process import run
from heading_intercompare.nodes.ros.steady_timer import every
from heading_intercompare.nodes.runtime.awake_clock import AwakeClock
from heading_intercompare.nodes.runtime.publishing import await_acknowledgement, Backlog
from heading_intercompare.nodes.runtime.sole_node import SoleNode
from heading_intercompare.nodes.sensors.places import called, choose_streams, list_watched
from heading_intercompare.nodes.taking.headings_intake import HeadingsIntake
from heading_intercompare.nodes.taking.mark_intake import MarkIntake
from heading_intercompare.nodes.taking.predecessor import Predecessor
from heading_intercompare.nodes.taking.raw_subscription import subscribe

from .ros import qos
from .settings import HeadingTypes, PAIRED, SynchronizerNode, Taking

# A subscriber of the pairs that hangs holds up the others no longer than this.
# What a driver that has ended said last, such as its losses, may still be under way.
_PATIENCE_S, _LAST_S = 10.0, 0.3


class Synchronizer(GraphNode):
    """Publish pairs and ledger; take headings once pairs have subscribers: none gets lost."""

    done = ended = _flushed = _opened = False

    def __init__(self, **kwargs: Any) -> None:
        super().__init__('synchronizer', **kwargs)
        settings, taking, types, self._own = declare(
            self, PAIRED, Taking, HeadingTypes, SynchronizerNode, followed=('stale_s',))
        streams = choose_streams(settings, self._own.sensor)
        places, settings = list_watched(settings, self._own.sensor), streams
        self._started_ns = time.time_ns()
        self._pairer = Pairer(settings)
        self.health = Health(self, called(self, self._own.sensor))
        self.alarms = StreamAlarms(self, self.health, settings.pairing, taking)
        GraphAlarms(self, self.health, self.alarms.panel, places, keepers_only=True)
        self._marks = MarkIntake(self.health)
        self._pairs = self.create_publisher(TwistStamped, 'pairs', qos.PAIRS,
                                            event_callbacks=self.health.of_publisher('pairs'))
        self.sole = SoleNode(self, ['pairs'], self.health)
        self._ledger = self.create_publisher(DiagnosticArray, 'pairs/ledger', qos.LEDGER)
        self._headings = HeadingsIntake(
            self, self.health, taking, {
                'ts': (settings.ts_topic, settings.ts_convention, types.ts_message_type),
                'rs': (settings.rs_topic, settings.rs_convention, types.rs_message_type)},
            self._lose, Arrivals(self, self._drain, taking.drain_period_s))
        subscribe(self, DiagnosticArray, MARKER_TOPIC, qos.MARKER, self.health, decode_marks,
                  self._mark)
        self._intakes = self._headings.intakes
        for intake in self._intakes.values():
            intake.open = False
        self._predecessor = Predecessor(self, self.health, self._intakes, self._started_ns,
                                        self._pairs.topic_name)
        self._awake, self._end_s, self._seen_s = AwakeClock(), math.inf, 0.0
        self._open_at_s = time.monotonic() + self._own.startup_wait_s
        self._waiting = Backlog(self._pairs, self.health, patience_s=_PATIENCE_S)
        every(self, 1.0, self._beat)

    def _drain(self) -> None:
        if not self._opened:
            self._open_when_wanted()
        if not self._flushed:
            headings = self._headings.take()
            self._send(self._pairer.update(headings['ts'], headings['rs'], self._awake.now_s()))
        self._waiting.publish()
        if self._end_s < math.inf and not self.ended:
            self._finish_if_quiet()

    def _send(self, pairs: Pairs) -> None:
        for part in pairs.in_segments():
            segment = int(part.segment[0])
            self._waiting.add(pair_messages(part, f'{self._started_ns}/{segment}' if segment
                                            else str(self._started_ns)))

    def _open_when_wanted(self) -> None:
        """Open the inputs once the pairs have their subscribers, or after `startup_wait_s`."""
        if (count_subscribed(self, self._pairs) >= self._own.subscribers
                and self._predecessor.is_known() or time.monotonic() > self._open_at_s):
            self._opened = True
            for intake in self._intakes.values():
                intake.open = True

    def _lose(self, stream: str, lost_as: str, losses: Losses) -> None:
        self._pairer.lose(LedgerKey.of_told(stream, lost_as), losses)

    def _beat(self) -> None:
        self._pairer.forget_earlier()
        self._ledger.publish(encode_ledger(self._pairer.ledger, self.ended, self._started_ns,
                                           self._headings.numbers))
        self.alarms.look(self._pairer, [*self._intakes.values()])

    def _mark(self, marks: Sequence[tuple[str, int]]) -> None:
        for kind, stamp_ns in marks:
            if self._marks.take(kind, stamp_ns):
                self._pairer.ledger.cut_run(stamp_ns + 1)
        self._beat()

    def end(self) -> None:
        """Take the last headings, until their publishers are gone or time is up."""
        self.alarms.panel.muted = True
        self._seen_s = time.monotonic()
        self._end_s = self._seen_s + self._own.end_wait_s

    def _finish_if_quiet(self) -> None:
        now_s = time.monotonic()
        if self._headings.count_publishers():
            self._seen_s = now_s
        if now_s < min(self._end_s, self._seen_s + _LAST_S):
            return
        if not self._flushed:
            self._flushed = True
            headings = self._headings.take(last=True)
            self._send(self._pairer.update(headings['ts'], headings['rs'])
                       + self._pairer.flush())
        if not self._waiting:
            self.ended = True
            self._beat()
            await_acknowledgement([self._pairs, self._ledger])


def main(args: Sequence[str] | None = None) -> int:
    """Run the node."""
    return run('synchronizer', Synchronizer, args)
