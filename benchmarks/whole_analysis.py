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
What a whole verdict costs, next to only reading the headings of the same bag in the same run.

The bag holds Imu of two sensors, 12 h at 100 Hz each. Their differences are correlated over a
minute, and the ship turns and yaws. Each row is a process of its own: its CPU time, user and
system, with that of its helpers, and its wall clock; the least of several alternating rounds.
`analyze` makes the whole verdict, with all diagnostics and SHA-256. `mcap` and `rosbags` only
iterate over the first messages, undecoded and in the order of log time; their times are scaled to
the whole bag. Memory is the peak of one process. A pair takes what the peak of the whole bag
exceeds that of its first ten minutes by. Python has compiled the sources before.

Promises: `analyze` takes at most twice the CPU time of the reading loop, `apply` at most 1.1
times that of `analyze`, and a pair at most 24 bytes. `analyze` is 40 times as fast as `mcap`, and
a bag of ten minutes takes at most 3 times the CPU time of `import numpy`. The exit code is 1 if
a promise is broken.

    python benchmarks/whole_analysis.py
    python benchmarks/whole_analysis.py --hours 2 --rounds 1
"""

from __future__ import annotations

import argparse
from multiprocessing import get_context
import os
from pathlib import Path
import subprocess
import sys
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import NamedTuple

import history

ROOT = Path(__file__).resolve().parent.parent
RATE_HZ = 100
SHORT_S = 600
CHUNK_S = 60
SLOW_S = 60.0
#: A sea that makes the ship yaw by about 1.5 deg in eight seconds, forgotten in twenty.
SEA = (1.0, -1.99893836, 0.99900050)
YAW_DEG = 5.3e-4
NORMS = '--set=norms.sigma_max_deg=0.3', '--set=norms.sigma_ref_max_deg=0.1'

READ = 'read the headings'
READ_TOGETHER = 'read the headings, all cores'
ANALYZE = 'analyze --jobs 1'
ANALYZE_TOGETHER = 'analyze'
APPLY = 'analyze, skew: apply'
MCAP, ROSBAGS = 'mcap, log order', 'rosbags, raw'
NUMPY = 'import numpy'
SHORT = 'analyze, 10 min'

READ_MOST, APPLY_MOST, BYTES_MOST, MCAP_LEAST, NUMPY_MOST = 2.0, 1.1, 24.0, 40.0, 3.0


class Cost(NamedTuple):
    """CPU time, wall clock and peak of resident memory of one process."""

    cpu_s: float
    wall_s: float
    peak_mb: float


def write_bag(path: Path, seconds: int) -> None:
    """Write a bag of both sensors."""
    from bag_reading import encode_headings, FRAMES, IMU, TOPICS
    import numpy as np
    import scipy

    from heading_intercompare.bags.mcap.chunk_writer import Rows
    from heading_intercompare.bags.recording.bag_writer import BagWriter
    from heading_intercompare.bags.settings import BagSettings
    from heading_intercompare.core.records import Headings

    rng = np.random.default_rng(1)
    keep, last, sea = np.exp(-1.0 / (SLOW_S * RATE_HZ)), np.zeros(1), np.zeros(2)
    with BagWriter(path, BagSettings(compression='zstd')) as bag:
        for topic in TOPICS:
            bag.add_topic(topic, IMU)
        for lo in range(0, seconds * RATE_HZ, CHUNK_S * RATE_HZ):
            number = np.arange(lo, min(lo + CHUNK_S * RATE_HZ, seconds * RATE_HZ))
            n, t = number.size, number / RATE_HZ
            stamp_ns = 10**18 + number * (10**9 // RATE_HZ) + rng.integers(0, 10**5, n)
            yaw_deg, sea = scipy.signal.lfilter([YAW_DEG], SEA, rng.standard_normal(n), zi=sea)
            true_deg = 90.0 + 40.0 * np.sin(t / 1500.0) + yaw_deg
            error_deg, last = scipy.signal.lfilter(
                [0.2 * np.sqrt(1.0 - keep ** 2)], [1.0, -keep], rng.standard_normal(n), zi=last)
            both = (Headings.of(stamp_ns, true_deg + error_deg + rng.normal(0.0, 0.02, n)),
                    Headings.of(stamp_ns + 3_000_000, true_deg + rng.normal(0.0, 0.05, n)))
            bag.write_rows([
                Rows(topic, encode_headings(IMU, headings, frame), headings.stamp_ns,
                     sequence=number)
                for topic, frame, headings in zip(TOPICS, FRAMES, both)])


def do_part(name: str, path: Path, most: int) -> None:
    """Read a bag by one of several readers."""
    if name in (READ, READ_TOGETHER):
        from heading_intercompare.bags.rosbag2.bag_reader import BagReader

        helpers = 0 if name == READ else (os.cpu_count() or 1) - 1
        conventions = dict.fromkeys(('/ts/heading', '/rs/heading'), 'enu')
        for _ in BagReader(path).headings(conventions, helpers):
            pass
        return
    import bag_reading

    # Print what the messages alone took, without opening the bag.
    print(bag_reading.by_mcap(path, most) if name == MCAP else
          bag_reading.by_rosbags(path, most)[0])


def run(words: list[str], folder: str) -> tuple[Cost, str]:
    """Run Python with some arguments; return the cost, and what it printed."""
    path = os.pathsep.join([str(ROOT), *filter(None, [os.environ.get('PYTHONPATH')])])
    begin = perf_counter()
    process = subprocess.Popen([sys.executable, *words], stdout=subprocess.PIPE, text=True,
                               env={**os.environ, 'PYTHONPATH': path,
                                    'PYTHONPYCACHEPREFIX': f'{folder}/compiled',
                                    'PYTHONDONTWRITEBYTECODE': ''})
    with process:
        assert process.stdout is not None
        said = process.stdout.read()
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        raise SystemExit(f'{words}: ended with {process.returncode}')
    return Cost(usage.ru_utime + usage.ru_stime, perf_counter() - begin,
                usage.ru_maxrss / 1024.0), said


def measure(bag: Path, short: Path, n: int, most: int, rounds: int) -> dict[str, Cost]:
    """Return the least cost of each row."""
    def judge(path: Path, *words: str) -> list[str]:
        return ['-m', 'heading_intercompare', 'analyze', str(path), '--quiet', *NORMS, *words]

    programs = {
        READ: [__file__, '--part', READ, str(bag)],
        ANALYZE: judge(bag, '--jobs', '1'),
        APPLY: judge(bag, '--jobs', '1', '--set=alignment.skew=apply'),
        READ_TOGETHER: [__file__, '--part', READ_TOGETHER, str(bag)],
        ANALYZE_TOGETHER: judge(bag),
        SHORT: judge(short, '--jobs', '1'),
        NUMPY: ['-c', 'import numpy'],
    }
    folder = str(bag.parent)
    # Python compiles the sources once, which an installation has done.
    for name in (SHORT, NUMPY):
        run(programs[name], folder)
    costs: dict[str, list[Cost]] = {name: [] for name in programs}
    for _ in range(rounds):
        for name, words in programs.items():
            costs[name].append(run(words, folder)[0])
    least = {name: Cost(*map(min, zip(*found))) for name, found in costs.items()}
    for name in (MCAP, ROSBAGS):
        cost, said = run([__file__, '--part', name, str(bag), '--peers', str(most)], folder)
        least[name] = Cost(float(said) * n, float(said) * n, cost.peak_mb)
    return least


def main() -> int:
    """Print a row per program; return 1 if a promise is broken."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument('--hours', type=float, default=12.0)
    parser.add_argument('--rounds', type=int, default=3)
    parser.add_argument('--peers', type=int, default=100_000, metavar='N',
                        help='messages after which to stop slow readers')
    parser.add_argument('--part', nargs=2, help=argparse.SUPPRESS)
    history.add_option(parser)
    options = parser.parse_args()
    if options.part:
        do_part(options.part[0], Path(options.part[1]), options.peers)
        return 0
    seconds = round(options.hours * 3600.0)
    n = 2 * seconds * RATE_HZ
    with TemporaryDirectory() as folder:
        bag, short = Path(folder, 'bag'), Path(folder, 'short')
        for path, length in ((bag, seconds), (short, SHORT_S)):
            # A process of its own, or its memory would count as that of every other one.
            writer = get_context('spawn').Process(target=write_bag, args=(path, length))
            writer.start()
            writer.join()
        costs = measure(bag, short, n, options.peers, options.rounds)
    reading = costs[READ]
    print('| | CPU | × reading | ns a heading | wall | peak |\n|---|---|---|---|---|---|')
    for name, cost in costs.items():
        print(f'| {name} | {cost.cpu_s:.2f} s | {cost.cpu_s / reading.cpu_s:.2f} '
              f'| {cost.cpu_s / n * 1e9:.0f} | {cost.wall_s:.2f} s | {cost.peak_mb:.0f} MB |')
    pairs = 0.5 * n - SHORT_S * RATE_HZ
    bytes_a_pair = (costs[ANALYZE].peak_mb - costs[SHORT].peak_mb) * 2 ** 20 / pairs
    figures = {
        'analyze over reading': (costs[ANALYZE].cpu_s / reading.cpu_s, READ_MOST),
        'apply over analyze': (costs[APPLY].cpu_s / costs[ANALYZE].cpu_s, APPLY_MOST),
        'bytes a pair': (bytes_a_pair, BYTES_MOST),
        'analyze over mcap': (costs[ANALYZE].cpu_s / costs[MCAP].cpu_s, 1.0 / MCAP_LEAST),
        '10 min over numpy': (costs[SHORT].cpu_s / costs[NUMPY].cpu_s, NUMPY_MOST),
    }
    broken = {name for name, (value, limit) in figures.items() if value > limit}
    for name, (value, limit) in figures.items():
        print(f'{name}: {value:.3g}, promised {limit:.3g}{" BROKEN" * (name in broken)}')
    if options.keep:
        history.keep('whole_analysis', {name: value for name, (value, _) in figures.items()})
    return int(bool(broken))


if __name__ == '__main__':
    sys.exit(main())
