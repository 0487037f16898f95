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

"""What the journal of a run in progress costs: CPU, bytes per pair, and the time to read it."""

from __future__ import annotations

import argparse
from pathlib import Path
import tempfile
import time

import numpy as np

from heading_intercompare.bags.recording.run_journal import RunJournal
from heading_intercompare.core.pipeline import Compliance
from heading_intercompare.core.records import Pairs
from heading_intercompare.core.settings import Settings

RULE = Settings.from_mapping({'norms.sigma_max_deg': 0.2, 'norms.sigma_ref_max_deg': 0.1})
BATCH_S = 0.05


def measure(rate_hz: int, span_s: int, folder: str) -> str:
    """Return the figures of one rate as a line."""
    rng, n = np.random.default_rng(1), rate_hz * span_s
    pairs = Pairs.of(10 ** 18 + np.arange(n) * (10 ** 9 // rate_hz), rng.normal(90.0, 0.1, n),
                     rng.normal(90.0, 1.0, n), None, rng.uniform(0.5, 1.0, n))
    path, size = Path(folder, f'{rate_hz}.journal'), max(1, round(rate_hz * BATCH_S))
    journal = RunJournal(path, Compliance(RULE), within_s=3600.0, now_ns=time.time_ns())
    began_s, now_s = time.process_time(), 0.0
    for lo in range(0, n, size):
        now_s += size / rate_hz
        journal.add(pairs[lo:lo + size], {'1700000000000000000': (1, lo + size, 0)})
        journal.tick(now_s)
    cpu_s = time.process_time() - began_s
    journal.close(over=False)
    per_pair = path.stat().st_size / n
    began_s = time.monotonic()
    again = RunJournal(path, Compliance(RULE), within_s=3600.0, now_ns=time.time_ns())
    read_s = time.monotonic() - began_s
    assert again.kept.n_pairs == n
    again.close(over=True)
    return f'{rate_hz:7d} {100.0 * cpu_s / span_s:9.3f} {per_pair:12.1f} {read_s:16.2f}'


def main() -> None:
    """Print a row per rate."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--seconds', type=int, default=600)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory(dir='/var/tmp') as folder:
        print(f'rate Hz   CPU [%]   bytes/pair   read {given.seconds} s [s]')
        for rate_hz in (10, 100, 1000):
            print(measure(rate_hz, given.seconds, folder), flush=True)


if __name__ == '__main__':
    main()
