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

"""The motion of a ship in waves that it meets by its own speed and heading."""

from __future__ import annotations

from dataclasses import dataclass
import math
from typing import NamedTuple

import numpy as np

from heading_intercompare.ahrs.random_noise import open_stream
from heading_intercompare.core.records import Reals

from .course import Course
from .seaway import BLOCK_S, BLOCK_STEPS, CHANNELS, GRID_S, KEPT_BLOCKS, read_blocks

BANDS = 32
DIRECTIONS = 5
LOWEST, HIGHEST = 0.5, 3.0
_NARROW, _WIDE = 0.07, 0.09
_FINE = 4001


@dataclass(frozen=True, slots=True)
class Waves:
    """
    A sea state.

    Attributes
    ----------
    height_m
        Significant wave height, four standard deviations of the elevation.
    peak_period_s
        Period of the peak of the spectrum.
    from_deg
        Where the waves come from, degrees from true north.
    peak_factor
        JONSWAP's gamma; 1 for the spectrum of Pierson and Moskowitz, which is Bretschneider's.
    spreading
        Exponent s of the spreading cos^2s of half the angle; None for waves of one direction.

    """

    height_m: float
    peak_period_s: float = 9.0
    from_deg: float = 0.0
    peak_factor: float = 3.3
    spreading: float | None = 10.0

    def density_m2_s(self, omega_rad_s: Reals) -> Reals:
        """
        Return the spectrum of the elevation, m^2 s, whose integral is height^2 / 16.

        Parameters
        ----------
        omega_rad_s : ndarray, shape (n,)
            Frequencies, rad/s, greater than 0.

        References
        ----------
        Hasselmann et al., "Measurements of wind-wave growth and swell decay during the Joint North
        Sea Wave Project", 1973.

        """
        peak = 2.0 * math.pi / self.peak_period_s
        every = peak * np.geomspace(0.2, 20.0, _FINE)
        shape = self._shape(every)
        whole = 0.5 * float(np.sum((shape[1:] + shape[:-1]) * np.diff(every)))
        return self.height_m**2 / 16.0 / whole * self._shape(omega_rad_s)

    def _shape(self, omega: Reals) -> Reals:
        """Return the spectrum to a factor."""
        peak = 2.0 * math.pi / self.peak_period_s
        width = np.where(omega <= peak, _NARROW, _WIDE)
        enhanced = np.exp(-0.5 * ((omega - peak) / (width * peak)) ** 2)
        shape: Reals = (omega**-5.0 * np.exp(-1.25 * (peak / omega) ** 4)
                        * self.peak_factor**enhanced)
        return shape

    def spread_rad(self, share: Reals) -> Reals:
        """
        Return the direction, relative to the main one, below which a share of the energy lies.

        Parameters
        ----------
        share : ndarray, shape (n,)
            Between 0 and 1.

        References
        ----------
        Mitsuyasu et al., "Observations of the directional spectrum of ocean waves using a
        cloverleaf buoy", 1975.

        """
        if self.spreading is None:
            return np.zeros(share.shape)
        angles = np.linspace(-math.pi, math.pi, _FINE)
        density = np.cos(0.5 * angles).clip(0.0) ** (2.0 * self.spreading)
        total = np.cumsum(density)
        return np.interp(share, (total - 0.5 * density) / total[-1], angles)


class Wavelets(NamedTuple):
    """
    The sinusoids of a sea, each of one frequency and one direction; every column shape (n,).

    Attributes
    ----------
    omega_rad_s, amplitude_m, phase_rad : ndarray
        Frequency at a fixed place, amplitude, and phase at the start.
    towards_rad : ndarray
        Where it goes, clockwise from true north.

    """

    omega_rad_s: Reals
    amplitude_m: Reals
    phase_rad: Reals
    towards_rad: Reals


def draw_waves(waves: Waves, seed: int) -> Wavelets:
    """
    Draw the sinusoids of a sea.

    The frequencies from half the peak to three times the peak are cut into bands of equal ratio.
    Each band holds one sinusoid for each fifth of the energy by direction, at a random frequency
    and a random direction within its part, so that the mean over the seeds is the spectrum. No
    two have the same frequency, so the sea is the same everywhere on the average over time.

    Parameters
    ----------
    waves
        The sea state.
    seed
        Seed of the simulation.

    """
    rng = open_stream(seed, 'waves')
    n = BANDS * DIRECTIONS
    edges = 2.0 * math.pi / waves.peak_period_s * np.geomspace(LOWEST, HIGHEST, n + 1)
    omega = edges[:-1] + np.diff(edges) * rng.random(n)
    parts = np.concatenate([rng.permutation(DIRECTIONS) for _ in range(BANDS)])
    away = waves.spread_rad((parts + rng.random(n)) / DIRECTIONS)
    amplitude = np.sqrt(2.0 * waves.density_m2_s(omega) * np.diff(edges))
    return Wavelets(omega, amplitude, 2.0 * math.pi * rng.random(n),
                    math.radians(waves.from_deg + 180.0) + away)


@dataclass(frozen=True, slots=True)
class Hull:
    """
    The figures of a ship that its motion at sea depends on.

    Attributes
    ----------
    length_m, breadth_m, draught_m
        At the waterline.
    roll_period_s
        Natural period of roll.
    roll_damping
        Damping of roll as a share of the critical one.

    """

    length_m: float = 80.0
    breadth_m: float = 14.0
    draught_m: float = 4.5
    roll_period_s: float = 11.0
    roll_damping: float = 0.1


USUAL_HULL = Hull()


def respond(hull: Hull, wave_number_1_m: Reals, ahead: Reals, aside: Reals,
            encounter_rad_s: Reals) -> np.ndarray:
    """
    Return the complex response to waves of 1 m amplitude.

    Parameters
    ----------
    hull
        The ship.
    wave_number_1_m : ndarray, shape (n,)
        Wave numbers, rad/m.
    ahead, aside : ndarray, shape (..., n)
        Components of the unit vector in which a wave goes, along the ship axis and to starboard.
    encounter_rad_s : ndarray, shape (..., n)
        Frequencies as the ship meets the waves, negative if it overtakes them.

    Returns
    -------
    ndarray of complex, shape (6, ..., n)
        Roll (starboard down), pitch (bow up) and yaw (to starboard), rad/m; surge, sway and heave
        (down), 1. The real part of this times exp(j phase) belongs to an elevation cos(phase).

    Notes
    -----
    The hull follows the water averaged over its length, breadth and draught (Froude and Krylov's
    forces on a box, without its own waves). Pitch and yaw are the slopes of the straight line
    that fits the water best along the hull. Only roll resonates.

    References
    ----------
    Jensen, Mansour and Olsen, "Estimation of ship motions using closed-form expressions", Ocean
    Engineering 31 (2004), of which these are the limit for small frequencies.

    """
    k = wave_number_1_m
    along, across = 0.5 * hull.length_m * k * ahead, 0.5 * hull.breadth_m * k * aside
    depth = np.exp(-0.5 * hull.draught_m * k)
    mean = np.sinc(along / math.pi) * np.sinc(across / math.pi) * depth
    slope = _fit_slope(along) * np.sinc(across / math.pi) * depth
    ratio = encounter_rad_s * hull.roll_period_s / (2.0 * math.pi)
    swing = 1.0 / (1.0 - ratio * ratio + 2j * hull.roll_damping * ratio)
    return np.stack((1j * k * aside * mean * swing, -1j * k * ahead * slope,
                     -k * ahead * aside * slope, -1j * ahead * mean, -1j * aside * mean,
                     -mean + 0j))


def _fit_slope(q: Reals) -> Reals:
    """Return 3 (sin q - q cos q) / q^3: the slope of a line fitted to a sinusoid, over its own."""
    small = np.abs(q) < 1e-2
    safe = np.where(small, 1.0, q)
    return np.where(small, 1.0 - 0.1 * q * q, 3.0 * (np.sin(safe) - safe * np.cos(safe))
                    / safe**3)


STANDARD_GRAVITY_M_S2 = 9.80665
_REACH = 4
_STEADY = 1e-6
#: Central differences over seven points; the error is (w h)^6 / 140 of the rate.
_RATE = np.array([-1.0, 9.0, -45.0, 0.0, 45.0, -9.0, 1.0]) / 60.0
_BEND = np.array([2.0, -27.0, 270.0, -490.0, 270.0, -27.0, 2.0]) / 180.0


class WaveSea:
    """
    Roll, pitch, yaw, surge, sway and heave in waves, as pure functions of time.

    A wave is met where the ship is. So the frequency of encounter, w - k V cos(angle), follows
    from the way of the ship through the water, and the response from its heading and speed. Only
    a cache is kept between calls.

    Parameters
    ----------
    waves
        The sea state.
    hull
        The ship.
    course
        Its way through the water.
    seed
        Seed of the simulation.

    Notes
    -----
    Waves in deep water, k = w^2 / g, in the frame of the water. Rates and accelerations are
    differences of the motion on the grid of 0.1 s, so they hold in a turn, too.

    """

    def __init__(self, waves: Waves, hull: Hull, course: Course, seed: int) -> None:
        self.calm = waves.height_m == 0.0
        self._hull, self._course = hull, course
        self._waves = draw_waves(waves, seed)
        self._number = self._waves.omega_rad_s**2 / STANDARD_GRAVITY_M_S2
        self._blocks: dict[int, Reals] = {}

    def block(self, index: int) -> Reals:
        """Return the motion over one block of the grid, shape (6, 3, 601); see `Seaway.block`."""
        if index not in self._blocks:
            steps = np.arange(-_REACH, BLOCK_STEPS + 1 + _REACH, dtype=np.float64)
            t_s = index * BLOCK_S + GRID_S * steps
            values = self._move(t_s)
            motion = np.empty((len(CHANNELS), 3, BLOCK_STEPS + 1))
            motion[:, 0] = values[:, _REACH:-_REACH]
            for order, weights in ((1, _RATE), (2, _BEND)):
                motion[:, order] = sum(
                    weight * values[:, shift:shift + BLOCK_STEPS + 1]
                    for shift, weight in enumerate(weights, 1)) / GRID_S**order
            while len(self._blocks) >= KEPT_BLOCKS:
                del self._blocks[next(iter(self._blocks))]
            self._blocks[index] = motion
        return self._blocks[index]

    def read(self, t_s: Reals, *channels: tuple[str, int]) -> list[Reals]:
        """Return channels or their rates at any instants; see `Seaway.read`."""
        return read_blocks(self, t_s, *channels)

    def _move(self, t_s: Reals) -> Reals:
        """Return the motion at some instants, shape (6, n)."""
        sailed_s = np.maximum(t_s, 0.0)
        heading, turn = self._course.read_heading(sailed_s)
        # The differences at 0 need a few steps before it, in which the ship went straight on.
        heading = heading + (t_s - sailed_s) * turn
        speed = self._course.read_speed(sailed_s)
        east, north = self._course.read_way(sailed_s)
        east = east + (t_s - sailed_s) * speed * np.sin(heading)
        north = north + (t_s - sailed_s) * speed * np.cos(heading)
        omega, amplitude, phase, towards = self._waves
        to_east, to_north = np.sin(towards), np.cos(towards)
        # On a steady course one response serves the whole block, in a fraction of the time.
        steady = max(np.ptp(heading), np.ptp(speed)) < _STEADY
        rows = slice(0, 1) if steady else slice(None)
        c, s = np.cos(heading[rows])[:, np.newaxis], np.sin(heading[rows])[:, np.newaxis]
        ahead, aside = c * to_north + s * to_east, c * to_east - s * to_north
        met = omega - self._number * speed[rows, np.newaxis] * ahead
        angle = (np.outer(t_s, omega) + phase - np.outer(east, self._number * to_east)
                 - np.outer(north, self._number * to_north))
        answers = respond(self._hull, self._number, ahead, aside, met)
        answers = np.broadcast_to(answers, (len(CHANNELS), *angle.shape))
        moved: Reals = np.einsum('cti,ti->ct', answers, amplitude * np.exp(1j * angle)).real
        return moved
