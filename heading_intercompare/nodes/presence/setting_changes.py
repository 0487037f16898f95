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

"""Settings that are changed while their node runs: to the log, the bag and /diagnostics."""

from __future__ import annotations

from functools import partial
from typing import Any, Sequence

from rclpy.node import Node

from heading_intercompare.messages.status_messages import OK, WARN
from heading_intercompare.nodes.interface.parameters import follow

from .action_publisher import ActionPublisher
from .health import Health


class SettingChanges:
    """
    Says each change of the followed settings of a node: to the log, the recorder, diagnostics.

    Parameters
    ----------
    node, health
        The node, and its state. The part `settings` warns until it is acknowledged, and while a
        value differs from that at the start.
    names
        The settings.

    """

    def __init__(self, node: Node, health: Health, names: Sequence[str]) -> None:
        self._health = health
        self._first = {name: node.get_parameter(name).value for name in names}
        self._values = dict(self._first)
        self._actions = ActionPublisher(node, health)
        for name in names:
            follow(node, name, partial(self._take, name))

    def _take(self, name: str, value: Any) -> None:
        before, self._values[name] = self._values[name], value
        if value == before:
            return
        words = f'{name} changed from {before} to {value}'
        self._actions.publish(words, warn=True)
        self._health.note('settings', WARN, words, latch=True, log=False)
        if self._values == self._first:
            self._health.note('settings', OK, 'as at the start', log=False)
