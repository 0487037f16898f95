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
Measure how often a test of a norm is not met; prints the table of docs/risk.md.

Each row is one error alone, at half of its limit, at its limit, and at 1.5 and 2 times that. A
trial is judged as a whole by the product: two hours of legs in a swell, or three starts
alongside. The figure is the share of the trials in which the test of this error is not met. The
last column counts the trials in which any other test is not met.

    python benchmarks/norm_tests.py
    python benchmarks/norm_tests.py --tests rms_of_ten --trials 200 --jobs 1

The exit code is 1 if another test is ever not met, or if a test is not met more often than its
share of the producer's risk allows, by two standard errors, at half of its limit or at its limit.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from functools import partial
import math
from multiprocessing import get_context
from pathlib import Path
import sys
from typing import Any, Callable, Iterator, Mapping

import history

from heading_intercompare import analyze, Headings, Settings
from heading_intercompare.core.norm_tests.judged_test import NOT_MET

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / 'test'))

from sailed_trials import lie_alongside, sail  # noqa: E402

TIMES = (0.5, 1.0, 1.5, 2.0)
"""Errors as multiples of their limit."""

RISK = 0.05
"""The producer's risk, which the tests and runs of a norm share."""

_TURN_DEG_S = 3.0
_AMPLITUDE_DEG, _BAND_DEG = 40.0, 0.7
_SAILED = ('static_error 1.0; resolution 0.2; dynamic_error 1.5; fast_dynamic_error 0.5; '
           'follow_up 0.5 0-3')
_ALONGSIDE = 'settling_time 6; settle_point 0.75; rms_of_ten 0.25; repeatability 0.25'

Trial = Callable[..., tuple[Headings, Headings]]


@dataclass(frozen=True, slots=True)
class Case:
    """A trial, the tests of its norm, and its errors at a multiple of the limit."""

    trial: Trial
    tests: str
    sigma_max_deg: float
    runs: int
    errors: Callable[[float], Mapping[str, Any]]

    @property
    def risk(self) -> float:
        """Return the risk of one test."""
        return RISK / (len(self.tests.split(';')) * self.runs)


_sailed = partial(Case, partial(sail, hours=1.5, turn_deg_s=_TURN_DEG_S), _SAILED, 6.0, 1)
_alongside = partial(Case, lie_alongside, _ALONGSIDE, 1.0, 3)


def slow_down(third_h: float) -> Mapping[str, Any]:
    """Return one start whose settling error falls by the band in the hour before a time."""
    first_h = third_h - 1.0
    lo_s, hi_s = 600.0, 36000.0
    for _ in range(60):
        tau_s = 0.5 * (lo_s + hi_s)
        settled_s = tau_s * math.log(-_AMPLITUDE_DEG * math.expm1(-3600.0 / tau_s) / _BAND_DEG)
        lo_s, hi_s = (tau_s, hi_s) if settled_s < 3600.0 * first_h else (lo_s, tau_s)
    return {'points_deg': (0.1,), 'hours': third_h + 2.0, 'tau_s': tau_s, 'noise_deg': 0.01,
            'amplitude_deg': _AMPLITUDE_DEG}


CASES: Mapping[str, Case] = {
    'static_error': _sailed(lambda times: {'static_deg': 1.0 * times}),
    'resolution': _sailed(lambda times: {'step_deg': 0.4 * times}),
    'dynamic_error': _sailed(lambda times: {
        'dynamic_deg': 1.5 * times, 'period_s': 60.0, 'noise_deg': 0.03}),
    'fast_dynamic_error': _sailed(lambda times: {
        'dynamic_deg': 0.5 * times, 'noise_deg': 0.03}),
    'follow_up': _sailed(lambda times: {'lag_s': 0.5 / _TURN_DEG_S * times}),
    'settling_time': Case(lie_alongside, _ALONGSIDE, 1.0, 1,
                          lambda times: slow_down(6.0 * times)),
    'settle_point': _alongside(lambda times: {'points_deg': (0.75 * times,) * 3}),
    'rms_of_ten': _alongside(lambda times: {'noise_deg': 0.25 * times}),
    'repeatability': _alongside(lambda times: {
        'points_deg': (-0.125 * times, 0.0, 0.125 * times)}),
}
"""The errors by the test that must find each."""


def judge(task: tuple[str, float, int]) -> tuple[bool, bool]:
    """Tell whether the test of a case, and whether any other, is not met in one trial."""
    kind, times, seed = task
    case = CASES[kind]
    ts, rs = case.trial(seed=seed, **case.errors(times))
    verdict = analyze(ts, rs, Settings.of(
        sigma_max_deg=case.sigma_max_deg, sigma_ref_max_deg=0.1, tests=case.tests,
        stabilization_s='auto' if case.trial is lie_alongside else 0.0))
    broken = {row.kind for row in verdict.campaign.norm_tests or () if row.state == NOT_MET}
    return kind in broken, bool(broken - {kind})


def judge_all(tasks: list[tuple[str, float, int]], jobs: int) -> Iterator[tuple[bool, bool]]:
    """Yield the trials in order, judged in several processes."""
    if jobs == 1:
        yield from map(judge, tasks)
        return
    with get_context('spawn').Pool(jobs) as pool:
        yield from pool.imap(judge, tasks, chunksize=4)


def is_too_often(broken: int, trials: int, risk: float) -> bool:
    """Tell whether a test is not met significantly more often than its risk."""
    return broken > trials * risk + 2.0 * math.sqrt(trials * risk * (1.0 - risk))


def main(arguments: list[str]) -> int:
    """Print the table; the exit code is 1 if a row fails."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument('--tests', nargs='+', default=list(CASES), choices=CASES)
    parser.add_argument('--trials', type=int, default=100, help='trials of each cell')
    parser.add_argument('--seed', type=int, default=1, help='that of the first trial')
    parser.add_argument('--jobs', type=int, default=2, help='processes')
    history.add_option(parser)
    options = parser.parse_args(arguments)
    print('| test | risk of the test | half of the limit | at the limit | 1.5 times | twice '
          '| another test |\n|---|---|---|---|---|---|---|', flush=True)
    failed, figures = False, {}
    seeds = range(options.seed, options.seed + options.trials)
    for kind in options.tests:
        tasks = [(kind, times, seed) for times in TIMES for seed in seeds]
        results = list(judge_all(tasks, options.jobs))
        counts = [sum(broken for broken, _ in results[k * len(seeds):(k + 1) * len(seeds)])
                  for k in range(len(TIMES))]
        others, risk = sum(other for _, other in results), CASES[kind].risk
        failed |= others > 0 or any(is_too_often(n, len(seeds), risk) for n in counts[:2])
        figures |= {f'{kind}: found at {times:g} times the limit': n / len(seeds)
                    for times, n in zip(TIMES, counts)}
        shares = ' | '.join(f'{n / len(seeds):.2f}' for n in counts)
        print(f'| `{kind}` | {risk:.3g} | {shares} | {others} |', flush=True)
    if options.keep:
        history.keep('norm_tests', figures)
    return int(failed)


if __name__ == '__main__':
    sys.exit(main(sys.argv[1:]))
