# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The node `watcher`: what the terminal shows of a graph; it runs beside other nodes."""

from __future__ import annotations

from typing import Any

from rclpy.node import Node

from heading_intercompare.nodes.ros.parameters import declare, OVERRIDES
from heading_intercompare.nodes.runtime.health import Health
from heading_intercompare.nodes.taking.bridge_intake import BridgeIntake
from heading_intercompare.web.bridge.bridge_view import BridgeView

from .settings import SHOWN, Taking

__all__ = ['Watcher']


class Watcher(Node):
    """Hear a graph, and say what to show of it; publish nothing but its own state."""

    done = False

    def __init__(self, **kwargs: Any) -> None:
        super().__init__('watcher', **OVERRIDES, **kwargs)
        settings, taking = declare(self, SHOWN, Taking)
        self.ended = False
        self.health = Health(self)
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
