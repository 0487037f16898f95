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

"""The node `nmea_driver`: sentences of a sensor to headings."""

from __future__ import annotations

import math
import time
from typing import Any, Sequence

from sensor_msgs.msg import Imu

from heading_intercompare.core.records import Headings
from heading_intercompare.drivers.nmea import NmeaDecoder
from heading_intercompare.drivers.settings import DriverSettings
from heading_intercompare.messages.heading_messages import imu_messages
from heading_intercompare.messages.status_messages import OK, WARN
from heading_intercompare.nodes.alarms.sentence_alarms import SentenceAlarms
from heading_intercompare.nodes.ros import qos
from heading_intercompare.nodes.ros.parameters import declare, OVERRIDES, resolve_topic
from heading_intercompare.nodes.ros.process import run
from heading_intercompare.nodes.ros.steady_timer import every
from heading_intercompare.nodes.runtime.driver_motion import DriverMotion
from heading_intercompare.nodes.runtime.health import Health
from heading_intercompare.nodes.runtime.loss_publisher import LossPublisher
from heading_intercompare.nodes.runtime.publishing import (
    Allowance,
    Audience,
    FlowControl,
    HeadingQueue,
)
from heading_intercompare.nodes.runtime.source_thread import Reading, ReadingNode
from heading_intercompare.nodes.sensors import places

from .settings import DriverNode, PUBLISHED, Sending, Taking

__all__ = ['main', 'NmeaDriver']


class NmeaDriver(ReadingNode):
    """Publish the headings of a source; a file waits for subscribers, and ends the node."""

    def __init__(self, **kwargs: Any) -> None:
        super().__init__('nmea_driver', **OVERRIDES, **kwargs)
        analysis, settings, sending, taking, node_settings = declare(
            self, PUBLISHED, DriverSettings, Sending, Taking, DriverNode, followed=('stale_s',))
        self._allow_silence(taking)
        self.done = self.ended = self._flushed = self._ending = False
        self._frame_id = node_settings.frame_id or settings.topic.strip('/').replace('/', '_')
        self._lost = LossPublisher(self, resolve_topic(self, settings.topic))
        self._decoder, self.health = NmeaDecoder(settings), Health(self)
        wake = self.create_guard_condition(self._pass_on)
        self._reading = Reading(settings, sending.max_rate_hz, wake.trigger)
        self._motion = DriverMotion(self, self.health, analysis, settings, node_settings)
        self.alarms = SentenceAlarms(self, self.health, settings.talker)
        self._publisher = self.create_publisher(
            Imu, settings.topic, qos.HEADINGS_OUT,
            event_callbacks=self.health.of_publisher(settings.topic))
        if self._reading.from_file and node_settings.origin_ns is not None:
            self.play_from(node_settings.origin_ns)
        self._audience = Audience(
            self, [self._publisher], sending.subscribers, self.health,
            judged=places.judging_topics(analysis),
            patience_s=math.inf if self._reading.from_file else sending.start_wait_s)
        # Headings held until the sentence was chosen would overrun subscribers all at once.
        self._waiting, self._allowance = HeadingQueue(), Allowance(sending.max_rate_hz)
        # A live source waits for nobody once it has begun.
        self._flow = FlowControl([self._publisher] * self._reading.from_file, self.health)
        self._later = every(self, 0.01, self._pass_on)
        self._published = self._beyond = self._published_before = 0
        self._newest_s = self._beat_s = time.monotonic()
        self.health.add_refresher(self._note)
        every(self, 0.05, self._begin)
        self._begin()

    def _pass_on(self) -> None:
        """Publish the headings in the bytes received."""
        if self.ended:
            return
        for received in self._reading.take():
            self._take(self._decoder.feed(*received))
            self._motion.feed(received)
        if self._reading.over and not self._flushed:
            self._flushed = True
            self._take(self._decoder.flush())
            self._motion.flush()
        clear = self._ending or self._audience.is_there() and self._audience.sole.clear
        while self._waiting and clear and self._allowance.has_left() and self._flow.has_room():
            self._publish(self._waiting.popleft())
        if self._motion.publish() or self._waiting:
            self._later.reset()
            return
        self._later.cancel()
        if (self._flushed and not self.done) or self._ending:
            self._leave([self._publisher, *self._motion.publishers])

    def _take(self, headings: Headings) -> None:
        headings = self._waiting.add(headings)
        dropped = self._reading.source.counts.get('kernel_dropped', 0)
        self._lost.count({'lost.at_source': dropped + self._waiting.overrun,
                          'rejected.burst': self._decoder.count('burst')}, headings)

    def _publish(self, headings: Headings) -> None:
        messages = imu_messages(headings, self._frame_id)
        for message in messages:
            self._publisher.publish(message)
        self._allowance.spend(len(messages))
        self._flow.spend(len(messages))
        self._published += len(messages)
        self._beyond += len(headings) - len(messages)
        if messages:
            self._newest_s = time.monotonic()

    def _note(self) -> None:
        if self._reading.started and not self.done:
            # On a silent line this makes the time of listening pass.
            self._take(self._decoder.feed(b'', time.time_ns()))
            self._pass_on()
        now_s = time.monotonic()
        age_s = now_s - self._newest_s
        allowed_s = self._allowed_s[self._published > 0]
        silent = self._reading.started and not self._flushed and age_s > allowed_s
        rate_hz = (self._published - self._published_before) / max(now_s - self._beat_s, 1e-3)
        counts = {**self._reading.source.counts, **self._decoder.counts}
        self._beat_s, self._published_before = now_s, self._published
        words = f'no heading for more than {allowed_s:g} s; ' if silent else ''
        self.health.note('source', WARN if silent else OK, words + self._reading.source.status,
                          sentence=self._decoder.chosen, published=self._published,
                          rate_hz=rate_hz, age_s=age_s, stamp_beyond_2038=self._beyond or None,
                          overrun=self._waiting.overrun or None, **counts)
        self.alarms.look(counts, self._published)

    def end(self) -> None:
        """Stop reading; `ended` becomes True once everything received is published."""
        self._reading.stop()
        self._ending = True
        self._pass_on()
        self._lost.end()


def main(args: Sequence[str] | None = None) -> int:
    """Run the node."""
    return run('nmea_driver', NmeaDriver, args)
