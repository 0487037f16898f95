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
How fast `simulate` writes a trial: time, its ratio to the simulated time, peak memory, size.

The TS is the gimballed AHRS at sea, the RS a satellite compass. Promise: 12 h with both sensors
at 100 Hz take less than a minute, and the memory does not grow with the length. These figures are
printed but not judged, because they depend on the machine.

A second table compares the CPU time and the peak memory of the simulation alone, each in a process
of its own, the least of several alternating rounds: the code before numba (commit 8a18fe4, taken
out of the repository), and today's, interpreted and, if numba is installed (extra `fast`),
compiled. It checks that the readings of today's are the same to the bit. The time to compile
stands for itself. Promises: without numba no more CPU time than before, with numba at most 0.375.
The exit code is 1 if one is broken.

    python benchmarks/simulate.py
    python benchmarks/simulate.py --hours 1 12 --rate-hz 10 --model marine_0p1
"""

from __future__ import annotations

import argparse
from importlib.util import find_spec
import math
import os
from pathlib import Path
import resource
import subprocess
import sys
import tempfile
from time import perf_counter
from typing import NamedTuple

import history

ROOT = Path(__file__).resolve().parent.parent
BEFORE = '8a18fe4'
INTERPRETED_MOST, COMPILED_MOST = 1.0, 0.375

SCENARIO = """\
title: Benchmark
duration_s: {duration_s}
seaway: ss5
legs: 0 30 10; 7200 120 12; 14400 210 12; 28800 300 12
ts:
  model: {model}
  rate_hz: {rate_hz}
  ahrs: {{initial_state: aligned}}
rs: {{model: gnss_compass, rate_hz: {rate_hz}}}
"""


def measure(duration_s: float, rate_hz: float, model: str) -> tuple[float, float, int]:
    """Return seconds, peak memory in MB and bytes of the bag, of one run in its own process."""
    with tempfile.TemporaryDirectory() as folder:
        scenario, bag = Path(folder, 'scenario.yaml'), Path(folder, 'bag')
        scenario.write_text(SCENARIO.format(duration_s=duration_s, rate_hz=rate_hz, model=model),
                            encoding='utf-8')
        begin = perf_counter()
        subprocess.run([sys.executable, '-m', 'heading_intercompare', 'simulate', '--scenario',
                        str(scenario), '-o', str(bag)], check=True, stdout=subprocess.PIPE)
        took_s = perf_counter() - begin
        # This is the peak of the largest child so far, so measure rising lengths.
        peak_mb = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024.0
        return took_s, peak_mb, sum(file.stat().st_size for file in bag.iterdir())


#: What a process does: make the trial after a short one, which compiles.
TRIAL = """\
import resource, sys, time
import numpy as np
from heading_intercompare.ahrs.settings import Scenario
from heading_intercompare.ahrs.simulator import Simulation
seconds, rate_hz, model, fast = float(sys.argv[1]), float(sys.argv[2]), sys.argv[3], sys.argv[4]
def simulate(duration_s):
    simulation, total = Simulation(Scenario.from_mapping({
        'duration_s': duration_s, 'seaway': 'ss5', 'legs': '0 30 10; 7200 120 12; 14400 210 12',
        'ts': {'model': model, 'rate_hz': rate_hz, 'ahrs.initial_state': 'aligned'},
        'rs': {'model': 'gnss_compass', 'rate_hz': rate_hz}})), 0
    trial = simulation.begin(*([] if fast == 'before' else [fast == 'compiled']))
    while not trial.over:
        read = trial.advance(trial.now_s + 60.0).ts.heading_deg
        total = (total + int(np.bitwise_xor.reduce(read.view(np.int64)))) * 31 % 2**61
    return total
began = time.process_time()
simulate(10.0)
made = time.process_time()
total = simulate(seconds)
print(time.process_time() - made, made - began,
      resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0, total)
"""


class Cost(NamedTuple):
    """CPU seconds, those of the start, peak memory in MB, and a sum of the readings."""

    cpu_s: float
    start_s: float
    peak_mb: float
    total: int


def time_trial(root: Path, duration_s: float, rate_hz: float, model: str, how: str) -> Cost:
    """Return the cost of a trial made by the code in a folder, in a process of its own."""
    said = subprocess.run([sys.executable, '-P', '-c', TRIAL, str(duration_s), str(rate_hz),
                           model, how], check=True, capture_output=True, text=True,
                          env={**os.environ, 'PYTHONPATH': str(root)}).stdout.split()
    return Cost(*map(float, said[:3]), int(said[3]))


def take_out(commit: str, folder: str) -> Path | None:
    """Write the package of a commit into a folder; None if the repository does not have it."""
    if subprocess.run(['git', '-C', str(ROOT), 'cat-file', '-e', commit], capture_output=True,
                      check=False).returncode:
        return None
    archive = subprocess.run(['git', '-C', str(ROOT), 'archive', commit, 'heading_intercompare'],
                             check=True, capture_output=True).stdout
    subprocess.run(['tar', '-x', '-C', folder], input=archive, check=True)
    return Path(folder)


def compare(duration_s: float, rate_hz: float, model: str, rounds: int) -> dict[str, Cost]:
    """Return the least cost of each way to make a trial."""
    with tempfile.TemporaryDirectory() as folder:
        before = take_out(BEFORE, folder)
        ways = {**({'before': before} if before else {}), 'interpreted': ROOT,
                **({'compiled': ROOT} if find_spec('numba') else {})}
        found = [{how: time_trial(root, duration_s, rate_hz, model, how)
                  for how, root in ways.items()} for _ in range(rounds)]
    return {how: min(one[how] for one in found) for how in ways}


def main() -> int:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.split('\n\n')[0])
    parser.add_argument('--hours', type=float, nargs='+', default=[1.0, 12.0])
    parser.add_argument('--rate-hz', type=float, default=100.0)
    parser.add_argument('--model', default='dtg_precision')
    parser.add_argument('--rounds', type=int, default=3)
    history.add_option(parser)
    arguments = parser.parse_args()
    figures = {}
    print('simulated    took  simulated/took  peak memory       bag')
    for hours in sorted(arguments.hours):
        took_s, peak_mb, size = measure(3600.0 * hours, arguments.rate_hz, arguments.model)
        print(f'{hours:7.2f} h {took_s:5.1f} s {3600.0 * hours / took_s:15.0f} '
              f'{peak_mb:9.0f} MB {size / 1e6:6.0f} MB')
        row = f'{arguments.model}, {arguments.rate_hz:g} Hz, {hours:g} h'
        figures |= {f'{row}: simulated / taken': 3600.0 * hours / took_s,
                    f'{row}: peak MB': peak_mb, f'{row}: bag MB': size / 1e6}
    broken = False
    print('\nsimulated                  CPU  of before  peak memory  CPU of the start')
    for hours in sorted(arguments.hours):
        costs = compare(3600.0 * hours, arguments.rate_hz, arguments.model, arguments.rounds)
        for how, cost in costs.items():
            ratio = cost.cpu_s / costs['before'].cpu_s if 'before' in costs else math.nan
            print(f'{hours:7.2f} h {how:>12} {cost.cpu_s:5.2f} s {ratio:9.3f} '
                  f'{cost.peak_mb:9.0f} MB {cost.start_s:7.1f} s')
            most = {'interpreted': INTERPRETED_MOST, 'compiled': COMPILED_MOST}.get(how, 1.0)
            broken |= ratio > most
            figures[f'{arguments.model}, {arguments.rate_hz:g} Hz, {hours:g} h: {how} / '
                    'before'] = ratio
        if len({cost.total for how, cost in costs.items() if how != 'before'}) > 1:
            print('the readings are NOT the same')
            broken = True
        if 'before' not in costs:
            print(f'commit {BEFORE} is not in this repository: nothing to compare with')
    print('a promise is BROKEN' if broken else 'no promise is broken')
    if arguments.keep:
        history.keep('simulate', figures)
    return int(broken)


if __name__ == '__main__':
    sys.exit(main())
