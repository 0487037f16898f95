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

"""A simulated trial of a ship, a TS and an RS, delivered chunk by chunk."""

from __future__ import annotations

from dataclasses import dataclass, replace
import math
from typing import Iterator, Mapping

import numpy as np

from heading_intercompare.ahrs.gimballed.modes import AhrsStatus
from heading_intercompare.ahrs.inertial.compiled_loop import compile_steering
from heading_intercompare.ahrs.ship.ship_motion import ShipTruth
from heading_intercompare.ahrs.ship.steering import Steering
from heading_intercompare.ahrs.ship.track_course import Track
from heading_intercompare.core.declared_settings import SettingsError
from heading_intercompare.core.records import Headings, Motion, Reals

from .faults import Fault, FAULTS, Faults
from .plans import EVENTS, parse_faults, parse_legs, parse_utc
from .random_noise import open_stream
from .sensors import Readings, SimulatedSensor
from .settings import AHRS_MODELS, Scenario, Sensor

POSITION_SIGMA_M = 1.0
"""Standard deviation of a position to the north and to the east, metres; white."""

VELOCITY_SIGMA_M_S = 0.05
"""Standard deviation of a velocity to the north and to the east, m/s; white."""

RATE_SIGMA_DEG_S = 0.05
"""Standard deviation of a rate of turn, degrees per second; white."""

_DRAWN_AT_ONCE = 64
_METRES_A_DEGREE = 111_200.0


class ToldMotion:
    """
    The motion of a ship as its receivers tell it, at a fixed rate and without latency.

    Parameters
    ----------
    start_ns
        UTC stamp of the start, nanoseconds.
    seed
        Seed of the simulation.
    rate_hz
        Rows a second of each kind; 0: none.
    duration_s
        Length of the trial, seconds.

    Notes
    -----
    Position and velocity are those over ground, with the current; the sea moves neither. The rate
    of turn is that of the ship in the sea.

    """

    def __init__(self, ship: ShipTruth, start_ns: int, seed: int, rate_hz: float,
                 duration_s: float) -> None:
        self._ship, self._start_ns, self._rate_hz = ship, start_ns, rate_hz
        self._rng = open_stream(seed, 'motion')
        self._n = math.ceil(duration_s * rate_hz)
        self._next = 0
        self._noise = np.empty((5, 0))

    def take(self, end_s: float) -> Motion:
        """Return the rows since the last call and before `end_s`."""
        stop = max(self._next, min(self._n, math.ceil(end_s * self._rate_hz)))
        if stop == self._next:
            return Motion.empty()
        t_s = np.arange(self._next, stop) / self._rate_hz
        noise = self._draw(stop - self._next)
        self._next = stop
        stamps = self._start_ns + np.rint(t_s * 1e9).astype(np.int64)
        latitude, longitude = self._ship.position_deg(t_s)
        east, north = self._ship.velocity_m_s(t_s)
        metres = POSITION_SIGMA_M * noise[:2] / _METRES_A_DEGREE
        return Motion.concatenate([
            Motion.of_positions(stamps, latitude + metres[0],
                                longitude + metres[1] / np.cos(np.radians(latitude))),
            Motion.of_velocities(stamps, east + VELOCITY_SIGMA_M_S * noise[2],
                                 north + VELOCITY_SIGMA_M_S * noise[3]),
            Motion.of_rates(stamps, np.degrees(self._ship.heading_rate_rad_s(t_s))
                            + RATE_SIGMA_DEG_S * noise[4])])

    def _draw(self, n: int) -> Reals:
        """Return the next numbers, shape (5, n); drawn in blocks, whatever the chunks."""
        while self._noise.shape[1] < n:
            more = self._rng.standard_normal((5, _DRAWN_AT_ONCE))
            self._noise = np.concatenate((self._noise, more), axis=1)
        drawn, self._noise = self._noise[:, :n], self._noise[:, n:]
        return drawn


BLOCK_S = 10.0
WORTH_COMPILING_S = 3600.0


@dataclass(frozen=True, slots=True)
class SimulatedChunk:
    """
    The data delivered in one span of simulated time.

    Attributes
    ----------
    end_s
        End of the span, seconds since the start; a live sender delivers the chunk then.
    ts, rs
        Readings of the sensors, as delivered.
    truth
        True heading at the instants of the TS readings, with stamps of a perfect clock.
    ts_readings, rs_readings
        The same readings with claimed standard deviation and rate of turn.
    ts_statuses, rs_statuses
        Statuses of a gimballed AHRS; empty for other models.
    others
        Readings and statuses of the further sensors, by name.
    motion
        What the ship tells of its motion.

    """

    end_s: float
    truth: Headings
    ts_readings: Readings
    rs_readings: Readings
    ts_statuses: tuple[AhrsStatus, ...]
    rs_statuses: tuple[AhrsStatus, ...]
    others: Mapping[str, tuple[Readings, tuple[AhrsStatus, ...]]]
    motion: Motion

    @property
    def sent(self) -> dict[str, tuple[Readings, tuple[AhrsStatus, ...]]]:
        """Return the readings and statuses of all sensors: 'ts', 'rs', and the others by name."""
        return {'ts': (self.ts_readings, self.ts_statuses),
                'rs': (self.rs_readings, self.rs_statuses), **self.others}

    @property
    def ts(self) -> Headings:
        """Return the readings of the TS."""
        return self.ts_readings.headings

    @property
    def rs(self) -> Headings:
        """Return the readings of the RS."""
        return self.rs_readings.headings


class Simulation:
    """
    A trial, reproducible to the bit from its scenario.

    Parameters
    ----------
    scenario
        What to simulate.
    start_ns
        UTC stamp of the start, nanoseconds; default that of the track, or of the scenario. A live
        sender passes the time of its clock.
    track
        The recorded voyage that the scenario names. The trial ends with it.

    Raises
    ------
    SettingsError
        If the scenario names a voyage that is not given.

    """

    def __init__(self, scenario: Scenario, start_ns: int | None = None,
                 track: Track | None = None) -> None:
        if scenario.track.file and track is None:
            raise SettingsError(f'track.file = {scenario.track.file!r}: only the command simulate '
                                'reads a recorded voyage; simulate it into a bag and replay that')
        if track is not None:
            scenario = replace(scenario, duration_s=min(scenario.duration_s, track.duration_s))
        self.scenario, self._track = scenario, track
        if start_ns is None:
            start_ns = parse_utc(scenario.start_utc) if track is None else track.start_ns
        self.start_ns = start_ns

    def truth(self) -> ShipTruth:
        """Create the ship of this trial."""
        s = self.scenario
        return ShipTruth(parse_legs(s.legs), s.latitude_deg, s.longitude_deg, s.seaway, s.seed,
                         current=s.current.current(), waves=s.sea.waves(), hull=s.sea.hull(),
                         track=self._track, turn_deg_s=s.turn_deg_s)

    def chunks(self, chunk_s: float = 60.0, fast: bool = True) -> Iterator[SimulatedChunk]:
        """
        Yield the trial from its start, in spans of simulated time.

        Parameters
        ----------
        chunk_s
            Length of a span, seconds, greater than 0. The readings do not depend on it.
        fast
            Compile the loop of an AHRS first, if numba is installed and the trial lasts longer
            than `WORTH_COMPILING_S`. The readings do not depend on that either.

        Yields
        ------
        SimulatedChunk
            A reading belongs to the span in which it is delivered (instant + latency). Readings
            are in the order of their instants, which is stamp order unless a fault steps the
            clock back. Spans without readings are yielded too. Each call restarts the trial.

        """
        if not chunk_s > 0.0:
            raise ValueError(f'chunk_s = {chunk_s!r}: must be greater than 0')
        trial, number = self.begin(fast and self.scenario.duration_s > WORTH_COMPILING_S), 0
        while not trial.over:
            number += 1
            yield trial.advance(number * chunk_s)

    def begin(self, fast: bool = False) -> 'Trial':
        """Begin the trial, which takes commands as it advances; see `Trial`."""
        return Trial(self.scenario, self.truth(), self.start_ns, fast)


class Trial:
    """
    A trial in progress, reproducible from its scenario and the times of the commands.

    Parameters
    ----------
    scenario
        What to simulate.
    ship
        The ship.
    start_ns
        UTC stamp of the start, nanoseconds.
    fast
        Compile the loop of an AHRS if numba is installed. That takes seconds, in which a live
        trial would send nothing.

    Attributes
    ----------
    now_s : float
        Simulated time delivered so far, seconds since the start.

    """

    def __init__(self, scenario: Scenario, ship: ShipTruth, start_ns: int,
                 fast: bool = False) -> None:
        s = scenario
        # Without an AHRS, loading numba would take longer than it saves.
        fast = fast and any(sensor.model in AHRS_MODELS for sensor in s.sensors.values())
        if fast and isinstance(ship.course, Steering):
            compile_steering(ship.course)
        self.now_s = 0.0
        self._last_s = s.duration_s + max(sensor.latency_s for sensor in s.sensors.values())
        self._true = _Truth(ship, start_ns, s)
        self._motion = ToldMotion(ship, start_ns, s.seed, s.motion_hz, s.duration_s)
        self._senders = {
            role: _Sender(SimulatedSensor(sensor, ship, start_ns, s.seed, role, fast), sensor,
                          s.duration_s)
            for role, sensor in s.sensors.items()}

    @property
    def over(self) -> bool:
        """Whether everything has been delivered."""
        return self.now_s >= self._last_s

    def advance(self, end_s: float) -> SimulatedChunk:
        """Return the data delivered from now up to, but not at, `end_s`, which becomes now."""
        deliveries = {name: (sender.take(end_s), sender.statuses(end_s))
                      for name, sender in self._senders.items()}
        self.now_s = end_s
        (ts, ts_said), (rs, rs_said) = deliveries.pop('ts'), deliveries.pop('rs')
        return SimulatedChunk(end_s=end_s, truth=self._true.take(end_s), ts_readings=ts,
                              rs_readings=rs, ts_statuses=ts_said, rs_statuses=rs_said,
                              others=deliveries, motion=self._motion.take(end_s))

    def command(self, role: str, kind: str, t_s: float | None = None) -> float:
        """
        Make one of `plans.EVENTS` happen to an AHRS, such as the command of a mode.

        Parameters
        ----------
        role
            'ts', 'rs', or the name of a further sensor.
        kind
            The event.
        t_s
            Time of the event, seconds since the start, not before now; default now.

        Returns
        -------
        float
            Time at which it happens. An AHRS is simulated in blocks of 10 s; an event within a
            block that has already begun happens at the next block.

        Raises
        ------
        ValueError
            If the time is past, the event is unknown, the sensor is not an AHRS, or the event is
            due within the next block and would change nothing, with the reason.

        """
        if kind not in EVENTS:
            raise ValueError(f'command {kind!r}: must be {" or ".join(EVENTS)}')
        return self._senders[role].command(kind, self._time(t_s))

    def inject(self, role: str, kind: str, value: float | None = None,
               t_s: float | None = None) -> float:
        """
        Put one of `faults.FAULTS` on a sensor until it is mended.

        Parameters
        ----------
        role
            'ts', 'rs', or the name of a further sensor.
        kind
            The fault.
        value
            Value of the fault; default that of its kind.
        t_s
            First instant at which it acts on a reading, not before now; default now.

        Returns
        -------
        float
            That instant.

        Raises
        ------
        ValueError
            If the time is past, or the fault is unknown or already present.

        """
        if kind not in FAULTS:
            raise ValueError(f'fault {kind!r}: must be {" or ".join(FAULTS)}')
        at_s = self._time(t_s)
        self._senders[role].faults.begin(
            Fault(at_s, kind, FAULTS[kind][1] if value is None else value))
        return at_s

    def mend(self, role: str, kind: str, t_s: float | None = None) -> float:
        """
        End a fault, whether injected or from the scenario; return the time.

        Raises
        ------
        ValueError
            If the time is past, or the fault is not present at that time.

        """
        at_s = self._time(t_s)
        self._senders[role].faults.end(kind, at_s)
        return at_s

    def faults(self, role: str) -> tuple[str, ...]:
        """Return the kinds of the current faults of a sensor."""
        return tuple(fault.kind for fault in self._senders[role].faults.list_active(self.now_s))

    def _time(self, t_s: float | None) -> float:
        if t_s is None:
            return self.now_s
        if not t_s >= self.now_s:
            raise ValueError(f't_s = {t_s!r}: must be at least {self.now_s:g} s, the time that '
                             'the trial has reached')
        return t_s


class _Sender:
    """Makes readings in blocks of fixed length, so that they do not depend on the chunks."""

    def __init__(self, sensor: SimulatedSensor, settings: Sensor, duration_s: float) -> None:
        self.faults = Faults(parse_faults(settings.faults))
        self.command = sensor.command
        self._sensor = sensor
        self._latency_s = settings.latency_s
        self._duration_s = duration_s
        self._made_s = 0.0
        self._waiting = sensor.take(0.0)
        self._statuses: list[AhrsStatus] = []

    def take(self, end_s: float) -> Readings:
        """Return the readings delivered since the last call and before `end_s`."""
        parts = [self._waiting]
        wanted_s = min(end_s - self._latency_s, self._duration_s)
        if self._made_s < wanted_s:
            self._made_s = min(BLOCK_S * math.ceil(wanted_s / BLOCK_S), self._duration_s)
            parts.append(self._sensor.take(self._made_s))
        readings = Readings.concatenate(parts)
        n = int(np.searchsorted(readings.t_s + self._latency_s, end_s, side='left'))
        self._waiting = readings[slice(n, None)]
        return self._add_faults(readings[slice(0, n)])

    def _add_faults(self, sound: Readings) -> Readings:
        """Return readings with the faults; without a heading there is no claim either."""
        heading_deg, stamp_ns, present = self.faults.put(
            sound.t_s, sound.headings.heading_deg, sound.headings.stamp_ns)
        sigma_deg = np.where(np.isnan(heading_deg), np.nan, sound.sigma_deg)
        return Readings(Headings.as_sent(stamp_ns, heading_deg), sound.t_s, sigma_deg,
                        sound.rate_deg_s)[present]

    def statuses(self, end_s: float) -> tuple[AhrsStatus, ...]:
        """Return the statuses of the sensor before `end_s`; call after `take`."""
        self._statuses += [status for status in self._sensor.statuses()
                           if status.t_s < self._duration_s]
        n = sum(status.t_s + self._latency_s < end_s for status in self._statuses)
        now, self._statuses = tuple(self._statuses[:n]), self._statuses[n:]
        return now


class _Truth:
    """True heading at the instants of the TS readings."""

    def __init__(self, ship: ShipTruth, start_ns: int, scenario: Scenario) -> None:
        self._ship = ship
        self._start_ns = start_ns
        self._rate_hz, self._phase_s = scenario.ts.rate_hz, scenario.ts.phase_s
        self._duration_s = scenario.duration_s
        self._next = 0

    def take(self, end_s: float) -> Headings:
        """Return the true headings since the last call and before `end_s`."""
        end_s = min(end_s, self._duration_s)
        stop = max(self._next, math.ceil((end_s - self._phase_s) * self._rate_hz))
        t_s = self._phase_s + np.arange(self._next, stop) / self._rate_hz
        t_s = t_s[t_s < end_s]
        self._next += t_s.size
        return Headings.as_sent(self._start_ns + np.rint(t_s * 1e9).astype(np.int64),
                           self._ship.heading_deg(t_s))
