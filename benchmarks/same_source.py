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
Measure how often one source is found, and how often two sensors are mistaken for one.

Every row is one kind of TS; the motion, the rate, the length and the noise of the RS are drawn
at random. Runs are paired and tested as in the product. "testable" counts the runs in which the
RS shows its own noise or glitches, "common" those of them in which one source is found, by its
"noise" and by its "glitches". "doubt" counts the runs that share a part of their noise, or are not
testable but differ only by rounding. The last columns show the larger coherence. Nominal are 0.95
of the testable runs for copies, and 0.001 for independent sensors.

    python benchmarks/same_source.py --runs 300
    python benchmarks/same_source.py --rows independent --runs 2000
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass, replace
import math
import re
import sys
from typing import Callable

import history
import numpy as np
from scipy.interpolate import CubicSpline
from scipy.signal import lfilter

from heading_intercompare.core.conditions.one_source import find_one_source, OneSource
from heading_intercompare.core.declared_settings import from_mapping
from heading_intercompare.core.pairing.difference import subtract
from heading_intercompare.core.pairing.pairer import pair
from heading_intercompare.core.records import Headings
from heading_intercompare.core.runs.run_series import RunSeries
from heading_intercompare.core.settings import Settings

Motion = Callable[[np.ndarray], np.ndarray]


def seaway(rng: np.random.Generator, span_s: float) -> Motion:
    """Return the yaw in a sea whose spectrum falls as f^-5; the yaw's falls as f^-9."""
    step = 0.125
    n = 1 << math.ceil(math.log2((span_s + 20.0) / step))
    frequency = np.fft.rfftfreq(n, step)[1:]
    peak = rng.uniform(0.08, 0.17)
    inside = (frequency >= 0.6 * peak) & (frequency <= 6.0 * peak)
    density = np.where(inside, np.exp(-1.25 * (peak / frequency) ** 4)
                       * (frequency / peak) ** -9.0, 0.0)
    lines = np.sqrt(density) * (rng.standard_normal(frequency.size)
                                + 1j * rng.standard_normal(frequency.size))
    yaw = np.fft.irfft(np.concatenate(([0.0], lines)), n)
    yaw *= rng.uniform(0.2, 2.0) / math.sqrt(2.0) / yaw.std()
    return CubicSpline(step * np.arange(n) - 10.0, yaw)


def turn(t: np.ndarray, at_s: float, angle_deg: float, rate_deg_s: float) -> np.ndarray:
    """Return the heading of a turn; a ship takes some seconds to begin and to end it."""
    u = np.clip((t - at_s) / max(abs(angle_deg) / rate_deg_s, 10.0), 0.0, 1.0)
    return angle_deg * (u - np.sin(2.0 * math.pi * u) / (2.0 * math.pi))


def motion(rng: np.random.Generator, span_s: float, kicks: bool = False) -> Motion:
    """Return a heading as a function of time, s: steady, turning, in swell or in a seaway."""
    lines = []
    if rng.random() < 0.8:
        size = rng.uniform(0.2, 3.0)
        for _ in range(rng.integers(1, 13)):
            lines.append((size / math.sqrt(12.0), rng.uniform(6.0, 12.0)))
    sea = seaway(rng, span_s) if rng.random() < 0.3 else None
    if rng.random() < 0.5:
        lines.append((rng.uniform(0.1, 2.0), rng.uniform(60.0, 900.0)))
    lines = [(a, p, rng.uniform(0.0, 2.0 * math.pi)) for a, p in lines]
    turns = [(rng.uniform(0.0, span_s), rng.uniform(-150.0, 150.0), rng.choice([0.2, 1.0, 3.0]))
             for _ in range(rng.integers(0, 8) if rng.random() < 0.6 else 0)]
    start = rng.uniform(0.0, 360.0)
    blows = [(rng.uniform(0.0, span_s), rng.uniform(-1.4, 1.4))
             for _ in range(rng.integers(4, 40) if kicks else 0)]

    def heading(t: np.ndarray) -> np.ndarray:
        found = np.full(t.shape, start) if sea is None else start + sea(t)
        for size, period, phase in lines:
            found += size * np.sin(2.0 * math.pi * t / period + phase)
        for at, angle, rate in turns:
            found += turn(t, at, angle, rate)
        for at, angle in blows:
            # There and back in 1.2 s: up to 19 deg/s^2.
            u = np.clip((t - at) / 1.2, 0.0, 1.0)
            found += 0.5 * angle * (1.0 - np.cos(2.0 * np.pi * u))
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
    """Return values rounded to a step; unchanged for 0."""
    return np.round(values / step) * step if step else values


@dataclass(frozen=True, slots=True)
class Run:
    """The common input of all kinds of TS."""

    rng: np.random.Generator
    t: np.ndarray
    rs_hz: float
    sigma: float
    heading: Motion
    true: np.ndarray
    rs: np.ndarray
    jitter: np.ndarray
    settings: Settings


def glitches(rng: np.random.Generator, t: np.ndarray) -> np.ndarray:
    """Return glitches of one to three readings each, 2 to 12 per hour and at least four."""
    found = np.zeros(t.size)
    count = max(4, rng.poisson(rng.uniform(2, 12) * t[-1] / 3600))
    for at in rng.integers(20, t.size - 20, count):
        found[at:at + rng.integers(1, 4)] = rng.choice([-1.0, 1.0]) * rng.uniform(0.5, 8.0)
    return found


def draw_run(seed: int, tau_s: float | None, noisy: bool = True, *, spoilt: bool = False,
             kicks: bool = False, method: str = 'auto') -> Run:
    """
    Return a run of 20 min to 2 h; the RS is sampled at 1 to 10 Hz, in one of ten at 50 Hz.

    The RS has glitches if it is spoilt. Kicks are yaws of a small craft, there and back in 1.2 s.

    """
    rng = np.random.default_rng(seed)
    rs_hz = float(rng.choice([1.0, 2.0, 5.0, 10.0, 50.0], p=[0.3, 0.15, 0.2, 0.25, 0.1]))
    if kicks:
        # Slower readings alias them: no spectrum can tell them from noise.
        rs_hz = max(rs_hz, 10.0)
    span = float(rng.choice([1200.0, 3600.0, 7200.0]) if rs_hz < 20.0 else 1200.0)
    t = np.arange(round(span * rs_hz)) / rs_hz
    sigma = rng.choice([0.02, 0.05, 0.1, 0.2]) if noisy else 0.0
    jitter = rng.choice([0.0, 0.02]) / rs_hz * rng.standard_normal(t.size)
    heading = motion(rng, span, kicks)
    true = heading(t + jitter)
    tau = 0.0 if tau_s is None else tau_s * rs_hz
    rs = true + sigma * coloured(rng, t.size, tau)
    if spoilt:
        rs = rs + glitches(rng, t)
    return Run(rng, t, rs_hz, sigma, heading, true, rounded(rs, rng.choice([0.0, 0.01])), jitter,
               from_mapping(Settings, {'pairing': {'method': method}}))


def stamps(t: np.ndarray) -> np.ndarray:
    """Return stamps in nanoseconds."""
    return np.rint((t + 1000.0) * 1e9).astype(np.int64)


def judge(run: Run, ts_t: np.ndarray, ts: np.ndarray) -> OneSource:
    """Test a TS just as the judge of a run does."""
    pairs, _ = pair(Headings.as_sent(stamps(ts_t), ts % 360.0),
                    Headings.as_sent(stamps(run.t + run.jitter), run.rs % 360.0), run.settings)
    taken = RunSeries(0, run.settings)
    taken.update(pairs, subtract(pairs))
    return find_one_source(taken.stamp_ns.values, taken.x_deg.values, taken.rs_deg.values,
                           factor=taken.factor.values, interpolates_ts=taken.interpolates_ts)


def exact(run: Run) -> OneSource:
    """Judge a copy."""
    return judge(run, run.t + run.jitter, run.rs)


def delayed(run: Run) -> OneSource:
    """Judge a copy that is up to three seconds late."""
    return judge(run, run.t + run.jitter + run.rng.uniform(0.0, 3.0), run.rs)


def requantised(run: Run) -> OneSource:
    """Judge a copy rounded to at most twice the noise."""
    step = max(s for s in (0.01, 0.02, 0.05, 0.1, 0.2) if s <= max(0.01, 2.0 * run.sigma))
    return judge(run, run.t + run.jitter, rounded(run.rs, step))


def filtered(run: Run) -> OneSource:
    """Judge a copy through a first-order filter of 1 to 5 s."""
    phi = math.exp(-1.0 / run.rs_hz / run.rng.uniform(1.0, 5.0))
    ts = lfilter([1.0 - phi], [1.0, -phi], run.rs - run.rs[0]) + run.rs[0]
    return judge(run, run.t + run.jitter, ts)


def filtered_rounded(run: Run) -> OneSource:
    """Judge the same, rounded to a hundredth of a degree."""
    phi = math.exp(-1.0 / run.rs_hz / run.rng.uniform(1.0, 5.0))
    ts = lfilter([1.0 - phi], [1.0, -phi], run.rs - run.rs[0]) + run.rs[0]
    return judge(run, run.t + run.jitter, rounded(ts, 0.01))


def noisy_copy(run: Run) -> OneSource:
    """Judge a copy with its own noise, half that of the RS."""
    ts = run.rs + 0.5 * run.sigma * run.rng.standard_normal(run.t.size)
    return judge(run, run.t + run.jitter, ts)


def repeater(run: Run) -> OneSource:
    """Judge a TS with slow errors and some noise, which the RS repeats with noise of its own."""
    rng, n = run.rng, run.t.size
    ts = run.true + 0.3 * coloured(rng, n, 120.0 * run.rs_hz)
    ts += rng.choice([0.3, 0.5, 1.0]) * run.sigma * rng.standard_normal(n)
    rs = rounded(ts + run.sigma * rng.standard_normal(n), rng.choice([0.0, 0.01]))
    return judge(replace(run, rs=rs), run.t + run.jitter, rounded(ts, rng.choice([0.0, 0.01])))


def faster_copy(run: Run) -> OneSource:
    """Judge an interpolated copy sent five times as often, 0.37 s late."""
    t = np.arange(run.t[0], run.t[-1], 0.2 / run.rs_hz)
    return judge(run, t + 0.37, np.interp(t, run.t + run.jitter, run.rs))


def held_copy(run: Run) -> OneSource:
    """Judge a copy whose value is repeated five times."""
    t = np.arange(run.t.size * 5) / (5.0 * run.rs_hz)
    return judge(run, t, np.repeat(run.rs, 5))


def independent(run: Run, ts_noise: float | None = None) -> OneSource:
    """Judge an independent TS: its rate, noise, rounding and skew are drawn at random."""
    rng = run.rng
    ratio = rng.choice([0.5, 1.0, 1.0, 2.0, 5.0])
    hz = min(100.0, run.rs_hz * ratio * rng.choice([1.0, 1.003]))
    t = np.arange(round(run.t[-1] * hz)) / hz + rng.uniform(0.0, 0.3)
    skew = rng.choice([0.0, 0.0, rng.uniform(-2.0, 2.0)])
    sigma = rng.choice([0.0, 0.01, 0.05, 0.2]) if ts_noise is None else ts_noise
    tau = rng.choice([0.0, 1.0, 60.0]) * hz
    ts = run.heading(t - skew) + sigma * coloured(rng, t.size, tau)
    return judge(run, t, rounded(ts, rng.choice([0.0, 0.01, 0.1])))


def perfect(run: Run) -> OneSource:
    """Judge a TS that follows the motion exactly, with the stamps of the RS."""
    return judge(run, run.t + run.jitter, run.true)


def perfect_rounded(run: Run) -> OneSource:
    """Judge a TS that follows the motion exactly and rounds like the RS."""
    return judge(run, run.t + run.jitter, rounded(run.true, 0.01))


def spoilt(run: Run) -> OneSource:
    """Judge an independent TS with its own glitches."""
    noise = run.rng.choice([0.0, 0.01, 0.05]) * run.rng.standard_normal(run.t.size)
    ts = run.heading(run.t) + noise + glitches(run.rng, run.t)
    return judge(run, run.t, rounded(ts, 0.01))


def perfect_spoilt(run: Run) -> OneSource:
    """Judge a TS whose only errors are its own glitches."""
    return judge(run, run.t + run.jitter, run.true + glitches(run.rng, run.t))


SPOILT = {'tau_s': None, 'noisy': False, 'spoilt': True}
KICKED = {'tau_s': None, 'noisy': False, 'kicks': True}

ROWS: dict[str, tuple[Callable[[Run], OneSource], dict]] = {
    'copy, white': (exact, {'tau_s': None}),
    'copy, AR(1) 0.5 s': (exact, {'tau_s': 0.5}),
    'copy, AR(1) 60 s': (exact, {'tau_s': 60.0}),
    'delayed copy': (delayed, {'tau_s': None}),
    'requantised copy': (requantised, {'tau_s': None}),
    'filtered copy': (filtered, {'tau_s': None}),
    'filtered copy, 0.01 deg': (filtered_rounded, {'tau_s': None}),
    'copy with half the noise': (noisy_copy, {'tau_s': None}),
    'noisy repeater as RS': (repeater, {'tau_s': None}),
    'faster copy': (faster_copy, {'tau_s': None}),
    'held copy': (held_copy, {'tau_s': None}),
    'independent, white RS': (independent, {'tau_s': None}),
    'independent, AR(1) 1 s': (independent, {'tau_s': 1.0}),
    'independent, AR(1) 60 s': (independent, {'tau_s': 60.0}),
    'independent, RS without noise': (independent, {'tau_s': None, 'noisy': False}),
    'independent, perfect TS': (perfect, {'tau_s': None}),
    'independent, two perfect': (perfect, {'tau_s': None, 'noisy': False}),
    'independent, two perfect, rounded': (perfect_rounded, {'tau_s': None, 'noisy': False}),
    'glitches, copy': (exact, SPOILT),
    'glitches, delayed copy': (delayed, SPOILT),
    'glitches, requantised copy': (requantised, SPOILT),
    'glitches, filtered copy': (filtered, SPOILT),
    'glitches, filtered copy, 0.01 deg': (filtered_rounded, SPOILT),
    'independent, glitches of the RS': (independent, SPOILT),
    'independent, glitches of both': (spoilt, SPOILT),
    'independent, two perfect, glitches': (perfect_spoilt, SPOILT),
    'independent, kicks': (independent, {'tau_s': None, 'kicks': True}),
    'independent, two perfect, kicks': (perfect, KICKED),
    'independent, two rounded, kicks': (perfect_rounded, KICKED),
    'interpolated RS, faster copy': (faster_copy, {'tau_s': None, 'method': 'interpolate'}),
    'independent, interpolated RS': (independent, {'tau_s': None, 'method': 'interpolate'}),
    'independent, interpolated, AR(1) 1 s': (independent, {'tau_s': 1.0, 'method': 'interpolate'}),
}


def main(arguments: list[str]) -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.split('\n\n')[0])
    parser.add_argument('--runs', type=int, default=200)
    parser.add_argument('--rows', default='', help='regular expression for the rows to measure')
    parser.add_argument('--seed', type=int, default=0)
    history.add_option(parser)
    options = parser.parse_args(arguments)
    figures = {}
    print(f'{"TS":36s} {"runs":>5s} {"testable":>8s} {"common":>6s} {"noise":>5s} '
          f'{"glitch":>6s} {"doubt":>5s} {"q50":>6s} {"max":>6s}')
    for number, (name, (kind, how)) in enumerate(ROWS.items()):
        if not re.search(options.rows, name):
            continue
        found = [kind(draw_run(options.seed + 100_000 * number + k, **how))
                 for k in range(options.runs)]
        kinds = [f.kind for f in found]
        values = [f.noise.strongest.coherence for f in found
                  if f.noise.strongest.coherence is not None]
        print(f'{name:36s} {len(found):5d} '
              f'{kinds.count("common") + kinds.count("independent"):8d} '
              f'{kinds.count("common"):6d} '
              f'{sum(f.noise.kind == "common" for f in found):5d} '
              f'{sum(f.glitches.kind == "common" for f in found):6d} '
              f'{kinds.count("suspected") + kinds.count("unsure"):5d} '
              f'{np.median(values) if values else math.nan:6.3f} '
              f'{max(values, default=math.nan):6.3f}', flush=True)
        figures[f'{name}: found'] = kinds.count('common') / len(kinds)
    if options.keep:
        history.keep('same_source', figures)
    return 0


if __name__ == '__main__':
    sys.exit(main(sys.argv[1:]))
