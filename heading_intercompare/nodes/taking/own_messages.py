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

"""The messages of the nodes of a graph, for those who show them; those of others are held."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import partial
import time
from typing import Callable, Sequence, TypeVar

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.subscription import Subscription

from heading_intercompare.bags.recording.part_states import DIAGNOSTICS_TOPIC
from heading_intercompare.messages.status_messages import decode_statuses, Status
from heading_intercompare.nodes.interface import qos
from heading_intercompare.nodes.interface.parameters import resolve_topic
from heading_intercompare.nodes.presence.endpoints import is_named, name_node
from heading_intercompare.nodes.presence.health import Health
from heading_intercompare.nodes.presence.rivals import Rivals

from .raw_subscription import subscribe
from .vouchers import HOLD_S, MOST_HELD, say_strange, Strangers, Vouchers

_Read = TypeVar('_Read')


@dataclass(slots=True)
class _Topic:
    """
    One topic of statuses.

    Attributes
    ----------
    open
        Makes the subscription.
    rivals
        The other publishers, where one node must publish the topic.
    doubted
        Messages came since somebody else publishes the topic too.
    since_s
        When a publisher was first seen that says no state, by a steady clock; None without one.
    strangers
        The messages that were not taken.
    noted
        Something is wrong, and was said.

    """

    open: Callable[[], Subscription]
    rivals: Rivals | None
    subscription: Subscription | None = None
    doubted: bool = False
    since_s: float | None = None
    strangers: Strangers = field(default_factory=Strangers)
    noted: bool = False


class OwnMessages:
    """
    Passes on the messages of the nodes of a graph, and holds those of all others.

    Parameters
    ----------
    node
        The node that takes the messages.
    health
        Shows whose messages were not taken.
    hear
        Called with each message of /diagnostics, and the time of a steady clock.

    Notes
    -----
    A message does not say which publisher sent it, but it names its node. A message waits until
    that node says on /diagnostics that it runs. If nobody does, somebody else sent the message,
    and it is counted.

    While somebody else publishes a topic too, a message that names the right node may be a copy,
    and nothing tells it apart. Then what is shown stays. When the other one is gone, the
    subscription is made again, so the publisher sends what it keeps.

    """

    def __init__(self, node: Node, health: Health,
                 hear: Callable[[Sequence[Status], float], None] = lambda statuses, now_s: None,
                 ) -> None:
        self._node, self._health, self._hear_states = node, health, hear
        self._vouchers = Vouchers()
        self._topics: dict[str, _Topic] = {}
        #: By topic and owner: since when the newest message waits, and what takes it.
        self._held: dict[tuple[str, str], tuple[float, Callable[[], None]]] = {}
        subscribe(node, DiagnosticArray, DIAGNOSTICS_TOPIC, qos.HEADINGS_UNRELIABLE, health,
                  decode_statuses, self._hear)
        health.add_refresher(self._look)

    def subscribe(self, topic: str, profile: QoSProfile, read: Callable[[bytes], _Read],
                  act: Callable[[_Read], None], find_owner: Callable[[_Read], str], *,
                  act_in_doubt: Callable[[_Read], None] | None = None) -> None:
        """
        Subscribe to a topic of statuses.

        Parameters
        ----------
        topic, profile, read, act
            As for `subscribe` of `raw_subscription`.
        find_owner
            Returns the owner that a message names.
        act_in_doubt
            Several nodes of the graph publish the topic, and this takes a message that may be a
            copy. Without it one node publishes the topic, and such a message is left out.

        """
        def take(message: _Read) -> None:
            self._take(topic, find_owner(message), partial(act, message),
                       None if act_in_doubt is None else partial(act_in_doubt, message))
        self._topics[topic] = state = _Topic(
            partial(subscribe, self._node, DiagnosticArray, topic, profile, self._health, read,
                    take), Rivals(topic) if act_in_doubt is None else None)
        state.subscription = state.open()

    def _take(self, topic: str, owner: str, act: Callable[[], None],
              act_in_doubt: Callable[[], None] | None) -> None:
        key, now_s = (topic, owner), time.monotonic()
        pass_on = partial(self._pass_on, topic, act, act_in_doubt)
        if self._vouchers.vouch(owner):
            pass_on()
        elif key in self._held or len(self._held) < MOST_HELD:
            self._held[key] = self._held.get(key, (now_s,))[0], pass_on
        else:
            self._topics[topic].strangers.add(owner, now_s)

    def _pass_on(self, topic: str, act: Callable[[], None],
                 act_in_doubt: Callable[[], None] | None) -> None:
        state = self._topics[topic]
        if not self._find_rivals(topic, state):
            act()
            return
        state.doubted = True
        if act_in_doubt is not None:
            act_in_doubt()

    def _find_rivals(self, topic: str, state: _Topic) -> str:
        """Return in words who else publishes a topic; '' if nobody does."""
        infos = [*filter(is_named, self._node.get_publishers_info_by_topic(
            resolve_topic(self._node, topic)))]
        if state.rivals is not None:
            words = state.rivals.look(infos)
            return '' if state.rivals.is_ghost else words
        names = {*map(name_node, infos)}
        strangers = sorted(names - self._vouchers.nodes)
        # A player of a bag alone publishes for all nodes whose states it plays.
        if not strangers or len(strangers) == len(names):
            return ''
        return f'{", ".join(strangers)} also publishes {topic}, and says no state'

    def _hear(self, message: tuple[int, Sequence[Status]]) -> None:
        """Take the state of a node, and the messages that it vouches for."""
        now_s = time.monotonic()
        self._vouchers.hear(message[1], now_s)
        self._hear_states(message[1], now_s)
        for key in [key for key in self._held if self._vouchers.vouch(key[1])]:
            self._held.pop(key)[1]()

    def _look(self) -> None:
        """Say who else publishes, and whose messages are not taken."""
        now_s = time.monotonic()
        for topic, owner in [key for key, (since_s, _) in self._held.items()
                             if now_s > since_s + HOLD_S]:
            del self._held[topic, owner]
            self._topics[topic].strangers.add(owner, now_s)
        for topic, state in self._topics.items():
            rivals = self._find_rivals(topic, state)
            state.since_s = (state.since_s or now_s) if rivals else None
            if state.doubted and not rivals:
                self._begin_again(state)
            self._note(topic, state, rivals, now_s)

    def _begin_again(self, state: _Topic) -> None:
        """Subscribe again: publishers send what they keep."""
        if state.subscription is not None:
            self._node.destroy_subscription(state.subscription)
        state.subscription, state.doubted = state.open(), False

    def _note(self, topic: str, state: _Topic, rivals: str, now_s: float) -> None:
        """Say what is wrong with a topic; a node that starts has not said its state yet."""
        words = []
        if rivals and state.since_s is not None and (
                state.rivals is not None or now_s > state.since_s + HOLD_S):
            words.append(f'{rivals}; what is shown may be older')
        words += filter(None, [state.strangers.describe(topic, now_s)])
        if words or state.noted:
            say_strange(self._health, topic, words)
        state.noted = bool(words)
