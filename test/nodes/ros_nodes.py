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

"""The nodes of one test: one context and one executor, no threads, conditions with a deadline."""

from __future__ import annotations

import time

from deadlines import DEADLINE_S
import pytest
import rclpy
from rclpy.context import Context
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

NORMS = {'norms.sigma_max_deg': 0.2, 'norms.sigma_ref_max_deg': 0.1}


#: The test runs with either executor.
EITHER_EXECUTOR = pytest.mark.usefixtures('either_executor')


class NoPage:
    """Stands for the server of the page, so that a test needs no browser and no NiceGUI."""

    url, token_made = 'http://127.0.0.1:1/', None

    def __init__(self, controls, **kwargs):
        self.controls, self.kwargs = controls, kwargs
        self.closed = False

    def close(self):
        """Note that it was closed."""
        self.closed = True


class Ros:
    """Nodes of one test: made, spun and destroyed."""

    def __init__(self) -> None:
        self.context = Context()
        rclpy.init(context=self.context, args=[],
                   signal_handler_options=SignalHandlerOptions.NO)
        from heading_intercompare.nodes.spinning.executors import make_executor
        self.executor = make_executor(self.context)
        self.nodes = []
        self.plain = self.add(Node, 'test_node')

    def add(self, make, *args, name=None, **kwargs):
        """Make a node and spin it from now on."""
        if name is not None:
            kwargs['cli_args'] = ['--ros-args', '-r', f'__node:={name}']
        node = make(*args, context=self.context, **kwargs)
        self.nodes.append(node)
        self.executor.add_node(node)
        return node

    def ours(self, make, name=None, **values):
        """Make a node of the package with settings, including the norms."""
        from heading_intercompare.nodes.interface.parameters import make_overrides
        named = {key.replace('__', '.'): value for key, value in values.items()}
        return self.add(make, name=name, parameter_overrides=make_overrides({**NORMS, **named}))

    def spin_until(self, condition):
        """Spin until a condition holds; fail if it does not in time."""
        deadline_s = time.monotonic() + DEADLINE_S
        while not condition():
            assert time.monotonic() < deadline_s, 'the condition did not come true in time'
            self.executor.spin_once(0.02)

    def end(self, *nodes):
        """End nodes as their process would; they are destroyed."""
        from heading_intercompare.nodes.launching.process import end
        end(self.executor, nodes)
        self.nodes = [node for node in self.nodes if node not in nodes]

    def listen(self, kind, topic, profile, node=None):
        """Return a list that fills with messages of a topic, which the test or a node hears."""
        heard = []
        (node or self.plain).create_subscription(kind, topic, heard.append, profile)
        return heard

    def close(self):
        """Destroy everything, in the order that rclpy wants."""
        self.executor.shutdown()
        for node in self.nodes:
            node.destroy_node()
        self.context.try_shutdown()
