#!/usr/bin/env python3
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
Judge 240 pairs of sound sensors, and print all that the program holds against them.

The pairs of `sound_ships` are of ten kinds of motion, rates from 0.2 to 100 Hz, errors of all
colours, coarse and quiet sensors, gaps, jitter, marked legs. The TS is at 0.3 to 0.8 of its
norm. A line each tells a run that is void or doubtful, a warning, a sound TS that is rejected,
and a pair without a run.

The second part judges pairs whose TS is just at its norm, and whose RS is at its lower bound.
It prints the share of the runs that are certified, nominally at most 0.05, and each of them.

    python benchmarks/sound_pairs.py                      # 3 minutes with two processes
    python benchmarks/sound_pairs.py --pair 37            # one pair again, with its verdict
    python benchmarks/sound_pairs.py --at-norm --pair 37

The exit code is 1 if a run is void, doubtful or wrongly rejected, or if a pair has no run, or if
significantly more than 0.05 of the runs at the norm are certified.
"""

from __future__ import annotations

import argparse
from collections import Counter
from dataclasses import dataclass
from functools import partial
import math
from multiprocessing import get_context
import sys
from typing import Iterable, Iterator

import history
from sound_ships import draw_pair, SoundPair

from heading_intercompare import Outcome, Verdict
from heading_intercompare.core.pipeline import Intercomparison

_AT_NORM = 10_000
"""Added to the seed for the pairs at the norm, which are others."""
_GOOD = ('holds', 'not_testable')


@dataclass(frozen=True, slots=True)
class Judged:
    """
    What the program said of a pair.

    Attributes
    ----------
    number
        Number of the pair.
    words
        The pair in words.
    outcomes
        Outcome of each run.
    against : tuple of (kind, words)
        What it holds against the pair: 'void', 'doubtful', 'warning', 'rejected', 'no run'.

    """

    number: int
    words: str
    outcomes: tuple[str, ...]
    against: tuple[tuple[str, str], ...]


def judge(pair: SoundPair) -> Verdict:
    """Return the verdict on a pair, by the product."""
    comparison = Intercomparison(pair.settings, table=pair.legs if pair.legs and pair.table
                                 else None)
    if not pair.table:
        for start_ns, stop_ns in pair.legs:
            comparison.mark('start', start_ns)
            comparison.mark('stop', stop_ns)
    if len(pair.motion):
        comparison.take_motion(pair.motion)
    comparison.update(pair.ts, pair.rs)
    comparison.finish()
    return comparison.verdict()


def find_against(verdict: Verdict) -> Iterator[tuple[str, str]]:
    """Yield what a verdict holds against a pair, as in `Judged`."""
    if not verdict.runs:
        yield 'no run', ''
    for run in verdict.runs:
        for finding in run.validity:
            if finding.effect not in _GOOD:
                yield finding.effect, f'{finding.condition}: {finding.words}'
        yield from (('warning', warning) for warning in run.warnings)
        if run.outcome is Outcome.NON_COMPLIANT:
            yield 'rejected', f'{run.reason}, sd {run.std_deg:.3g} deg'


def judge_number(number: int, seed: int, share: float | None) -> Judged:
    """Judge the pair of a number."""
    pair = draw_pair(number, seed, share=share)
    verdict = judge(pair)
    return Judged(number, pair.words, tuple(run.outcome.value for run in verdict.runs),
                  tuple(find_against(verdict)))


def judge_all(numbers: Iterable[int], seed: int, share: float | None,
              jobs: int) -> Iterator[Judged]:
    """Yield the pairs in order, judged in several processes."""
    work = partial(judge_number, seed=seed, share=share)
    if jobs == 1:
        yield from map(work, numbers)
        return
    with get_context('spawn').Pool(jobs) as pool:
        yield from pool.imap(work, numbers, chunksize=2)


def describe(judged: Judged) -> list[str]:
    """Return a line for each thing that is held against a pair."""
    return [f'pair {judged.number}: {kind.upper()} {words} [{judged.words}]'
            for kind, words in judged.against]


def print_sound(found: Iterable[Judged]) -> Counter[str]:
    """Print what is held against sound pairs; return the number of pairs by kind."""
    counts: Counter[str] = Counter()
    outcomes: Counter[str] = Counter()
    for judged in found:
        counts.update({'pairs': 1, 'runs': len(judged.outcomes),
                       **dict.fromkeys({kind for kind, _ in judged.against}, 1)})
        outcomes.update(judged.outcomes)
        for line in describe(judged):
            print(line, flush=True)
    print(f'{counts["pairs"]} sound pairs: ' + ', '.join(
        f'{counts[kind]} {kind}' for kind in ('void', 'doubtful', 'warning', 'rejected',
                                              'no run')))
    print(f'{counts["runs"]} runs: ' + ', '.join(
        f'{n} {outcome}' for outcome, n in outcomes.most_common()))
    return counts


def print_at_norm(found: Iterable[Judged]) -> tuple[int, int]:
    """Print the runs at the norm that are certified; return their number and that of all."""
    certified = runs = 0
    for judged in found:
        n = judged.outcomes.count('compliant')
        certified, runs = certified + n, runs + len(judged.outcomes)
        if n:
            print(f'pair {judged.number}: CERTIFIED at its norm, {n} of '
                  f'{len(judged.outcomes)} runs [{judged.words}]', flush=True)
    share = certified / runs if runs else 0.0
    print(f'{runs} runs at the norm: {certified} certified, {share:.4f} ± '
          f'{math.sqrt(share * (1.0 - share) / max(runs, 1)):.4f}')
    return certified, runs


def main(arguments: list[str]) -> int:
    """Print both parts; the exit code is 1 if anything fails."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument('--pairs', type=int, default=240, help='sound pairs')
    parser.add_argument('--norm-pairs', type=int, default=160, help='pairs at the norm')
    parser.add_argument('--seed', type=int, default=1, help='decides all pairs')
    parser.add_argument('--jobs', type=int, default=2, help='processes')
    parser.add_argument('--pair', type=int, help='judge this pair alone, and print its verdict')
    parser.add_argument('--at-norm', action='store_true', help='with --pair: one at the norm')
    history.add_option(parser)
    given = parser.parse_args(arguments)
    if given.pair is not None:
        pair = (draw_pair(given.pair, given.seed + _AT_NORM, share=1.0) if given.at_norm
                else draw_pair(given.pair, given.seed))
        verdict = judge(pair)
        print(pair.words)
        print(verdict)
        return int(any(kind != 'warning' for kind, _ in find_against(verdict)))
    counts = print_sound(judge_all(range(given.pairs), given.seed, None, given.jobs))
    certified, runs = print_at_norm(judge_all(range(given.norm_pairs), given.seed + _AT_NORM, 1.0,
                                              given.jobs))
    if given.keep:
        history.keep('sound_pairs', {
            **{f'sound: {kind}': counts[kind] / max(counts['pairs'], 1)
               for kind in ('void', 'doubtful', 'warning', 'rejected', 'no run')},
            'at the norm: certified': certified / max(runs, 1)})
    too_many = certified > 0.05 * runs + 2.0 * math.sqrt(0.05 * 0.95 * runs)
    return int(too_many or any(counts[kind] for kind in ('void', 'doubtful', 'rejected',
                                                         'no run')))


if __name__ == '__main__':
    sys.exit(main(sys.argv[1:]))
