# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Random numbers: named streams from one seed, and coloured noise that continues across calls."""

from __future__ import annotations

from itertools import accumulate, islice
import math
import zlib

import numpy as np

__all__ = ['Markov', 'open_stream']


def open_stream(seed: int, name: str) -> np.random.Generator:
    """
    Return the random generator for a named purpose.

    Parameters
    ----------
    seed : int
        Seed of the whole simulation, at least 0.
    name : str
        Purpose, such as 'ts.white'. Streams with different names are independent, so a new one
        does not change the numbers of the others.

    """
    child = np.random.SeedSequence(seed, spawn_key=(zlib.crc32(name.encode()),))
    return np.random.Generator(np.random.PCG64(child))


class Markov:
    """
    First-order Gauss-Markov noise on an even grid, stationary from the start.

    Parameters
    ----------
    sigma : float
        Standard deviation, in the unit of the noise.
    tau_s : float
        Correlation time, seconds.
    step_s : float
        Grid step, seconds.
    rng : numpy.random.Generator
        Source of the numbers, for this noise only.

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

    def take(self, n: int) -> np.ndarray:
        """
        Return the next n values.

        The values do not depend on the number taken at a time: two calls of `take(2)` give the
        same as `take(4)`, to the bit.
        """
        if n == 0 or self._sigma == 0.0:
            return np.zeros(n)
        driven = self._drive * self._rng.standard_normal(n)
        decay = self._decay
        # scipy.signal has the same filter with the same bits, but takes a second to load.
        values = accumulate(driven.tolist(), lambda last, x: x + decay * last, initial=self._last)
        values = np.fromiter(islice(values, 1, None), float, n)
        self._last = float(values[-1])
        return values
