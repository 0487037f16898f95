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

"""The node `motion_driver`: the motion of the ship from a source of its own."""

from __future__ import annotations

import time
from typing import Any, Sequence

from heading_intercompare.drivers.settings import DriverSettings
from heading_intercompare.messages.status_messages import OK, WARN
from heading_intercompare.nodes.ros.parameters import declare, OVERRIDES
from heading_intercompare.nodes.ros.process import run
from heading_intercompare.nodes.ros.steady_timer import every
from heading_intercompare.nodes.runtime.driver_motion import DriverMotion
from heading_intercompare.nodes.runtime.health import Health
from heading_intercompare.nodes.runtime.publishing import Audience
from heading_intercompare.nodes.runtime.source_thread import Reading, ReadingNode

from .settings import DriverNode, PUBLISHED, Sending, Taking

__all__ = ['main', 'MotionDriver']


class MotionDriver(ReadingNode):
    """Publish the motion in the sentences of a source, whatever headings they tell."""

    def __init__(self, **kwargs: Any) -> None:
        super().__init__('motion_driver', **OVERRIDES, **kwargs)
        analysis, settings, sending, taking, node_settings = declare(
            self, PUBLISHED, DriverSettings, Sending, Taking, DriverNode, followed=('stale_s',))
        self._allow_silence(taking)
        self.done = self.ended = False
        self.health = Health(self)
        wake = self.create_guard_condition(self._pass_on)
        self._reading = Reading(settings, sending.max_rate_hz, wake.trigger)
        self._motion = DriverMotion(self, self.health, analysis, settings, node_settings,
                                    alone=True)
        if self._reading.from_file:
            self._motion.open()
            if node_settings.origin_ns is not None:
                self.play_from(node_settings.origin_ns)
        subscribers = sending.subscribers if self._motion.publishers else 0
        self._audience = Audience(self, self._motion.publishers, subscribers, self.health)
        self._flushed = self._ending = False
        self._newest_s, self._n_before = time.monotonic(), 0
        self._later = every(self, 0.01, self._pass_on)
        self.health.add_refresher(self._note)
        every(self, 0.05, self._begin)
        self._begin()

    def _pass_on(self) -> None:
        """Publish the motion in the bytes received."""
        if self.ended:
            return
        for received in self._reading.take():
            self._motion.feed(received)
        if self._reading.over and not self._flushed:
            self._flushed = True
            self._motion.flush()
        if self._motion.publish():
            self._later.reset()
            return
        self._later.cancel()
        if (self._flushed and not self.done) or self._ending:
            self._leave(self._motion.publishers)

    def _note(self) -> None:
        if self._reading.started and not self.done:
            self._pass_on()
        now_s, n = time.monotonic(), self._motion.n_published
        if n != self._n_before:
            self._newest_s, self._n_before = now_s, n
        age_s = now_s - self._newest_s
        allowed_s = self._allowed_s[n > 0]
        silent = self._reading.started and not self._flushed and age_s > allowed_s
        words = f'no motion for more than {allowed_s:g} s; ' if silent else ''
        self.health.note('source', WARN if silent else OK, words + self._reading.source.status,
                         published=n, age_s=age_s, **self._reading.source.counts)

    def end(self) -> None:
        """Stop reading; `ended` becomes True once everything received is published."""
        self._reading.stop()
        self._ending = True
        self._pass_on()


def main(args: Sequence[str] | None = None) -> int:
    """Run the node."""
    return run('motion_driver', MotionDriver, args)
