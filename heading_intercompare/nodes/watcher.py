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

"""The node `watcher`: what the terminal shows of a graph; it runs beside other nodes."""

from __future__ import annotations

from typing import Any

from heading_intercompare.nodes.interface.parameters import declare
from heading_intercompare.nodes.presence.graph_node import GraphNode
from heading_intercompare.nodes.presence.health import Health
from heading_intercompare.nodes.taking.bridge_intake import BridgeIntake
from heading_intercompare.web.bridge.bridge_view import BridgeView

from .settings import SHOWN, Taking


class Watcher(GraphNode):
    """Hear a graph, and say what to show of it; publish nothing but its own state."""

    done = False

    def __init__(self, **kwargs: Any) -> None:
        super().__init__('watcher', **kwargs)
        settings, taking = declare(self, SHOWN, Taking)
        self.ended = False
        self.health = Health(self, priority=None)
        self._graph = BridgeIntake(self, self.health, settings, taking)

    def open(self) -> None:
        """Hear headings and pairs from now on, even without a synchronizer."""
        self._graph.open()

    def view(self) -> BridgeView:
        """Return what to show now."""
        return self._graph.view()

    def end(self) -> None:
        """Nothing is left to do."""
        self.ended = True
