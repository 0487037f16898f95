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

"""The motion of the ship in what a driver reads, published unless another node does."""

from __future__ import annotations

import time

from rclpy.node import Node
from rclpy.publisher import Publisher

from heading_intercompare.core.sensor_table import read_sensors
from heading_intercompare.core.settings import Settings
from heading_intercompare.drivers.framing import Received
from heading_intercompare.drivers.motion.motion_decoder import MotionDecoder
from heading_intercompare.drivers.motion.motion_sentences import MOTION_WORDS
from heading_intercompare.drivers.settings import DriverError, DriverSettings
from heading_intercompare.messages.status_messages import OK
from heading_intercompare.nodes.presence.health import Health
from heading_intercompare.nodes.sending.motion_sender import MotionSender
from heading_intercompare.nodes.settings import DriverNode

# A driver waits this long for each one that comes before it: drivers choose after `learn_s`.
_TURN_S = 3.0


class DriverMotion:
    """
    Publishes the motion in the lines of a driver.

    Parameters
    ----------
    node, health
        As for `MotionSender`.
    analysis
        Names the topics. Without `motion.compare` nothing is published.
    driver
        How lines are read.
    own
        Without `motion` nothing is published.
    alone
        The source has nothing else to tell, so it waits for no other driver.

    Notes
    -----
    Of several drivers that of the RS comes first, or that of the last sensor of the table, as
    with logs. Each one before it makes a driver wait for three seconds.

    """

    def __init__(self, node: Node, health: Health, analysis: Settings, driver: DriverSettings,
                 own: DriverNode, *, alone: bool = False) -> None:
        self._wanted = own.motion and analysis.motion.compare
        topics = [sensor.heading_topic for sensor in read_sensors(analysis.sensors)] or [
            analysis.ts_topic, analysis.rs_topic]
        before = 0 if alone or driver.topic not in topics else [*reversed(topics)].index(
            driver.topic)
        self._health, self._path = health, driver.address.path
        self._sender = MotionSender(node, health, analysis.motion, after_s=before * _TURN_S)
        if self._wanted:
            self._decoder = MotionDecoder(driver)
            health.add_refresher(self._note)

    @property
    def publishers(self) -> list[Publisher]:
        """Return the publishers made so far."""
        return self._sender.publishers

    @property
    def n_published(self) -> int:
        """Return the number of messages published."""
        return sum(self._sender.published.values())

    def open(self) -> None:
        """
        Make the publishers of what a log tells, before it is played.

        Raises
        ------
        DriverError
            If it tells nothing.

        """
        if self._wanted and not self._decoder.chosen:
            raise DriverError(f'{self._path}: has no motion of the ship: no VTG, RMC, GNS, GGA, '
                              'GLL or ROT with a stamp')
        for what in self._decoder.chosen if self._wanted else ():
            self._sender.open(what)

    def feed(self, received: Received) -> None:
        """Take bytes."""
        if self._wanted:
            self._sender.take(self._decoder.feed(*received))

    def flush(self) -> None:
        """Take the last rows at the end of the source."""
        if self._wanted:
            self._sender.take(self._decoder.flush())
            self._sender.look(ending=True)

    def publish(self) -> bool:
        """Publish what may be published now; tell whether messages wait for subscribers."""
        return self._sender.look()

    def _note(self) -> None:
        # On a silent line this makes the time of listening pass.
        self._sender.take(self._decoder.feed(b'', time.time_ns()))
        chosen = ', '.join(f'{MOTION_WORDS[what]} of {name}'
                           for what, name in self._decoder.chosen.items())
        self._health.note('motion', OK, chosen or 'no motion of the ship heard', log=False,
                          figures={**self._sender.describe(), **self._decoder.counts})
