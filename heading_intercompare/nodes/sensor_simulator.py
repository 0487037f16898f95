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

"""The node `sensor_simulator`: headings of simulated sensors, and the true heading."""

from __future__ import annotations

from functools import partial
import math
import time
from typing import Any, Callable, Sequence

from sensor_msgs.msg import Imu
from std_srvs.srv import SetBool, Trigger

from heading_intercompare.ahrs.faults import FAULTS
from heading_intercompare.ahrs.gimballed.condition import describe_condition
from heading_intercompare.ahrs.gimballed.modes import AhrsStatus
from heading_intercompare.ahrs.plans import EVENTS
from heading_intercompare.ahrs.settings import Scenario
from heading_intercompare.ahrs.simulator import SimulatedChunk, Simulation, Trial
from heading_intercompare.bags.rosbag2.provenance import TRUTH_TOPIC
from heading_intercompare.core.sensor_table import simulated_topics
from heading_intercompare.messages.heading_messages import imu_messages
from heading_intercompare.messages.status_messages import LEVELS, OK
from heading_intercompare.nodes.interface.parameters import declare, resolve_topic
from heading_intercompare.nodes.launching.process import run
from heading_intercompare.nodes.presence.graph_node import GraphNode
from heading_intercompare.nodes.presence.health import Health
from heading_intercompare.nodes.sending.motion_sender import MotionSender
from heading_intercompare.nodes.sending.publishing import (
    Allowance,
    Audience,
    await_acknowledgement,
    FlowControl,
)
from heading_intercompare.nodes.spinning.clocks import every

from .interface import qos
from .interface.places import heading_places, judging_topics
from .settings import PUBLISHED, Sending, SimulatorNode

_TICK_S, _STEP_S = 0.05, 0.5  # the latter: simulated time of a step as fast as possible


class SensorSimulator(GraphNode):
    """Publish a trial, truth first, once all sensors have subscribers; its end ends the node."""

    done, ended, _began_s = False, False, 0.0

    def __init__(self, **kwargs: Any) -> None:
        super().__init__('sensor_simulator', **kwargs)
        settings, self._scenario, sending, self._own = declare(
            self, PUBLISHED, Scenario, Sending, SimulatorNode)
        self.health, named = Health(self), simulated_topics(
            settings.sensors, self._scenario.sensors, settings.ts_topic, settings.rs_topic)
        topics = {'truth': TRUTH_TOPIC, **Simulation(self._scenario).scenario.topics, **named}
        self._frames = {role: topic.strip('/').replace('/', '_') for role, topic in topics.items()
                        if resolve_topic(self, topic)}
        self._publishers_of = {role: self.create_publisher(
            Imu, topic, qos.HEADINGS_OUT, event_callbacks=self.health.of_publisher(topic))
            for role, topic in topics.items()}
        compared = heading_places(settings)  # Other topics may go unheard.
        self._audience = Audience(
            self, [self._publishers_of[role] for role in topics if topics[role] in compared],
            sending.subscribers, self.health, judged=judging_topics(settings))
        self._motion = MotionSender(self, self.health, settings.motion,
                                    is_first=self._scenario.motion_hz > 0.0)
        self._allowance = Allowance(sending.max_rate_hz)
        self._flow = FlowControl(self._publishers_of.values(), self.health)
        self._trial: Trial | None = None
        for role in self._scenario.sensors:
            place = '~' if role == 'ts' else f'~/{role}'
            for kind in EVENTS:
                self.create_service(Trigger, f'{place}/{kind}', partial(self._command, role, kind))
            for kind in FAULTS:
                self.create_service(SetBool, f'{place}/inject_{kind}',
                                    partial(self._inject, role, kind))
        self.health.add_refresher(self._tell)
        every(self, _TICK_S, self._tick)

    def _tell(self) -> None:
        self.health.note('simulation', OK, self._scenario.title or 'simulating',
                         simulated_s=self._trial.now_s if self._trial else 0.0,
                         duration_s=self._scenario.duration_s, figures={
                             f'{role}_faults': ' '.join(self._trial.faults(role)) or 'none'
                             for role in self._scenario.sensors if self._trial is not None})

    def _begin(self) -> Trial:
        start_ns = time.time_ns() if self._own.stamps == 'now' else None
        self._began_s = time.monotonic()
        return Simulation(self._scenario, start_ns).begin()

    def _tick(self) -> None:
        if self.done or self.ended or not self._audience.is_there():
            return
        trial = self._trial = self._trial or self._begin()
        speed, elapsed_s, step_s = self._own.speed, math.inf, _STEP_S
        if speed > 0.0:
            elapsed_s, step_s = (time.monotonic() - self._began_s) * speed, _TICK_S * speed
        # Other nodes of the process, such as the recorder, must have their turn.
        until_s = time.monotonic() + _TICK_S
        while not trial.over and trial.now_s + step_s <= elapsed_s and (
                time.monotonic() < until_s
                and self._allowance.has_left() and self._flow.has_room()):
            self._publish(trial.advance(trial.now_s + step_s))
        if not self._motion.look() and trial.over:
            self.done = self._audience.has_heard(
                [*self._publishers_of.values(), *self._motion.publishers])

    def _publish(self, chunk: SimulatedChunk) -> None:
        """Publish truth and motion, the readings of each sensor in order, and their state."""
        self._motion.take(chunk.motion)
        for message in imu_messages(chunk.truth, self._frames['truth']):
            self._publishers_of['truth'].publish(message)
        for role, (readings, statuses) in chunk.sent.items():
            messages = imu_messages(readings.headings, self._frames[role],
                                    sigma_deg=readings.sigma_deg,
                                    turn_rate_deg_s=readings.rate_deg_s)
            for message in messages:
                self._publishers_of[role].publish(message)
            self._allowance.spend(len(messages))
            self._flow.spend(len(messages))
            for status in statuses:
                self._report(role, status)

    def _report(self, role: str, status: AhrsStatus) -> None:
        """Report mode, progress and built-in tests of an AHRS; log its events."""
        condition = describe_condition(status)
        self.health.note(role, LEVELS[condition.level], condition.words, log=False,
                         figures=condition.figures)
        if status.message:
            self.get_logger().info(f'{role}: {status.message}, {status.t_s:.1f} s of the trial')

    def _command(self, role: str, kind: str, _: Trigger.Request, response: Any) -> Any:
        return self._answer(response, role.upper(), kind, lambda trial: trial.command(role, kind))

    def _inject(self, role: str, kind: str, request: SetBool.Request, response: Any) -> Any:
        act, what = (Trial.inject, 'begins') if request.data else (Trial.mend, 'ends')
        return self._answer(response, role.upper(), f'{kind} {what}',
                            lambda trial: act(trial, role, kind))

    def _answer(self, response: Any, who: str, what: str, act: Callable[[Trial], float]) -> Any:
        """Act on the trial; answer when that takes effect, or why it cannot."""
        if self._trial is None or self._trial.over:
            response.message = f'the trial {"is over" if self._trial else "has not begun"}'
            return response
        try:
            response.message = f'{who}: {what} at {act(self._trial):.2f} s of the trial'
        except ValueError as error:
            response.message = f'{who}: {error}'
        else:
            response.success = True
            self.get_logger().info(response.message)
        return response

    def end(self) -> None:
        """Stop publishing, and wait until the last messages have arrived."""
        await_acknowledgement([*self._publishers_of.values(), *self._motion.publishers])
        self.ended = True


def main(args: Sequence[str] | None = None) -> int:
    """Run the node."""
    return run('sensor_simulator', SensorSimulator, args)
