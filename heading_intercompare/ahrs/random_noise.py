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

"""Random numbers: named streams from one seed; coloured noise and outages across calls."""

from __future__ import annotations

from itertools import accumulate, islice
import math
from typing import Callable
import zlib

import numpy as np

from heading_intercompare.core.records import Reals


def open_stream(seed: int, name: str) -> np.random.Generator:
    """
    Return the random generator for a named purpose.

    Parameters
    ----------
    seed
        Seed of the whole simulation, at least 0.
    name
        Purpose, such as 'ts.white'. Streams with different names are independent, so a new one
        does not change the numbers of the others.

    """
    child = np.random.SeedSequence(seed, spawn_key=(zlib.crc32(name.encode()),))
    return np.random.Generator(np.random.PCG64(child))


def recur(driven: Reals, decay: float, last: float) -> Reals:
    """
    Return x[k] = driven[k] + decay x[k - 1], x[-1] = last, by a plain loop that numba compiles.

    Examples
    --------
    >>> recur(np.array([1.0, 0.0, 1.0]), 0.5, 4.0).tolist()
    [3.0, 1.5, 1.75]

    """
    values = np.empty_like(driven)
    for k in range(driven.size):
        last = driven[k] + decay * last
        values[k] = last
    return values


def _accumulate(driven: Reals, decay: float, last: float) -> Reals:
    """Return the same as `recur` and to the bit, in a quarter of the time without numba."""
    # scipy.signal has the same filter with the same bits, but takes a second to load.
    values = accumulate(driven.tolist(), lambda last, x: x + decay * last, initial=last)
    return np.fromiter(islice(values, 1, None), float, driven.size)


class Markov:
    """
    First-order Gauss-Markov noise on an even grid, stationary from the start.

    Parameters
    ----------
    sigma
        Standard deviation, in the unit of the noise.
    tau_s
        Correlation time, seconds.
    step_s
        Grid step, seconds.
    rng
        Source of the numbers, for this noise only.

    Attributes
    ----------
    recur
        The recursion: a compiled `recur` may take the place of the interpreted one.

    References
    ----------
    Exact step of the Ornstein-Uhlenbeck process:
    x' = exp(-h/tau) x + sigma sqrt(1 - exp(-2h/tau)) n.

    """

    def __init__(self, sigma: float, tau_s: float, step_s: float,
                 rng: np.random.Generator) -> None:
        self._rng = rng
        self._sigma = sigma
        self._decay = math.exp(-step_s / tau_s)
        self._drive = sigma * math.sqrt(-math.expm1(-2.0 * step_s / tau_s))
        self._last = sigma * float(rng.standard_normal())
        self.recur: Callable[[Reals, float, float], Reals] = _accumulate

    def take(self, n: int) -> Reals:
        """
        Return the next n values.

        The values do not depend on the number taken at a time: two calls of `take(2)` give the
        same as `take(4)`, to the bit.
        """
        if n == 0 or self._sigma == 0.0:
            return np.zeros(n)
        driven = self._drive * self._rng.standard_normal(n)
        values = self.recur(driven, self._decay, self._last)
        self._last = float(values[-1])
        return values


class Outages:
    """
    Random outages: times between them, and their lengths, with exponential distributions.

    Parameters
    ----------
    every_s
        Mean time from the end of an outage to the next, seconds; 0: there are none.
    length_s
        Mean length of an outage, seconds.
    rng
        Source of the numbers, for this purpose only.

    """

    def __init__(self, every_s: float, length_s: float, rng: np.random.Generator) -> None:
        self._every_s, self._length_s, self._rng = every_s, length_s, rng
        self._begin_s = self._end_s = 0.0
        if every_s:
            self._draw()

    def cover(self, t_s: Reals) -> np.ndarray:
        """
        Tell which instants lie in an outage.

        Parameters
        ----------
        t_s : ndarray, shape (n,)
            Rising instants, seconds, none before those of the last call.

        Returns
        -------
        ndarray of bool, shape (n,)

        """
        covered = np.zeros(t_s.shape, dtype=bool)
        if not self._every_s or not t_s.size:
            return covered
        while True:
            covered |= (t_s >= self._begin_s) & (t_s < self._end_s)
            if self._end_s > t_s[-1]:
                return covered
            self._draw()

    def _draw(self) -> None:
        """Draw the next outage."""
        gap, length = self._rng.standard_exponential(2)
        self._begin_s = self._end_s + self._every_s * float(gap)
        self._end_s = self._begin_s + self._length_s * float(length)
