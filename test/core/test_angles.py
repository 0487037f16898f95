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

"""The circle: wraps, means and the quaternion conversion."""

from __future__ import annotations

from hypothesis import given, strategies as st
import numpy as np
import pytest

from heading_intercompare.core.angles import (
    circular_mean,
    heading_from_quaternion,
    quaternion_from_heading,
    unwrap_deg,
    wrap180,
    wrap360,
)

angles = st.floats(-1e6, 1e6)


@given(st.lists(angles, max_size=20), st.floats(-360, 360))
def test_wrap180_stays_in_its_range_and_moves_by_whole_turns(values, center):
    wrapped = wrap180(values, center)
    assert np.all(wrapped >= center - 180.0) and np.all(wrapped < center + 180.0 + 1e-9)
    turns = (np.asarray(values) - wrapped) / 360.0
    assert np.abs(turns - np.round(turns)).max(initial=0.0) < 1e-9


@given(st.lists(angles, max_size=20))
def test_wrap360_stays_in_its_range(values):
    wrapped = wrap360(values)
    assert np.all((wrapped >= 0.0) & (wrapped < 360.0))
    assert np.abs(wrap180(wrapped - values)).max(initial=0.0) < 1e-9


@pytest.mark.parametrize('angle, wrapped', [
    (180.0, -180.0), (-180.0, -180.0), (179.9, 179.9), (540.0, -180.0), (-190.0, 170.0),
    (np.nan, np.nan), (np.inf, np.nan)])
def test_wrap180_at_the_edges(angle, wrapped):
    assert wrap180(angle) == pytest.approx(wrapped, nan_ok=True)


def test_unwrap_goes_on_through_north():
    assert unwrap_deg([359.0, 1.0, 3.0, 358.0]).tolist() == [359.0, 361.0, 363.0, 358.0]
    assert unwrap_deg([]).tolist() == []


def test_circular_mean_of_nothing_and_of_opposites_is_not_a_number():
    assert np.isnan(circular_mean([])).all()
    assert circular_mean(90.0) == (90.0, 1.0)
    assert circular_mean([0.0, 180.0])[1] == pytest.approx(0.0, abs=1e-15)


@given(st.lists(st.floats(0.0, 359.999), max_size=20))
def test_a_heading_survives_the_quaternion(headings):
    z, w = quaternion_from_heading(headings)
    back = heading_from_quaternion(np.zeros(len(headings)), np.zeros(len(headings)), z, w)
    assert np.abs(wrap180(back - headings)).max(initial=0.0) < 1e-12


@pytest.mark.parametrize('yaw_deg, enu, ned', [(0, 90, 0), (90, 0, 90), (-90, 180, 270)])
def test_conventions_by_hand(yaw_deg, enu, ned):
    """REP-103: yaw counts from east to north; in NED it counts from north to east."""
    half = np.radians(yaw_deg) / 2
    q = ([0.0], [0.0], [np.sin(half)], [np.cos(half)])
    assert wrap180(heading_from_quaternion(*q) - enu) == pytest.approx([0.0], abs=1e-12)
    assert wrap180(heading_from_quaternion(*q, 'ned') - ned) == pytest.approx([0.0], abs=1e-12)


def test_roll_and_pitch_do_not_change_the_heading():
    yaw, pitch, roll = np.radians([30.0, 20.0, -15.0])
    cy, sy, cp, sp = np.cos(yaw / 2), np.sin(yaw / 2), np.cos(pitch / 2), np.sin(pitch / 2)
    cr, sr = np.cos(roll / 2), np.sin(roll / 2)
    x = sr * cp * cy - cr * sp * sy
    y = cr * sp * cy + sr * cp * sy
    z = cr * cp * sy - sr * sp * cy
    w = cr * cp * cy + sr * sp * sy
    assert heading_from_quaternion([x], [y], [z], [w]) == pytest.approx([60.0])


def test_a_quaternion_that_is_none_gives_nan():
    q = np.array([[0.0, 0, 0, 0], [np.nan, 0, 0, 1], [np.inf, 0, 0, 1], [1e200, 0, 0, 1e200]]).T
    assert np.isnan(heading_from_quaternion(*q)).all()


def test_an_unknown_convention_is_refused():
    with pytest.raises(ValueError, match="'enu' or 'ned'"):
        heading_from_quaternion([0.0], [0.0], [0.0], [1.0], 'flu')


@pytest.mark.slow
@given(st.lists(st.floats(0.0, 359.999), min_size=1, max_size=40), st.data())
def test_conversions_do_not_depend_on_the_chunk(headings, data):
    """Live nodes convert few at a time, offline programs many: the same headings to the bit."""
    cut = data.draw(st.integers(0, len(headings)))
    z, w = quaternion_from_heading(headings)
    none = np.zeros(len(headings))
    whole = heading_from_quaternion(none, none, z, w)
    parts = [heading_from_quaternion(none[s], none[s], z[s], w[s])
             for s in (slice(None, cut), slice(cut, None))]
    assert np.array_equal(np.concatenate(parts), whole)
    one_by_one = [heading_from_quaternion([0.0], [0.0], [a], [b])[0] for a, b in zip(z, w)]
    assert np.array_equal(one_by_one, whole)


def test_unwrap_adds_whole_turns_and_nothing_else(rng):
    """Three pieces of the cache, turns both ways, and steps of more than a turn."""
    true = np.cumsum(rng.normal(0.0, 30.0, 100_000)) + 500.0 * np.sin(np.arange(100_000) / 20_000)
    unwrapped = unwrap_deg(true % 360.0)
    assert unwrapped == pytest.approx(true - 360.0 * np.floor(true[0] / 360.0), abs=1e-9)
    assert (wrap360(unwrapped) == pytest.approx(true % 360.0, abs=1e-9))
    far = 720.0 * np.arange(50_000) + 10.0
    assert unwrap_deg(far).tolist() == [10.0] * far.size
