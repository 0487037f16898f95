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

"""The node `synchronizer`: headings of two sensors or more to pairs, with ledgers."""

from __future__ import annotations

import math
import time
from typing import Any, Mapping, Sequence, TYPE_CHECKING

from diagnostic_msgs.msg import DiagnosticArray

from heading_intercompare.core.pairing.pair_maker import PairMaker
from heading_intercompare.core.pairing.pairer import Pairer
from heading_intercompare.core.records import Headings, Losses
from heading_intercompare.core.sensors.compared_sensors import list_sensors
from heading_intercompare.journal.reading_batches import Batch, choose_pairs, count_losses
from heading_intercompare.messages.status_messages import decode_marks, MARKER_TOPIC
from heading_intercompare.nodes.alarms.stream_alarms import StreamAlarms
from heading_intercompare.nodes.interface.parameters import declare
from heading_intercompare.nodes.interface.places import label_tested, name_place
from heading_intercompare.nodes.launching.process import run
from heading_intercompare.nodes.presence.graph_node import GraphNode
from heading_intercompare.nodes.presence.health import Health
from heading_intercompare.nodes.presence.setting_changes import SettingChanges
from heading_intercompare.nodes.presence.sole_node import SoleNode
from heading_intercompare.nodes.sending.pair_outlet import PairOutlet
from heading_intercompare.nodes.spinning.batches import Arrivals
from heading_intercompare.nodes.spinning.clocks import AwakeClock, every
from heading_intercompare.nodes.taking.headings_intake import HeadingsIntake
from heading_intercompare.nodes.taking.mark_intake import MarkIntake
from heading_intercompare.nodes.taking.raw_subscription import subscribe

from .interface import qos
from .settings import HeadingTypes, PAIRED, SynchronizerNode, Taking

if TYPE_CHECKING:
    from .compliance import Compliance

# What a driver that has ended said last, such as its losses, may still be under way.
_LAST_S = 0.3
_FOLLOWED = ('stale_s',)


class Synchronizer(GraphNode):
    """
    Publish pairs and ledgers; take headings once pairs have subscribers: none gets lost.

    Parameters
    ----------
    judge
        The compliance node of this process, if there is one. It keeps the readings and the marks,
        and judges the pairs as they are made; after a crash the pairing goes on where it was.
    **kwargs
        As for `Node`.

    Attributes
    ----------
    judge

    """

    done = ended = _flushed = _opened = False

    def __init__(self, judge: Compliance | None = None, **kwargs: Any) -> None:
        super().__init__('synchronizer', **kwargs)
        settings, taking, types, self._own = declare(
            self, PAIRED, Taking, HeadingTypes, SynchronizerNode, followed=_FOLLOWED)
        self.judge, labels = judge, label_tested(settings)
        if judge is None:
            self._makers = {names: PairMaker(Pairer(settings)) for names in labels}
            started_ns = time.time_ns()
        else:
            self._makers = {names: pair.maker for names, pair in judge.comparison.pairs.items()}
            started_ns = judge.journal.began_ns
        self.health = Health(self)
        SettingChanges(self, self.health, _FOLLOWED)
        healths = {names: self.health.of_sensor(label) for names, label in labels.items()}
        topics = {names: f'{name_place(label)}pairs' for names, label in labels.items()}
        self._alarms = {names: StreamAlarms(self, health, settings.pairing, taking)
                        for names, health in healths.items()}
        self._outlets = {names: PairOutlet(self, health, topics[names], names,
                                           self._makers[names], started_ns)
                         for names, health in healths.items()}
        self.sole = SoleNode(self, [*topics.values()], self.health)
        self._headings = HeadingsIntake(self, self.health, taking, {
            sensor.name: (sensor.heading_topic, sensor.convention,
                          types.rs_message_type if sensor.is_reference else types.ts_message_type)
            for sensor in list_sensors(settings)},
            self._note_losses, Arrivals(self, self._drain, taking.drain_period_s),
            settings.unit_of)
        self._losses: list[tuple[str, str, Losses]] = []
        for intake in self._headings.intakes.values():
            intake.open = False
        if judge is None:
            self._marks = MarkIntake(self.health)
            subscribe(self, DiagnosticArray, MARKER_TOPIC, qos.MARKER, self.health, decode_marks,
                      self._mark)
        else:
            judge.while_judging = self._hold
            if judge.journal.resumed:
                self._headings.go_on(judge.journal.kept.heard, started_ns)
        self._awake = AwakeClock(0.0 if judge is None else judge.journal.kept.now_s)
        self._end_s, self._seen_s = math.inf, 0.0
        self._open_at_s = time.monotonic() + self._own.startup_wait_s
        every(self, 1.0, self._beat)

    def _drain(self) -> int:
        """Take and pair what has come, and publish; return the number of readings taken."""
        headings: Mapping[str, Headings] = {}
        if not self._opened:
            self._open_when_wanted()
        if not self._flushed:
            self._pair(headings := self._headings.take())
        for outlet in self._outlets.values():
            outlet.publish()
        if self._end_s < math.inf and not self.ended:
            self._finish_if_quiet()
        return sum(map(len, headings.values()))

    def _hold(self) -> None:
        """Make room for readings while the pairs are judged."""
        if not self._flushed:
            self._headings.hold()

    def _pair(self, headings: Mapping[str, Headings], *, last: bool = False) -> None:
        """Pair readings, after what was lost of them; `last` says that none follow."""
        losses, self._losses = self._losses, []
        batch = Batch(headings, losses, self._awake.now_s(), self._headings.last_heard)
        if self.judge is not None:
            self.judge.keep(batch, self._headings.received_ns)
        pairs = {names: choose_pairs(maker, batch, names, end=last)
                 for names, maker in self._makers.items()}
        for names, outlet in self._outlets.items():
            outlet.add(pairs[names])
        if self.judge is not None:
            self.judge.take(pairs)

    def _open_when_wanted(self) -> None:
        """Open the inputs once the pairs have their subscribers, or after `startup_wait_s`."""
        if self.sole.clear and (time.monotonic() > self._open_at_s or all(
                outlet.is_heard(self._own.subscribers) for outlet in self._outlets.values())):
            self._opened = True
            for intake in self._headings.intakes.values():
                intake.open = True

    def _note_losses(self, sensor: str, lost_as: str, losses: Losses) -> None:
        if len(losses):
            self._losses.append((sensor, lost_as, losses))

    def _beat(self) -> None:
        if self._flushed:
            losses, self._losses = self._losses, []
            for names, maker in self._makers.items():
                count_losses(maker.pairer, losses, names)
        for maker in self._makers.values():
            maker.pairer.forget_earlier()
        for names, outlet in self._outlets.items():
            outlet.publish_ledger(self._headings.numbers, final=self.ended)
            self._alarms[names].look(self._makers[names].pairer,
                                     [self._headings.intakes[name] for name in names])
        if self.judge is not None:
            self.health.judging_s = self.judge.health.judging_s

    def _mark(self, marks: Sequence[tuple[str, int]]) -> None:
        for kind, stamp_ns in marks:
            if self._marks.take(kind, stamp_ns):
                for maker in self._makers.values():
                    maker.pairer.ledger.cut_run(stamp_ns + 1)
        self._beat()

    def end(self) -> None:
        """Take the last headings, until their publishers are gone or time is up."""
        self._seen_s = time.monotonic()
        self._end_s = self._seen_s + self._own.end_wait_s

    def give_up(self) -> str:
        """Pair the last headings that came, so that each has its fate in the account."""
        if not self._flushed:
            self._flush()
        n = sum(outlet.n_waiting for outlet in self._outlets.values())
        return f'{n} pairs are not published' if n else 'headings still come'

    def _flush(self) -> None:
        self._flushed = True
        self._pair(self._headings.take(last=True), last=True)

    def _finish_if_quiet(self) -> None:
        now_s = time.monotonic()
        if self._headings.count_publishers():
            self._seen_s = now_s
        if now_s < min(self._end_s, self._seen_s + _LAST_S):
            return
        if not self._flushed:
            self._flush()
        if not any(outlet.n_waiting for outlet in self._outlets.values()):
            self.ended = True
            self._beat()
            for outlet in self._outlets.values():
                outlet.close()


def main(args: Sequence[str] | None = None) -> int:
    """Run the node."""
    return run('synchronizer', Synchronizer, args)
