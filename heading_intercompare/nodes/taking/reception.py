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

from heading_intercompare.bags.recording.cut_bag import LastMessages
from heading_intercompare.nodes.spinning.batches import take_all, Unwatched

#: The state of a subscription is looked at once a second; a node that was stopped looks later.
_STOPPED_S = 3.0
#: No stream that is judged has a longer step; a silence is unusual from three steps on.
_SILENT_S = 5.0
_STEPS = 3.0
#: Arrivals after which the steps of a stream are known.
_KNOWN_FROM = 20
#: What is under way arrives within this; only then is it missing.
_WAIT_S = 2.0
#: A sensor that is switched off, or a network that loses all the time, costs no more than one new
#: subscription in this time.
_LONGEST_S = 300.0


class Renewal:
    """
    Tells when a subscription is to be made again.

    Notes
    -----
    DDS gives up a process that it cannot reach for the lease, 20 s. When that one is back, its
    subscriptions are usually connected again, but sometimes not, or without the messages that were
    published in the meantime. A new subscription is connected for certain. So it is made where
    messages are missing, where a stream has fallen silent, and where this process stood still.

    A new subscription takes all that its publishers keep, which costs time. Where it has not
    brought what was missing, the next one waits twice as long. The clock is the caller's.

    Examples
    --------
    >>> renewal = Renewal()
    >>> [renewal.is_due(float(s), received=10 * s, missing=0) for s in range(4)]
    [False, False, False, False]
    >>> [renewal.is_due(4.0 + s, received=40, missing=84) for s in range(4)]
    [False, False, True, False]

    """

    def __init__(self) -> None:
        self._looked_s: float | None = None
        self._told_s: float | None = None
        self._missing, self._asked_for, self._wait_s = 0, 0, _WAIT_S
        self._due_s: float | None = None
        self._received, self._arrivals, self._newest_s = 0, 0, 0.0
        self._step_s, self._patience_s = 0.0, 0.0

    def is_due(self, now_s: float, received: int, missing: int) -> bool:
        """Tell whether to make it again, given the messages received and missing so far."""
        before_s = now_s if self._looked_s is None else self._looked_s
        self._looked_s = now_s
        if now_s - before_s > _STOPPED_S:
            self._due_s = now_s + _WAIT_S
        elif missing > self._missing and self._due_s is None:
            self._due_s = now_s + self._wait_s
        if missing < self._asked_for:
            # It has brought some of them.
            self._asked_for, self._wait_s = 0, _WAIT_S
        self._missing = missing
        if self._is_silent(now_s, now_s - before_s, received):
            self._due_s = now_s
        if self._due_s is None or now_s < self._due_s:
            return False
        self._due_s = None
        if missing:
            self._wait_s = min(2.0 * self._wait_s, _LONGEST_S)
        self._asked_for = missing
        return True

    def stood_still(self, now_s: float) -> bool:
        """Tell, once, whether this process stood still since it last asked what is due."""
        if self._looked_s in (None, self._told_s) or now_s - self._looked_s <= _STOPPED_S:
            return False
        self._told_s = self._looked_s
        return True

    def _is_silent(self, now_s: float, passed_s: float, received: int) -> bool:
        """Tell whether a stream is silent for unusually long, now and then."""
        if received > self._received or not self._newest_s:
            if self._received:
                step_s = now_s - self._newest_s - passed_s
                self._step_s = max(self._step_s, min(step_s, _LONGEST_S))
                self._arrivals += 1
            self._received, self._newest_s = received, now_s
            self._patience_s = max(_SILENT_S, _STEPS * self._step_s)
        elif self._arrivals >= _KNOWN_FROM and now_s - self._newest_s > self._patience_s:
            self._patience_s = min(2.0 * (now_s - self._newest_s),
                                   now_s - self._newest_s + _LONGEST_S)
            return True
        return False


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
        self._recorded = LastMessages()
        self.newest = 0
        self._seamless, self._joint = False, 0
        self._first = 0, 0

    @property
    def there(self) -> bool:
        """Whether there is a subscription."""
        return self._current is not None

    def go_on(self, recorded: LastMessages) -> None:
        """Take what was sent after these messages, and none of them again."""
        self._whole, self._recorded = True, recorded
        self._known = dict.fromkeys(recorded.names)

    def open(self, kind: type, profile: QoSProfile, since_ns: int = 0) -> None:
        """
        Subscribe.

        Parameters
        ----------
        kind
            Message type.
        profile
            Quality of service.
        since_ns
            Leave out what publishers keep from before this time. They usually keep what the
            subscription that was set aside held, too.

        """
        self._kind = kind
        self._current = self._subscribe(kind, profile)
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

    def hold(self) -> None:
        """Take what has come, so that the subscription has room, and return it later."""
        self._left = self.take()

    def close(self) -> None:
        """Give up the subscription, but not what it holds."""
        self.hold()
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
        number, info = number_of(message), message[1]
        if self._whole:
            return self._recorded.holds(number, info['source_timestamp']) or (
                info['source_timestamp'] < self._recorded.since_ns
                and info['received_timestamp'] < self._kept_until_ns)
        if self._since_ns:
            return (info['source_timestamp'] < self._since_ns
                    and info['received_timestamp'] < self._kept_until_ns
                    and (not self.newest or number < self.newest))
        first, sent_ns = self._first
        return number < first and info['source_timestamp'] < sent_ns
