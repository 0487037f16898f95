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

"""Publishing from a recording or simulation: wait for subscribers, limit the rate, confirm."""

from __future__ import annotations

from collections import deque
import math
import time
from typing import Iterable, Iterator, Mapping, Sequence

from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.publisher import Publisher

from heading_intercompare.core.records import Headings
from heading_intercompare.messages.status_messages import ERROR, OK, WARN
from heading_intercompare.nodes.presence.endpoints import count_subscribed, name_node
from heading_intercompare.nodes.presence.health import Health
from heading_intercompare.nodes.presence.sole_node import SoleNode

# Discovery between processes takes up to two seconds; a longer wait than this is a warning.
_PATIENCE_S = 5.0
# A synchronizer opens its inputs 10 s after its start at the latest. One that does not subscribe
# then hears other topics.
_JUDGES_S = 15.0
# Five seconds after the recorder, a synchronizer that was started with it is there.
_GRAPH_S = 5.0
# DDS gives up a process that hangs after 20 s; after this time its connection must be broken.
_BROKEN_S = 30.0

# A subscriber that was cut off finds within the first time that something is missing, and needs no
# longer than the second to be connected again.
_CATCH_UP_S, _RETURN_S = 10.0, 45.0

# DDS sends again what was lost after 3 s at the latest.
_ARRIVAL_S = 3.5

# Number of messages that go out before the first question whether they have come.
_UNASKED = 500
# A question costs twice as much as a message; until the window is full, it waits this long.
_ASKED_EVERY_S = 0.005

# Less than a subscription holds; at 1 kHz four seconds.
_WINDOW = 4000

# A recorder empties its subscription, which holds 5000, every 0.2 s.
_BURST_HZ, _LONGEST_BURST = 10_000.0, 2000


class Audience:
    """
    Waits until topics have their subscriptions.

    Parameters
    ----------
    node
        The node that publishes.
    publishers
        Publishers of the topics.
    wanted
        Nodes that must have subscribed to each; 0: do not wait.
    health
        Shows that the node waits.
    judged
        For a topic, the topics of those that judge it, by their names before remapping. Every
        node that publishes one of these must have subscribed, too: a recorder will not do. While
        no node publishes them, and the subscribers are nodes of a graph, the others may be about
        to come: without `patience_s`, these are waited for, 5 s.
    patience_s
        Go on without the subscriptions after this time, seconds.

    Attributes
    ----------
    sole : SoleNode
        Tells whether another node publishes the topics.

    """

    def __init__(self, node: Node, publishers: Sequence[Publisher], wanted: int,
                 health: Health, *, judged: Mapping[str, Sequence[str]] | None = None,
                 patience_s: float = math.inf) -> None:
        self._node, self._publishers, self._wanted = node, publishers, wanted
        self._judged = {node.resolve_topic_name(topic): [*map(node.resolve_topic_name, by)]
                        for topic, by in (judged or {}).items()}
        self._health, self._there, self._patience_s = health, False, patience_s
        self.sole = SoleNode(node, [p.topic_name for p in publishers], health)
        self._began_s = self._missing_s = time.monotonic()
        self._words = 'looking for subscribers'
        self._asked_s: float | None = None
        self._whole_s = math.inf

    @property
    def waiting(self) -> str:
        """For whom the node waits, in words; '' if for nobody."""
        return self._words

    def is_there(self) -> bool:
        """Tell whether all subscriptions are there; once True, it stays True."""
        if not self._there:
            if self._wanted and not self.sole.clear:
                # Only now the subscribers can be discovered.
                self._began_s = self._missing_s = time.monotonic()
                self._words = f'looking for other publishers of {self._publishers[0].topic_name}'
                return False
            missing, now_s = self._find_missing(), time.monotonic()
            waited_s = now_s - self._began_s
            if missing:
                # On a loaded machine all of the graph starts late, also those that judge.
                self._missing_s = now_s
            judges_waited_s = now_s - self._missing_s
            self._words = (self._describe(missing) or self._describe_judges()
                           or ('' if judges_waited_s > _GRAPH_S else self._describe_coming()))
            given_up = bool(self._words) and (
                waited_s > self._patience_s or judges_waited_s > _JUDGES_S)
            self._there = given_up or not self._words
            words = f'going on without; {self._words}' if given_up else self._words
            if self._there:
                # Nor does the end wait for subscribers that never came.
                self._words, self._wanted = '', 0 if missing else self._wanted
            self._health.note('audience', WARN if words and waited_s > _PATIENCE_S else OK,
                              words or 'all subscribers are there')
        return self._there

    def _describe_judges(self) -> str:
        """Say which nodes judge these topics and have not subscribed to them; '' if all have."""
        for topic, judges, heard_by in self._list_audience():
            if late := sorted(judges - heard_by):
                return f'waiting for {" and ".join(late)} to subscribe to {topic}'
        return ''

    def _describe_coming(self) -> str:
        """Say which topic a graph hears in which nobody judges yet; '' if there is none."""
        if self._patience_s < math.inf or not self._judged:
            return ''
        # Every node of this package says its health; what displays or copies a topic does not.
        graph = {*map(name_node, self._node.get_publishers_info_by_topic('/diagnostics'))}
        for topic, judges, heard_by in self._list_audience():
            if self._judged.get(topic) and not judges and heard_by and heard_by <= graph:
                return f'waiting for a node that judges {topic}'
        return ''

    def _list_audience(self) -> Iterator[tuple[str, set[str], set[str]]]:
        """Yield each topic with the nodes that judge it, and those that have subscribed to it."""
        for topic in [p.topic_name for p in self._publishers] if self._wanted else ():
            judges = {name_node(info) for judging in self._judged.get(topic, ())
                      for info in self._node.get_publishers_info_by_topic(judging)}
            yield topic, judges, {
                *map(name_node, self._node.get_subscriptions_info_by_topic(topic))}

    def has_heard(self, publishers: Sequence[Publisher]) -> bool:
        """
        Tell, after the last message, whether its subscribers have it; ask until they do.

        If one is missing, or does not acknowledge, it may have been cut off for a while. It gets
        time to come back and to take what it has missed.
        """
        if not (self._there and self._wanted):
            await_acknowledgement(publishers)
            return True
        now_s, missing = time.monotonic(), self._find_missing()
        first = self._asked_s is None
        heard = not missing and await_acknowledgement(publishers, _ARRIVAL_S if first else 0.0)
        if self._asked_s is None:
            if heard:
                return True
            self._asked_s = now_s
        self._whole_s = min(self._whole_s, now_s) if heard else math.inf
        done = now_s > self._whole_s + _CATCH_UP_S or now_s > self._asked_s + _RETURN_S
        words = self._describe(missing) or 'waiting until the last messages have arrived'
        self._health.note('audience', OK if done else WARN,
                          'the last messages are out' if done else f'at the end: {words}')
        return done

    def _find_missing(self) -> dict[str, int]:
        """Return the topics that lack subscriptions, each with the number it has."""
        counts = {p.topic_name: count_subscribed(self._node, p) for p in self._publishers}
        return {topic: n for topic, n in counts.items() if n < self._wanted}

    def _describe(self, missing: Mapping[str, int]) -> str:
        """Say which topics lack subscribers, given the number that each one has."""
        if not missing:
            return ''
        topics = ' and '.join(missing)
        if self._wanted == 1:
            return f'waiting for a subscriber of {topics}'
        counts = ' and '.join(map(str, missing.values()))
        return f'waiting for {self._wanted} subscribers of {topics} ({counts} there)'


class Allowance:
    """Limits the rate of messages: when it is used up, the next message must wait."""

    def __init__(self, rate_hz: float) -> None:
        self._rate_hz = rate_hz
        self._left = 0.0
        self._last_s = time.monotonic()

    def has_left(self) -> bool:
        """Tell whether a message may go out now; an unused allowance expires after 0.1 s."""
        now_s = time.monotonic()
        self._left = min(self._left + self._rate_hz * (now_s - self._last_s),
                         0.1 * self._rate_hz + 1.0)
        self._last_s = now_s
        return self._left >= 1.0

    def spend(self, n: int) -> None:
        """Count messages that were published."""
        self._left -= n


class FlowControl:
    """
    Holds publishing back until reliable subscribers have acknowledged what was sent.

    Parameters
    ----------
    publishers
        Each keeps more messages than the window.
    health
        Shows that it waits.
    window
        Most messages sent and perhaps not acknowledged.
    patience_s
        Publish without room after this time, seconds: a subscriber that hangs, or whose
        connection broke, must not stop the others.

    """

    def __init__(self, publishers: Iterable[Publisher], health: Health, *, window: int = 2000,
                 patience_s: float = _BROKEN_S) -> None:
        self._publishers, self._health = [*publishers], health
        self._window, self._patience_s = window, patience_s
        self._sent, self._full_s, self._asked_s = 0, math.inf, -math.inf

    def has_room(self) -> bool:
        """Tell whether a message may be published now."""
        if self._sent < min(_UNASKED, self._window):
            return True
        now_s = time.monotonic()
        if self._sent < self._window and now_s < self._asked_s + _ASKED_EVERY_S:
            return True
        self._asked_s = now_s
        # Asked early and often: DDS asks its readers what they have while messages go out, and
        # once these have stopped only every three seconds.
        if all(publisher.wait_for_all_acked(Duration(nanoseconds=0))
               for publisher in self._publishers):
            if self._full_s < math.inf:
                self._health.note('flow', OK, 'subscribers keep up')
            self._sent, self._full_s = 0, math.inf
            return True
        if self._sent < self._window:
            return True
        self._full_s = min(self._full_s, now_s)
        waited_s = now_s - self._full_s
        if waited_s > self._patience_s:
            self._health.note('flow', ERROR, 'going on without subscribers that do not keep up: '
                              'start them again')
            return True
        if waited_s > _PATIENCE_S:
            self._health.note('flow', WARN, f'waiting for subscribers that do not keep up: '
                              f'{self._sent} messages are not acknowledged')
        return False

    def spend(self, n: int) -> None:
        """Count messages that were published."""
        self._sent += n


class HeadingQueue:
    """
    Headings of a driver that wait to be published, in pieces.

    Attributes
    ----------
    overrun : int
        Headings that found the queue full and are lost: more than any sensor sends.

    """

    def __init__(self, most: int = 100_000, piece: int = 200) -> None:
        self._most, self._piece = most, piece
        self._waiting: deque[Headings] = deque()
        self._n = self.overrun = 0

    def __len__(self) -> int:
        return self._n

    def add(self, headings: Headings) -> Headings:
        """Let headings wait, if there is room for them; return those that do."""
        room = max(0, self._most - self._n)
        self.overrun += max(0, len(headings) - room)
        headings = headings[:room]
        self._waiting += [headings[lo:lo + self._piece]
                          for lo in range(0, len(headings), self._piece)]
        self._n += len(headings)
        return headings

    def popleft(self) -> Headings:
        """Return the next piece."""
        piece = self._waiting.popleft()
        self._n -= len(piece)
        return piece


class Backlog:
    """
    Messages that wait to be published, so that no burst overruns the subscribers.

    Parameters
    ----------
    publisher
        Publishes them.
    health
        Shows subscribers that do not keep up.
    burst
        Most messages published at once; more, if `publish` is called less often than 50 times a
        second, so that the rate does not depend on that.
    patience_s
        As for `FlowControl`.

    """

    def __init__(self, publisher: Publisher, health: Health, *, burst: int = 200,
                 patience_s: float = _BROKEN_S) -> None:
        self._publisher, self._burst, self._last_s = publisher, burst, math.inf
        self._flow = FlowControl([publisher], health, window=_WINDOW, patience_s=patience_s)
        self._waiting: deque[bytes] = deque()

    def __len__(self) -> int:
        return len(self._waiting)

    def add(self, messages: Iterable[bytes]) -> None:
        """Let messages wait for their turn."""
        self._waiting += messages

    def publish(self) -> None:
        """Publish the next messages if the subscribers keep up."""
        now_s = time.monotonic()
        due = min(_BURST_HZ * max(0.0, now_s - self._last_s), _LONGEST_BURST)
        self._last_s = now_s
        left = min(max(self._burst, int(due)), len(self._waiting))
        while left and self._flow.has_room():
            n = min(self._burst, left)
            for _ in range(n):
                self._publisher.publish(self._waiting.popleft())
            self._flow.spend(n)
            left -= n


def await_acknowledgement(publishers: Iterable[Publisher], timeout_s: float = _ARRIVAL_S) -> bool:
    """Wait until all messages have reached the reliable subscriptions; return whether they did."""
    deadline_s = time.monotonic() + timeout_s
    arrived = True
    for publisher in publishers:
        left_s = max(0.0, deadline_s - time.monotonic())
        arrived = publisher.wait_for_all_acked(Duration(seconds=left_s)) and arrived
    return arrived
