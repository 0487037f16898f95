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
What a row of a csv and a line of a log cost, next to other readers of the same files.

    python benchmarks/text_reading.py
    python benchmarks/text_reading.py --rows 10000000

The tables have a time and two headings in each row; the log has stamped sentences of HDT and GGA
by turns. Each reader is a process of its own, so that memory is its own, too: numpy and pyarrow
read the columns, pynmeagps parses the sentences, and grep counts the lines with a heading. CPU is
the least of three rounds, in which the readers take turns. A reader that is not installed is left
out.
"""

from __future__ import annotations

import argparse
from functools import reduce
import importlib.util
from operator import xor
import os
from pathlib import Path
import subprocess
import sys
from tempfile import TemporaryDirectory
from typing import NamedTuple

import numpy as np

ROUNDS = 3
#: The peak of a process in kilobytes; that of the parent counts in what `wait4` returns.
TELL_PEAK = 'print(open("/proc/self/status").read().partition("VmHWM:")[2].split()[0])'
OURS_TABLE = ('from heading_intercompare.readers.tables import read_table\n'
              'assert len(read_table(PATH).streams()) == 2')
READERS = {
    'table': {
        'read_table': OURS_TABLE,
        'numpy.loadtxt': 'import numpy; numpy.loadtxt(PATH, delimiter=",", skiprows=1)',
        'pyarrow.csv': 'import pyarrow.csv; pyarrow.csv.read_csv(PATH)'},
    'table of ISO times': {
        'read_table': OURS_TABLE,
        'pyarrow.csv': 'import pyarrow.csv; pyarrow.csv.read_csv(PATH)'},
    'csv of pairs': {
        'PairsCsv': ('from heading_intercompare.bags.csv.pairs_csv import PairsCsv\n'
                     'assert sum(map(len, PairsCsv(PATH)))'),
        'numpy.loadtxt': 'import numpy; numpy.loadtxt(PATH, delimiter=",", skiprows=1)'},
    'log': {
        'LogReader': ('from heading_intercompare.drivers.logs import LogReader\n'
                      'assert sum(map(len, LogReader(PATH)))'),
        'grep': 'import subprocess; subprocess.run(["grep", "-c", "HEHDT", PATH], check=True)',
        'pynmeagps': ('import pynmeagps\n'
                      'for line in open(PATH, "rb"):\n'
                      '    pynmeagps.NMEAReader.parse(line.partition(b" ")[2])')},
}


class Cost(NamedTuple):
    """CPU time of a process, seconds, and the most memory that it had, megabytes."""

    cpu_s: float
    memory_mb: float


def write(folder: Path, n: int) -> dict[str, Path]:
    """Write the files, n rows or lines each; return them by kind."""
    rng, begin_ms = np.random.default_rng(1), 1_700_000_000_000
    paths = {kind: folder / f'{kind}.txt' for kind in READERS}
    files = {kind: path.open('w') for kind, path in paths.items()}
    for kind, header in (('table', 't'), ('table of ISO times', 'time')):
        files[kind].write(f'{header},gyro_heading,ins_heading\n')
    files['csv of pairs'].write('stamp_ns,ts_deg,rs_deg\n')
    for lo in range(0, n, 100_000):
        count = min(100_000, n - lo)
        ms = begin_ms + 100 * np.arange(lo, lo + count)
        iso = np.datetime_as_string(ms.astype('M8[ms]'))
        tails = [f'{ts:.3f},{rs:.3f}\n' for ts, rs in rng.uniform(0.0, 360.0, (count, 2))]
        files['table'].write(''.join(
            f'{stamp / 1e3:.3f},{tail}' for stamp, tail in zip(ms, tails)))
        files['table of ISO times'].write(''.join(
            f'{stamp}Z,{tail}' for stamp, tail in zip(iso, tails)))
        files['csv of pairs'].write(''.join(
            f'{stamp}000000,{tail}' for stamp, tail in zip(ms, tails)))
        files['log'].write(''.join(
            f'{stamp}Z {sentence(place, tail)}' for place, (stamp, tail) in
            enumerate(zip(iso, tails))))
    for file in files.values():
        file.close()
    return paths


def sentence(place: int, tail: str) -> str:
    """Return a heading or a position by turns."""
    body = (f'HEHDT,{tail.partition(",")[0]},T' if place % 2 == 0 else
            'GPGGA,101112.00,7053.0001,N,00224.0002,E,1,08,0.9,12.3,M,40.1,M,,')
    return f'${body}*{reduce(xor, body.encode()):02X}\n'


def measure(code: str, path: Path) -> Cost:
    """Run a reader in a process of its own."""
    with subprocess.Popen([sys.executable, '-c', f'PATH = {str(path)!r}\n{code}\n{TELL_PEAK}'],
                          stdout=subprocess.PIPE, text=True) as process:
        words = process.stdout.read().split()
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        raise SystemExit(f'a reader ended with {process.returncode}: {code}')
    return Cost(usage.ru_utime + usage.ru_stime, int(words[-1]) / 1024)


def main() -> None:
    """Write the files, measure all readers, print a table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument('--rows', type=int, default=1_000_000)
    count = parser.parse_args().rows
    print('| file | reader | us per line | ratio of ours | memory, MB |\n|---|---|---|---|---|')
    with TemporaryDirectory() as folder:
        for kind, path in write(Path(folder), count).items():
            readers = {name: code for name, code in READERS[kind].items()
                       if not name.startswith('py') or importlib.util.find_spec(
                           name.partition('.')[0])}
            rounds = [[measure(code, path) for code in readers.values()] for _ in range(ROUNDS)]
            costs = [min(costs) for costs in zip(*rounds)]
            for name, cost in zip(readers, costs):
                print(f'| {kind}, {path.stat().st_size / 1e6:.0f} MB | {name} '
                      f'| {1e6 * cost.cpu_s / count:.2f} | {costs[0].cpu_s / cost.cpu_s:.2f} '
                      f'| {cost.memory_mb:.0f} |', flush=True)


if __name__ == '__main__':
    main()
