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

"""A run in progress takes no memory, and is judged as if it were in memory."""

from __future__ import annotations

import json
import tracemalloc

import numpy as np
import pytest

from heading_intercompare.core.pipeline import Compliance
from heading_intercompare.core.records import Pairs
from heading_intercompare.core.settings import Settings
from heading_intercompare.journal.spool import Spool

SETTINGS = Settings.from_mapping({
    'norms.sigma_max_deg': 0.4, 'norms.sigma_ref_max_deg': 0.3, 'window_s': 60.0,
    'sequential.plan_s': 6000.0})


def pairs(rng, lo: int, hi: int) -> Pairs:
    """Return pairs at 100 Hz."""
    number = np.arange(lo, hi)
    rs_deg = 90.0 + 40.0 * np.sin(number / 30_000.0)
    error_deg = 0.2 * rng.standard_normal(len(number)) + 0.1 * np.sin(number / 9000.0)
    return Pairs.of(10**18 + number * 10**7, rs_deg + error_deg, rs_deg,
                    np.full(len(number), 10**6), np.ones(len(number)))


def judged(keeper, count: int = 300_000, step: int = 5000) -> str:
    """Return the verdict on one run as JSON."""
    compliance, rng = Compliance(SETTINGS, keeper=keeper), np.random.default_rng(4)
    for lo in range(0, count, step):
        compliance.update(pairs(rng, lo, min(lo + step, count)))
    compliance.finish()
    return json.dumps(compliance.verdict().to_dict())


def test_pages_come_back_as_they_were(tmp_path, rng):
    spool = Spool(folder=str(tmp_path))
    sent = [rng.standard_normal(n) for n in (1000, 1, 65536)] + [np.arange(70, dtype=np.int64)]
    pages = [spool.keep(page) for page in sent]
    for page, expected in reversed(list(zip(pages, sent))):
        assert page().dtype == expected.dtype
        assert np.array_equal(page(), expected)
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
def test_the_verdict_is_the_same(tmp_path):
    assert judged(lambda: Spool(folder=str(tmp_path)).keep) == judged(lambda: None)


@pytest.mark.slow
def test_a_page_that_cannot_be_written_stays_in_memory(tmp_path):
    faults = []
    lost = str(tmp_path / 'gone')
    assert judged(lambda: Spool(faults.append, lost).keep, 80_000) == judged(lambda: None, 80_000)
    assert set(faults) == {'No such file or directory'}


@pytest.mark.slow
def test_memory_does_not_grow_with_the_run(tmp_path):
    compliance = Compliance(SETTINGS, keeper=lambda: Spool(folder=str(tmp_path)).keep)
    rng, held = np.random.default_rng(4), []
    tracemalloc.start()
    try:
        for lo in range(0, 1_400_000, 10_000):
            compliance.update(pairs(rng, lo, lo + 10_000))
            compliance.run_figures()
            held.append(tracemalloc.get_traced_memory()[0])
    finally:
        tracemalloc.stop()
    # All pairs would be 24 MB more from the 400 000th to the last.
    assert held[-1] - held[40] < 1_000_000


@pytest.mark.slow
@pytest.mark.parametrize('count', [65536, 65537, 131072])
def test_runs_that_end_with_a_page_are_judged_alike(tmp_path, count):
    assert judged(lambda: Spool(folder=str(tmp_path)).keep, count) == judged(lambda: None, count)
