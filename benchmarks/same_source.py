# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""
Measure how often one source is found, and how often two sensors are taken for one.

Every row is one kind of TS; the motion, the rate, the length and the noise of the RS are drawn
at random. "testable" is the share of the runs in which the RS shows noise of its own, "common"
the share of these in which one source is found. Nominal are 0.95 for copies and 0.001 for
independent sensors.

    python benchmarks/same_source.py --runs 300
    python benchmarks/same_source.py --rows independent --runs 2000
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass
import math
import re
import sys
from typing import Callable

import numpy as np
from scipy.signal import lfilter

from heading_intercompare.core.angles import wrap180
from heading_intercompare.core.common_noise import common_noise, CommonNoise
from heading_intercompare.core.pairing import pair
from heading_intercompare.core.records import Headings
from heading_intercompare.core.standstill import resolution_of

Motion = Callable[[np.ndarray], np.ndarray]


def motion(rng: np.random.Generator, span_s: float) -> Motion:
    """Return a heading as a function of time, s: steady, turning, in swell or in a seaway."""
    lines = []
    if rng.random() < 0.8:
        size = rng.uniform(0.2, 3.0)
        for _ in range(rng.integers(1, 13)):
            lines.append((size / math.sqrt(12.0), rng.uniform(6.0, 12.0)))
    if rng.random() < 0.3:
        # A sea whose spectrum falls with the fifth power, of the yaw with the ninth.
        peak = rng.uniform(0.08, 0.17)
        frequency = peak * np.linspace(0.6, 6.0, 200)
        density = frequency ** -9.0 * np.exp(-1.25 * (peak / frequency) ** 4) * frequency[0] ** 9
        size = np.sqrt(density / density.sum()) * rng.uniform(0.2, 2.0)
        lines += [(a, 1.0 / f) for a, f in zip(size, frequency * rng.uniform(0.99, 1.01, 200))]
    if rng.random() < 0.5:
        lines.append((rng.uniform(0.1, 2.0), rng.uniform(60.0, 900.0)))
    lines = [(a, p, rng.uniform(0.0, 2.0 * math.pi)) for a, p in lines]
    turns = [(rng.uniform(0.0, span_s), rng.uniform(-150.0, 150.0), rng.choice([0.2, 1.0, 3.0]))
             for _ in range(rng.integers(0, 8) if rng.random() < 0.6 else 0)]
    start = rng.uniform(0.0, 360.0)

    def heading(t: np.ndarray) -> np.ndarray:
        found = np.full(t.shape, start)
        for size, period, phase in lines:
            found += size * np.sin(2.0 * math.pi * t / period + phase)
        for at, angle, rate in turns:
            # A ship needs some seconds to begin and to end a turn.
            lasts = max(abs(angle) / rate, 10.0)
            u = np.clip((t - at) / lasts, 0.0, 1.0)
            found += angle * (u - np.sin(2.0 * math.pi * u) / (2.0 * math.pi))
        return found
    return heading


def coloured(rng: np.random.Generator, n: int, tau: float) -> np.ndarray:
    """Return noise of variance 1 and correlation time tau in samples; white for 0."""
    white = rng.standard_normal(n)
    if tau <= 0.0:
        return white
    phi = math.exp(-1.0 / tau)
    return lfilter([math.sqrt(1.0 - phi * phi)], [1.0, -phi], white)


def rounded(values: np.ndarray, step: float) -> np.ndarray:
    """Return values rounded to a step; as they are for 0."""
    return np.round(values / step) * step if step else values


@dataclass(frozen=True, slots=True)
class Run:
    """What the kinds of TS are made of."""

    rng: np.random.Generator
    t: np.ndarray
    rs_hz: float
    sigma: float
    heading: Motion
    true: np.ndarray
    rs: np.ndarray
    jitter: np.ndarray


def drawn(seed: int, tau_s: float | None, noisy: bool = True) -> Run:
    """Return a run of 20 min to 2 h; the RS is sampled at 1 to 10 Hz, once in ten at 50 Hz."""
    rng = np.random.default_rng(seed)
    rs_hz = float(rng.choice([1.0, 2.0, 5.0, 10.0, 50.0], p=[0.3, 0.15, 0.2, 0.25, 0.1]))
    span = float(rng.choice([1200.0, 3600.0, 7200.0]) if rs_hz < 20.0 else 1200.0)
    t = np.arange(round(span * rs_hz)) / rs_hz
    sigma = rng.choice([0.02, 0.05, 0.1, 0.2]) if noisy else 0.0
    jitter = rng.choice([0.0, 0.02]) / rs_hz * rng.standard_normal(t.size)
    heading = motion(rng, span)
    true = heading(t + jitter)
    tau = 0.0 if tau_s is None else tau_s * rs_hz
    rs = true + sigma * coloured(rng, t.size, tau)
    return Run(rng, t, rs_hz, sigma, heading, true, rounded(rs, rng.choice([0.0, 0.01])), jitter)


def stamps(t: np.ndarray) -> np.ndarray:
    """Return stamps in nanoseconds."""
    return np.rint((t + 1000.0) * 1e9).astype(np.int64)


def judged(run: Run, ts_t: np.ndarray, ts: np.ndarray) -> CommonNoise:
    """Return what is found for a TS."""
    pairs, _ = pair(Headings.of(stamps(ts_t), ts % 360.0),
                    Headings.of(stamps(run.t + run.jitter), run.rs % 360.0))
    return common_noise(pairs.stamp_ns, wrap180(pairs.ts_deg - pairs.rs_deg), pairs.rs_deg,
                        rs_factor=pairs.rs_variance_factor,
                        rs_interval_s=1.0 / run.rs_hz, rs_step_deg=resolution_of(run.rs),
                        ts_step_deg=resolution_of(ts))


def exact(run: Run) -> CommonNoise:
    """Judge a copy."""
    return judged(run, run.t + run.jitter, run.rs)


def delayed(run: Run) -> CommonNoise:
    """Judge a copy that comes up to three seconds late."""
    return judged(run, run.t + run.jitter + run.rng.uniform(0.0, 3.0), run.rs)


def requantised(run: Run) -> CommonNoise:
    """Judge a copy rounded to twice the noise at most."""
    step = max(s for s in (0.01, 0.02, 0.05, 0.1, 0.2) if s <= max(0.01, 2.0 * run.sigma))
    return judged(run, run.t + run.jitter, rounded(run.rs, step))


def filtered(run: Run) -> CommonNoise:
    """Judge a copy through a filter of the first order of 1 to 5 s."""
    phi = math.exp(-1.0 / run.rs_hz / run.rng.uniform(1.0, 5.0))
    ts = lfilter([1.0 - phi], [1.0, -phi], run.rs - run.rs[0]) + run.rs[0]
    return judged(run, run.t + run.jitter, ts)


def filtered_rounded(run: Run) -> CommonNoise:
    """Judge the same, rounded to a hundredth of a degree."""
    phi = math.exp(-1.0 / run.rs_hz / run.rng.uniform(1.0, 5.0))
    ts = lfilter([1.0 - phi], [1.0, -phi], run.rs - run.rs[0]) + run.rs[0]
    return judged(run, run.t + run.jitter, rounded(ts, 0.01))


def noisy_copy(run: Run) -> CommonNoise:
    """Judge a copy with noise of its own, half that of the RS."""
    ts = run.rs + 0.5 * run.sigma * run.rng.standard_normal(run.t.size)
    return judged(run, run.t + run.jitter, ts)


def faster_copy(run: Run) -> CommonNoise:
    """Judge an interpolated copy sent five times as often, a second late."""
    t = np.arange(run.t[0], run.t[-1], 0.2 / run.rs_hz)
    return judged(run, t + 0.37, np.interp(t, run.t + run.jitter, run.rs))


def held_copy(run: Run) -> CommonNoise:
    """Judge a copy whose value is repeated five times."""
    t = np.arange(run.t.size * 5) / (5.0 * run.rs_hz)
    return judged(run, t, np.repeat(run.rs, 5))


def independent(run: Run, ts_noise: float | None = None) -> CommonNoise:
    """Judge a TS of its own: its rate, noise, rounding, skew and filter drawn at random."""
    rng = run.rng
    ratio = rng.choice([0.5, 1.0, 1.0, 2.0, 5.0])
    hz = min(100.0, run.rs_hz * ratio * rng.choice([1.0, 1.003]))
    t = np.arange(round(run.t[-1] * hz)) / hz + rng.uniform(0.0, 0.3)
    skew = rng.choice([0.0, 0.0, rng.uniform(-2.0, 2.0)])
    sigma = rng.choice([0.0, 0.01, 0.05, 0.2]) if ts_noise is None else ts_noise
    tau = rng.choice([0.0, 1.0, 60.0]) * hz
    ts = run.heading(t - skew) + sigma * coloured(rng, t.size, tau)
    return judged(run, t, rounded(ts, rng.choice([0.0, 0.01, 0.1])))


def perfect(run: Run) -> CommonNoise:
    """Judge a TS that follows the motion exactly, with the stamps of the RS."""
    return judged(run, run.t + run.jitter, run.true)


def perfect_rounded(run: Run) -> CommonNoise:
    """Judge one that does and rounds like the RS."""
    return judged(run, run.t + run.jitter, rounded(run.true, 0.01))


ROWS: dict[str, tuple[Callable[[Run], CommonNoise], dict]] = {
    'copy, white': (exact, {'tau_s': None}),
    'copy, AR(1) 0.5 s': (exact, {'tau_s': 0.5}),
    'copy, AR(1) 60 s': (exact, {'tau_s': 60.0}),
    'delayed copy': (delayed, {'tau_s': None}),
    'requantised copy': (requantised, {'tau_s': None}),
    'filtered copy': (filtered, {'tau_s': None}),
    'filtered copy, 0.01 deg': (filtered_rounded, {'tau_s': None}),
    'copy with half the noise': (noisy_copy, {'tau_s': None}),
    'faster copy': (faster_copy, {'tau_s': None}),
    'held copy': (held_copy, {'tau_s': None}),
    'independent, white RS': (independent, {'tau_s': None}),
    'independent, AR(1) 1 s': (independent, {'tau_s': 1.0}),
    'independent, AR(1) 60 s': (independent, {'tau_s': 60.0}),
    'independent, RS without noise': (independent, {'tau_s': None, 'noisy': False}),
    'independent, perfect TS': (perfect, {'tau_s': None}),
    'independent, two perfect': (perfect, {'tau_s': None, 'noisy': False}),
    'independent, two perfect, rounded': (perfect_rounded, {'tau_s': None, 'noisy': False}),
}


def main(arguments: list[str]) -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.split('\n\n')[0])
    parser.add_argument('--runs', type=int, default=200)
    parser.add_argument('--rows', default='', help='regular expression of the rows wanted')
    parser.add_argument('--seed', type=int, default=0)
    options = parser.parse_args(arguments)
    print(f'{"TS":34s} {"testable":>8s} {"common":>8s} {"q05":>6s} {"q50":>6s} {"q95":>6s} '
          f'{"max":>6s}')
    for number, (name, (kind, how)) in enumerate(ROWS.items()):
        if not re.search(options.rows, name):
            continue
        found = [kind(drawn(options.seed + 100_000 * number + k, **how))
                 for k in range(options.runs)]
        tested = [f for f in found if f.kind != 'not_testable']
        values = [f.coherence for f in tested] or [math.nan]
        common = sum(f.kind == 'common' for f in tested)
        q = np.quantile(values, [0.05, 0.5, 0.95, 1.0])
        print(f'{name:34s} {len(tested) / len(found):8.3f} '
              f'{common / len(tested) if tested else math.nan:8.4f} '
              + ' '.join(f'{v:6.3f}' for v in q), flush=True)
    return 0


if __name__ == '__main__':
    sys.exit(main(sys.argv[1:]))
