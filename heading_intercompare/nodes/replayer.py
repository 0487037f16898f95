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

"""The node `replayer`: headings, motion and marks of a bag, at any pace."""

from __future__ import annotations

from functools import partial
import time
from typing import Any, Callable, Collection, Sequence

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.publisher import Publisher
from rosgraph_msgs.msg import Clock
from std_srvs.srv import Trigger

from heading_intercompare.bags.rosbag2.bag_reader import BagReader
from heading_intercompare.bags.rosbag2.paced_replay import Replay
from heading_intercompare.core.declared_settings import SettingsError
from heading_intercompare.messages.heading_places import HeadingPlace
from heading_intercompare.messages.sentence_messages import TOPIC_TYPES
from heading_intercompare.messages.stamps import encode_clock
from heading_intercompare.messages.status_messages import MARKER_TOPIC, OK, WARN
from heading_intercompare.nodes.interface.message_types import (
    begins_with_header,
    find_heading_type,
    list_heading_types,
)
from heading_intercompare.nodes.interface.parameters import declare
from heading_intercompare.nodes.launching.process import run
from heading_intercompare.nodes.presence.endpoints import published_names
from heading_intercompare.nodes.presence.graph_node import GraphNode
from heading_intercompare.nodes.presence.health import Health
from heading_intercompare.nodes.sending.publishing import (
    Allowance,
    Audience,
    await_acknowledgement,
    FlowControl,
)
from heading_intercompare.nodes.spinning.clocks import every

from .interface import qos
from .interface.places import heading_places, judging_topics
from .sending import replayed_beside as beside
from .settings import REPLAYED, ReplayerNode, Sending

_TICK_S = 0.02
_BESIDE_WAIT_S = 5.0  # For those who judge; then the replay starts without them.
_PAUSED_BY = {'pause': True, 'resume': False, 'toggle_paused': None}


class Replayer(GraphNode):
    """Publish the marks of a bag, then its headings as recorded; done at the end of the bag."""

    def __init__(self, *, remapped: Collection[str] = (),
                 clock_ns: Callable[[], int] = time.monotonic_ns, **kwargs: Any) -> None:
        super().__init__('replayer', **kwargs)
        settings, sending, node_settings = declare(self, REPLAYED, Sending, ReplayerNode)
        if node_settings.bag is None:
            raise SettingsError('bag is required: an .mcap file or a rosbag2 folder')
        self.done = self.ended = self._begun = False
        self.health, self._reader = Health(self), BagReader(node_settings.bag,
                                                            settings.bag_namespace)
        self._motion = beside.ReplayedMotion(self._reader, settings.motion)
        sources = heading_places(settings)
        topics = [*sources, MARKER_TOPIC, *self._motion.topics]
        names = published_names(self, topics + ['/clock'] * node_settings.clock, remapped)
        self._headings = {}
        for topic, name in zip(sources, names):
            in_bag = self._reader.resolve(topic)
            self._headings[in_bag] = self.create_publisher(
                self._find_type(in_bag, sources[topic]), topic, qos.HEADINGS_OUT,
                event_callbacks=self.health.of_publisher(name))
        self._lost = beside.ReplayedLosses(self, self._reader, dict(zip(self._headings, names)),
                                           whole=not node_settings.start_s)
        self._quality = beside.ReplayedQuality(
            self, self.health, self._reader, dict(zip(self._headings, names)))
        self._replay = Replay(
            self._reader, [*self._lost.topics, *self._motion.in_bag, *self._quality.publishers],
            rate=node_settings.rate,
            start_s=node_settings.start_s, duration_s=node_settings.duration_s,
            loop=node_settings.loop, paused=node_settings.start_paused, clock_ns=clock_ns)
        self._motion.open(self, self.health)
        self._marker = self.create_publisher(DiagnosticArray, MARKER_TOPIC, qos.MARKER)
        self._time = (self.create_publisher(Clock, '/clock', qos.CLOCK)
                      if node_settings.clock else None)
        self._audience = Audience(self, [*self._headings.values()], sending.subscribers,
                                  self.health, judged=judging_topics(settings))
        self._allowance = Allowance(sending.max_rate_hz)
        self._flow = FlowControl(self._headings.values(), self.health)
        # Before any heading: marks act by stamp, and a late mark would not.
        self.published, self._marks = 0, beside.publish_marks(self._reader, self._marker)
        self._heard_s: float | None = None
        for name, paused in _PAUSED_BY.items():
            self.create_service(Trigger, f'~/{name}', partial(self._serve, paused))
        if self._replay.over:
            self.get_logger().warning(f'nothing to replay: {self._replay.part} has no heading')
        self.health.add_refresher(self._note)
        every(self, _TICK_S, self._tick)

    def _find_type(self, in_bag: str, place: HeadingPlace) -> type:
        """Return the type of a topic of the bag; an error if its headings cannot be replayed."""
        if not place.part:
            self._reader.check_heading(in_bag, TOPIC_TYPES)
        message_type = find_heading_type(self._reader.topics[in_bag].type_name,
                                         list_heading_types(place))
        if place.clock or not (place.names_frames or begins_with_header(message_type)):
            raise SettingsError(
                f'topic {in_bag}: its readings have the times at which the messages were '
                'published, and a replay publishes them at others; analyze takes those of the '
                'bag, and import makes a bag with stamps, which can be replayed')
        return message_type

    @property
    def state(self) -> str:
        """Return what the node does, and its place in the bag, in words."""
        words = f'{"paused" if self._replay.paused else "replaying"} at {self._replay.place}'
        waiting = self._audience.waiting or 'waiting for synchronizer and compliance'
        return words if self._begun else f'{waiting}; then {words}'

    def pause(self, wanted: bool | None = None) -> str:
        """Pause (True), resume (False) or toggle (None); return what was done, in words."""
        words = self._replay.pause(wanted)
        self._note()
        self.health.publish()
        return words

    def _serve(self, wanted: bool | None, _: Trigger.Request, response: Any) -> Any:
        response.success = not self._replay.over
        response.message = self.pause(wanted) if response.success else 'the replay is over'
        self.get_logger().info(response.message)
        return response

    def _is_ready(self) -> bool:
        """Tell whether the headings have subscribers, and marks and quality too."""
        if not self._audience.is_there():
            return False
        self._heard_s = self._heard_s or time.monotonic()
        beside = [*[self._marker] * (self._marks > 0), *self._quality.publishers.values()]
        return (all(publisher.get_subscription_count() for publisher in beside)
                or time.monotonic() > self._heard_s + _BESIDE_WAIT_S)

    def _tick(self) -> None:
        if self.done or self.ended:
            return
        if not self._begun and self._is_ready():
            await_acknowledgement([self._marker])
            self._begun = True
            self._replay.begin()
        until_s = time.monotonic() + _TICK_S
        while (self._begun and time.monotonic() < until_s and self._allowance.has_left()
               and self._flow.has_room() and (message := self._replay.take()) is not None):
            if not (self._motion.take(message) or self._quality.take(message)
                    or self._lost.take(message, self._replay.round)):
                self._headings[message.topic].publish(message.data)
                for budget in (self._allowance, self._flow):
                    budget.spend(1)
                self.published += 1
        self._lost.publish()
        if self._time:
            self._time.publish(encode_clock(self._replay.shown_ns))
        if self._replay.over:
            self.done = self._audience.has_heard(self._all_publishers())

    def _note(self) -> None:
        words = '; '.join(filter(None, [self.state, self._reader.incomplete]))
        self.health.note('bag', WARN if self._reader.incomplete else OK, words,
                          path=self._reader.path, published=self.published,
                          paused=self._replay.paused, position_s=self._replay.place_s)

    def _all_publishers(self) -> list[Publisher]:
        return [*self._headings.values(), *self._motion.publishers.values(),
                *self._quality.publishers.values()]

    def end(self) -> None:
        """Stop publishing, and wait until the last messages have arrived."""
        await_acknowledgement(self._all_publishers())
        self.ended = True


def main(args: Sequence[str] | None = None) -> int:
    """Run the node."""
    return run('replayer', Replayer, args)
