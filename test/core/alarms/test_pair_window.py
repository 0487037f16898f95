# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The newest pairs as columns."""

from __future__ import annotations

import numpy as np
import pytest

from heading_intercompare.core.alarms.pair_window import PairWindow
from heading_intercompare.core.pairing.difference import subtract
from heading_intercompare.core.records import Pairs

S_NS = 10 ** 9


@pytest.mark.parametrize('most', [7, 64, 1000])
def test_the_window_holds_the_newest_pairs_however_they_are_cut(rng, most):
    """By a plain filter over all pairs: finite, at most 30 s old, at most `most`."""
    n = 500
    stamps = np.cumsum(rng.integers(1, S_NS, n))
    ts, rs = rng.uniform(0.0, 360.0, (2, n))
    ts[rng.random(n) < 0.1] = np.nan
    pairs, window, lo = Pairs.of(stamps, ts, rs), PairWindow(30.0, most), 0
    while lo < n:
        hi = min(n, lo + int(rng.integers(0, 40)))
        window.update(pairs[lo:hi], subtract(pairs[lo:hi]))
        good = np.flatnonzero(np.isfinite(ts[:hi]))[-most:]
        if good.size:
            good = good[stamps[good] >= stamps[good[-1]] - 30 * S_NS]
        assert window.stamp_ns.tolist() == stamps[good].tolist()
        assert window.rs_deg.tolist() == rs[good].tolist()
        assert window.x_deg.tolist() == subtract(pairs[good]).x_deg.tolist()
        assert len(window) == window.factor.size == good.size
        lo = hi
    at = window.find(3.0)
    assert (window.stamp_ns[at:] >= window.stamp_ns[-1] - 3 * S_NS).all()
    window.clear()
    assert len(window) == 0 and window.x_deg.size == 0


def test_a_window_that_becomes_shorter_drops_what_is_too_old():
    stamps = np.arange(1, 101) * S_NS
    pairs, window = Pairs.of(stamps, np.full(100, 1.0), np.zeros(100)), PairWindow(60.0)
    window.update(pairs[:99], subtract(pairs[:99]))
    window.resize(10.0)
    window.update(pairs[99:], subtract(pairs[99:]))
    assert window.stamp_ns.tolist() == stamps[-11:].tolist()
