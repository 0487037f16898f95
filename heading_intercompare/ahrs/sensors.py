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

"""A simulated heading sensor: its readings, their stamps, and dropouts."""

from __future__ import annotations

from dataclasses import dataclass
import math

import numpy as np

from heading_intercompare.ahrs.gimballed.modes import AhrsStatus
from heading_intercompare.ahrs.gimballed.output import AhrsOutput
from heading_intercompare.ahrs.inertial.compiled_loop import compile_recursion
from heading_intercompare.ahrs.ship.ship_motion import ShipTruth
from heading_intercompare.core.angles import wrap360
from heading_intercompare.core.records import Headings, Integers, Reals

from .plans import parse_deviation, parse_starts
from .random_noise import Markov, open_stream, Outages
from .sensor_presets import terms_of
from .settings import AHRS_MODELS, Sensor


@dataclass(frozen=True, slots=True)
class Readings:
    """
    Readings of one sensor, with the claims that it makes about them.

    Attributes
    ----------
    headings
        Stamps and headings.
    t_s : ndarray, shape (n,)
        True instants of the readings, seconds since the start.
    sigma_deg : ndarray, shape (n,)
        Standard deviation that the sensor claims, degrees; nan where it flags itself as invalid.
    rate_deg_s : ndarray, shape (n,)
        Rate of turn to starboard, degrees per second.

    """

    headings: Headings
    t_s: Reals
    sigma_deg: Reals
    rate_deg_s: Reals

    def __len__(self) -> int:
        return len(self.headings)

    def __getitem__(self, which: slice | np.ndarray) -> 'Readings':
        """Return the readings of a slice or mask."""
        return Readings(self.headings[which], self.t_s[which], self.sigma_deg[which],
                        self.rate_deg_s[which])

    @classmethod
    def concatenate(cls, parts: list['Readings']) -> 'Readings':
        """Return the readings joined in the order given; at least one part."""
        if len(parts) == 1:
            return parts[0]
        return cls(Headings.concatenate([p.headings for p in parts]),
                   *(np.concatenate([getattr(p, name) for p in parts])
                     for name in ('t_s', 'sigma_deg', 'rate_deg_s')))


class SimulatedSensor:
    """
    Readings of one heading sensor, block by block, before faults are applied.

    Parameters
    ----------
    settings
        Errors and stamps of the sensor.
    truth
        The ship that carries it.
    start_ns
        UTC stamp of the start, nanoseconds.
    seed
        Seed of the simulation.
    role
        'ts' or 'rs'; names its random numbers, so that the two never share any.
    fast
        Compile the control loop of an AHRS, and the coloured noise, if numba is installed. That
        gives the same bits.

    """

    def __init__(self, settings: Sensor, truth: ShipTruth, start_ns: int, seed: int,
                 role: str, fast: bool = False) -> None:
        self._settings = settings
        self._terms = terms_of(settings)
        self._deviation = parse_deviation(settings.deviation)
        starts = parse_starts(settings.starts)
        self._starts_s = np.array([start.t_s for start in starts])
        self._settle_points_deg = np.array([start.error_deg for start in starts])
        self._truth = truth
        self._start_ns = start_ns
        self._rng = {name: open_stream(seed, f'{role}.{name}')
                     for name in ('white', 'jitter', 'dropout')}
        self._tone_phase_rad = 2.0 * math.pi * open_stream(seed, f'{role}.tone').random()
        self._markov = Markov(self._terms.markov_deg, self._terms.markov_tau_s,
                              1.0 / settings.rate_hz, open_stream(seed, f'{role}.markov'))
        self._outages = Outages(self._terms.outage_every_s, self._terms.outage_s,
                                open_stream(seed, f'{role}.outage'))
        self._ahrs = (AhrsOutput(settings, truth, seed, role, fast)
                      if settings.model in AHRS_MODELS else None)
        if fast:
            compile_recursion(self._markov)
        self._next = 0

    def statuses(self) -> tuple[AhrsStatus, ...]:
        """Return the statuses of an AHRS since the last call; none for other models."""
        return self._ahrs.statuses() if self._ahrs else ()

    def command(self, kind: str, t_s: float) -> float:
        """
        Make an event happen to an AHRS; return its time.

        Raises
        ------
        ValueError
            If the sensor is not an AHRS, or refuses the event.

        """
        if self._ahrs is None:
            raise ValueError(f'a sensor of the model {self._settings.model!r} has no modes, only '
                             f'{", ".join(AHRS_MODELS)} have')
        return self._ahrs.command(kind, t_s)

    def take(self, until_s: float) -> Readings:
        """Return the readings from the end of the last call up to, but not at, `until_s`."""
        s = self._settings
        stop = max(self._next, math.ceil((until_s - s.phase_s) * s.rate_hz))
        t_s = s.phase_s + np.arange(self._next, stop) / s.rate_hz
        # Rounding must not deliver a reading that belongs to the next call.
        t_s = t_s[t_s < until_s]
        self._next += t_s.size
        random_deg = math.hypot(self._terms.white_deg, self._terms.markov_deg,
                                s.resolution_deg / math.sqrt(12.0))
        if self._ahrs:
            heading_deg, sigma_deg, rate_rad_s = self._ahrs.read(t_s)
            sigma_deg = np.hypot(sigma_deg, random_deg)
        else:
            heading_rad, rate_rad_s = self._truth.read_heading(t_s)
            heading_deg = np.degrees(heading_rad)
            sigma_deg = np.full(t_s.shape, random_deg)
        if s.claimed_sigma_deg is not None:
            sigma_deg = np.where(np.isnan(heading_deg), np.nan, s.claimed_sigma_deg)
        heading_deg = heading_deg + self._errors(t_s)
        if any(self._deviation):
            heading_deg = heading_deg + self._deviate(t_s)
        if s.resolution_deg:
            heading_deg = s.resolution_deg * np.rint(heading_deg / s.resolution_deg)
        present = self._rng['dropout'].random(t_s.size) >= s.dropout
        present &= ~self._outages.cover(t_s)
        return Readings(Headings.as_sent(self._stamps(t_s), wrap360(heading_deg)), t_s, sigma_deg,
                        np.degrees(rate_rad_s))[present]

    def _errors(self, t_s: Reals) -> Reals:
        """Return the errors of the closed-form model, degrees."""
        terms = self._terms
        white = self._rng['white']
        drawn = (white.standard_normal(t_s.size) if terms.white_shape == 'normal'
                 else math.sqrt(12.0) * (white.random(t_s.size) - 0.5))
        error_deg: Reals = terms.offset_deg + terms.drift_deg_h * t_s / 3600.0
        start = np.searchsorted(self._starts_s, t_s, side='right') - 1
        error_deg += self._settle_points_deg[start]
        if terms.settling_deg:
            error_deg += terms.settling_deg * np.exp(
                -(t_s - self._starts_s[start]) / terms.settling_tau_s)
        if terms.tone_deg:
            error_deg += terms.tone_deg * np.sin(
                2.0 * math.pi / terms.tone_period_s * t_s + self._tone_phase_rad)
        error_deg += self._markov.take(t_s.size)
        error_deg += terms.white_deg * drawn
        return error_deg

    def _deviate(self, t_s: Reals) -> Reals:
        """Return the error that depends on the true heading, degrees."""
        b, c, d, e = self._deviation
        psi = self._truth.heading_rad(t_s)
        return (b * np.sin(psi) + c * np.cos(psi) + d * np.sin(2.0 * psi)
                + e * np.cos(2.0 * psi))

    def _stamps(self, t_s: Reals) -> Integers:
        """Return the stamps that the clock of the sensor gives these instants."""
        s = self._settings
        late_s = (s.stamp_offset_s + 1e-6 * s.clock_drift_ppm * t_s
                  + s.stamp_jitter_s * (2.0 * self._rng['jitter'].random(t_s.size) - 1.0))
        return (self._start_ns + np.rint(t_s * 1e9).astype(np.int64)
                + np.rint(late_s * 1e9).astype(np.int64))
