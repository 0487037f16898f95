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

"""The row of a run holds the figures of its verdict."""

from __future__ import annotations

import math

from logbook.made_up_rows import make_row
import numpy as np
import pytest
from trials import judge_headings

from heading_intercompare.logbook.logbook_file import Logbook
from heading_intercompare.logbook.run_row import make_rows

S = 1_000_000_000


def judge(rng, n=2000, **more):
    rs_deg = 90.0 + 0.01 * rng.standard_normal(n)
    return judge_headings(90.05 + 0.1 * rng.standard_normal(n), rs_deg,
                          (1_700_000_000 + np.arange(n)) * S, **{
                              'norms': {'sigma_max_deg': 0.2, 'sigma_ref_max_deg': 0.1}, **more})


def test_a_row_has_the_figures_of_the_verdict(rng):
    verdict = judge(rng)
    run, = verdict.runs
    row, = make_rows(verdict, ship='MV Example', find_bag=lambda source: f'/bags/{source}')
    assert (row.ship, row.bag, row.source) == ('MV Example', '/bags/', '')
    assert (row.start_ns, row.end_ns, row.n) == (run.start_ns, run.end_ns, run.n)
    assert (row.mean_deg, row.sd_deg, row.nu) == (run.mean_deg, run.std_deg, run.guarded.nu)
    assert (row.outcome, row.headline) == (run.outcome.value, run.headline)
    assert (row.paired, row.ts_received) == (run.pairing.paired, run.pairing.ts_received)
    assert row.settings_sha256 == verdict.settings_sha256
    # The errors are white, so the mean of n is known to sd / sqrt(n), within a third.
    assert abs(math.log(row.mean_u_deg / (0.1 / math.sqrt(2000)))) < 0.33


def test_conditions_that_bind_are_listed(rng):
    row, = make_rows(judge(rng, **{'detectors.mean_max_deg': 0.01}))
    assert row.validity_effect == 'void' and 'mean' in row.conditions


def test_the_row_of_a_run_without_figures_can_be_written(rng, tmp_path):
    rows = make_rows(judge(rng, n=1))
    assert rows[0].sd_deg is None and rows[0].mean_u_deg is None
    Logbook(tmp_path / 'l').write(rows)
    assert Logbook(tmp_path / 'l').read() == rows


def test_earlier_runs_come_first(rng):
    verdict = judge(rng, n=3600, **{'runs.every_h': 0.2, 'runs.keep': 2})
    rows = make_rows(verdict, earlier=judge(rng, n=300).runs)
    assert [row.start_ns for row in rows] == sorted(row.start_ns for row in rows)
    assert len(rows) == len(verdict.runs) + 1


def turn(rng, offset_deg, n=4000):
    """Return the row of a run around the compass: TS - RS is offset + 0.4 + 0.2 sin(psi)."""
    rs_deg = (0.9 * np.arange(n)) % 360.0
    ts_deg = rs_deg + offset_deg + 0.4 + 0.2 * np.sin(np.radians(rs_deg))
    row, = make_rows(judge_headings(
        (ts_deg + 0.05 * rng.standard_normal(n)) % 360.0, rs_deg,
        (1_700_000_000 + np.arange(n)) * S,
        norms={'sigma_max_deg': 1.0, 'sigma_ref_max_deg': 0.3},
        installation_offset_deg=offset_deg))
    return row


@pytest.mark.parametrize('offset_deg', [0.0, 3.0, -179.8])
def test_the_mean_as_measured_has_the_installation_offset_in_it(rng, offset_deg):
    row = turn(rng, offset_deg)
    assert row.installation_offset_deg == offset_deg
    assert row.mean_deg == pytest.approx(0.4, abs=0.01)
    assert row.measured_mean_deg == pytest.approx(
        (offset_deg + 0.4 + 180.0) % 360.0 - 180.0, abs=0.01)


def test_the_dependence_on_the_heading_comes_back_to_the_bit(rng, tmp_path):
    row = turn(rng, 1.0)
    assert row.deviation_coefficients_deg == pytest.approx((0.4, 0.2, 0.0, 0.0, 0.0), abs=0.01)
    assert np.shape(row.deviation_covariance_deg2) == (5, 5) and row.empty_arc_deg < 1.0
    Logbook(tmp_path / 'l').write([row])
    assert Logbook(tmp_path / 'l').read() == [row]


def test_a_mean_as_measured_is_unknown_without_the_offset():
    assert make_row().measured_mean_deg is None
    assert make_row(mean_deg=None, installation_offset_deg=1.0).measured_mean_deg is None
