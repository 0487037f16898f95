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

from rclpy.publisher import Publisher
from sensor_msgs.msg import Imu

from heading_intercompare.core.records import Headings
from heading_intercompare.drivers.framing import Received
from heading_intercompare.drivers.log_lines.rollovers import describe_far
from heading_intercompare.drivers.nmea import NmeaDecoder
from heading_intercompare.messages.heading_messages import imu_messages
from heading_intercompare.messages.status_messages import WARN
from heading_intercompare.nodes.alarms.sentence_alarms import SentenceAlarms
from heading_intercompare.nodes.interface.parameters import resolve_topic
from heading_intercompare.nodes.launching.process import run
from heading_intercompare.nodes.sending.loss_publisher import LossPublisher
from heading_intercompare.nodes.sending.publishing import (
    Allowance,
    Audience,
    FlowControl,
    HeadingQueue,
)
from heading_intercompare.nodes.sending.quality_publisher import QualityPublisher
from heading_intercompare.nodes.sending.source_thread import ReadingNode

from .interface import qos
from .interface.places import judging_topics


class NmeaDriver(ReadingNode):
    """Publish the headings of a source; a file waits for subscribers, and ends the node."""

    def __init__(self, **kwargs: Any) -> None:
        super().__init__('nmea_driver', 'heading', **kwargs)
        settings = self._settings
        self._frame_id = self._own.frame_id or settings.topic.strip('/').replace('/', '_')
        full_name = resolve_topic(self, settings.topic)
        self._lost = LossPublisher(self, full_name)
        self._quality = QualityPublisher(self, self.health, full_name)
        self._decoder = NmeaDecoder(settings)
        self._open()
        from_file = self._reading.from_file
        self.alarms = SentenceAlarms(self, self.health, settings)
        self._publisher = self.create_publisher(
            Imu, settings.topic, qos.HEADINGS_OUT,
            event_callbacks=self.health.of_publisher(settings.topic))
        self._audience = Audience(
            self, [self._publisher], self._sending.subscribers, self.health,
            judged=judging_topics(self._analysis),
            patience_s=math.inf if from_file else self._sending.start_wait_s)
        # Headings held until the sentence was chosen would overrun subscribers all at once.
        self._waiting, self._allowance = HeadingQueue(), Allowance(self._sending.max_rate_hz)
        # A live source waits for nobody once it has begun.
        self._flow = FlowControl([self._publisher] * from_file, self.health)
        self._published = self._beyond = self._published_before = 0
        self._newest_ns = 0
        self._beat_s = time.monotonic()
        self._watch()

    @property
    def n_published(self) -> int:
        """Return the number of headings published."""
        return self._published

    def _take(self, received: Received) -> None:
        self._queue(self._decoder.feed(*received))
        super()._take(received)

    def _take_last(self) -> None:
        self._queue(self._decoder.flush())
        super()._take_last()

    def _queue(self, headings: Headings) -> None:
        self._quality.take(self._decoder.drain_quality(end=True))
        if len(headings):
            self._newest_ns = int(headings.stamp_ns[-1])
        headings = self._waiting.add(headings)
        # A datagram that the kernel dropped is missing in the numbers of the lines, too.
        missing = max(self._reading.source.counts.get('kernel_dropped', 0),
                      self._decoder.numbers.n_missing)
        self._lost.count({'lost.at_source': missing + self._waiting.overrun,
                          **{f'rejected.{reason}': self._decoder.count(reason)
                             for reason in ('burst', 'repeated', 'old_number')}}, headings)

    def _publish_waiting(self) -> bool:
        clear = self._ending or self._audience.is_there() and self._audience.sole.clear
        if clear:
            self._quality.publish()
        while self._waiting and clear and self._allowance.has_left() and self._flow.has_room():
            self._publish(self._waiting.popleft())
        return super()._publish_waiting() or len(self._waiting) > 0

    def _publish(self, headings: Headings) -> None:
        messages = imu_messages(headings, self._frame_id,
                                sigma_deg=self._quality.claims_deg(headings.stamp_ns))
        for message in messages:
            self._publisher.publish(message)
        self._allowance.spend(len(messages))
        self._flow.spend(len(messages))
        self._published += len(messages)
        self._beyond += len(headings) - len(messages)

    def _list_publishers(self) -> list[Publisher]:
        return [self._publisher, self._quality.publisher, *super()._list_publishers()]

    @property
    def _counts(self) -> dict[str, int]:
        return {**self._reading.source.counts, **self._decoder.counts}

    def _note(self) -> None:
        if self._reading.started and not self.done:
            # On a silent line this makes the time of listening pass.
            self._queue(self._decoder.feed(b'', time.time_ns()))
        super()._note()
        words = (describe_far(self._newest_ns, self._newest_ns, time.time_ns())
                 or self._decoder.undone)
        if words:
            self.health.note('stamps', WARN, words)
        self.alarms.look(self._counts, self._published, self._decoder)

    def _describe(self, n_published: int, age_s: float) -> dict[str, object]:
        now_s = time.monotonic()
        rate_hz = (n_published - self._published_before) / max(now_s - self._beat_s, 1e-3)
        self._beat_s, self._published_before = now_s, n_published
        return {'sentence': self._decoder.chosen, 'published': n_published, 'rate_hz': rate_hz,
                'age_s': age_s, 'stamp_beyond_2038': self._beyond or None,
                'overrun': self._waiting.overrun or None,
                'missing_lines': self._decoder.numbers.n_missing or None, **self._counts}

    def end(self) -> None:
        """Stop reading; `ended` becomes True once everything received is published."""
        super().end()
        self._lost.end()


def main(args: Sequence[str] | None = None) -> int:
    """Run the node."""
    return run('nmea_driver', NmeaDriver, args)
