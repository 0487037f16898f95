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

"""
Error processes of known variance 1, to measure the risks of the decision.

A process is called with a generator, a number of runs and a number of samples n, and returns an
array of shape (runs, n). Every row is an independent run that starts in the stationary state. The
variance is exactly 1, except for the tabulated quantiles of Student's law: there it is 1 within
1e-6.
"""

from __future__ import annotations

from functools import lru_cache
import math
from typing import Callable

import numpy as np
from scipy.signal import lfilter
from scipy.special import ndtr, stdtrit

Errors = Callable[[np.random.Generator, int, int], np.ndarray]
"""Called with generator, runs, n: an array of shape (runs, n) of errors of variance 1."""

Sampling = Callable[[np.random.Generator, int], np.ndarray]
"""Called with generator and n: which of n instants at equal steps have a sample, ascending."""


def white(rng: np.random.Generator, runs: int, n: int) -> np.ndarray:
    """Return uncorrelated normal errors."""
    return rng.standard_normal((runs, n))


def ar1(tau: float) -> Errors:
    """Return normal errors with autocorrelation exp(-k / tau)."""
    phi, gain = math.exp(-1.0 / tau), math.sqrt(-math.expm1(-2.0 / tau))

    def errors(rng: np.random.Generator, runs: int, n: int) -> np.ndarray:
        start = phi * rng.standard_normal((runs, 1))
        return lfilter([gain], [1.0, -phi], rng.standard_normal((runs, n)), axis=1, zi=start)[0]
    return errors


def blue(rng: np.random.Generator, runs: int, n: int) -> np.ndarray:
    """Return normal errors with autocorrelation (-1/2)^k."""
    start = -0.5 * rng.standard_normal((runs, 1))
    return lfilter([math.sqrt(0.75)], [1.0, 0.5], rng.standard_normal((runs, n)), axis=1,
                   zi=start)[0]


def narrow_band(coherence: float, period: float) -> Errors:
    """Return normal errors with autocorrelation exp(-k / coherence) cos(2 pi k / period)."""
    pole = np.exp(complex(-1.0 / coherence, 2.0 * math.pi / period))
    gain = math.sqrt(-math.expm1(-2.0 / coherence))

    def both(rng: np.random.Generator, runs: int, n: int) -> np.ndarray:
        return rng.standard_normal((runs, 2 * n)).view(np.complex128)

    def errors(rng: np.random.Generator, runs: int, n: int) -> np.ndarray:
        start = pole * both(rng, runs, 1)
        return lfilter([gain], [1.0, -pole], both(rng, runs, n), axis=1, zi=start)[0].real.copy()
    return errors


def mixed(share: float, one: Errors, other: Errors) -> Errors:
    """Return the sum of two processes, the first with this share of the variance."""
    a, b = math.sqrt(share), math.sqrt(1.0 - share)

    def errors(rng: np.random.Generator, runs: int, n: int) -> np.ndarray:
        x = a * one(rng, runs, n)
        x += b * other(rng, runs, n)
        return x
    return errors


def as_laplace(normal: Errors) -> Errors:
    """Return a normal process transformed to a Laplacian marginal distribution."""
    def errors(rng: np.random.Generator, runs: int, n: int) -> np.ndarray:
        z = normal(rng, runs, n)
        return -np.sign(z) * np.log(2.0 * ndtr(-np.abs(z))) / math.sqrt(2.0)
    return errors


def as_uniform(normal: Errors) -> Errors:
    """Return a normal process transformed to a uniform marginal distribution."""
    return lambda rng, runs, n: math.sqrt(3.0) * (2.0 * ndtr(normal(rng, runs, n)) - 1.0)


_TABLE_END, _TABLE_STEPS = 8.0, 400_000


@lru_cache(maxsize=1)
def _student5_table() -> np.ndarray:
    """Return Student-5 values of variance 1 at equally probable normal values from -8 to 8."""
    z = np.linspace(-_TABLE_END, 0.0, _TABLE_STEPS // 2 + 1)
    left = stdtrit(5.0, ndtr(z)) * math.sqrt(0.6)
    left[-1] = 0.0
    return np.concatenate((left, -left[-2::-1]))


def as_student5(normal: Errors) -> Errors:
    """Return a normal process transformed to a Student marginal with 5 degrees of freedom."""
    def errors(rng: np.random.Generator, runs: int, n: int) -> np.ndarray:
        table = _student5_table()
        at = normal(rng, runs, n)
        at += _TABLE_END
        at *= _TABLE_STEPS / (2.0 * _TABLE_END)
        np.clip(at, 0.0, _TABLE_STEPS - 1e-6, out=at)
        index = at.astype(np.int64)
        at -= index
        return table[index] + at * (table[index + 1] - table[index])
    return errors


def quantised(step: float, normal: Errors) -> Errors:
    """Return a normal process rounded to multiples of step, scaled back to variance 1."""
    k = np.arange(1, 2 + math.ceil(12.0 / step))
    mass = ndtr(-(k - 0.5) * step) - ndtr(-(k + 0.5) * step)
    sigma = step * math.sqrt(2.0 * float(np.sum(k * k * mass)))
    return lambda rng, runs, n: np.rint(normal(rng, runs, n) / step) * (step / sigma)


def _shaped(variance: Callable[[np.ndarray], np.ndarray], errors: Errors) -> Errors:
    """Return a process whose variance follows a fixed pattern over time 0 to 1, with mean 1."""
    def shaped(rng: np.random.Generator, runs: int, n: int) -> np.ndarray:
        v = variance((np.arange(n) + 0.5) / n)
        return errors(rng, runs, n) * np.sqrt(v / v.mean())
    return shaped


def calm_then_rough(errors: Errors) -> Errors:
    """Return a process whose variance is nine times as large in the second half."""
    return _shaped(lambda u: np.where(u < 0.5, 0.2, 1.8), errors)


def ramp(errors: Errors) -> Errors:
    """Return a process whose variance grows linearly to nineteen times its start."""
    return _shaped(lambda u: 0.1 + 1.8 * u, errors)


def sea_state(sd: float, tau: float, errors: Errors) -> Errors:
    """Return a process whose log variance is an AR(1) process of this sd and correlation time."""
    log_variance = ar1(tau)

    def gusty(rng: np.random.Generator, runs: int, n: int) -> np.ndarray:
        g = log_variance(rng, runs, n)
        g *= 0.5 * sd
        # The mean of exp(sd z) is exp(sd^2 / 2); half of both, as this is the root of a variance.
        g -= 0.25 * sd * sd
        return errors(rng, runs, n) * np.exp(g, out=g)
    return gusty


def polynomial(n: int, order: int) -> np.ndarray:
    """Return the Legendre polynomial of this order at n equal steps, with mean square 1."""
    p = np.polynomial.legendre.Legendre.basis(order)(np.linspace(-1.0, 1.0, n))
    return p / math.sqrt(np.mean(p * p))


def without_drift(x: np.ndarray, order: int) -> np.ndarray:
    """Return runs, shape (runs, n), minus their best-fit polynomials at equal steps."""
    basis = np.polynomial.legendre.legvander(np.linspace(-1.0, 1.0, x.shape[1]), order)
    q = np.linalg.qr(basis)[0]
    return x - (x @ q) @ q.T


def five_gaps(rng: np.random.Generator, n: int) -> np.ndarray:
    """Return n instants minus five equally spaced gaps of 6 % each."""
    u = (np.arange(n) + 0.5) / n
    sixth = np.rint(6.0 * u)
    return np.flatnonzero((np.abs(u - sixth / 6.0) >= 0.03) | (sixth == 0.0) | (sixth == 6.0))


def half_missing(rng: np.random.Generator, n: int) -> np.ndarray:
    """Return the first and the last quarter of n instants."""
    i = np.arange(n)
    return i[(i < n // 4) | (i >= n - n // 4)]


def one_in_four(rng: np.random.Generator, n: int) -> np.ndarray:
    """Return a quarter of n instants, drawn at random."""
    return np.sort(rng.permutation(n)[:n // 4])


def some_lost(rng: np.random.Generator, n: int) -> np.ndarray:
    """Return n instants minus one in a hundred, drawn at random."""
    return np.sort(rng.permutation(n)[n // 100:])


def one_missing(rng: np.random.Generator, n: int) -> np.ndarray:
    """Return n instants minus the middle one, so that cells of equal time are used."""
    return np.delete(np.arange(n), n // 2)


def jittered(rng: np.random.Generator, n: int) -> np.ndarray:
    """Return every tenth of n instants, each up to four steps early or late."""
    middle = np.arange(5, n - 4, 10)
    return middle + rng.integers(-4, 5, size=middle.size)


def seconds_on_and_off(rng: np.random.Generator, n: int) -> np.ndarray:
    """Return the first ten of every twenty instants."""
    i = np.arange(n)
    return i[i % 20 < 10]
