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

"""What every node of the graph offers in addition to a node of rclpy."""

from __future__ import annotations

from typing import Any

from rclpy.impl.rcutils_logger import RcutilsLogger
from rclpy.node import Node

from heading_intercompare.nodes.presence.health import Health


class GraphNode(Node):
    """
    A node that can be declared with `declare`, and that ends in two steps.

    Parameters
    ----------
    name
        Name of the node, unless it is remapped.
    **kwargs
        As for `Node`.

    Attributes
    ----------
    done : bool
        Its work is finished.
    ended : bool
        Everything is published and written. After `end`, the node is spun until then.
    health
        Its state, which is muted before `end`.

    """

    done = False
    ended = False
    health: Health

    def __init__(self, name: str, **kwargs: Any) -> None:
        super().__init__(name, automatically_declare_parameters_from_overrides=True, **kwargs)

    def end(self) -> None:
        """Begin to shut down."""
        raise NotImplementedError

    def give_up(self) -> str:
        """Leave what is not published or written; return in words what that is."""
        return 'something is not published or written'

    def get_logger(self) -> RcutilsLogger:
        """Return the logger of the node; rclpy does not say its type."""
        logger: RcutilsLogger = Node.get_logger(self)
        return logger

    def destroy_node(self) -> None:
        """Destroy the node; rclpy does not say that this returns nothing."""
        Node.destroy_node(self)
