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

"""The subscription to one topic, and how another one takes over from it: each message once."""

from __future__ import annotations

from itertools import islice
import time
from typing import Mapping, Sequence

from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.subscription import Subscription

from heading_intercompare.nodes.ros.batches import take_all, Unwatched

#: A message as bytes, and its info.
Message = tuple[bytes, Mapping[str, int]]

#: More messages than any publisher keeps for late subscriptions.
_REMEMBERED = 12_000
#: What publishers keep arrives within this. What comes later is new, whatever its stamp says.
_KEPT_NS = 5_000_000_000


def number_of(message: Message) -> int:
    """Return the sequence number that the publisher gave to a message."""
    return message[1]['publication_sequence_number']


class Reception:
    """
    Takes each message of one topic once, whatever becomes of the subscription.

    Parameters
    ----------
    node
        The node that takes the messages.
    topic
        Relative or absolute name.
    group
        Callback group of the subscriptions.
    whole
        Take also what was sent before the first message that was taken.

    Attributes
    ----------
    newest : int
        Number of the newest message taken; 0 before the first.

    Notes
    -----
    A transient local subscription gets again what a publisher sent while it could not be reached,
    but also what it sent long before. So a first subscription that is volatile says where to
    begin, and a second one that is transient local takes over as soon as it has come as far. What
    both deliver is known by its number and its time of sending. What was sent before the first
    message that was taken is left out.

    Where a subscription may have been cut off before its first message, there is no such number.
    It is set aside, and the next one begins with what was sent since the first one was made. What
    the first one held is used where it is older than what the next one brings, or where that one
    brings nothing, because the publisher has ended.

    """

    def __init__(self, node: Node, topic: str, group: Unwatched, *, whole: bool = False) -> None:
        self._node, self._topic, self._group, self._whole = node, topic, group, whole
        self._kind: type | None = None
        self._current: Subscription | None = None
        self._successor: Subscription | None = None
        self._left: list[Message] = []
        self._aside: list[Message] = []
        self._since_ns = self._kept_until_ns = 0
        self._known: dict[tuple[int, int], None] = {}
        self._skip_until = self.newest = 0
        self._seamless, self._joint = False, 0
        self._first = 0, 0

    @property
    def there(self) -> bool:
        """Whether there is a subscription."""
        return self._current is not None

    def open(self, kind: type, profile: QoSProfile, after: int = 0, since_ns: int = 0) -> None:
        """
        Subscribe.

        Parameters
        ----------
        kind
            Message type.
        profile
            Quality of service.
        after
            Leave out the first messages up to this number.
        since_ns
            Leave out what publishers keep from before this time. They usually keep what the
            subscription that was set aside held, too.

        """
        self._kind = kind
        self._current, self._skip_until = self._subscribe(kind, profile), after
        self._since_ns, self._kept_until_ns = since_ns, time.time_ns() + _KEPT_NS
        if not since_ns:
            self.bring_back()

    def bring_back(self) -> None:
        """Take what a subscription held that was set aside: nothing better is to come."""
        aside, self._aside = self._aside, []
        self._left += self._once(aside)

    def set_aside(self) -> None:
        """Give up a subscription that is to be made again; `open` says what it held."""
        assert self._current is not None
        self._aside += take_all(self._current)
        self._node.destroy_subscription(self._current)
        self._current = None

    def hand_over(self, profile: QoSProfile, *, seamless: bool = False) -> None:
        """
        Subscribe with another profile, too, and keep only that one once it has come as far.

        Parameters
        ----------
        profile
            Quality of service.
        seamless
            Keep the first one until it has brought all that was sent before the other one began.

        """
        assert self._kind is not None
        if self._successor is not None:
            self._node.destroy_subscription(self._successor)
        self._successor = self._subscribe(self._kind, profile)
        self._seamless, self._joint = seamless, 0
        self._kept_until_ns = time.time_ns() + _KEPT_NS

    def take(self) -> list[Message]:
        """Return the messages since the last call."""
        messages, self._left = self._left, []
        if self._current is not None:
            came = take_all(self._current)
            messages += self._once([*self._take_older(came), *came])
        if self._successor is not None:
            again = take_all(self._successor)
            self._joint = self._joint or (number_of(again[0]) if again else 0)
            caught_up = bool(again) and number_of(again[-1]) >= self.newest and not (
                self._seamless and self._joint > self.newest + 1)
            messages += self._once(again)
            if caught_up:
                # What the first subscription still holds comes to the second one, too.
                if self._current is not None:
                    self._node.destroy_subscription(self._current)
                self._current, self._successor = self._successor, None
        return messages

    def _take_older(self, came: Sequence[Message]) -> list[Message]:
        """Return what was set aside and sent before the first messages that came since."""
        if not self._aside:
            return []
        sent_ns = next((message[1]['source_timestamp'] for message in came
                        if not self._is_earlier(message)), None)
        if sent_ns is None:
            return []
        aside, self._aside = self._aside, []
        return [message for message in aside if message[1]['source_timestamp'] < sent_ns]

    def close(self) -> None:
        """Give up the subscription, but not what it holds."""
        self._left = self.take()
        for subscription in (self._current, self._successor):
            if subscription is not None:
                self._node.destroy_subscription(subscription)
        self._current = self._successor = None

    def _subscribe(self, kind: type, profile: QoSProfile) -> Subscription:
        return self._node.create_subscription(kind, self._topic, lambda message: None, profile,
                                              callback_group=self._group, raw=True)

    def _once(self, messages: Sequence[Message]) -> list[Message]:
        """Return the messages that were not taken before."""
        fresh = []
        for message in messages:
            number = number_of(message)
            if self._skip_until:
                if number <= self._skip_until:
                    continue
                self._skip_until = 0
            if self._is_earlier(message):
                continue
            name = number, message[1]['source_timestamp']
            if name not in self._known:
                self._known[name] = None
                fresh.append(message)
        for name in [*islice(self._known, max(0, len(self._known) - _REMEMBERED))]:
            del self._known[name]
        if fresh:
            self.newest = number_of(fresh[-1])
            if not self._first[0]:
                self._first = number_of(fresh[0]), fresh[0][1]['source_timestamp']
        return fresh

    def _is_earlier(self, message: Message) -> bool:
        """Tell whether a message was sent before the first one taken, or the time of `open`."""
        if self._whole:
            return False
        number, info = number_of(message), message[1]
        if self._since_ns:
            return (info['source_timestamp'] < self._since_ns
                    and info['received_timestamp'] < self._kept_until_ns
                    and (not self.newest or number < self.newest))
        first, sent_ns = self._first
        return number < first and info['source_timestamp'] < sent_ns
