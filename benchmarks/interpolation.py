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
Measure the effect of interpolation on the decision, one table of outcomes.

A ship moves as 40 sines around one frequency, with a spread of 15 %, swings slowly and turns. The
errors of both sensors are white unless a row says otherwise, the RS at 0.7 of its norm; norms 0.2
and 0.1 deg, m_low 0.5. Each row has a TS at some shares of its norm, and counts the runs that are
non-compliant (N), void for the interpolation (V), indeterminate (I) and compliant (C), with the
band-limited kernel and with the line.

Rows with a polled sensor hold each of its values until the next one, as a logger of a fixed rate
writes them. They count whole verdicts, with decisions in doubt as void: the delay of the logger is
a skew, which the verdict names.

A row fails if a TS up to its norm is N, or one at its norm is C, in too many runs.

    python benchmarks/interpolation.py --replications 100
    python benchmarks/interpolation.py --replications 20 --rows 'craft 6 s'
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass
import math
import sys
from types import SimpleNamespace
from typing import Iterator

import history
import numpy as np
from scipy.signal import lfilter

from heading_intercompare import analyze, Compliance, Headings, pair, Settings
from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.record_conditions.interpolation import judge_interpolation
from heading_intercompare.core.timing.interpolation_error import estimate_interpolation_error
from heading_intercompare.core.validity.condition import is_doubtful, VOID
from heading_intercompare.core.validity.examined import RunAccount

NORM_DEG, REF_DEG, M_LOW, RS_SHARE = 0.2, 0.1, 0.5, 0.7
SINES, SPREAD, SLOW_S, TURNING_S = 40, 0.15, 120.0, 900.0
T0_NS = 1_700_000_000_000_000_000
SHARES = (0.5, 0.85, 1.0, 1.3)
#: Standard deviation of the motion, degrees, and its period, seconds.
SHIPS = {'merchant 8 s': (1.0, 8.0), 'merchant 10 s': (0.7, 10.0), 'craft 5 s': (2.0, 5.0),
         'craft 6 s': (2.0, 6.0), 'yacht': (3.0, 4.2), 'boat': (3.0, 3.0), 'moored': (0.1, 20.0),
         'slow 7 s': (3.0, 7.0)}


@dataclass(frozen=True)
class Row:
    """A row of the table: the ship, the rates of TS and RS, and what is special."""

    ship: str
    ts_hz: float
    rs_hz: float
    span_s: float = 1500.0
    phase: float | None = 0.5  # None: any
    missing: float = 0.0
    both_missing: bool = False
    jitter: float = 0.0
    tau_s: float = 0.0
    average_s: float = 0.0
    #: Rates at which a logger polls TS and RS, so that each value stands; 0 for their own rates.
    polled_hz: tuple[float, float] = (0.0, 0.0)
    shares: tuple[float, ...] = SHARES

    @property
    def name(self) -> str:
        """Return the row in words."""
        words = f'{self.ship}, {self.ts_hz:g}:{self.rs_hz:g} Hz'
        if self.phase == 0.0:
            words += ', equal stamps'
        if self.span_s != 1500.0:
            words += f', {self.span_s / 3600.0:g} h'
        if self.tau_s:
            words += f', errors AR(1) {self.tau_s:g} s'
        if self.jitter:
            words += f', stamps +-{100.0 * self.jitter:g} %'
        if self.missing:
            words += f', {100.0 * self.missing:g} % of {"both" if self.both_missing else "the RS"}'
            words += ' missing'
        if self.average_s:
            words += f', TS averages over {self.average_s:g} s'
        for sensor, rate_hz in zip(('TS', 'RS'), self.polled_hz):
            words += f', {sensor} polled at {rate_hz:g} Hz' if rate_hz else ''
        return words


ROWS = (
    Row('craft 6 s', 1.0, 1.0), Row('craft 6 s', 1.0, 1.0, tau_s=5.0),
    Row('craft 6 s', 1.0, 1.0, missing=0.1, phase=None),
    Row('craft 6 s', 1.25, 1.0), Row('craft 6 s', 5.0, 1.0, phase=None),
    Row('craft 6 s', 10.0, 1.0, phase=None), Row('craft 6 s', 1.0, 5.0, phase=None),
    Row('craft 5 s', 1.0, 1.0), Row('yacht', 1.0, 1.0),
    Row('yacht', 1.0, 1.0, jitter=0.2, missing=0.05, both_missing=True, phase=None),
    Row('yacht', 2.0, 1.0, phase=None), Row('yacht', 2.0, 2.0), Row('yacht', 5.0, 5.0),
    Row('craft 6 s', 10.0, 10.0, missing=0.06, both_missing=True, phase=None),
    Row('craft 6 s', 10.0, 10.0, jitter=0.45, phase=None),
    Row('merchant 8 s', 1.0, 1.0), Row('merchant 10 s', 0.5, 0.5),
    Row('merchant 10 s', 5.0, 0.2, span_s=7200.0, phase=None),
    Row('boat', 1.0, 1.0), Row('craft 6 s', 0.5, 0.5), Row('merchant 8 s', 0.2, 0.2),
    Row('moored', 0.2, 0.2, span_s=7200.0),
    Row('slow 7 s', 1.0, 1.0, phase=0.0, missing=0.05),
    Row('slow 7 s', 1.0, 1.0, phase=0.0, missing=0.2),
    Row('craft 6 s', 1.0, 1.0, average_s=1.5, shares=(0.3,)),
    Row('craft 6 s', 1.0, 1.0, average_s=2.0, shares=(0.3,)),
    Row('yacht', 2.0, 2.0, average_s=1.0, shares=(0.3,)),
    Row('merchant 8 s', 1.0, 1.0, average_s=2.5, shares=(0.3,)),
    Row('merchant 10 s', 5.0, 1.0, phase=None, polled_hz=(0.0, 5.0)),
    Row('merchant 10 s', 10.0, 1.0, phase=None, polled_hz=(0.0, 10.0)),
    Row('merchant 10 s', 10.0, 1.0, phase=None, tau_s=5.0, polled_hz=(0.0, 10.0)),
    Row('merchant 10 s', 10.0, 1.0, phase=None, polled_hz=(0.0, 7.3)),
    Row('merchant 10 s', 1.0, 10.0, phase=None, polled_hz=(10.0, 0.0)),
    Row('merchant 10 s', 1.0, 1.0, phase=None, polled_hz=(10.0, 10.0)),
    Row('merchant 10 s', 5.0, 1.0, phase=None, polled_hz=(0.0, 2.5)),
    Row('craft 6 s', 10.0, 1.0, phase=None, polled_hz=(0.0, 10.0)),
    Row('craft 6 s', 10.0, 1.0, phase=None, polled_hz=(0.0, 7.3)),
)


class Ship:
    """The heading of a ship at any time, and its mean over a time around it."""

    def __init__(self, name: str, rng: np.random.Generator) -> None:
        sd_deg, period_s = SHIPS[name]
        self._w = 2.0 * math.pi / period_s * (1.0 + SPREAD * rng.standard_normal(SINES))
        self._phase = rng.uniform(0.0, 2.0 * math.pi, SINES)
        self._amplitude_deg = sd_deg * math.sqrt(2.0 / SINES)
        self._slow = rng.uniform(0.0, 2.0 * math.pi, 2)

    def heading(self, t_s: np.ndarray, average_s: float = 0.0) -> np.ndarray:
        """Return headings, averaged over a time centred on each stamp."""
        result = 100.0 + 3.0 * np.sin(2.0 * np.pi * t_s / SLOW_S + self._slow[0]) \
            + 40.0 * np.sin(2.0 * np.pi * t_s / TURNING_S + self._slow[1])
        for w, phase in zip(self._w, self._phase):
            gain = np.sinc(0.5 * w * average_s / np.pi)
            result += gain * self._amplitude_deg * np.sin(w * t_s + phase)
        return result


def errors(n: int, step_s: float, tau_s: float, rng: np.random.Generator) -> np.ndarray:
    """Return normal errors of variance 1, white or AR(1)."""
    if not tau_s:
        return rng.standard_normal(n)
    phi = math.exp(-step_s / tau_s)
    steps = rng.standard_normal(n) * math.sqrt(1.0 - phi * phi)
    return lfilter([1.0], [1.0, -phi], steps, zi=[phi * rng.standard_normal()])[0]


def headings(t_s: np.ndarray, heading_deg: np.ndarray) -> Headings:
    """Return readings as a sensor reports them."""
    return Headings.of(T0_NS + np.rint(t_s * 1e9).astype(np.int64), heading_deg % 360.0)


def readings(row: Row, share: float, rng: np.random.Generator) -> Iterator[Headings]:
    """Yield the readings of the TS and of the RS."""
    ship = Ship(row.ship, rng)
    phase = rng.uniform() if row.phase is None else row.phase
    for is_rs, rate_hz in enumerate((row.ts_hz, row.rs_hz)):
        step_s = 1.0 / rate_hz
        place = np.arange(0.0, row.span_s * rate_hz) + (phase if is_rs else 0.0)
        place += row.jitter * rng.uniform(-1.0, 1.0, place.size)
        t_s = place * step_s
        heading = ship.heading(t_s, 0.0 if is_rs else row.average_s)
        sd_deg = RS_SHARE * REF_DEG if is_rs else share * NORM_DEG
        heading += sd_deg * errors(t_s.size, step_s, row.tau_s, rng)
        kept = np.ones(t_s.size, bool)
        if is_rs or row.both_missing:
            kept = rng.uniform(size=t_s.size) >= row.missing
        if row.polled_hz[is_rs]:
            yield poll(t_s[kept], heading[kept], row.polled_hz[is_rs], rng)
        else:
            yield headings(t_s[kept], heading[kept])


def poll(t_s: np.ndarray, heading_deg: np.ndarray, rate_hz: float,
         rng: np.random.Generator) -> Headings:
    """Return what a logger writes that polls a sensor: the newest value, with its own stamps."""
    polled_s = t_s[0] + (rng.uniform() + np.arange((t_s[-1] - t_s[0]) * rate_hz)) / rate_hz
    newest = np.searchsorted(t_s, polled_s, 'right') - 1
    return headings(polled_s, np.round(heading_deg[newest], 3))


def decide(ts: Headings, rs: Headings, settings: Settings) -> tuple[str, float, float]:
    """Return the letter of the outcome, the standard deviation and the factors' product."""
    pairs, ledger = pair(ts, rs, settings)
    compliance = Compliance(settings)
    compliance.update(pairs)
    found = compliance.run_figures()
    if 'upper_bound_deg2' not in found or found['upper_bound_deg2'] is None:
        return 'I', math.nan, math.nan
    limits = compliance._run.limits(settings.norms, settings.model)
    low, high = found['lower_bound_deg2'], found['upper_bound_deg2']
    outcome = (Outcome.COMPLIANT if high <= limits.tightened_limit_deg2 else
               Outcome.NON_COMPLIANT if low > limits.rejection_limit_deg2 else
               Outcome.INDETERMINATE)
    interpolates_ts = compliance._run.interpolates_ts
    error = estimate_interpolation_error(
        ledger.total.counts, NORM_DEG if interpolates_ts else REF_DEG,
        is_line=settings.pairing.kernel == 'line')
    bounds = SimpleNamespace(lower_bound_deg2=low, upper_bound_deg2=high)
    finding = judge_interpolation(error, RunAccount(outcome, bounds, limits, settings, None, None))
    letter = 'V' if finding.effect == VOID else {
        Outcome.COMPLIANT: 'C', Outcome.NON_COMPLIANT: 'N'}.get(outcome, 'I')
    return letter, found['std_deg'], float(
        (pairs.ts_variance_factor * pairs.rs_variance_factor).mean())


def decide_wholly(ts: Headings, rs: Headings, settings: Settings) -> tuple[str, float, float]:
    """Return the same of the whole verdict, in which a decision in doubt counts as void."""
    verdict = analyze(ts, rs, settings)
    run = verdict.runs[0]
    letter = {Outcome.COMPLIANT: 'C', Outcome.NON_COMPLIANT: 'N'}.get(verdict.outcome, 'I')
    if verdict.validity_effect == VOID or is_doubtful(verdict.outcome, verdict.validity_effect):
        letter = 'V'
    pairing = run.pairing
    return letter, run.std_deg or math.nan, (pairing.ts_variance_factor or 1.0) * (
        pairing.rs_variance_factor or 1.0)


def main() -> int:
    """Print the table; the exit code is 1 if a row of the band-limited kernel fails."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument('--replications', type=int, default=100)
    parser.add_argument('--rows', default='', help='only rows whose name contains this')
    parser.add_argument('--kernels', nargs='+', default=['band_limited', 'line'])
    parser.add_argument('--seed', type=int, default=1)
    history.add_option(parser)
    arguments = parser.parse_args()
    failed, kept = 0, {}
    n = arguments.replications
    print(f'N/V/I/C of {n}, TS at a share of its norm')
    for number, row in enumerate(ROWS):
        if arguments.rows not in row.name:
            continue
        for kernel in arguments.kernels:
            settings = Settings.from_mapping({
                'norms.sigma_max_deg': NORM_DEG, 'norms.sigma_ref_max_deg': REF_DEG,
                'norms.m_low': M_LOW, 'pairing.kernel': kernel})
            cells = []
            for share in row.shares:
                # Each cell has its own seed, so it does not depend on the others.
                rng = np.random.default_rng([arguments.seed, number, round(100 * share)])
                judge = decide_wholly if any(row.polled_hz) else decide
                found = [judge(*readings(row, share, rng), settings) for _ in range(n)]
                count = {letter: sum(one[0] == letter for one in found) for letter in 'NVIC'}
                cells.append(f'{share:g}: ' + '/'.join(map(str, count.values())))
                if kernel == 'band_limited':
                    kept[f'{row.name}, TS at {share:g}: C'] = count['C'] / n
                    bad = share <= 1.0 and not row.average_s and count['N'] > 0.02 * n + 1
                    failed += bad or (share == 1.0 and fails(count['C'] / n, n))
            sd = float(np.mean([one[1] for one in found]))
            factor = float(np.mean([one[2] for one in found]))
            print(f'{row.name:58s} {kernel:12s} ' + '  '.join(cells)
                  + f'   sd {sd:.3f} f {factor:.2f}', flush=True)
    print(f'{failed} cells of the band-limited kernel fail')
    if arguments.keep:
        history.keep('interpolation', kept)
    return 1 if failed else 0


def fails(estimate: float, replications: int) -> bool:
    """Tell whether a rate is above its nominal value."""
    error = math.sqrt(max(estimate * (1.0 - estimate), 1e-12) / replications)
    return estimate - 2.0 * error > 0.05


if __name__ == '__main__':
    sys.exit(main())
