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

"""Computed minus observed, at the instants of observations."""

from __future__ import annotations

import numpy as np
import pytest

from heading_intercompare.core.observations.corrections import find_corrections, Observations
from heading_intercompare.core.records import Headings

SECOND = 1_000_000_000
START = 1_773_136_800 * SECOND


def observations(t_s, true_deg, ts_deg=np.nan, *, turn=0.0, u=0.0, time_u=0.0):
    """Return observations at seconds after the start."""
    t_s = np.atleast_1d(t_s)
    columns = [np.broadcast_to(np.asarray(c, float), t_s.shape).copy()
               for c in (true_deg, ts_deg, turn, u, time_u)]
    return Observations(START + np.round(t_s * 1e9).astype(np.int64), *columns)


def log(t_s, heading_deg):
    """Return readings at seconds after the start."""
    return Headings.of(START + np.round(np.asarray(t_s) * 1e9).astype(np.int64), heading_deg)


def test_the_ts_is_interpolated_over_north():
    """Halfway between 359 and 1 the TS shows 0; the true heading is 359.5: C - O = -0.5."""
    found = find_corrections(observations(1.0, 359.5), log([0.0, 2.0], [359.0, 1.0]))
    assert found.ts_deg.tolist() == pytest.approx([0.0])
    assert found.c_minus_o_deg.tolist() == pytest.approx([-0.5])


def test_every_observation_is_used_or_counted_with_its_reason():
    ts = log([0.0, 1.0, 2.0, 10.0, 11.0], [90.0] * 5)
    found = find_corrections(observations([-1.0, 0.0, 1.5, 5.0, 11.0, 12.0], 90.0), ts)
    assert found.row.tolist() == [1, 2, 4]
    assert found.not_used == {'outside_the_log': 2, 'gap_in_the_log': 1}
    assert find_corrections(observations([0.0, 1.0], 90.0)).not_used == {'no_ts_reading': 2}
    assert len(find_corrections(observations([], 90.0), ts)) == 0


def test_a_noted_reading_comes_before_the_log():
    found = find_corrections(observations([0.5, 99.0], 90.0, [89.0, 88.0]),
                             log([0.0, 1.0], [80.0, 80.0]))
    assert found.ts_deg.tolist() == [89.0, 88.0]


def test_latency_and_installation_offset_are_removed():
    """The TS turns by 2 deg/s and is 0.5 s late: at 10 s it showed what its stamp 10.5 s says."""
    t = np.arange(0.0, 20.0, 0.1)
    found = find_corrections(observations(10.0, 20.0), log(t, 2.0 * (t - 0.5) + 3.0),
                             latency_s=0.5, offset_deg=3.0)
    assert found.c_minus_o_deg.tolist() == pytest.approx([0.0], abs=1e-9)


def test_the_time_counts_by_the_rate_of_turn():
    """TS turning by 0.2 deg/s, time known to 1 s, u = 0.15: sqrt(0.15² + 0.2²) = 0.25."""
    t = np.arange(0.0, 20.0, 1.0)
    found = find_corrections(observations([0.0, 10.0], [0.0, 2.0], u=0.15, time_u=1.0),
                             log(t, 0.2 * t))
    assert found.rate_deg_s.tolist() == pytest.approx([-0.2, -0.2])
    assert found.u_deg.tolist() == pytest.approx([0.25, 0.25])


def test_the_sun_moves_also_for_a_ship_that_holds_its_heading():
    found = find_corrections(observations(0.0, 120.0, 119.0, turn=0.004, time_u=10.0))
    assert found.u_deg.tolist() == pytest.approx([0.04])


def test_differences_near_180_keep_together():
    found = find_corrections(observations([0.0, 1.0], 270.0, [90.1, 89.9]))
    assert np.ptp(found.c_minus_o_deg) == pytest.approx(0.2)


@pytest.mark.parametrize('readings, step', [([73.6] * 9, 0.1), ([73.0] * 9, 1.0),
                                            ([73.61, 73.6], 0.01), ([np.pi] * 3, None)])
def test_the_step_of_a_ts_that_hardly_changes_is_decimal(readings, step):
    found = find_corrections(observations(0.0, 73.0),
                             log(np.arange(len(readings)), readings))
    assert found.step_deg == (None if step is None else pytest.approx(step))
    assert find_corrections(observations(0.0, 73.0, 73.5), step_deg=0.05).step_deg == 0.05


def test_the_order_and_a_rotation_of_all_headings_change_nothing(rng):
    t = np.arange(0.0, 60.0, 0.5)
    ts = rng.normal(0.0, 0.3, t.size) + 10.0 * np.sin(t / 9.0)
    at = rng.uniform(1.0, 58.0, 12)
    plain = find_corrections(observations(at, 0.5), log(t, ts))
    turned = find_corrections(observations(at[::-1], 180.5), log(t, ts + 180.0))
    assert turned.c_minus_o_deg[::-1] == pytest.approx(plain.c_minus_o_deg, abs=1e-9)


def test_columns_of_different_lengths_do_not_belong_together():
    with pytest.raises(ValueError, match='Observations: columns differ in shape'):
        Observations(np.zeros(2, np.int64), *np.zeros((5, 3)))
