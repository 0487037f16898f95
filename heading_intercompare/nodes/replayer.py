# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The node `replayer`: headings and marks of a bag, at the time of the recording or faster."""

from __future__ import annotations

import math
import time
from typing import Any, Iterator, Sequence

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.node import Node
from rosgraph_msgs.msg import Clock

from heading_intercompare.bags.errors import BagError
from heading_intercompare.bags.reader import BagMessage, BagReader
from heading_intercompare.core.settings import Settings, SettingsError

from . import qos
from .health import Health
from .messages import HEADING_TYPES
from .parameters import declare, OVERRIDES, resolved
from .process import run
from .sending import all_acknowledged, Allowance, Audience
from .settings import ReplayerNode, Sending
from .stamps import clock_message
from .status_messages import OK, WARN
from .timing import every

__all__ = ['main', 'Replayer']

_TICK_S = 0.02
_MARKER = 'compliance/marker'
# Synchronizer and compliance; who replays without them waits for this long.
_MARK_READERS = 2
_MARK_WAIT_S = 5.0


class Replayer(Node):
    """Publish the headings of a bag as they were recorded, after its marks; its end is the end."""

    def __init__(self, **kwargs: Any) -> None:
        super().__init__('replayer', **OVERRIDES, **kwargs)
        settings, sending, self._own = declare(self, Settings, Sending, ReplayerNode)
        if self._own.bag is None:
            raise SettingsError('bag is required: an .mcap file or a rosbag2 folder')
        self.done = self.ended = False
        self._health = Health(self)
        self._reader = BagReader(self._own.bag)
        self._marker = self.create_publisher(DiagnosticArray, _MARKER, qos.MARKER)
        self._headings = {}
        for topic in (settings.ts_topic, settings.rs_topic):
            resolved(self, topic)
            name = self._reader.resolve(topic)
            type_name = self._reader.topics[name].type_name
            if type_name not in HEADING_TYPES:
                raise BagError(f'topic {name} is {type_name}; a heading is '
                               f'{", ".join(HEADING_TYPES)}', self._own.bag)
            self._headings[name] = self.create_publisher(
                HEADING_TYPES[type_name], topic, qos.HEADINGS_OUT,
                event_callbacks=self._health.of_publisher(topic))
        self._clock_publisher = (self.create_publisher(Clock, '/clock', qos.CLOCK)
                                 if self._own.clock else None)
        self._audience = Audience(self, [*self._headings.values()], sending.subscribers,
                                  self._health)
        self._allowance = Allowance(sending.max_rate_hz)
        self._origin_ns = (self._reader.start_ns or 0) + round(self._own.start_s * 1e9)
        self._shown_ns = self._origin_ns
        self._messages: Iterator[BagMessage] | None = None
        self._next: BagMessage | None = None
        self._began_s = 0.0
        self.published = self._marks = 0
        self._heard_s: float | None = None
        self._publish_marks()
        self._health.before_beat(self._note)
        every(self, _TICK_S, self._tick)

    def _publish_marks(self) -> None:
        """Publish all marks before any heading: they work by stamp, and late ones would not."""
        topics = [name for name in self._reader.topics if name.lstrip('/') == _MARKER]
        for message in self._reader.messages(topics) if topics else ():
            self._marker.publish(message.data)
            self._marks += 1

    def _ready(self) -> bool:
        """Tell whether the headings are heard and the marks have arrived."""
        if not self._audience.there():
            return False
        self._heard_s = self._heard_s or time.monotonic()
        return (not self._marks or self._marker.get_subscription_count() >= _MARK_READERS
                or time.monotonic() > self._heard_s + _MARK_WAIT_S)

    def _begin(self) -> None:
        all_acknowledged([self._marker])
        stop_ns = (2 ** 63 if self._own.duration_s is None
                   else self._origin_ns + round(self._own.duration_s * 1e9))
        self._messages = self._reader.messages(self._headings, self._origin_ns, stop_ns)
        self._next = next(self._messages, None)
        self._began_s = time.monotonic()

    def _tick(self) -> None:
        if self.done or self.ended or (self._messages is None and not self._ready()):
            return
        if self._messages is None:
            self._begin()
        now_ns = math.inf
        if self._own.rate > 0.0:
            elapsed_s = (time.monotonic() - self._began_s) * self._own.rate
            now_ns = self._shown_ns = self._origin_ns + round(elapsed_s * 1e9)
        while self._next and self._next.log_time_ns <= now_ns and self._allowance.left():
            self._headings[self._next.topic].publish(self._next.data)
            self._allowance.spend(1)
            self.published += 1
            if now_ns == math.inf:
                self._shown_ns = self._next.log_time_ns
            self._next = next(self._messages, None)
        if self._clock_publisher:
            self._clock_publisher.publish(clock_message(self._shown_ns))
        if self._next is None:
            all_acknowledged(self._headings.values())
            self._messages = None
            self.done = not self._own.loop

    def _note(self) -> None:
        self._health.note('bag', WARN if self._reader.incomplete else OK,
                          self._reader.incomplete or f'replaying {self._own.bag}',
                          published=self.published)

    def end(self) -> None:
        """Stop."""
        all_acknowledged(self._headings.values(), 2.0)
        self.ended = True


def main(args: Sequence[str] | None = None) -> int:
    """Run the node."""
    return run('replayer', Replayer, args)
