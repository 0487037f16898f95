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

"""Differences by heading and by rate of turn: known deviations and lags, each found alone."""

from __future__ import annotations

import dataclasses
import math
from types import SimpleNamespace

import numpy as np
import pytest

from heading_intercompare.core.diagnostics.averaged_pairs import AveragedPairs
from heading_intercompare.core.diagnostics.by_motion import (
    divide_by_motion,
    SECTORS_DEG,
)
from heading_intercompare.core.diagnostics.deviation import fit_deviation
from heading_intercompare.core.timing.skew_instrument import common_tracks


def voyage(t_s, rate_deg_s=1.3, turn_deg=45.0, leg_s=300.0, yaw_deg=0.0):
    """Return headings of legs with a turn after each, eight to starboard, then eight to port."""
    leg, since_s = np.divmod(t_s, leg_s + turn_deg / rate_deg_s)
    turns = 8.0 - np.abs(leg % 16.0 - 8.0)
    way = np.where(leg % 16.0 < 8.0, 1.0, -1.0)
    turned = turn_deg * turns + way * np.clip((since_s - leg_s) * rate_deg_s, 0.0, turn_deg)
    return turned + yaw_deg * np.sin(2.0 * math.pi * t_s / 8.0)


def divide(x, heading, step_s=0.1):
    stamps = 10 ** 18 + np.round(np.arange(x.size) * step_s * 1e9).astype(np.int64)
    pairs = AveragedPairs.of(common_tracks(stamps, x, heading % 360.0), x.size,
                             float(np.sum((x - x.mean()) ** 2)), 0.0)
    return divide_by_motion(pairs, fit_deviation(x, heading % 360.0))


def rows(columns):
    """Return a namespace for each sector or band."""
    names = [field.name for field in dataclasses.fields(columns)]
    return [SimpleNamespace(**dict(zip(names, row, strict=True)))
            for row in zip(*(getattr(columns, name) for name in names), strict=True)]


def late_ts(lag_s, t_s, **ship):
    return voyage(t_s - lag_s, **ship) - voyage(t_s, **ship)


T_S = np.arange(60_000) / 10.0


def test_fewer_than_64_pairs_give_no_rows():
    assert divide_by_motion(None, fit_deviation([], [])) is None


def test_sound_sensors_show_neither_deviation_nor_lag(rng):
    found = divide(0.1 * rng.standard_normal(T_S.size), voyage(T_S))
    assert found.sectors.heading_deg == SECTORS_DEG
    assert [*zip(found.turns.from_deg_s, found.turns.to_deg_s)] == [
        (-2.0, -1.0), (-1.0, -0.5), (-0.5, 0.0), (0.0, 0.5), (0.5, 1.0), (1.0, 2.0)]
    for row in (*rows(found.sectors), *rows(found.turns)):
        assert abs(row.mean_deg) < 6.0 * 0.1 / math.sqrt(row.n)
        assert row.std_deg == pytest.approx(0.1, abs=6.0 * 0.1 / math.sqrt(2.0 * row.n))


def test_a_deviation_is_found_on_each_heading(rng):
    heading = voyage(T_S)
    deviation = 0.3 * np.sin(np.radians(heading)) + 0.2 * np.cos(np.radians(2.0 * heading))
    found = divide(deviation + 0.05 * rng.standard_normal(T_S.size), heading)
    for row in rows(found.sectors):
        psi = math.radians(row.heading_deg)
        expected = 0.3 * math.sin(psi) + 0.2 * math.cos(2.0 * psi)
        assert row.low_deg - 0.004 < expected < row.up_deg + 0.004
        assert row.duration_s == pytest.approx(row.n / 10.0, rel=0.01)


@pytest.mark.parametrize('rate', [1.3, 3.0, 7.0, 15.0])
def test_a_lag_is_found_in_turns_alone(rate, rng):
    """A TS that follows 0.4 s late points to port in a turn to starboard, by 0.4 s of it."""
    ship = {'rate_deg_s': rate, 'turn_deg': 405.0}
    found = divide(late_ts(0.4, T_S, **ship) + 0.02 * rng.standard_normal(T_S.size),
                  voyage(T_S, **ship))
    assert max(abs(row.mean_deg) for row in rows(found.sectors)) < 0.005
    turns = [row for row in rows(found.turns) if row.from_deg_s < rate < row.to_deg_s
             or row.from_deg_s < -rate < row.to_deg_s]
    port, starboard = turns
    assert port.rate_deg_s == pytest.approx(-rate, rel=0.1)
    assert starboard.rate_deg_s == pytest.approx(rate, rel=0.1)
    for row in turns:
        assert row.mean_deg == pytest.approx(-0.4 * row.rate_deg_s, rel=0.1)
        assert row.n > 100


def test_a_lag_in_a_swell_bends_no_sector(rng):
    x = late_ts(0.5, T_S, yaw_deg=3.0) + 0.02 * rng.standard_normal(T_S.size)
    found = divide(x, voyage(T_S, yaw_deg=3.0))
    assert all(row.duration_s > 400.0 for row in rows(found.sectors))
    assert max(abs(row.mean_deg) for row in rows(found.sectors)) < 0.01


def test_a_ship_that_turns_all_the_time_has_no_sector(rng):
    found = divide(0.1 * rng.standard_normal(T_S.size), 0.5 * T_S)
    assert found.sectors.n == (0,) * 8 and found.sectors.mean_deg == (None,) * 8
    assert sum(row.n for row in rows(found.turns)) == pytest.approx(T_S.size, rel=0.01)


def test_headings_that_are_not_sailed_are_empty(rng):
    found = divide(0.1 * rng.standard_normal(T_S.size), np.full(T_S.size, 91.0))
    *others, east = sorted(rows(found.sectors), key=lambda row: row.n)
    assert east.heading_deg == 90.0 and east.n == pytest.approx(T_S.size, rel=0.01)
    assert all((row.n, row.duration_s, row.mean_deg, row.std_deg, row.low_deg)
               == (0, 0.0, None, None, None) for row in others)


def test_headings_turned_by_a_sector_turn_the_rows(rng):
    x, heading = 0.1 * rng.standard_normal(T_S.size), voyage(T_S)
    found, turned = divide(x, heading), divide(x, heading + 45.0)
    assert turned.sectors.n[1:] + turned.sectors.n[:1] == found.sectors.n
    assert turned.sectors.mean_deg[1:] == pytest.approx(found.sectors.mean_deg[:-1], abs=1e-9)
    assert turned.turns.n == found.turns.n


def test_a_silence_gives_no_rate_and_no_steady_heading(rng):
    """Of two legs apart by five minutes, the ship may have turned between."""
    x = 0.1 * rng.standard_normal(6000)
    heading = np.repeat([10.0, 100.0], 3000)
    t_s = np.arange(6000) / 10.0
    t_s[3000:] += 300.0
    stamps = 10 ** 18 + np.round(t_s * 1e9).astype(np.int64)
    pairs = AveragedPairs.of(common_tracks(stamps, x, heading), x.size, float(x @ x), 0.0)
    found = divide_by_motion(pairs, fit_deviation(x, heading))
    assert [row.heading_deg for row in rows(found.sectors) if row.n] == [0.0, 90.0]
    assert sum(row.n for row in rows(found.sectors)) == 6000 - 4 * 150
    assert [*zip(found.turns.from_deg_s, found.turns.to_deg_s)] == [(0.0, 0.5)]


def test_a_noisy_rs_has_longer_rates(rng):
    noise = 2.0 * rng.standard_normal(6000)
    found = divide(-noise, voyage(np.arange(6000.0)) + noise, step_s=1.0)
    quiet = divide(0.0 * noise, voyage(np.arange(6000.0)), step_s=1.0)
    assert (quiet.rate_span_s, found.rate_span_s) == (2.0, 8.0)


@pytest.mark.slow
def test_the_rows_of_a_long_run_are_those_of_every_reading(rng):
    """At 100 Hz the averages keep number, mean and scatter."""
    t_s = np.arange(1_200_000) / 100.0
    x = 0.1 * rng.standard_normal(t_s.size) + late_ts(0.3, t_s)
    found, thinned = (divide(x[::every], voyage(t_s[::every]), every / 100.0)
                     for every in (1, 10))
    for row, other in zip(rows(found.sectors), rows(thinned.sectors)):
        assert row.n == pytest.approx(10 * other.n, rel=0.01)
        assert row.std_deg == pytest.approx(other.std_deg, rel=0.05)
        assert row.mean_deg == pytest.approx(other.mean_deg, abs=0.005)
