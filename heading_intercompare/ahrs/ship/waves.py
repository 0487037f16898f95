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

"""Waves as a sum of sinusoids: JONSWAP spectrum, and directions spread about the main one."""

from __future__ import annotations

from dataclasses import dataclass
import math
from typing import NamedTuple

import numpy as np

from heading_intercompare.ahrs.random_noise import open_stream
from heading_intercompare.core.records import Reals

__all__ = ['draw_waves', 'Wavelets', 'Waves']

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
    height_m : float
        Significant wave height, four standard deviations of the elevation.
    peak_period_s : float
        Period of the peak of the spectrum.
    from_deg : float
        Where the waves come from, degrees from true north.
    peak_factor : float
        JONSWAP's gamma; 1 for the spectrum of Pierson and Moskowitz, which is Bretschneider's.
    spreading : float or None
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
    waves : Waves
        The sea state.
    seed : int
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
