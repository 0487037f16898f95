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

"""The publisher of an operator's note for the recorder."""

from __future__ import annotations

import time

import rclpy
from rclpy.context import Context
from rclpy.signals import SignalHandlerOptions
from std_msgs.msg import String

from heading_intercompare.bags.rosbag2.provenance import NOTE_TOPIC
from heading_intercompare.core.declared_settings import SettingsError
from heading_intercompare.messages.status_messages import encode_text
from heading_intercompare.nodes.interface.qos import NOTE
from heading_intercompare.nodes.launching.process import (
    check_security,
    say_security_errors,
    spin_nodes,
)
from heading_intercompare.nodes.presence.endpoints import check_namespace
from heading_intercompare.nodes.presence.graph_node import GraphNode
from heading_intercompare.nodes.sending.publishing import await_acknowledgement

# Discovery between processes takes up to two seconds.
_PATIENCE_S = 5.0


def publish_note(text: str, namespace: str = '/', patience_s: float = _PATIENCE_S) -> None:
    """
    Publish a note as soon as a recorder listens; return when the recorder has received it.

    Parameters
    ----------
    text
        The note.
    namespace
        That of the graph of the recorder, with a leading slash.
    patience_s
        How long to wait for a recorder, seconds.

    Raises
    ------
    SettingsError
        If the namespace is none, no recorder listens in time, or it does not confirm the note.

    """
    check_namespace(namespace)
    context, topic = Context(), f'{namespace.rstrip("/")}/{NOTE_TOPIC}'
    check_security()
    rclpy.init(args=[], context=context, signal_handler_options=SignalHandlerOptions.NO)
    try:
        with spin_nodes(context) as (executor, nodes):
            with say_security_errors():
                nodes.append(GraphNode('operator_note', namespace=namespace, context=context))
            publisher = nodes[0].create_publisher(String, NOTE_TOPIC, NOTE)
            executor.add_node(nodes[0])
            deadline_s = time.monotonic() + patience_s
            while not publisher.get_subscription_count():
                if time.monotonic() > deadline_s:
                    raise SettingsError(
                        f'nobody listens to {topic}: a recorder must be running, on this '
                        'network, in this ROS_DOMAIN_ID and in this namespace (--namespace /NAME)')
                executor.spin_once(0.05)
            publisher.publish(encode_text(text))
            if not await_acknowledgement([publisher]):
                raise SettingsError(f'a subscriber to {topic} has not confirmed the note')
    finally:
        context.try_shutdown()
