# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""
Measure the risks of the guarded decision by simulation; prints the tables of docs/risk.md.

Every process has variance 1, which is made the acceptance and the rejection limit. "hi" is how
often the upper bound is below 1: a TS exactly at its norm is certified (consumer's risk). "lo"
is how often the lower bound is above 1: such a TS is rejected (producer's risk). Where the gate
is closed there is no statement. Nominal are 0.05 each.

    python benchmarks/guarded_risk.py --replications 1000
    python benchmarks/guarded_risk.py --rows 'AR.1. T/tau=100$' --replications 4000
    python benchmarks/guarded_risk.py --looks --replications 300
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass
import math
import re
import sys
from typing import Callable, Iterator

import numpy as np
from scipy.signal import lfilter
from scipy.special import chdtri, ndtr

from heading_intercompare.core.bounds import lower_bound, upper_bound
from heading_intercompare.core.criteria import Limits
from heading_intercompare.core.dyadic import Components, Dyadic
from heading_intercompare.core.guarded import decide, evidence_of
from heading_intercompare.core.noise import effective_size
from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.sequential import Looks
from heading_intercompare.core.settings import Norms, Risk

SAMPLES_AT_ONCE = 4_000_000
LONG = 30_000

Rows = Callable[[int, int, np.random.Generator], np.ndarray]
"""Called with rows, n, generator: rows of n errors of variance 1."""


def white(rows: int, n: int, rng: np.random.Generator) -> np.ndarray:
    """Return uncorrelated normal errors."""
    return rng.standard_normal((rows, n))


def ar1(tau: float) -> Rows:
    """Return normal errors with autocorrelation exp(-k / tau)."""
    phi = math.exp(-1.0 / tau)

    def errors(rows: int, n: int, rng: np.random.Generator) -> np.ndarray:
        start = phi * rng.standard_normal((rows, 1))
        steps = rng.standard_normal((rows, n)) * math.sqrt(1.0 - phi * phi)
        return lfilter([1.0], [1.0, -phi], steps, axis=1, zi=start)[0]
    return errors


def narrow_band(period: float, coherence: float) -> Rows:
    """Return normal errors with autocorrelation exp(-k / coherence) cos(2 pi k / period)."""
    pole = np.exp(complex(-1.0 / coherence, 2.0 * math.pi / period))
    gain = math.sqrt(1.0 - abs(pole) ** 2)

    def both(shape: tuple[int, int], rng: np.random.Generator) -> np.ndarray:
        return rng.standard_normal(shape) + 1j * rng.standard_normal(shape)

    def errors(rows: int, n: int, rng: np.random.Generator) -> np.ndarray:
        start = pole * both((rows, 1), rng)
        return lfilter([1.0], [1.0, -pole], gain * both((rows, n), rng), axis=1,
                       zi=start)[0].real
    return errors


def mixed(share: float, one: Rows, other: Rows) -> Rows:
    """Return the sum of two processes, the first with this share of the variance."""
    a, b = math.sqrt(share), math.sqrt(1.0 - share)
    return lambda rows, n, rng: a * one(rows, n, rng) + b * other(rows, n, rng)


def as_uniform(errors: Rows) -> Rows:
    """Return the process with its marginal distribution made uniform."""
    return lambda rows, n, rng: math.sqrt(3.0) * (2.0 * ndtr(errors(rows, n, rng)) - 1.0)


def as_laplace(errors: Rows) -> Rows:
    """Return the process with its marginal distribution made Laplacian."""
    def transformed(rows: int, n: int, rng: np.random.Generator) -> np.ndarray:
        z = errors(rows, n, rng)
        return -np.sign(z) * np.log(2.0 * ndtr(-np.abs(z))) / math.sqrt(2.0)
    return transformed


def polynomial(n: int, order: int) -> np.ndarray:
    """Return the Legendre polynomial of an order with mean square 1."""
    p = np.polynomial.legendre.Legendre.basis(order)(np.linspace(-1.0, 1.0, n))
    p -= p.mean()
    return p / math.sqrt(np.mean(p * p))


def drifting(share: float, order: int, errors: Rows) -> Rows:
    """Return errors with a drift that holds this share of the variance."""
    a, b = math.sqrt(share), math.sqrt(1.0 - share)
    return lambda rows, n, rng: a * polynomial(n, order) + b * errors(rows, n, rng)


def without_drift(order: int, errors: Rows) -> Rows:
    """Return errors on a large drift, after least squares have removed it."""
    def residuals(rows: int, n: int, rng: np.random.Generator) -> np.ndarray:
        x = errors(rows, n, rng) + 3.0 * polynomial(n, order)
        basis = np.polynomial.legendre.legvander(np.linspace(-1.0, 1.0, n), order)
        q = np.linalg.qr(basis)[0]
        return x - (x @ q) @ q.T
    return residuals


@dataclass(frozen=True, slots=True)
class Case:
    """A row of the table: a process, its length, what `docs/risk.md` expects."""

    name: str
    n: int
    errors: Rows
    stated: str = ''
    order: int = 0


def cases() -> Iterator[Case]:
    """Yield the rows; `stated` are gate, and hi / lo of dyadic+acf, of the design."""
    for n, stated in ((100, '1.000 0.021 / 0.022'), (1000, '1.000 0.029 / 0.034'),
                      (10_000, '1.000 0.026 / 0.032')):
        yield Case(f'white n={n}', n, white, stated)
    for length, stated in ((10, '0.000 0.000 / 0.000'), (30, '0.042 0.027 / 0.000'),
                           (50, '0.466 0.048 / 0.001'), (100, '0.907 0.040 / 0.014'),
                           (300, '0.995 0.035 / 0.028'), (1000, '0.995 0.035 / 0.024')):
        yield Case(f'AR(1) T/tau={length}', 100 * length, ar1(100.0), stated)
    for length, stated in ((6, '0.025 0.025 / 0.000'), (30, '0.049 0.030 / 0.000'),
                           (100, '0.908 0.042 / 0.011'), (300, '0.994 0.038 / 0.024')):
        yield Case(f'0.5 white + 0.5 AR(1) T/tau={length}', 100 * length,
                   mixed(0.5, white, ar1(100.0)), stated)
    yield Case('0.7 white + 0.3 AR(1) T/tau=6', 600, mixed(0.7, white, ar1(100.0)),
               '0.089 0.081 / 0.000')
    yield Case('AR(1) to uniform T/tau=100', 10_000, as_uniform(ar1(100.0)),
               '0.910 0.005 / 0.000')
    yield Case('AR(1) to Laplace T/tau=100', 10_000, as_laplace(ar1(100.0)),
               '0.907 0.087 / 0.035')
    yield Case('AR(1) to Laplace T/tau=300', 30_000, as_laplace(ar1(100.0)),
               '0.995 0.067 / 0.038')
    yield Case('Laplace white n=1000', 1000, as_laplace(white), '1.000 0.042 / 0.035')
    yield Case('uniform white n=1000', 1000, as_uniform(white), '1.000 0.003 / 0.004')
    band = narrow_band(100.0, 500.0)
    for periods, stated in ((25, '0.343 0.083 / 0.000'), (80, '0.983 0.058 / 0.019'),
                            (250, '1.000 0.046 / 0.019')):
        yield Case(f'narrow band, coherence 5 periods, {periods} periods', 100 * periods, band,
                   stated)
    for length, stated in ((20, '1.000 0.101 / 0.008'), (100, '1.000 0.066 / 0.017'),
                           (300, '1.000 0.052 / 0.025')):
        yield Case(f'0.5 white + 0.5 narrow band, T={length} coherence times', 500 * length,
                   mixed(0.5, white, band), stated)
    for tau_s in (10, 100):
        for length_s in (100 * tau_s, 36_000):
            yield Case(f'10 Hz AR(1) tau={tau_s} s, {length_s} s', 10 * length_s,
                       ar1(10.0 * tau_s))
    for order in (1, 3):
        for length in (50, 100, 300):
            yield Case(f'AR(1) T/tau={length}, drift of order {order} removed', 100 * length,
                       without_drift(order, ar1(100.0)), '', order)
    for share in (0.05, 0.2, 0.5):
        yield Case(f'AR(1) T/tau=300, linear drift left in, {share:g} of the variance', 30_000,
                   drifting(share, 1, ar1(100.0)))
        yield Case(f'white n=30000, linear drift left in, {share:g} of the variance', 30_000,
                   drifting(share, 1, white))


@dataclass(slots=True)
class Tally:
    """How often each wrong statement was made."""

    runs: int = 0
    is_open: int = 0
    naive: tuple[int, int] = (0, 0)
    dyadic: tuple[int, int] = (0, 0)
    both: tuple[int, int] = (0, 0)

    def add(self, x: np.ndarray, order: int, alpha: float, risk: Risk) -> None:
        """Judge one run."""
        self.runs += 1
        n = x.size
        c = Dyadic.of(x).components(order)
        squares = float(np.sum((x - x.mean()) ** 2))
        self.naive = _add(self.naive, squares / chdtri(n - 1, 1.0 - alpha) < 1.0,
                          squares / chdtri(n - 1, alpha) > 1.0)
        for name, nu in (('dyadic', c.nu_batch), ('both', min(c.nu_batch, effective_size(x)))):
            nu = min(nu, float(n - 1 - order))
            if _gate(c, nu, risk):
                self.is_open += name == 'both'
                setattr(self, name, _add(getattr(self, name), upper_bound(c, nu, alpha) < 1.0,
                                         lower_bound(c, nu, alpha) > 1.0))

    def row(self, case: Case) -> str:
        """Return the row of the table."""
        def rates(pair: tuple[int, int]) -> str:
            return ' / '.join(f'{k / self.runs:.3f}' for k in pair)
        gate, *stated = case.stated.split(' ', 1) if case.stated else ('', '')
        return (f'| {case.name} | {self.runs} | {self.is_open / self.runs:.3f} | {gate} | '
                f'{rates(self.naive)} | {rates(self.dyadic)} | {rates(self.both)} | '
                f'{stated[0]} |')


def _add(pair: tuple[int, int], hi: bool, lo: bool) -> tuple[int, int]:
    return pair[0] + bool(hi), pair[1] + bool(lo)


def _gate(c: Components, nu: float, risk: Risk) -> bool:
    return nu >= risk.nu_min and not (c.r1_blocks > risk.r1_max
                                      and c.slow_share > risk.share_max)


def runs_of(errors: Rows, n: int, count: int, rng: np.random.Generator) -> Iterator[np.ndarray]:
    """Yield runs, made many at once."""
    at_once = max(1, SAMPLES_AT_ONCE // n)
    while count > 0:
        yield from errors(min(count, at_once), n, rng)
        count -= at_once


def measure(case: Case, count: int, seed: int, alpha: float) -> str:
    """Return the row of one case."""
    rng = np.random.default_rng([seed, *case.name.encode()])
    tally, risk = Tally(), Risk()
    for x in runs_of(case.errors, case.n, count, rng):
        tally.add(x, case.order, alpha, risk)
    return tally.row(case)


def measure_looks(name: str, errors: Rows, count: int, seed: int, alpha: float,
                  method: str) -> str:
    """Return how often seven looks in ten hours at 10 Hz ever accept or reject at the limit."""
    rng = np.random.default_rng([seed, *name.encode()])
    limits = Limits.of(Norms(sigma_max_deg=1.0, sigma_ref_max_deg=0.0))
    risk = Risk(alpha_consumer=alpha, alpha_producer=alpha)
    found = {(shared, o): 0 for shared in (True, False)
             for o in (Outcome.COMPLIANT, Outcome.NON_COMPLIANT)}
    for x in runs_of(errors, 360_000, count, rng):
        open_rules = {True, False}
        for look in Looks(36_000.0, 7, risk).due(36_000.0):
            n = look.span_ns // 10 ** 8
            evidence = evidence_of(x[:n], n_plus=0, n_plus_plus=0, span_s=n / 10.0,
                                   method=method)
            for shared in tuple(open_rules):
                outcome = decide(evidence, limits, look.risk if shared else risk).outcome
                if outcome is not Outcome.INDETERMINATE:
                    found[shared, outcome] += 1
                    open_rules.remove(shared)
    cells = [f'{k / count:.3f}' for k in found.values()]
    return f'| {name} | {count} | {cells[0]} / {cells[1]} | {cells[2]} / {cells[3]} |'


def main() -> None:
    """Print the tables asked for."""
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--replications', type=int, default=1000,
                        help=f'runs of each row (a third of it beyond {LONG} samples)')
    parser.add_argument('--rows', default='', help='regular expression of the rows wanted')
    parser.add_argument('--seed', type=int, default=2016)
    parser.add_argument('--alpha', type=float, default=0.05, help='nominal risk of each side')
    parser.add_argument('--looks', action='store_true', help='doubling looks instead')
    parser.add_argument('--method', default='dyadic+acf', choices=('dyadic+acf', 'dyadic'),
                        help='risk.method of the looks')
    given = parser.parse_args()
    if given.looks:
        print('| errors (10 h at 10 Hz, 7 looks) | runs | accepted / rejected, risk shared | '
              'the same, risk not shared |\n|---|---|---|---|')
        band = narrow_band(100.0, 500.0)
        for name, errors in (('white', white), ('AR(1) 10 s', ar1(100.0)),
                             ('AR(1) 100 s', ar1(1000.0)),
                             ('0.5 white + 0.5 AR(1) 100 s', mixed(0.5, white, ar1(1000.0))),
                             ('0.5 white + 0.5 narrow band (10 s, coherence 50 s)',
                              mixed(0.5, white, band))):
            if re.search(given.rows, name):
                print(measure_looks(name, errors, given.replications, given.seed, given.alpha,
                                    given.method), flush=True)
        return
    print('| errors | runs | gate open | stated | naive chi-square hi / lo | dyadic hi / lo | '
          'dyadic+acf hi / lo | stated |\n|---|---|---|---|---|---|---|---|')
    for case in cases():
        if re.search(given.rows, case.name):
            count = given.replications if case.n <= LONG else -(-given.replications // 3)
            print(measure(case, count, given.seed, given.alpha), flush=True)


if __name__ == '__main__':
    sys.exit(main())
