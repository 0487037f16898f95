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

import numpy as np

from heading_intercompare.core.records import Reals

from .course import Course
from .seaway import BLOCK_S, BLOCK_STEPS, CHANNELS, GRID_S, KEPT_BLOCKS, read_blocks
from .ship_response import Hull, respond
from .waves import draw_waves, Waves

__all__ = ['WaveSea']

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
    waves : Waves
        The sea state.
    hull : Hull
        The ship.
    course : Course
        Its way through the water.
    seed : int
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
