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
False alarms of compliance on sound sensors, by kind of ship, and the CPU time of a look.

    python benchmarks/alarms.py                                   # 2 h of each kind, 8 minutes
    python benchmarks/alarms.py --hours 10 --kind turning '1 Hz' --seed 7

`made_up_ships` makes voyages of 10 min of two sound sensors. The alarms look at each once a second
of the data, as the node does, so everything that they raise is false. The last column is the upper
limit of the rate per 1000 h with 95 % confidence: without any alarm 3 / hours, otherwise that of a
Poisson count. The limit of all kinds together is that of this mixture of ships. CPU time includes
taking the pairs; it depends on the machine.
"""

from __future__ import annotations

import argparse
from collections import Counter
from dataclasses import dataclass
import math
import sys
import time
from typing import Iterable
import zlib

from made_up_ships import KINDS, norms_of, raised, voyage, watch
import numpy as np
import scipy

_VOYAGE_S = 600.0


@dataclass(frozen=True, slots=True)
class Alarms:
    """
    The alarms raised on some voyages.

    Attributes
    ----------
    span_s
        Length of the voyages together, seconds; there is a look a second.
    cpu_s
        CPU time of all looks, seconds.
    raised
        Number of alarms, by rule.

    """

    span_s: float
    cpu_s: float
    raised: Counter[str]

    def __add__(self, other: Alarms) -> Alarms:
        return Alarms(self.span_s + other.span_s, self.cpu_s + other.cpu_s,
                      self.raised + other.raised)


def count_alarms(kind: str, hours: float, seed: int) -> Alarms:
    """
    Simulate voyages of a kind and count the alarms.

    Parameters
    ----------
    kind
        One of `KINDS`.
    hours
        Hours to simulate, rounded up to whole voyages.
    seed
        With the kind it decides all voyages, whatever other kinds are simulated.

    """
    found: Counter[str] = Counter()
    n, cpu_s = math.ceil(3600.0 * hours / _VOYAGE_S), 0.0
    for number in range(n):
        rng = np.random.default_rng([seed, zlib.crc32(kind.encode()), number])
        trip = voyage(rng, span_s=_VOYAGE_S, **KINDS[kind])
        began_s = time.process_time()
        found.update(raised(watch(*trip, **norms_of(kind))[0]))
        cpu_s += time.process_time() - began_s
    return Alarms(n * _VOYAGE_S, cpu_s, found)


def most_per_1000_h(n: int, hours: float) -> float:
    """Return the upper limit of the rate of n alarms in some hours, per 1000 h; 95 %."""
    return 1000.0 * float(scipy.special.gammaincinv(n + 1.0, 0.95)) / hours


def describe(name: str, found: Alarms) -> str:
    """Return the row of a kind."""
    hours, n = found.span_s / 3600.0, found.raised.total()
    rules = ', '.join(f'{rule} {times}' for rule, times in sorted(found.raised.items()))
    return (f'| {name} | {hours:.1f} | {rules or "none"} | {1e3 * found.cpu_s / found.span_s:.1f} '
            f'| {1e3 * n / hours:.0f} | {most_per_1000_h(n, hours):.0f} |')


def print_table(kinds: Iterable[str], hours: float, seed: int) -> None:
    """Print a row for each kind, and one for all."""
    print('| kind | hours | false alarms | CPU, ms a look | per 1000 h | at most (95 %) |\n'
          '|---|---|---|---|---|---|')
    everything = Alarms(0.0, 0.0, Counter())
    for kind in kinds:
        found = count_alarms(kind, hours, seed)
        everything += found
        print(describe(kind, found), flush=True)
    print(describe('all', everything))


def _hours(text: str) -> float:
    try:
        hours = float(text)
    except ValueError:
        hours = math.nan
    if not 0.0 < hours < math.inf:
        raise argparse.ArgumentTypeError(f'{text} must be a number of hours above 0')
    return hours


def _seed(text: str) -> int:
    if not text.isdecimal():
        raise argparse.ArgumentTypeError(f'{text} must be a whole number, at least 0')
    return int(text)


def main(arguments: list[str]) -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument('--hours', type=_hours, default=2.0, help='hours to simulate of each kind')
    parser.add_argument('--kind', nargs='+', choices=KINDS, default=KINDS, metavar='KIND',
                        help='kinds of ships; all by default')
    parser.add_argument('--seed', type=_seed, default=1, help='decides the voyages')
    given = parser.parse_args(arguments)
    print_table(given.kind, given.hours, given.seed)
    return 0


if __name__ == '__main__':
    sys.exit(main(sys.argv[1:]))
