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

"""The track keeps its shape in bounded memory."""

from __future__ import annotations

import numpy as np
import pytest

from heading_intercompare.core.records import Motion
from heading_intercompare.report.sketching.track import MOST_POSITIONS, Track

S = 10 ** 9
START_NS = 1_700_000_000 * S


def sailed(n, step_ns=S // 2):
    """Return n positions on a line."""
    at = np.arange(n)
    return Motion.of_positions(START_NS + at * step_ns, 50.0 + 1e-5 * at, 10.0 + 2e-5 * at)


def of(*chunks):
    """Return the track of some chunks."""
    track = Track()
    for chunk in chunks:
        track.update(chunk)
    return track


@pytest.mark.parametrize('n, step_s', [(100, 1.0), (20_000, 4.0), (200_000, 32.0)])
def test_a_record_of_any_length_keeps_few_positions_all_along(n, step_s):
    motion, track = sailed(n), of(sailed(n))
    assert track.n == n and track.step_s == step_s
    assert min(n / 2.1, MOST_POSITIONS / 2.1) < len(track.positions) <= MOST_POSITIONS
    assert track.positions.stamp_ns[0] == START_NS
    assert motion.stamp_ns[-1] - track.positions.stamp_ns[-1] < step_s * S
    assert np.ptp(np.diff(track.positions.stamp_ns)) == 0


def test_the_chunks_do_not_matter(rng):
    motion = sailed(30_000)
    cuts = [0, *np.sort(rng.choice(30_000, 40, replace=False)).tolist(), 30_000]
    pieces = [motion[lo:hi] for lo, hi in zip(cuts[:-1], cuts[1:])]
    assert of(*pieces).positions == of(motion).positions


def test_rows_without_a_position_and_empty_chunks_do_not_count():
    motion = sailed(10) + Motion.of_rates([START_NS + 90 * S], [1.0])
    track = of(Motion.empty(), motion, Motion.empty())
    assert track.n == 10 and len(track.positions) == 5
    assert len(of().positions) == 0


def test_positions_before_the_last_one_are_skipped():
    motion = sailed(20)
    assert of(motion[10:], motion[:10]).positions == of(motion[10:]).positions
