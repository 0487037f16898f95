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

"""Histories: whose runs they are, and what the charts say of them in words."""

from __future__ import annotations

from dataclasses import replace
import math

from logbook.made_up_rows import DAY_NS, make_row, T0_NS
import numpy as np
import pytest

from heading_intercompare.logbook.history import tell_histories


def rows_of(rng, days=60, shift_at=None, by_deg=0.0, factor=1.0, **given):
    """Return a run a day; from a day on its mean is shifted and its scatter multiplied."""
    changed = np.arange(days) >= (days if shift_at is None else shift_at)
    mean = 0.1 + 0.01 * rng.standard_normal(days) + by_deg * changed
    sd = 0.2 * np.exp(0.03 * rng.standard_normal(days)) * np.where(changed, factor, 1.0)
    return [make_row(day, mean_deg=float(mean[day]), sd_deg=float(sd[day]), mean_u_deg=0.002,
                     **given) for day in range(days)]


def test_an_unchanged_sensor_stays_within_its_limits(rng):
    history, = tell_histories(rows_of(rng))
    assert not history.differs and history.why_no_chart is None
    assert [trend.words.partition(' deg ')[2] for trend in history.trends] == [
        'in the baseline and has stayed within its limits'] * 2
    assert all(p.mean_low_deg < p.row.mean_deg < p.mean_high_deg
               and p.sd_low_deg < p.row.sd_deg < p.sd_high_deg for p in history.points[20:])


def test_a_mean_that_moves_is_dated(rng):
    """60 days from 2024-10-04; the mean moves by 10 standard deviations on day 40, 11-13."""
    history, = tell_histories(rows_of(rng, shift_at=40, by_deg=0.1))
    mean, sd = history.trends
    assert mean.first_outside_ns == mean.differs_since_ns == T0_NS + 40 * DAY_NS
    assert 'it left its limits at 2024-11-13 00:00 UTC' in mean.words
    assert 'it differs since 2024-11-13 00:00 UTC by +0.1021 deg, as the run of ' in mean.words
    assert sd.differs_since_ns is None and history.differs
    # 40 runs watched in two charts: together 5 %.
    assert 1.0 - (1.0 - mean.false_alarm_probability) ** 2 == pytest.approx(0.05)
    assert mean.shift_deg == pytest.approx(0.1, abs=0.01) and sd.shift_deg is None


def test_a_scatter_that_grows_is_dated(rng):
    history, = tell_histories(rows_of(rng, shift_at=45, factor=1.5))
    assert history.trends[0].differs_since_ns is None
    assert history.trends[1].differs_since_ns == T0_NS + 45 * DAY_NS
    assert history.trends[1].center_deg == pytest.approx(0.2, rel=0.03)


def test_each_ship_and_each_set_of_settings_has_a_history_of_its_own(rng):
    rows = [*rows_of(rng, 30, ship='B'), *rows_of(rng, 25, ship='A'),
            *rows_of(rng, 25, ship='A', settings_sha256='b' * 64)]
    found = tell_histories(rows)
    assert [(h.ship, h.settings_sha256[0], len(h.points)) for h in found] == [
        ('B', 'a', 30), ('A', 'a', 25), ('A', 'b', 25)]


def test_the_length_in_control_follows_from_the_ships_and_their_runs(rng):
    """Any of all charts is false with 5 %; few runs keep one in 370."""
    fleet = tell_histories([row for ship in range(10)
                            for row in rows_of(rng, 60, ship=str(ship))])
    watched = 10 * 2 * 40
    assert len({history.runs_between for history in fleet}) == 1
    assert (1.0 - 1.0 / fleet[0].runs_between) ** watched == pytest.approx(0.95)
    assert tell_histories(rows_of(rng, 21))[0].runs_between == 370.0
    assert tell_histories(rows_of(rng, 60), runs_between=99.0)[0].runs_between == 99.0


def test_the_worst_come_first(rng):
    """Sound, outside once, non-compliant, differs: in the reverse order."""
    rows = {name: rows_of(rng, 40, ship=name) for name in 'abcd'}
    rows['b'][-1] = replace(rows['b'][-1], mean_deg=9.0)
    rows['c'][-1] = replace(rows['c'][-1], outcome='non_compliant')
    rows['d'] = rows_of(rng, 40, ship='d', shift_at=30, by_deg=0.5)
    histories = tell_histories([row for ship in rows.values() for row in ship])
    assert [history.ship for history in histories] == ['d', 'c', 'b', 'a']


def test_the_order_of_rows_and_rows_given_twice_do_not_matter(rng):
    rows = rows_of(rng, 30)
    assert tell_histories([*rows[::-1], *rows]) == tell_histories(rows)


def test_void_runs_are_listed_but_not_charted(rng):
    rows = rows_of(rng, 30)
    rows[25] = make_row(25, mean_deg=90.0, validity_effect='void')
    rows[26] = make_row(26, mean_deg=None, mean_u_deg=None, sd_deg=None)
    history, = tell_histories(rows)
    assert len(history.points) == 30 and history.trends[0].watched == 8
    assert not history.differs and history.points[25].mean_low_deg is None


def test_too_few_runs_have_no_chart(rng):
    history, = tell_histories(rows_of(rng, 20))
    assert history.trends == () and len(history.points) == 20
    assert history.why_no_chart == (
        '20 runs with figures; charts need more than the 20 of the baseline')


def test_a_short_run_has_wider_limits(rng):
    """U 0.1 beside 0.002, at a scatter of 0.01 from run to run: about ten times as wide."""
    rows = rows_of(rng, 30)
    rows[28] = make_row(28, mean_deg=0.3, mean_u_deg=0.1)
    history, = tell_histories(rows)
    width = [p.mean_high_deg - p.mean_low_deg for p in history.points]
    assert 5.0 < width[28] / width[27] < 20.0 and not history.points[28].outside


def test_limits_of_the_scatter_are_those_of_its_logarithm(rng):
    history, = tell_histories(rows_of(rng, 30))
    point = history.points[25]
    assert math.sqrt(point.sd_low_deg * point.sd_high_deg) == pytest.approx(
        history.trends[1].center_deg, rel=0.02)
