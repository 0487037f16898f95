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

"""The motion that the sea gives a ship: six processes with a Bretschneider spectrum."""

from __future__ import annotations

from dataclasses import dataclass
import math
from typing import Protocol

import numpy as np

from heading_intercompare.ahrs.random_noise import open_stream
from heading_intercompare.core.records import Reals

GRID_S = 0.1
"""Step of the table of the ship's motion, and of the control loop, seconds."""

BLOCK_S = 60.0
"""Length of one tabulated block, seconds."""

BLOCK_STEPS = 600
CHANNELS = ('roll', 'pitch', 'yaw', 'surge', 'sway', 'heave')
COMPONENTS = 32
LOWEST, HIGHEST = 0.55, 2.2
KEPT_BLOCKS = 4


@dataclass(frozen=True, slots=True)
class SeawayPreset:
    """RMS motion: roll, pitch and yaw in degrees; surge, sway and heave in metres."""

    angles_deg: tuple[float, float, float]
    shifts_m: tuple[float, float, float]


SEAWAYS = {
    'calm': SeawayPreset((0.0, 0.0, 0.0), (0.0, 0.0, 0.0)),
    'moored': SeawayPreset((0.3, 0.1, 0.05), (0.05, 0.05, 0.05)),
    'ss3': SeawayPreset((2.0, 0.6, 0.3), (0.15, 0.25, 0.4)),
    'ss5': SeawayPreset((4.0, 1.2, 0.6), (0.3, 0.5, 0.8)),
}
"""Sea states by name."""

MODAL_PERIODS_S = (11.0, 8.0, 12.0, 10.0, 10.0, 9.0)


class Sea(Protocol):
    """The motion that a sea gives a ship: see `Seaway`, which is one."""

    calm: bool

    def block(self, index: int) -> Reals:
        """Return the motion over one block of the grid."""

    def read(self, t_s: Reals, *channels: tuple[str, int]) -> list[Reals]:
        """Return channels or their rates at any instants."""


class Seaway:
    """
    Roll, pitch, yaw, surge, sway and heave as pure functions of time.

    Each is a sum of sinusoids with irregular frequencies, so derivatives are exact and any instant
    can be computed. Only a cache is kept between calls.

    Parameters
    ----------
    preset
        A name of `SEAWAYS`.
    seed
        Seed of the simulation.

    References
    ----------
    Bretschneider's spectrum S ~ (w0/w)^5 exp(-1.25 (w0/w)^4), normalised to the given RMS.

    """

    def __init__(self, preset: str, seed: int) -> None:
        rms = [math.radians(a) for a in SEAWAYS[preset].angles_deg] + list(
            SEAWAYS[preset].shifts_m)
        self.calm = not any(rms)
        rng = open_stream(seed, 'seaway')
        steps_s = GRID_S * np.arange(BLOCK_STEPS + 1)
        self._omega, self._complex, self._table = [], [], []
        for value, period_s in zip(rms, MODAL_PERIODS_S):
            omega0 = 2.0 * math.pi / period_s
            edges = omega0 * np.linspace(LOWEST, HIGHEST, COMPONENTS + 1)
            omega = edges[:-1] + np.diff(edges) * rng.random(COMPONENTS)
            phase = 2.0 * math.pi * rng.random(COMPONENTS)
            density = (omega0 / omega) ** 5 * np.exp(-1.25 * (omega0 / omega) ** 4)
            amplitude = np.sqrt(density)
            amplitude *= value * math.sqrt(2.0 / float(np.sum(density)))
            self._omega.append(omega)
            self._complex.append(amplitude * np.exp(1j * phase))
            self._table.append(np.exp(1j * np.outer(steps_s, omega)))
        self._blocks: dict[int, Reals] = {}

    def block(self, index: int) -> Reals:
        """
        Return the motion over one block of the grid, both ends included.

        Parameters
        ----------
        index
            Block from `index * BLOCK_S` to `(index + 1) * BLOCK_S`.

        Returns
        -------
        ndarray, shape (6, 3, 601)
            Channel (as in `CHANNELS`), derivative 0 to 2, step of `GRID_S`; in rad or m, and s.

        """
        if index not in self._blocks:
            values = np.zeros((len(CHANNELS), 3, BLOCK_STEPS + 1))
            if not self.calm:
                for channel, (omega, start, table) in enumerate(
                        zip(self._omega, self._complex, self._table)):
                    now = start * np.exp(1j * np.fmod(omega * (index * BLOCK_S), 2.0 * math.pi))
                    weights = np.stack((now, 1j * omega * now, -omega * omega * now))
                    # In this order of the axes it adds along both rows, four times as fast.
                    values[channel] = np.einsum('ti,di->dt', table, weights).real
            while len(self._blocks) >= KEPT_BLOCKS:
                del self._blocks[next(iter(self._blocks))]
            self._blocks[index] = values
        return self._blocks[index]

    def read(self, t_s: Reals, *channels: tuple[str, int]) -> list[Reals]:
        """
        Return channels or their rates at any instants.

        Parameters
        ----------
        t_s : ndarray, shape (n,)
            Seconds since the start, not negative.
        *channels : tuple of str and {0, 1}
            Names of `CHANNELS`, each with 0 for the value or 1 for its rate.

        Returns
        -------
        list of ndarray, each of shape (n,)
            Interpolated by cubics with the exact slopes at the grid (error below 0.02 arc
            seconds). An instant gives the same bits whatever other instants are read with it.

        """
        return read_blocks(self, t_s, *channels)


def read_blocks(sea: Sea, t_s: Reals, *channels: tuple[str, int]) -> list[Reals]:
    """Return channels of a sea or their rates at any instants; see `Seaway.read`."""
    columns: list[Reals] = [np.zeros(t_s.shape) for _ in channels]
    if sea.calm or not t_s.size:
        return columns
    blocks = np.floor(t_s / BLOCK_S).astype(np.int64)
    first, last = int(blocks.min()), int(blocks.max())
    for index in (first,) if first == last else np.unique(blocks).tolist():
        rows = slice(None) if first == last else blocks == index
        table = sea.block(index)
        position = (t_s[rows] - index * BLOCK_S) / GRID_S
        step = np.minimum(position.astype(np.int64), BLOCK_STEPS - 1)
        u, after = position - step, step + 1
        back = 1.0 - u
        bend, sag = u * u * (3.0 - 2.0 * u), u * back
        # The cubic through the values of a step, with their slopes.
        for value, (channel, order) in zip(columns, channels):
            values, slopes = table[CHANNELS.index(channel)][order:order + 2]
            left = values[step]
            value[rows] = (left + bend * (values[after] - left)
                           + GRID_S * (sag * (back * slopes[step] - u * slopes[after])))
    return columns
