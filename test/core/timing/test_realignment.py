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

"""Differences without a skew: by hand, at the ends of a run, across a gap, without pairs."""

from __future__ import annotations

import numpy as np
import pytest

from heading_intercompare.core.timing.realignment import move_pairs, realign

S = 1_000_000_000


def test_differences_without_a_skew_by_hand():
    """RS 0, 2, 4, 8; TS 1.5 s late shows 0 at 1.5 s, 2 at 2.5 s: two of four pairs remain."""
    stamps = np.arange(4) * S
    rs = np.array([0.0, 2.0, 4.0, 8.0])
    ts = np.array([-3.0, -1.0, 1.0, 3.0])
    kept, x, factor = realign(stamps, ts - rs, rs, 1.5)
    assert kept.tolist() == [2 * S, 3 * S]
    assert (x.tolist(), factor) == ([0.0, 0.0], 0.5)
    kept, x, _ = realign(stamps, ts - rs, rs, -1.0)
    assert (kept.tolist(), x.tolist()) == ([0, S, 2 * S], [-5.0, -5.0, -7.0])


def test_moved_pairs_by_hand():
    """As above; the RS of the pairs that remain is read 1.5 s earlier: 1 and 3."""
    stamps, rs = np.arange(4) * S, np.array([0.0, 2.0, 4.0, 8.0])
    kept, x, moved = move_pairs(stamps, np.array([-3.0, -3.0, -3.0, -5.0]), rs, 1.5)
    assert (kept.tolist(), x.tolist(), moved.tolist()) == ([2 * S, 3 * S], [0.0, 0.0], [1.0, 3.0])


@pytest.mark.parametrize('late_s', [0.7, -0.7])
def test_no_heading_is_made_up_at_the_ends_or_over_a_gap(late_s, rng):
    """A gap of 100 s in which the ship turns: only real readings remain, without error."""
    t = np.concatenate((np.arange(0.0, 60.0, 0.1), np.arange(160.0, 220.0, 0.1)))

    def heading(at_s):
        return 350.0 + 2.0 * at_s + np.sin(at_s) ** 3
    rs = heading(t) % 360.0
    kept, x, _ = realign(np.rint(t * 1e9).astype(np.int64), heading(t - late_s) - heading(t),
                         rs, late_s)
    assert t.size - kept.size == 14
    assert np.abs(x).max() < 0.02


def test_a_skew_of_zero_changes_nothing(rng):
    stamps, x, rs = np.arange(9) * S, rng.standard_normal(9), np.linspace(0.0, 80.0, 9)
    kept, same, factor = realign(stamps, x, rs, 0.0)
    assert (kept.size, factor) == (9, 1.0)
    assert same == pytest.approx(x)


@pytest.mark.parametrize('n', [0, 1])
def test_nothing_is_left_of_nothing(n):
    kept, x, factor = realign(np.arange(n), np.zeros(n), np.zeros(n), 0.5)
    assert (kept.size, x.size, factor) == (0, 0, 1.0)
    assert [part.size for part in move_pairs(np.arange(n), np.zeros(n), np.zeros(n), 0.5)] \
        == [0, 0, 0]
