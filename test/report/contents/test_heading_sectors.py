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

"""The table by heading: sectors centred on N, NE, E..., each with what its readings give."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from trials import make_settings

from heading_intercompare import analyze, Headings, pair
from heading_intercompare.report import SeriesSketch
from heading_intercompare.report.contents.heading_sectors import tabulate_sectors
from heading_intercompare.report.figures.drawing import Subject


def tabulate(rs_deg, error_deg, **changes):
    """Return the rows for a TS with these errors; `changes` are made in the correlation."""
    rules = make_settings(pairing__method='nearest')
    stamps = (np.arange(len(rs_deg)) + 1_700_000_000) * 10 ** 9
    trial = (Headings.of(stamps, np.mod(rs_deg + error_deg, 360.0)), Headings.of(stamps, rs_deg))
    sketch, verdict = SeriesSketch(), analyze(*trial, rules)
    sketch.update(pair(*trial, rules)[0], rules)
    about = Subject.of(sketch, verdict)
    runs = [replace(run, correlation=replace(run.correlation, **changes)) for run in about.runs]
    return tabulate_sectors(replace(about, runs=runs)).rows


def test_each_sector_has_count_mean_and_deviation_of_its_readings(rng):
    rs_deg = rng.uniform(0.0, 360.0, 2000)
    error_deg = 0.5 * np.cos(np.radians(rs_deg)) + rng.normal(0.0, 0.1, 2000)
    rows = tabulate(rs_deg, error_deg)
    at = np.floor(np.mod(rs_deg + 22.5, 360.0) / 45.0)
    assert sum(int(row[1]) for row in rows) == 2000
    assert [row[0] for row in rows][:2] == ['N: 337.5 to 22.5', 'NE: 22.5 to 67.5']
    assert rows[7][0] == 'NW: 292.5 to 337.5'
    for k, (_, n, mean, _, std) in enumerate(rows):
        inside = error_deg[at == k]
        assert int(n) == len(inside)
        assert float(mean) == pytest.approx(inside.mean(), abs=6e-3)
        assert float(std) == pytest.approx(inside.std(ddof=1), rel=6e-3)


def test_the_interval_of_a_mean_by_hand():
    """
    400 differences of one sector, 0.1 and 0.3 in turn: mean 0.2, deviation 0.10013.

    At a worth of a tenth each they are 40 independent ones: 2.0227 * 0.10013 / sqrt(40) = 0.0320.
    """
    error_deg = np.tile((0.1, 0.3), 200)
    east = tabulate(np.full(400, 90.0), error_deg, closed=True, n=400, n_effective_mean=40.0)[2]
    assert east == ['E: 67.5 to 112.5', '400', '0.200', '0.168 to 0.232', '0.100']


@pytest.mark.parametrize('changes', [
    {'closed': False}, {'closed': True, 'n_effective_mean': 4.9},
    {'closed': True, 'n': 0, 'n_effective_mean': 0.0}])
def test_without_enough_independent_differences_there_is_no_interval(changes):
    east = tabulate(np.full(400, 90.0), np.tile((0.1, 0.3), 200), **{'n': 400, **changes})[2]
    assert east[1:4] == ['400', '0.2', '-']


def test_a_heading_that_the_ship_did_not_take_has_only_dashes():
    rows = tabulate(np.full(400, 90.0), np.tile((0.1, 0.3), 200))
    assert rows[0] == ['N: 337.5 to 22.5', '0', '-', '-', '-']
