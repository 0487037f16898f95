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
The results of benchmarks over time: kept as one JSON line per run, shown as trends.

A benchmark called with `--keep` appends its figures to `history.jsonl` in its folder, with date,
commit and versions. Figures are ratios to a peer measured in the same run, rates, or sizes: plain
times would mainly show which machine it was.

    python benchmarks/history.py
    python benchmarks/history.py recover bag_reading
"""

from __future__ import annotations

import argparse
from datetime import datetime, timezone
import json
import os
from pathlib import Path
import platform
import subprocess
import sys
from typing import Iterator, Mapping

import numpy
import scipy

HISTORY = Path(__file__).with_name('history.jsonl')

_BARS = '▁▂▃▄▅▆▇█'


def add_option(parser: argparse.ArgumentParser) -> None:
    """Add the option `--keep` to a benchmark."""
    parser.add_argument('--keep', action='store_true',
                        help=f'append the figures to {HISTORY.name}')


def keep(benchmark: str, figures: Mapping[str, float], path: Path = HISTORY) -> None:
    """
    Append one run of a benchmark.

    Parameters
    ----------
    benchmark
        Name of its module.
    figures
        Figures by descriptive name; without figures nothing is written.
    path
        The file.

    """
    if not figures:
        return
    run = {'benchmark': benchmark,
           'date': f'{datetime.now(timezone.utc):%Y-%m-%dT%H:%M:%SZ}',
           'commit': _find_commit(), 'python': platform.python_version(),
           'numpy': numpy.__version__, 'scipy': scipy.__version__, 'cores': os.cpu_count(),
           'figures': {name: float(f'{value:.4g}') for name, value in figures.items()}}
    with open(path, 'a', encoding='utf-8') as file:
        file.write(json.dumps(run) + '\n')


def _find_commit() -> str:
    """Return the commit of the checkout, with a plus if it is modified; '' outside a checkout."""
    done = subprocess.run(['git', 'describe', '--always', '--dirty=+'], cwd=HISTORY.parent,
                          stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    return done.stdout.strip()


def read_runs(path: Path = HISTORY) -> list[dict]:
    """Return all runs, oldest first; ValueError names a line that is not a run."""
    runs = []
    for number, line in enumerate(path.read_text('utf-8').splitlines(), start=1):
        try:
            run = json.loads(line)
            runs.append({**run, 'figures': dict(run['figures'])})
        except (ValueError, KeyError, TypeError) as error:
            raise ValueError(f'{path}, line {number}: is not a run of a benchmark') from error
    return runs


def _draw(values: list[float]) -> str:
    """Return the values as bars, scaled from the smallest to the largest."""
    low, high = min(values), max(values)
    return ''.join(_BARS[round((value - low) / (high - low) * (len(_BARS) - 1))]
                   if high > low else _BARS[0] for value in values)


def describe_trend(runs: list[dict], benchmark: str) -> Iterator[str]:
    """Yield a line per figure of a benchmark: number of runs, first, last, and all as bars."""
    values: dict[str, list[float]] = {}
    for run in runs:
        if run['benchmark'] == benchmark:
            for name, value in run['figures'].items():
                values.setdefault(name, []).append(value)
    width = max(map(len, values), default=0)
    for name, found in values.items():
        yield (f'  {name:{width}s} {len(found):4d} {found[0]:10.4g} {found[-1]:10.4g}  '
               f'{_draw(found)}')


def main(arguments: list[str]) -> int:
    """Print the trends; return 2 if there is nothing to show."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument('benchmarks', nargs='*', help='names; all by default')
    given = parser.parse_args(arguments)
    try:
        runs = read_runs()
    except (OSError, ValueError) as error:
        sys.stderr.write(f'history: error: {error}\n')
        return 2
    for name in given.benchmarks or dict.fromkeys(run['benchmark'] for run in runs):
        print(f'{name}: runs, first, last')
        for line in describe_trend(runs, name):
            print(line)
    return 0


if __name__ == '__main__':
    sys.exit(main(sys.argv[1:]))
