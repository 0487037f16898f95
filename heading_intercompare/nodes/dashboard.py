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

"""The node `dashboard`: the live page of a graph, with the actions of an operator."""

from __future__ import annotations

import os
import sys
import time
from typing import Any, Sequence

from heading_intercompare.core.alarms.alarm import Priority
from heading_intercompare.core.decision.criteria import Limits
from heading_intercompare.core.sensors.compared_sensors import pair_with_reference
from heading_intercompare.core.sensors.pair_settings import settings_of_pair
from heading_intercompare.core.settings import Settings
from heading_intercompare.nodes.interface.parameters import declare
from heading_intercompare.nodes.judging.operator_actions import OperatorActions
from heading_intercompare.nodes.launching.process import run
from heading_intercompare.nodes.presence.graph_node import GraphNode
from heading_intercompare.nodes.presence.health import Health
from heading_intercompare.nodes.spinning.clocks import every
from heading_intercompare.nodes.taking.bridge_intake import BridgeIntake
from heading_intercompare.web.bridge.bridge_view import BridgeView
from heading_intercompare.web.controls import Controls
from heading_intercompare.web.server import PageServer
from heading_intercompare.web.tokens import read_tokens

from .settings import DashboardNode, SHOWN, Taking

_VIEW_S = 0.2


class Dashboard(GraphNode):
    """Show a graph on a page; what a person does there goes to the nodes concerned."""

    done = False

    def __init__(self, **kwargs: Any) -> None:
        super().__init__('dashboard', **kwargs)
        settings, taking, node_settings = declare(self, SHOWN, Taking, DashboardNode)
        self.ended = False
        self.health = Health(self, priority=Priority.CAUTION)
        self._graph = BridgeIntake(self, self.health, settings, taking, _list_limits(settings))
        self._actions = OperatorActions(self, self.health)
        self._seen: tuple[BridgeView, float] = self._graph.view(), time.monotonic()
        self.page = PageServer(Controls(self._look, self._actions.ask, self._actions.delay),
                               host=node_settings.host, port=node_settings.port,
                               tokens=read_tokens(node_settings.token_file, os.environ),
                               names=node_settings.names,
                               connections_by_address=node_settings.connections_by_address)
        self._say_where()
        every(self, _VIEW_S, self._show)

    def _say_where(self) -> None:
        """Print the address once, and a token that was made here; the log keeps no token."""
        token = '' if self.page.token_made is None else f' token: {self.page.token_made}'
        sys.stdout.write(f'page: {self.page.url}{token}\n')
        sys.stdout.flush()

    def _show(self) -> None:
        self._seen = self._graph.view(), time.monotonic()

    def _look(self) -> tuple[BridgeView, float]:
        """Return the newest view and its age; called by the thread of the page."""
        view, made_s = self._seen
        return view, time.monotonic() - made_s

    def drop_action(self) -> None:
        """Say of an action that still waits that it is not done."""
        self._actions.drop()

    def end(self) -> None:
        """Close the page."""
        self.page.close()
        self.drop_action()
        self.ended = True


def _list_limits(settings: Settings) -> dict[str, float]:
    """Return the limit of a single difference of each tested sensor, degrees."""
    pairs = {tested.name: settings_of_pair(settings, tested, reference)
             for tested, reference in pair_with_reference(settings)}
    return {name: Limits.of(pair.norms, pair.model).count_limit_deg
            for name, pair in pairs.items()}


def main(args: Sequence[str] | None = None) -> int:
    """Run the node."""
    return run('dashboard', Dashboard, args)
