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

"""The search for a skew: the correlogram by a plain loop, without motion, with noise."""

from __future__ import annotations

import numpy as np
import pytest

from heading_intercompare.core.records import Headings
from heading_intercompare.core.timing.heading_track import Track
from heading_intercompare.core.timing.skew_instrument import Instrument
from heading_intercompare.core.timing.skew_search import (
    coarsen,
    compute_correlogram,
    find_skew,
    has_turned,
)


def track(t_s, heading_deg):
    """Return a track of headings that need no unwrapping."""
    made = Track(Headings.empty())
    made.t_s, made.heading_deg = np.asarray(t_s, float), np.asarray(heading_deg, float)
    return made


def test_the_correlogram_agrees_with_a_plain_loop(rng):
    """Rates over a second at quarters of one, about their means; the ends allowed for."""
    t = np.arange(0.0, 60.25, 0.25)
    ts, rs = rng.standard_normal((2, t.size)).cumsum(axis=1)
    found = compute_correlogram(track(t, ts), track(t, rs), 5.0)
    a, b = np.zeros(t.size), np.zeros(t.size)
    for rate, heading in ((a, ts), (b, rs)):
        rate[2:-2] = heading[4:] - heading[:-4]
        rate[2:-2] -= rate[2:-2].mean()
    for k in range(-20, 21):
        plain = sum(a[i] * b[i - k] for i in range(t.size) if 0 <= i - k < t.size)
        plain /= np.sqrt((a @ a) * (b @ b)) * (1.0 - abs(k) / 240.0)
        assert found.value[20 + k] == pytest.approx(plain, abs=1e-9)
    assert found.lag_s.tolist() == (0.25 * np.arange(-20, 21)).tolist()


def test_long_runs_are_correlated_in_segments(rng):
    """Three hours are two segments and more: the highest value is at the true skew."""
    t = np.arange(0.0, 10_800.0, 0.25)

    def heading(at_s):
        return np.sin(1.1 * at_s) + 5.0 * np.sin(0.13 * at_s)

    found = compute_correlogram(track(t, heading(t - 7.25)), track(t, heading(t)))
    assert found.lag_s[np.argmax(found.value)] == 7.25
    assert found.value.max() == pytest.approx(1.0, abs=0.01)


def test_peaks_are_the_nearest_of_those_alike():
    t = np.arange(0.0, 1200.0, 0.25)
    ts, rs = (track(t, np.sin(np.pi * (t - late) / 4.0)) for late in (1.1, 0.0))
    found = compute_correlogram(ts, rs)
    assert found.starts(0.0, -20.0, 20.0)[:3] == pytest.approx([1.1, -6.9, 9.1], abs=0.02)
    assert found.starts(0.0, -2.0, 0.5) == []


def test_sensors_that_stand_still_have_no_skew(rng):
    t = np.arange(0.0, 300.0, 0.25)
    still = track(t, np.full(t.size, 7.0))
    assert not compute_correlogram(still, still).value.any()
    noisy = [track(t, 0.1 * rng.standard_normal(t.size)) for _ in range(2)]
    assert find_skew(Instrument(*noisy, 0.5, 3.0), 0.0, 2.0) is None
    assert not has_turned(noisy[1]) and not has_turned(still)
    assert has_turned(track(t, np.sin(t)))


def test_a_coarser_track_by_hand():
    t = 0.1 * np.arange(128)
    found = coarsen(track(t, t), 0.25)
    assert len(found) == 64
    assert found.t_s[:2] == pytest.approx([0.05, 0.25])
    assert coarsen(found, 0.25) is found
    empty = track([], [])
    assert coarsen(empty, 0.25) is empty
