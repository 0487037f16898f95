# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The node `sensor_simulator`: headings of a simulated TS and RS."""

from __future__ import annotations

import math
import time
from typing import Any, Iterator, Sequence

from rclpy.node import Node
from sensor_msgs.msg import Imu

from heading_intercompare.ahrs.settings import Scenario
from heading_intercompare.ahrs.simulator import SimulatedChunk, Simulation
from heading_intercompare.core.settings import Settings

from . import qos
from .health import Health
from .messages import heading_messages
from .parameters import declare, OVERRIDES
from .process import run
from .sending import all_acknowledged, Allowance, Audience
from .settings import Sending, SimulatorNode
from .status_messages import OK
from .timing import every

__all__ = ['main', 'SensorSimulator']

_TICK_S = 0.05


class SensorSimulator(Node):
    """Publish a simulated trial, begun once both topics are heard; its end ends the node."""

    def __init__(self, **kwargs: Any) -> None:
        super().__init__('sensor_simulator', **OVERRIDES, **kwargs)
        settings, self._scenario, sending, self._own = declare(
            self, Settings, Scenario, Sending, SimulatorNode)
        self.done = self.ended = False
        self._health = Health(self)
        topics = {'ts': settings.ts_topic, 'rs': settings.rs_topic}
        self._frames = {role: topic.strip('/').replace('/', '_') for role, topic in topics.items()}
        self._publishers_of = {
            role: self.create_publisher(Imu, topic, qos.HEADINGS_OUT,
                                        event_callbacks=self._health.of_publisher(topic))
            for role, topic in topics.items()}
        self._audience = Audience(self, [*self._publishers_of.values()], sending.subscribers,
                                  self._health)
        self._allowance = Allowance(sending.max_rate_hz)
        self._chunks: Iterator[SimulatedChunk] | None = None
        self._next: SimulatedChunk | None = None
        self._began_s = self.simulated_s = 0.0
        self._health.before_beat(lambda: self._health.note(
            'simulation', OK, self._scenario.title or 'simulating', simulated_s=self.simulated_s,
            duration_s=self._scenario.duration_s))
        every(self, _TICK_S, self._tick)

    def _begin(self) -> None:
        start_ns = time.time_ns() if self._own.stamps == 'now' else None
        chunk_s = _TICK_S * self._own.speed if self._own.speed > 0.0 else 0.5
        self._chunks = Simulation(self._scenario, start_ns).chunks(chunk_s)
        self._next = next(self._chunks)
        self._began_s = time.monotonic()

    def _tick(self) -> None:
        if self.done or self.ended or not self._audience.there():
            return
        if self._chunks is None:
            self._begin()
        elapsed_s = math.inf
        if self._own.speed > 0.0:
            elapsed_s = (time.monotonic() - self._began_s) * self._own.speed
        while self._next and self._next.end_s <= elapsed_s and self._allowance.left():
            self._publish(self._next)
            self.simulated_s = self._next.end_s
            self._next = next(self._chunks, None)
        if self._next is None:
            all_acknowledged(self._publishers_of.values())
            self.done = True

    def _publish(self, chunk: SimulatedChunk) -> None:
        """Publish the readings of both sensors, each stream in its order."""
        for role, readings in (('ts', chunk.ts_readings), ('rs', chunk.rs_readings)):
            messages = heading_messages(readings.headings, self._frames[role],
                                        readings.sigma_deg, readings.rate_deg_s)
            for message in messages:
                self._publishers_of[role].publish(message)
            self._allowance.spend(len(messages))

    def end(self) -> None:
        """Stop."""
        self.ended = True


def main(args: Sequence[str] | None = None) -> int:
    """Run the node."""
    return run('sensor_simulator', SensorSimulator, args)
