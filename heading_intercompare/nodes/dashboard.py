# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The node `dashboard`: the live page of a graph, with the actions of an operator."""

from __future__ import annotations

import sys
import time
from typing import Any, Sequence

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.node import Node

from heading_intercompare.bags.rosbag2.part_states import DIAGNOSTICS_TOPIC
from heading_intercompare.core.decision.criteria import Limits
from heading_intercompare.core.settings import Settings
from heading_intercompare.messages.heading_messages import read_headings, read_pairs
from heading_intercompare.messages.ledger_messages import decode_ledger, LedgerMessage
from heading_intercompare.messages.status_messages import decode_statuses
from heading_intercompare.nodes.judging.operator_actions import OperatorActions
from heading_intercompare.nodes.ros import qos
from heading_intercompare.nodes.ros.batches import Arrivals
from heading_intercompare.nodes.ros.message_types import HEADING_TYPES, PAIRS_TYPES
from heading_intercompare.nodes.ros.parameters import declare, OVERRIDES
from heading_intercompare.nodes.ros.process import run
from heading_intercompare.nodes.ros.steady_timer import every
from heading_intercompare.nodes.runtime.health import Health
from heading_intercompare.nodes.taking.intake import Intake
from heading_intercompare.nodes.taking.raw_subscription import subscribe
from heading_intercompare.nodes.taking.recorded_topics import ALARMS_TOPIC
from heading_intercompare.web.bridge_view import Bridge, BridgeView
from heading_intercompare.web.controls import Controls
from heading_intercompare.web.server import PageServer

from .settings import DashboardNode, Taking

__all__ = ['Dashboard', 'main']

_VIEW_S = 0.2


class Dashboard(Node):
    """
    Show a graph on a page; what a person does there goes to the nodes concerned.

    Headings and pairs are only heard once the synchronizer has readings. So the page is never
    mistaken for one of the subscribers that a log or a simulation waits for.
    """

    done = False

    def __init__(self, **kwargs: Any) -> None:
        super().__init__('dashboard', **OVERRIDES, **kwargs)
        settings, taking, own = declare(self, Settings, Taking, DashboardNode)
        self.ended = False
        self.health = Health(self)
        limits = Limits.of(settings.norms, settings.model)
        self._bridge = Bridge(settings, trend_limit_deg=limits.count_limit_deg,
                              stale_s=taking.stale_s, namespace=self.get_namespace())
        arrivals = Arrivals(self, self._drain, taking.drain_period_s)
        self._intakes = {stream: Intake(
            self, topic, HEADING_TYPES, qos.HEADINGS_IN, self.health,
            unreliable=qos.HEADINGS_UNRELIABLE, stale_s=taking.stale_s, needed=False,
            counted=False, arrivals=arrivals)
            for stream, topic in (('ts', settings.ts_topic), ('rs', settings.rs_topic))}
        self._conventions = {'ts': settings.ts_convention, 'rs': settings.rs_convention}
        self._pairs = Intake(self, 'pairs', PAIRS_TYPES, qos.PAIRS_TAKEN, self.health,
                             needed=False, counted=False, arrivals=arrivals)
        for intake in (*self._intakes.values(), self._pairs):
            intake.open = False
        self._listen()
        self._actions = OperatorActions(self)
        self._seen: tuple[BridgeView, float] = BridgeView(), time.monotonic()
        self.page = PageServer(Controls(self._look, self._actions.ask), host=own.host,
                               port=own.port, token=own.token)
        self._say_where(own)
        every(self, _VIEW_S, self._show)

    def _listen(self) -> None:
        """Subscribe to the statuses of the graph."""
        bridge = self._bridge
        for topic, profile, act in (
                ('compliance/rolling', qos.STATUS, bridge.take_rolling),
                ('compliance/run', qos.STATUS, bridge.take_run),
                ('compliance/verdict', qos.VERDICT, bridge.take_verdict)):
            subscribe(self, DiagnosticArray, topic, profile, self.health, decode_statuses,
                      lambda told, take=act: take(*told, time.monotonic()))
        for topic, profile, act in (
                (ALARMS_TOPIC, qos.ALARMS, bridge.take_alarms),
                (DIAGNOSTICS_TOPIC, qos.HEADINGS_UNRELIABLE, bridge.take_health)):
            subscribe(self, DiagnosticArray, topic, profile, self.health, decode_statuses,
                      lambda told, take=act: take(told[1], time.monotonic()))
        subscribe(self, DiagnosticArray, 'pairs/ledger', qos.LEDGER, self.health, decode_ledger,
                  self._book)

    def _book(self, told: LedgerMessage) -> None:
        self._bridge.take_ledger(told, time.monotonic())
        if any(told.ledger.total.counts.values()):
            for intake in (*self._intakes.values(), self._pairs):
                intake.open = True

    def _say_where(self, own: DashboardNode) -> None:
        """Print the address once, and a token that was made here; the log keeps no token."""
        made = self.page.token is not None and own.token is None
        sys.stdout.write(f'page: {self.page.url}'
                         f'{f" token: {self.page.token}" if made else ""}\n')
        sys.stdout.flush()

    def _drain(self) -> None:
        now_s = time.monotonic()
        for stream, intake in self._intakes.items():
            taken = intake.take()
            headings, refused = read_headings(intake.type_name, self._conventions[stream],
                                              [message for message, _ in taken])
            intake.refuse(refused)
            if taken:
                self._bridge.take_headings(stream, headings, taken[-1][1]['received_timestamp'],
                                           now_s)
        pairs, refused = read_pairs([message for message, _ in self._pairs.take()])
        self._pairs.refuse(refused)
        self._bridge.take_pairs(pairs, now_s)

    def _show(self) -> None:
        now_s = time.monotonic()
        self._seen = self._bridge.view(now_s), now_s

    def _look(self) -> tuple[BridgeView, float]:
        """Return the newest view and its age; called by the thread of the page."""
        view, made_s = self._seen
        return view, time.monotonic() - made_s

    def end(self) -> None:
        """Close the page."""
        self.page.close()
        self.ended = True


def main(args: Sequence[str] | None = None) -> int:
    """Run the node."""
    return run('dashboard', Dashboard, args)
