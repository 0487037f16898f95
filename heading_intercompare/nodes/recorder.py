# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The node `recorder`: what is compared, and what comes of it, to a bag."""

from __future__ import annotations

from datetime import datetime, timezone
import time
from typing import Any, Sequence

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.serialization import deserialize_message
from std_msgs.msg import String

from heading_intercompare.bags.bag_yaml import Qos
from heading_intercompare.bags.recording import Recording
from heading_intercompare.bags.settings import BagSettings
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.version import VERSION

from . import qos
from .health import Health
from .intake import Intake
from .messages import HEADING_TYPES, PAIRS_TYPES
from .parameters import declare, OVERRIDES
from .process import run
from .settings import RecorderNode, Taking
from .status_messages import ERROR, OK, run_table, WARN
from .timing import every

__all__ = ['main', 'Recorder']

_STATUS = {'diagnostic_msgs/msg/DiagnosticArray': DiagnosticArray}
_REPORT = 'compliance/report'
_QUIET_S = 0.3


def _offered(profile: QoSProfile) -> Qos:
    """Return what a player of the bag is to offer."""
    kept = profile.durability == DurabilityPolicy.TRANSIENT_LOCAL
    return Qos(depth=profile.depth, durability='transient_local' if kept else 'volatile')


class Recorder(Node):
    """Write headings, pairs, ledger, marks, verdicts and reports, at most a second late."""

    done = False

    def __init__(self, **kwargs: Any) -> None:
        super().__init__('recorder', **OVERRIDES, **kwargs)
        self._settings, taking, bag_settings, self._own = declare(
            self, Settings, Taking, BagSettings, RecorderNode)
        self.ended = False
        self._health = Health(self)
        self.path = self._own.output or f'heading_{datetime.now(timezone.utc):%Y%m%dT%H%M%SZ}'
        self._bag = Recording(self.path, bag_settings)
        self._bag.metadata('heading_intercompare', {
            'version': VERSION, **{f'settings.{name}': value for name, value
                                   in self._settings.to_mapping().items()}})
        self._intakes = {}
        for topic, types, taken, offered in (
                (self._settings.ts_topic, HEADING_TYPES, qos.HEADINGS_IN, qos.HEADINGS_OUT),
                (self._settings.rs_topic, HEADING_TYPES, qos.HEADINGS_IN, qos.HEADINGS_OUT),
                ('pairs', PAIRS_TYPES, qos.PAIRS, qos.PAIRS),
                ('pairs/ledger', _STATUS, qos.LEDGER, qos.LEDGER),
                ('compliance/marker', _STATUS, qos.MARKER, qos.MARKER),
                ('compliance/verdict', _STATUS, qos.VERDICT, qos.VERDICT),
                (_REPORT, {'std_msgs/msg/String': String}, qos.REPORT, qos.REPORT)):
            self._intakes[topic] = _offered(offered), Intake(
                self, topic, types, taken, self._health, raw=True, sole=False)
        self._state = ''
        self._report: bytes | None = None
        self._quiet_s = self._end_s = 0.0
        self._ending = False
        self._health.before_beat(self._note)
        every(self, taking.drain_period_s, self._drain)

    @property
    def written(self) -> int:
        """Number of messages that were handed to the bag."""
        return self._bag.written

    def _drain(self) -> None:
        if self.ended:
            return
        rows = []
        for topic, (offered, intake) in self._intakes.items():
            taken = intake.take()
            if taken:
                self._bag.add_topic(intake.full_name, intake.type_name, offered)
                self._report = taken[-1][0] if topic == _REPORT else self._report
            rows += [(info['received_timestamp'], intake.full_name, data, info)
                     for data, info in taken]
        rows.sort(key=lambda row: row[0])
        for received_ns, name, data, info in rows:
            self._bag.write(name, data, received_ns, info['source_timestamp'],
                            info['publication_sequence_number'])
        self._bag.tick(time.monotonic())
        if self._bag.fault + self._bag.remark != self._state:
            self._state = self._bag.fault + self._bag.remark
            self._note()
        if self._ending:
            self._close_if_quiet()

    def _note(self) -> None:
        bag = self._bag
        level = ERROR if bag.fault else WARN if bag.remark else OK
        self._health.note('bag', level, bag.fault or bag.remark or f'recording to {self.path}',
                          latch=True, messages=bag.written, waiting=bag.waiting,
                          lost=sum(bag.lost.values()), faults=bag.faults, absent=bag.absent)

    def end(self) -> None:
        """Go on until the other nodes are gone or time is up, for the last verdict."""
        self._health.mute()
        now_s = time.monotonic()
        self._ending, self._quiet_s, self._end_s = (True, now_s + _QUIET_S,
                                                    now_s + self._own.end_wait_s)

    def _close_if_quiet(self) -> None:
        now_s = time.monotonic()
        if any(self.count_publishers(i.full_name) for _, i in self._intakes.values()):
            self._quiet_s = now_s + _QUIET_S
        if now_s < min(self._quiet_s, self._end_s):
            return
        if self._report is not None:
            report = deserialize_message(self._report, String).data
            self._bag.attachment('report.json', 'application/json', report.encode())
            self._bag.attachment('runs.csv', 'text/csv', run_table(report).encode())
        self._bag.metadata('recording', self._losses())
        self._bag.close()
        self._note()
        self.ended = True

    def _losses(self) -> dict[str, int]:
        """Return what was received and what was lost, by topic and where."""
        bag, found = self._bag, {'faults': self._bag.faults, 'absent': self._bag.absent}
        for _, intake in self._intakes.values():
            name = intake.full_name
            found |= {f'received.{name}': intake.received, f'lost_on_the_way.{name}': intake.lost,
                      f'not_written.{name}': bag.lost.get(name, 0)}
        return found


def main(args: Sequence[str] | None = None) -> int:
    """Run the node."""
    return run('recorder', Recorder, args)
