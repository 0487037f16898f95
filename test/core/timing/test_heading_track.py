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

"""The heading of a sensor as a function of time, looked up at once or step by step."""

from __future__ import annotations

import numpy as np
import pytest

from heading_intercompare import Headings
from heading_intercompare.core.timing.heading_track import RisingTimes, select_usable, Track


def track_of(t_s, heading_deg):
    """Return a track with its time zero at stamp 0."""
    return Track(Headings.as_sent(np.rint(np.asarray(t_s) * 1e9).astype(np.int64), heading_deg))


def test_rising_times_by_hand():
    """From 350 deg in 10 s to 10 deg, then in 1 s to 40 deg."""
    rising = RisingTimes(track_of([0.0, 10.0, 11.0], [350.0, 10.0, 40.0]), np.array([0.0, 9.0]))
    assert rising.at(np.array([0.0, 9.0])).tolist() == [350.0, 368.0]
    assert rising.at(np.array([5.0, 10.5])).tolist() == [360.0, 385.0]
    assert rising.at(np.array([10.0, 11.0])).tolist() == [370.0, 400.0]


@pytest.mark.parametrize('step_s', [0.0, 0.003, 0.1, 7.0])
def test_rising_times_give_what_a_search_gives(rng, step_s):
    """Readings at uneven times, with gaps that a time crosses at once or waits in."""
    t_s = np.cumsum(rng.choice([0.01, 0.02, 0.5, 20.0], 3000, p=[0.5, 0.45, 0.04, 0.01]))
    track = track_of(t_s, np.cumsum(rng.standard_normal(3000)) % 360.0)
    first_s, steps = rng.uniform(t_s[0], t_s[-1] - 40.0 * step_s, 500), range(41)
    rising = RisingTimes(track, first_s)
    for k in steps:
        at_s = np.minimum(first_s + k * step_s, t_s[-1])
        assert rising.at(at_s).tolist() == pytest.approx(track.at(at_s).tolist(), rel=1e-15)


def test_a_long_track_knows_its_times_step_and_gaps(rng):
    """In pieces of 16384 readings, beyond a million seconds from the origin."""
    stamp_ns = 10 ** 18 + np.cumsum(rng.integers(9_000_000, 11_000_000, 50_000))
    stamp_ns[30_000:] += 5 * 10 ** 9
    track = Track(Headings.as_sent(stamp_ns, np.zeros(50_000)), 999 * 10 ** 15)
    assert (track.t_s == (stamp_ns - 999 * 10 ** 15) / 1e9).all()
    assert track.step_s == pytest.approx(np.median(np.diff(stamp_ns)) / 1e9)
    middle_s = 0.5 * (track.t_s[29_999] + track.t_s[30_000])
    for max_gap_s, covered in ((4.0, False), (6.0, True), (np.inf, True), (4.0, False)):
        assert track.covers(np.array([middle_s - 3.0]), np.array([middle_s + 3.0]),
                            max_gap_s).tolist() == [covered]


def test_only_finite_readings_with_increasing_stamps_are_usable():
    headings = Headings.as_sent([1, 2, 2, 5, 4, 6, 7], [1.0, np.nan, 3.0, 4.0, 5.0, 6.0, np.inf])
    assert select_usable(headings).stamp_ns.tolist() == [1, 2, 5, 6]
    sound = headings[[0, 3, 5]]
    assert select_usable(sound) is sound
