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
at 100 Hz take less than a minute, and the memory does not grow with the length. The figures are
printed but not judged, because they depend on the machine.

If numba is installed (extra `fast`), a second table compares the CPU time of the simulation alone
with the loop of the AHRS interpreted and compiled, in this process, and checks that the readings
are the same to the bit. The time to compile stands for itself.

    python benchmarks/simulate.py
    python benchmarks/simulate.py --hours 1 12 --rate-hz 10 --model marine_0p1
"""

from __future__ import annotations

import argparse
from importlib.util import find_spec
from pathlib import Path
import resource
import subprocess
import sys
import tempfile
from time import perf_counter, process_time

import history
import numpy as np

from heading_intercompare.ahrs.settings import Scenario
from heading_intercompare.ahrs.simulator import Simulation

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


def compare(duration_s: float, rate_hz: float, model: str) -> tuple[float, float, bool]:
    """Return the CPU seconds interpreted and compiled, and whether the readings are the same."""
    scenario = Scenario.from_mapping({
        'duration_s': duration_s, 'seaway': 'ss5', 'legs': '0 30 10; 7200 120 12; 14400 210 12',
        'ts': {'model': model, 'rate_hz': rate_hz, 'ahrs.initial_state': 'aligned'},
        'rs': {'model': 'gnss_compass', 'rate_hz': rate_hz}})
    took_s, sums = [], []
    for fast in (False, True):
        begin, total = process_time(), 0
        trial = Simulation(scenario).begin(fast)
        while not trial.over:
            read = trial.advance(trial.now_s + 60.0).ts.heading_deg
            total = (total + int(np.bitwise_xor.reduce(read.view(np.int64)))) * 31 % 2**61
        took_s.append(process_time() - begin)
        sums.append(total)
    return took_s[0], took_s[1], sums[0] == sums[1]


def main() -> int:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.split('\n\n')[0])
    parser.add_argument('--hours', type=float, nargs='+', default=[1.0, 12.0])
    parser.add_argument('--rate-hz', type=float, default=100.0)
    parser.add_argument('--model', default='dtg_precision')
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
    if find_spec('numba'):
        begin = process_time()
        compare(10.0, 1.0, arguments.model)
        print(f'\ncompiled in {process_time() - begin:.1f} s\n'
              'simulated  interpreted  compiled  ratio  same bits')
        for hours in sorted(arguments.hours):
            plain_s, fast_s, same = compare(3600.0 * hours, arguments.rate_hz, arguments.model)
            print(f'{hours:7.2f} h {plain_s:10.1f} s {fast_s:7.1f} s {fast_s / plain_s:6.3f}  '
                  f'{same}')
            figures[f'{arguments.model}, {arguments.rate_hz:g} Hz, {hours:g} h: compiled / '
                    'interpreted'] = fast_s / plain_s
    if arguments.keep:
        history.keep('simulate', figures)
    return 0


if __name__ == '__main__':
    sys.exit(main())
