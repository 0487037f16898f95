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

"""Days: the worst verdict of all runs, and figures of those that count."""

from __future__ import annotations

from logbook.made_up_rows import DAY_NS, make_row, T0_NS
import numpy as np
import pytest

from heading_intercompare.core.outcome import Outcome
from heading_intercompare.logbook.days import list_days, SECTORS

HOUR_NS = DAY_NS // 24
UNITY = tuple(tuple(4e-4 * (row == column) for column in range(5)) for row in range(5))


def run(hour, **more):
    """Return the row of a run of an hour, with an installation offset of 1 deg."""
    return make_row(start_ns=T0_NS + hour * HOUR_NS, end_ns=T0_NS + (hour + 1) * HOUR_NS - 1,
                    n=3600, **{'installation_offset_deg': 1.0, **more})


def test_a_day_by_hand():
    """
    Means 0.1, 0.3 and 0.2: mean 0.2, s = 0.1, u = 0.1 / sqrt(3) = 0.0577350.

    With the offset, TS - RS is 1.2 as measured.
    """
    day, = list_days([run(0, mean_deg=0.1), run(5, mean_deg=0.3, sd_deg=0.4),
                      run(9, mean_deg=0.2)])
    assert (day.date, day.runs, day.counted, day.n) == ('2024-10-04', 3, 3, 10800)
    assert (day.mean.mean_deg, day.mean.u_deg) == pytest.approx((0.2, 0.0577350), abs=1e-6)
    assert (day.add_to_ts.mean_deg, day.add_to_ts.u_deg) == pytest.approx(
        (-1.2, 0.0577350), abs=1e-6)
    assert day.sd_deg == 0.4 and day.add_to_ts_on == {}


def test_a_run_belongs_to_the_day_on_which_it_begins():
    days = list_days([run(hour) for hour in (0, 22, 23, 24, 72)])
    assert [(day.date, day.runs) for day in days] == [
        ('2024-10-04', 3), ('2024-10-05', 1), ('2024-10-07', 1)]


@pytest.mark.parametrize('outcomes, outcome', [
    (['compliant', 'compliant'], Outcome.COMPLIANT),
    (['compliant', 'indeterminate'], Outcome.INDETERMINATE),
    (['non_compliant', 'indeterminate', 'compliant'], Outcome.NON_COMPLIANT)])
def test_the_worst_verdict_is_that_of_the_day(outcomes, outcome):
    outcomes = [word.replace('non_compliant', Outcome.NON_COMPLIANT.value) for word in outcomes]
    day, = list_days([run(hour, outcome=word) for hour, word in enumerate(outcomes)])
    assert day.outcome is outcome


def test_a_void_run_is_in_the_verdict_of_its_day_and_in_no_figure():
    day, = list_days([run(0), run(1, mean_deg=90.0, sd_deg=50.0, validity_effect='void')])
    assert (day.effect, day.runs, day.counted, day.n) == ('void', 2, 1, 3600)
    assert day.mean.mean_deg == pytest.approx(0.1) and day.sd_deg == 0.2
    day, = list_days([run(1, validity_effect='void')])
    assert (day.mean, day.sd_deg, day.add_to_ts, day.n) == (None, None, None, 0)


def test_a_correction_near_180_is_averaged_on_the_circle():
    day, = list_days([run(0, mean_deg=178.9), run(1, mean_deg=-180.9)])
    assert abs(day.add_to_ts.mean_deg) == pytest.approx(180.0)


def test_without_the_installation_offset_a_day_has_no_correction():
    day, = list_days([run(0, installation_offset_deg=None)])
    assert day.add_to_ts is None and day.mean.mean_deg == pytest.approx(0.1)


def test_the_correction_by_heading_by_hand():
    """
    TS - RS = 0.5 sin(psi) + 1 deg of offset: -1 on N, -1.5 on E, -0.5 on W.

    On N the variance is that of A, C and E: u = sqrt(3 * 4e-4) = 0.0346410; each of two runs.
    """
    fit = {'deviation_coefficients_deg': (0.0, 0.5, 0.0, 0.0, 0.0), 'empty_arc_deg': 10.0,
           'deviation_covariance_deg2': UNITY}
    day, = list_days([run(0, **fit), run(1, **fit), run(2),
                      run(3, **{**fit, 'empty_arc_deg': 200.0})])
    on = day.add_to_ts_on
    assert [*on] == [*SECTORS]
    assert [on[name].mean_deg for name in ('N', 'E', 'S', 'W')] == pytest.approx(
        [-1.0, -1.5, -1.0, -0.5])
    assert on['N'].u_deg == pytest.approx(0.0346410 / np.sqrt(2.0), abs=1e-6)
