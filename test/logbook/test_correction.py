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

"""The correction of a run: its sign, its interval, and which runs give none."""

from __future__ import annotations

from logbook.made_up_rows import make_row
import numpy as np
import pytest
from trials import judge_headings

from heading_intercompare.core.angles import wrap180
from heading_intercompare.logbook.correction import list_corrections
from heading_intercompare.logbook.run_row import make_rows

UNITY = tuple(tuple(1e-4 * (row == column) for column in range(5)) for row in range(5))


@pytest.mark.parametrize('offset_deg', [0.0, 3.0, -90.5])
def test_the_correction_added_to_the_tested_heading_gives_the_reference(rng, offset_deg):
    """TS reads offset + 0.4 + 0.2 sin(psi) too much; the correction takes that off again."""
    n = 4000
    rs_deg = (0.9 * np.arange(n)) % 360.0
    ts_deg = (rs_deg + offset_deg + 0.4 + 0.2 * np.sin(np.radians(rs_deg))
              + 0.05 * rng.standard_normal(n)) % 360.0
    correction, = list_corrections(make_rows(judge_headings(
        ts_deg, rs_deg, (1_700_000_000 + np.arange(n)) * 1_000_000_000,
        norms={'sigma_max_deg': 1.0, 'sigma_ref_max_deg': 0.3},
        installation_offset_deg=offset_deg)))[0]
    assert correction.add_to_ts_deg == pytest.approx(-(offset_deg + 0.4), abs=0.01)
    left_deg = wrap180(ts_deg + correction.add_to_ts_deg - rs_deg)
    assert abs(left_deg.mean()) < 0.01 and left_deg.std() > 0.1
    a, b, c, d, e = correction.coefficients_deg
    psi = np.radians(rs_deg)
    left_deg = wrap180(ts_deg + a + b * np.sin(psi) + c * np.cos(psi) + d * np.sin(2 * psi)
                       + e * np.cos(2 * psi) - rs_deg)
    assert abs(left_deg.mean()) < 0.01 and left_deg.std() < 0.06


def test_the_interval_by_hand():
    """Mean 0.1 and offset 0.5, u = 0.01, 10 degrees of freedom: -0.6 +/- 2.228139 * 0.01."""
    correction, = list_corrections([make_row(nu=10.0, installation_offset_deg=0.5)])[0]
    assert (correction.add_to_ts_deg, correction.low_deg, correction.high_deg) == pytest.approx(
        (-0.6, -0.6222814, -0.5777186), abs=1e-7)


@pytest.mark.parametrize('row, why', [
    ({'validity_effect': 'void'}, 'void'),
    ({'mean_deg': None}, 'without a mean and its uncertainty'),
    ({'mean_u_deg': None}, 'without a mean and its uncertainty'),
    ({'nu': None}, 'without a mean and its uncertainty'),
    ({'installation_offset_deg': None}, 'without the installation offset, from an old logbook')])
def test_a_run_that_may_not_count_gives_none_and_is_counted(row, why):
    good = make_row(0, installation_offset_deg=0.0)
    corrections, left_out = list_corrections(
        [good, make_row(1, **{'installation_offset_deg': 0.0, **row})])
    assert [correction.row for correction in corrections] == [good]
    assert left_out == {why: 1}


def test_a_doubtful_run_gives_its_correction():
    assert list_corrections([make_row(validity_effect='doubtful',
                                      installation_offset_deg=0.0)])[1] == {}


@pytest.mark.parametrize('empty_arc_deg, is_given', [(15.0, True), (120.0, True), (121.0, False)])
def test_by_heading_only_where_the_headings_cover_the_compass(empty_arc_deg, is_given):
    correction, = list_corrections([make_row(
        installation_offset_deg=1.5, deviation_coefficients_deg=(0.1, 0.2, -0.3, 0.0, 0.4),
        deviation_covariance_deg2=UNITY, empty_arc_deg=empty_arc_deg)])[0]
    if is_given:
        assert correction.coefficients_deg == pytest.approx((-1.6, -0.2, 0.3, 0.0, -0.4))
        assert correction.u_deg == pytest.approx((0.01,) * 5)
    else:
        assert correction.coefficients_deg is None and correction.u_deg is None
