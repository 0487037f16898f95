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
What the journal of readings costs: CPU, bytes per pair, and the time to read it.

Reading it pairs and judges again, so it stands beside that in the same run.
"""

from __future__ import annotations

import argparse
from pathlib import Path
import tempfile
import time

import numpy as np

from heading_intercompare.core.pairing.incarnations import StreamNumbers
from heading_intercompare.core.pairing.names import Span
from heading_intercompare.core.pairing.pair_maker import PairMaker
from heading_intercompare.core.pairing.pairer import Pairer
from heading_intercompare.core.pipeline import Compliance
from heading_intercompare.core.records import Headings
from heading_intercompare.core.sensors.pair_names import TWO
from heading_intercompare.core.settings import Settings
from heading_intercompare.journal.reading_batches import Batch, LastHeard, pair_batch
from heading_intercompare.journal.run_journal import RunJournal

RULE = Settings.from_mapping({'norms.sigma_max_deg': 0.2, 'norms.sigma_ref_max_deg': 0.1,
                              'pairing.method': 'interpolate'})
BATCH_S = 0.05


def make_batches(rate_hz: int, span_s: int) -> list[Batch]:
    """Return the readings of two sensors in the batches that a synchronizer takes."""
    rng, n, size = np.random.default_rng(1), rate_hz * span_s, max(1, round(rate_hz * BATCH_S))
    step_ns = 10 ** 9 // rate_hz
    stamps = 10 ** 18 + np.arange(n) * step_ns
    readings = {stream: Headings.of(stamps + late_ns, rng.normal(90.0, 0.1, n))
                for stream, late_ns in (('ts', 0), ('rs', step_ns // 3))}
    batches = []
    for lo in range(0, n, size):
        last = min(lo + size, n)
        numbers = StreamNumbers('publisher', 1, 'publisher', last, (Span('publisher', 1, last),))
        batches.append(Batch(
            {stream: rows[lo:last] for stream, rows in readings.items()}, (), last / rate_hz,
            dict.fromkeys(readings, LastHeard(numbers, int(stamps[last - 1])))))
    return batches


def measure(rate_hz: int, span_s: int, folder: str) -> str:
    """Return the figures of one rate as a line."""
    batches, path = make_batches(rate_hz, span_s), Path(folder, f'{rate_hz}.journal')

    def open_journal(compliance: Compliance, maker: PairMaker) -> RunJournal:
        return RunJournal(path, RULE, {TWO: compliance}, within_s=3600.0,
                          now_ns=time.time_ns(), makers=[maker])
    compliance, clock = Compliance(RULE), time.process_time
    maker = PairMaker(Pairer(RULE))
    journal, keeping_s, judging_s = open_journal(compliance, maker), 0.0, 0.0
    pairer = maker.pairer
    for batch in batches:
        times = [clock()]
        journal.add_batch(batch)
        journal.flush(batch.now_s)
        times.append(clock())
        compliance.update(pairs := pair_batch(pairer, batch))
        times.append(clock())
        journal.add(pairs)
        journal.tick(batch.now_s)
        keeping_s += clock() - times[2] + times[1] - times[0]
        judging_s += times[2] - times[1]
    n_pairs = pairer.ledger.paired
    journal.close(over=False)
    began_s = clock()
    size = path.stat().st_size
    again = open_journal(Compliance(RULE), PairMaker(Pairer(RULE)))
    read_s = clock() - began_s
    assert again.kept.n_pairs == n_pairs
    again.close(over=True)
    return (f'{rate_hz:7d} {100.0 * keeping_s / span_s:9.3f} {size / n_pairs:12.1f} '
            f'{read_s:16.2f} {read_s / judging_s:20.3f}')


def main() -> None:
    """Print a row per rate."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--seconds', type=int, default=600)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory(dir='/var/tmp') as folder:
        print(f'rate Hz   CPU [%]   bytes/pair   read {given.seconds} s [s]   / pairing, judging')
        for rate_hz in (10, 100, 1000):
            print(measure(rate_hz, given.seconds, folder), flush=True)


if __name__ == '__main__':
    main()
