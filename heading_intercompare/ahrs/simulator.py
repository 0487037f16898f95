# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""A simulated trial: the ship, the TS and the RS, handed over chunk by chunk."""

from __future__ import annotations

from dataclasses import dataclass
import math
from typing import Iterator

import numpy as np

from heading_intercompare.core.records import Headings

from .modes import AhrsStatus
from .motion import ShipTruth
from .plans import parse_legs, parse_utc
from .sensors import Readings, SimulatedSensor
from .settings import Scenario

__all__ = ['SimulatedChunk', 'Simulation']

BLOCK_S = 10.0


@dataclass(frozen=True, slots=True)
class SimulatedChunk:
    """
    What is handed over in one span of simulated time.

    Attributes
    ----------
    end_s : float
        End of the span, seconds since the start: a live sender hands the chunk over then.
    ts, rs : Headings
        Readings of the sensors, as delivered.
    truth : Headings
        True heading at the instants of the TS, at the rate of the TS, on a perfect clock.
    ts_readings, rs_readings : Readings
        The same readings with claimed standard deviation and rate of turn.
    ts_statuses, rs_statuses : tuple of AhrsStatus
        What a gimballed AHRS said of itself; empty for other models.

    """

    end_s: float
    truth: Headings
    ts_readings: Readings
    rs_readings: Readings
    ts_statuses: tuple[AhrsStatus, ...]
    rs_statuses: tuple[AhrsStatus, ...]

    @property
    def ts(self) -> Headings:
        """Readings of the TS."""
        return self.ts_readings.headings

    @property
    def rs(self) -> Headings:
        """Readings of the RS."""
        return self.rs_readings.headings


class Simulation:
    """
    A trial, reproducible to the bit from its scenario.

    Parameters
    ----------
    scenario : Scenario
        What to simulate.
    start_ns : int, optional
        UTC stamp of the start, nanoseconds; that of the scenario unless given. A live sender
        passes its clock here.

    """

    def __init__(self, scenario: Scenario, start_ns: int | None = None) -> None:
        self.scenario = scenario
        self.start_ns = parse_utc(scenario.start_utc) if start_ns is None else start_ns

    def truth(self) -> ShipTruth:
        """Return the ship of this trial."""
        s = self.scenario
        return ShipTruth(parse_legs(s.legs), s.latitude_deg, s.longitude_deg, s.seaway, s.seed)

    def chunks(self, chunk_s: float = 60.0) -> Iterator[SimulatedChunk]:
        """
        Yield the trial from its start, in spans of simulated time.

        Parameters
        ----------
        chunk_s : float
            Length of a span, seconds, greater than 0. The readings do not depend on it.

        Yields
        ------
        SimulatedChunk
            Readings are cut by the time at which they are handed over (instant + latency) and
            come in the order of their instants, which is stamp order unless a fault steps the
            clock back. Spans without readings come too. Each call starts the trial anew.

        """
        if not chunk_s > 0.0:
            raise ValueError(f'chunk_s = {chunk_s!r}: must be greater than 0')
        s = self.scenario
        ship = self.truth()
        senders = [
            _Sender(SimulatedSensor(sensor, ship, self.start_ns, s.seed, role), sensor.latency_s,
                    s.duration_s)
            for role, sensor in (('ts', s.ts), ('rs', s.rs))]
        true = _Truth(ship, self.start_ns, s)
        last_s = s.duration_s + max(s.ts.latency_s, s.rs.latency_s)
        for i in range(1, math.ceil(last_s / chunk_s) + 1):
            end_s = i * chunk_s
            ts, rs = (sender.take(end_s) for sender in senders)
            ts_said, rs_said = (sender.statuses(end_s) for sender in senders)
            yield SimulatedChunk(end_s, true.take(end_s), ts, rs, ts_said, rs_said)


class _Sender:
    """Makes readings in blocks of fixed length, so that they do not depend on the chunks."""

    def __init__(self, sensor: SimulatedSensor, latency_s: float, duration_s: float) -> None:
        self._sensor = sensor
        self._latency_s = latency_s
        self._duration_s = duration_s
        self._made_s = 0.0
        self._waiting = sensor.take(0.0)
        self._said: list[AhrsStatus] = []

    def take(self, end_s: float) -> Readings:
        """Return the readings handed over before `end_s` that were not yet."""
        parts = [self._waiting]
        while self._made_s < min(end_s - self._latency_s, self._duration_s):
            self._made_s = min(self._made_s + BLOCK_S, self._duration_s)
            parts.append(self._sensor.take(self._made_s))
        made = Readings.concatenate(parts)
        n = int(np.searchsorted(made.t_s + self._latency_s, end_s, side='left'))
        self._waiting = made[slice(n, None)]
        return made[slice(0, n)]

    def statuses(self, end_s: float) -> tuple[AhrsStatus, ...]:
        """Return what the sensor said before `end_s`; call after `take`."""
        self._said += [said for said in self._sensor.statuses() if said.t_s < self._duration_s]
        n = sum(said.t_s + self._latency_s < end_s for said in self._said)
        now, self._said = tuple(self._said[:n]), self._said[n:]
        return now


class _Truth:
    """True heading at the instants of the TS."""

    def __init__(self, ship: ShipTruth, start_ns: int, scenario: Scenario) -> None:
        self._ship = ship
        self._start_ns = start_ns
        self._rate_hz, self._phase_s = scenario.ts.rate_hz, scenario.ts.phase_s
        self._duration_s = scenario.duration_s
        self._next = 0

    def take(self, end_s: float) -> Headings:
        """Return the true headings before `end_s` that were not yet returned."""
        end_s = min(end_s, self._duration_s)
        stop = max(self._next, math.ceil((end_s - self._phase_s) * self._rate_hz))
        t_s = self._phase_s + np.arange(self._next, stop) / self._rate_hz
        t_s = t_s[t_s < end_s]
        self._next += t_s.size
        return Headings.of(self._start_ns + np.rint(t_s * 1e9).astype(np.int64),
                           self._ship.heading_deg(t_s))
