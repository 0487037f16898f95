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
Measure the effect of interpolation on the decision: good sensors rejected, bad ones certified.

Rejection: a ship yaws, and the RS is so slow that its interpolated heading lacks the yaw. The RS
is interpolated to the TS ('interpolate'), or the default is used ('auto').

Acceptance: the TS errors are exactly at the norm, white or AR(1); the RS errors are white and at
the lower bound of their norm; all pairs of rates. The TS is interpolated to the RS stamps without
its variance factor ('unfactored'), with it ('interpolate_ts'), or the default is used ('auto').
Nominal is 0.05. A row fails if its estimate is above 0.06, or two standard errors above 0.05.

    python benchmarks/interpolation.py --replications 400
    python benchmarks/interpolation.py --rates 1 5 --replications 4000
"""

from __future__ import annotations

import argparse
import math
import sys
from typing import Iterator

import history
import numpy as np
from scipy.signal import lfilter

from heading_intercompare import Compliance, Headings, pair, Pairs, Settings

RATES_HZ = (0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0)
NORM_DEG, REF_DEG, M_LOW, TAU_S = 0.2, 0.1, 0.9, 2.0
LEAST_S, LEAST_PAIRS = 200.0, 150
T0_NS = 1_700_000_000_000_000_000
NORMS = {'norms.sigma_max_deg': NORM_DEG, 'norms.sigma_ref_max_deg': REF_DEG,
         'norms.m_low': M_LOW}


def white(n: int, _: float, rng: np.random.Generator) -> np.ndarray:
    """Return uncorrelated normal errors of variance 1."""
    return rng.standard_normal(n)


def ar1(n: int, step_s: float, rng: np.random.Generator) -> np.ndarray:
    """Return normal errors of variance 1 and correlation time `TAU_S`."""
    phi = math.exp(-step_s / TAU_S)
    steps = rng.standard_normal(n) * math.sqrt(1.0 - phi * phi)
    return lfilter([1.0], [1.0, -phi], steps, zi=[phi * rng.standard_normal()])[0]


ERRORS = {'white': white, 'AR(1)': ar1}


def times_s(rate_hz: float, span_s: float, rng: np.random.Generator) -> np.ndarray:
    """Return the times of an independent clock: any phase, and a rate off by up to 1 per mille."""
    step_s = (1.0 + rng.uniform(-1e-3, 1e-3)) / rate_hz
    return np.arange(rng.uniform(0.0, step_s), span_s, step_s)


def headings(t_s: np.ndarray, heading_deg: np.ndarray) -> Headings:
    """Return readings as a sensor reports them."""
    return Headings.of(T0_NS + np.round(t_s * 1e9).astype(np.int64), heading_deg % 360.0)


def figures(pairs: Pairs, settings: Settings) -> dict:
    """Return the figures of a run, including bounds and limits, without diagnostics."""
    compliance = Compliance(settings)
    compliance.update(pairs)
    return compliance.run_figures()


def accepts(found: dict) -> bool:
    """Tell whether the upper bound proves compliance."""
    return found['upper_bound_deg2'] <= found['acceptance_limit_deg2']


def rejects(found: dict) -> bool:
    """Tell whether the lower bound proves non-compliance."""
    return found['lower_bound_deg2'] > found['rejection_limit_deg2']


def rejection(replications: int, rng: np.random.Generator) -> Iterator[str]:
    """Yield rows: how often a sound TS of 10 Hz is rejected."""
    norms = {'norms.sigma_max_deg': 0.15, 'norms.sigma_ref_max_deg': 0.02}
    rules = {method: Settings.from_mapping({**norms, 'pairing.method': method})
             for method in ('interpolate', 'auto')}
    for rs_hz, yaw_deg, period_s, share in ((0.5, 1.0, 8.0, 0.0), (1.0, 2.0, 6.0, 0.7)):
        count = dict.fromkeys(rules, 0)
        for _ in range(replications):
            period = period_s * rng.uniform(0.95, 1.05)
            phase = rng.uniform(0.0, 2.0 * math.pi)
            streams = []
            for rate_hz, sigma_deg in ((10.0, 0.15 * share), (rs_hz, 0.02)):
                t_s = times_s(rate_hz, 600.0, rng)
                yaw = yaw_deg * np.sin(2.0 * math.pi * t_s / period + phase)
                streams.append(headings(t_s, 100.0 + yaw
                                        + sigma_deg * rng.standard_normal(t_s.size)))
            for method, settings in rules.items():
                count[method] += rejects(figures(pair(*streams, settings)[0], settings))
        yield (f'RS {rs_hz:g} Hz, yaw {yaw_deg:g} deg in {period_s:g} s, TS at {share:g} of its '
               'norm: rejected ' + ', '.join(f'{method} {n / replications:.3f}'
                                             for method, n in count.items()))


def acceptance(ts_hz: float, rs_hz: float, errors, replications: int,
               rng: np.random.Generator) -> dict[str, float]:
    """Return how often a TS exactly at its norm is certified, and the mean factor of 'auto'."""
    span_s = max(LEAST_S, LEAST_PAIRS / min(ts_hz, rs_hz))
    rules = {method: Settings.from_mapping({**NORMS, 'pairing.method': method})
             for method in ('interpolate_ts', 'auto')}
    count = dict.fromkeys(('unfactored', 'interpolate_ts', 'auto', 'factor'), 0.0)
    for _ in range(replications):
        t_s = times_s(ts_hz, span_s, rng)
        ts = headings(t_s, 10.0 + NORM_DEG * errors(t_s.size, 1.0 / ts_hz, rng))
        t_s = times_s(rs_hz, span_s, rng)
        rs = headings(t_s, 10.0 + M_LOW * REF_DEG * rng.standard_normal(t_s.size))
        before = None
        for method, settings in rules.items():
            pairs, _ = pair(ts, rs, settings)
            if before is None or pairs != before:
                found = figures(pairs, settings)
            count[method] += accepts(found)
            factor = float(pairs.ts_variance_factor.mean())
            if before is None:
                limit_deg2 = found['acceptance_limit_deg2'] + (1.0 - factor) * NORM_DEG ** 2
                count['unfactored'] += found['upper_bound_deg2'] <= limit_deg2
            before = pairs
        count['factor'] += factor
    return {name: n / replications for name, n in count.items()}


def fails(estimate: float, replications: int) -> bool:
    """Tell whether a rate is above its nominal value."""
    error = math.sqrt(max(estimate * (1.0 - estimate), 1e-12) / replications)
    return estimate > 0.06 or estimate - 2.0 * error > 0.05


def main() -> int:
    """Print the tables; the exit code is 1 if a row of the default fails."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument('--replications', type=int, default=400)
    parser.add_argument('--most', type=int, default=4000,
                        help='replications of a row that would fail with fewer')
    parser.add_argument('--rates', type=float, nargs='+', default=RATES_HZ)
    parser.add_argument('--errors', nargs='+', choices=ERRORS, default=list(ERRORS))
    parser.add_argument('--seed', type=int, default=1)
    history.add_option(parser)
    arguments = parser.parse_args()
    for row in rejection(arguments.replications, np.random.default_rng(arguments.seed)):
        print(row, flush=True)
    failed, figures = 0, {}
    print('errors  TS Hz  RS Hz  unfactored  interpolate_ts  auto   factor      n')
    for name in arguments.errors:
        errors = ERRORS[name]
        for ts_hz in arguments.rates:
            for rs_hz in arguments.rates:
                n = arguments.replications
                # Each row has its own seed, so it does not depend on the other rows requested.
                rng = np.random.default_rng([arguments.seed, list(ERRORS).index(name),
                                             round(10 * ts_hz), round(10 * rs_hz)])
                found = acceptance(ts_hz, rs_hz, errors, n, rng)
                if fails(found['auto'], n) and n < arguments.most:
                    n = arguments.most
                    found = acceptance(ts_hz, rs_hz, errors, n, rng)
                bad = fails(found['auto'], n)
                failed += bad
                figures[f'{name}, {ts_hz:g} / {rs_hz:g} Hz: certified'] = found['auto']
                print(f'{name}   {ts_hz:5g}  {rs_hz:5g}       {found["unfactored"]:.3f}'
                      f'           {found["interpolate_ts"]:.3f}  {found["auto"]:.3f}'
                      f'   {found["factor"]:.3f}  {n:5d}{"  FAILS" if bad else ""}', flush=True)
    print(f'{failed} rows of the default fail')
    if arguments.keep:
        history.keep('interpolation', figures)
    return 1 if failed else 0


if __name__ == '__main__':
    sys.exit(main())
