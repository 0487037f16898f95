# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The headings of several sensors, each topic heard once, with what was lost of them."""

from __future__ import annotations

from functools import partial
import time
from typing import Callable, Mapping, Sequence

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.node import Node

from heading_intercompare.core.pairing.ledger import LedgerKey
from heading_intercompare.core.records import Headings, Losses
from heading_intercompare.core.rows.sensor_table import Sensor
from heading_intercompare.messages.heading_messages import read_headings
from heading_intercompare.messages.ledger_messages import decode_losses, lost_topic
from heading_intercompare.nodes.ros import qos
from heading_intercompare.nodes.ros.message_types import HEADING_TYPES
from heading_intercompare.nodes.runtime.health import Health
from heading_intercompare.nodes.settings import Taking
from heading_intercompare.nodes.taking.intake import Intake
from heading_intercompare.nodes.taking.raw_subscription import subscribe
from heading_intercompare.web.figures.stream_watch import SensorView, StreamWatch

__all__ = ['HeadingsIntake']


class HeadingsIntake:
    """
    Takes the headings of several sensors.

    Parameters
    ----------
    node, health, taking
        As for `Intake`.
    sensors : sequence of Sensor
    lose : callable
        Called with the name of a sensor, the key of the ledger for a TS, and its losses.

    Attributes
    ----------
    newest_ns : int or None
        The newest stamp of any sensor.

    """

    def __init__(self, node: Node, health: Health, taking: Taking, sensors: Sequence[Sensor],
                 lose: Callable[[str, LedgerKey, Losses], None]) -> None:
        self._sensors, self._lose_one = {one.name: one for one in sensors}, lose
        self._intakes = {one.name: Intake(
            node, one.heading_topic, HEADING_TYPES, qos.HEADINGS_IN, health,
            unreliable=qos.HEADINGS_UNRELIABLE, kept=qos.HEADINGS_KEPT, stale_s=taking.stale_s,
            first_wait_s=taking.first_wait_s, lost_shown_s=taking.lost_shown_s, stamped=True)
            for one in sensors}
        for name, intake in self._intakes.items():
            subscribe(node, DiagnosticArray, lost_topic(intake.full_name), qos.LOST, health,
                      decode_losses, partial(self._lose, name))
        self._watches = {one.name: StreamWatch(taking.stale_s) for one in sensors}
        self.newest_ns: int | None = None

    def take(self) -> dict[str, Headings]:
        """Return the readings since the last call, by the names of the sensors."""
        return {name: self._take(name, intake) for name, intake in self._intakes.items()}

    def _take(self, name: str, intake: Intake) -> Headings:
        taken = intake.take()
        headings, refused = read_headings(intake.type_name, self._sensors[name].convention,
                                          [message for message, _ in taken])
        intake.refuse(refused)
        self._lose(name, {'lost.on_the_way': intake.take_losses()})
        if len(headings):
            self._watches[name].take(headings, taken[-1][1]['received_timestamp'],
                                     time.monotonic())
            self.newest_ns = max(self.newest_ns or 0, int(headings.stamp_ns[-1]))
        return headings

    def _lose(self, name: str, found: Mapping[str, Losses]) -> None:
        for lost_as, losses in found.items():
            self._lose_one(name, LedgerKey.of_told('ts', lost_as), losses)

    def view(self) -> dict[str, SensorView]:
        """Return each sensor as it reports now."""
        now_s = time.monotonic()
        return {name: watch.view(now_s) for name, watch in self._watches.items()}

    @property
    def publishers(self) -> int:
        """Number of publishers of all topics now."""
        for intake in self._intakes.values():
            intake.look()
        return sum(intake.publishers for intake in self._intakes.values())
