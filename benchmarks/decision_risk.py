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
Measure the risks of the decision by simulation; prints the tables of docs/risk.md.

Every process has variance 1, and both the acceptance and the rejection limit are set to 1. "hi"
is how often U is below 1: a TS exactly at its norm is accepted (consumer's risk). "lo" is how
often L is above 1: such a TS is rejected (producer's risk). Each is nominally 0.05. A row fails,
and the exit code is 1, if a rate is above 0.06, or two standard errors above its nominal value.
Rows in brackets are shorter than 20 correlation times, where nothing is promised; they cannot
fail.

    python benchmarks/decision_risk.py --table A
    python benchmarks/decision_risk.py --table A --rows 'Student' --replications 20000 --seed 7
    python benchmarks/decision_risk.py --table rates --jobs 4

Tables: A one run; cells the same with cells of equal time; drift, gaps, rates, short; B lengths
needed; E slow components; runs and means several runs together; looks; open looks whose end is
not planned; stated, stated_lengths and stated_runs the same with the slowest error stated; longer
what a longer run decides; month a gyrocompass by its daily runs.
"""

from __future__ import annotations

import argparse
import multiprocessing
import re
import sys
from time import perf_counter

import history
import numpy as np
from risk_campaigns import Campaign, CAMPAIGNS
from risk_measures import COLUMNS, measure_row, Result, STATED_COLUMNS
from risk_rows import Row, ROWS


def rows_of(table: str) -> list[Row | Campaign]:
    """Return the rows of a table."""
    return list(ROWS[table]() if table in ROWS else CAMPAIGNS[table][0]())


def columns(table: str) -> tuple[str, ...]:
    """Return the heads of its columns."""
    if table == 'stated':
        return STATED_COLUMNS
    return COLUMNS if table in ROWS else CAMPAIGNS[table][1]


def measure(task: tuple[str, str, int, int | None, float]) -> tuple[Result, float]:
    """Measure a row, given as table, name, seed, runs, risk; return the result and its seconds."""
    table, name, seed, wanted, alpha = task
    row = next(r for r in rows_of(table) if r.name == name)
    rng = np.random.default_rng(np.random.SeedSequence([seed, *f'{table}: {name}'.encode()]))
    start = perf_counter()
    if isinstance(row, Row):
        result = measure_row(row, rng, wanted, alpha)
    else:
        result = row.measure(rng, wanted, alpha)
    return result, perf_counter() - start


def replications(text: str) -> int | None:
    """Read the number of runs of a row; None for `auto`."""
    if text == 'auto':
        return None
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"{text!r}: must be a number of at least 1, or 'auto'")
    return int(text)


def main(arguments: list[str] | None = None) -> int:
    """Print the requested tables; return 1 if a row fails."""
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--table', nargs='+', default=['A'], choices=[*ROWS, *CAMPAIGNS])
    parser.add_argument('--replications', type=replications, default='auto',
                        help='runs of each row; auto: 5000, 1000 above 20 000 samples, 400 '
                             'above 100 000')
    parser.add_argument('--rows', default='', help='regular expression for the rows to measure')
    parser.add_argument('--seed', type=int, default=2026)
    parser.add_argument('--alpha', type=float, default=0.05, help='nominal risk of each side')
    parser.add_argument('--jobs', type=int, default=1, help='processes; does not change figures')
    history.add_option(parser)
    given = parser.parse_args(arguments)
    failed, figures = 0, {}
    for table in given.table:
        tasks = [(table, row.name, given.seed, given.replications, given.alpha)
                 for row in rows_of(table) if re.search(given.rows, row.name)]
        heads = columns(table)
        print(f'| {" | ".join(heads)} |\n|{"---|" * len(heads)}', flush=True)
        found = _print(tasks, given.jobs)
        figures |= {f'{table}: rows': len(tasks), f'{table}: rows that fail': found}
        failed += found
        print(flush=True)
    print(f'{failed} rows fail', file=sys.stderr)
    if given.keep:
        history.keep('decision_risk', figures)
    return int(failed > 0)


def _print(tasks: list[tuple], jobs: int) -> int:
    """Print rows in order as they are finished; return how many fail."""
    failed = 0
    with multiprocessing.Pool(jobs) if jobs > 1 else _Here() as workers:
        for k, (result, seconds) in enumerate(workers.imap(measure, tasks), start=1):
            print(result.markdown, flush=True)
            print(f'{tasks[k - 1][0]} {k}/{len(tasks)} {tasks[k - 1][1]}: {seconds:.0f} s'
                  f'{" FAILS" if result.is_failed else ""}', file=sys.stderr, flush=True)
            failed += result.is_failed
    return failed


class _Here:
    """A pool that consists of this process only."""

    imap = staticmethod(map)

    def __enter__(self) -> '_Here':
        return self

    def __exit__(self, *_: object) -> None:
        pass


if __name__ == '__main__':
    sys.exit(main())
