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

"""The total of a ledger, which a live graph asks for several times a second."""

from __future__ import annotations

from collections import Counter

import numpy as np

from heading_intercompare.core.pairing.ledger import Ledger, LedgerKey

MINUTE_NS = 60_000_000_000
ADDED = (LedgerKey.PAIRED, LedgerKey.TS_PAIRED, LedgerKey.RS_USED, LedgerKey.TS_UNPAIRED,
         LedgerKey.RS_INVALID)


def fill(rng, ledger):
    """Count readings of some minutes, with losses, cuts and readings that are settled."""
    for minute in range(1, 13):
        stamps = minute * MINUTE_NS + np.sort(rng.integers(0, MINUTE_NS, 20))
        for key in ADDED:
            ledger.add(key, stamps[rng.random(20) < 0.7])
        # A loss that is taken back counts below zero.
        ledger.lose(LedgerKey.TS_LOST_ON_THE_WAY, stamps[:2], np.array([5, -2]))
        ledger.lose(LedgerKey.RS_BURST, stamps[:1], np.array([3]))
        ledger.cut(int(stamps[10]))
        ledger.cut_run(int(stamps[15]))
        ledger.set_pending('ts', minute % 3)
        ledger.settle(int(stamps[-1]))
        yield minute


def test_the_total_is_the_sum_of_the_segments_at_any_time(rng):
    ledger = Ledger()
    assert ledger.total.counts == {}
    for minute in fill(rng, ledger):
        if minute == 9:
            ledger.forget_before(5 * MINUTE_NS)
        summed = Counter()
        for segment in ledger.segments:
            summed.update(segment.counts)
        assert [*ledger.total.counts.items()] == sorted(summed.items())
        assert Ledger.from_segments(ledger.segments).total == ledger.total
    assert len(ledger.segments) > 10 and ledger.paired > 100


def test_the_total_does_not_divide_readings_among_segments(rng, monkeypatch):
    """That costs milliseconds, and the total is asked for with every beat of a node."""
    ledger = Ledger()
    for _ in fill(rng, ledger):
        pass
    expected = ledger.total
    monkeypatch.setattr(Ledger, '_fold', None)
    assert ledger.total == expected
