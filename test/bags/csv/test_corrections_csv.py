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

"""The correction as a time series: its sign, flags and window, and an interval that holds."""

from __future__ import annotations

import csv
import math

import numpy as np
import pytest
from scipy.signal import lfilter

from heading_intercompare.bags.csv.corrections_csv import COLUMNS, CorrectionsCsvWriter
from heading_intercompare.core.records import Pairs

S = 1_000_000_000
T0 = 1_406_851_200 * S


def pairs_of(x_deg, rs_deg=100.0, t_s=None):
    t_s = np.arange(x_deg.size) if t_s is None else t_s
    rs_deg = np.broadcast_to(np.asarray(rs_deg, np.float64), x_deg.shape)
    stamps = T0 + np.round(t_s * S).astype(np.int64)
    return Pairs.of(stamps, np.mod(rs_deg + x_deg, 360.0), np.mod(rs_deg, 360.0))


def rows(path, pairs, chunk=10 ** 9, **options):
    writer = CorrectionsCsvWriter(path, 120.0, **{'gap_s': 60.0, 'running_s': 1800.0,
                                                  'std_limit_deg': 0.5, **options})
    for lo in range(0, len(pairs), chunk):
        writer.write(pairs[lo:lo + chunk])
    writer.close()
    with open(path, newline='') as file:
        return [*csv.DictReader(file)]


def test_the_correction_is_what_to_add_to_the_ts(tmp_path, rng):
    x = 0.3 + 0.1 * rng.standard_normal(7200)
    found = rows(tmp_path / 'c.csv', pairs_of(x))
    assert len(found) == 60
    for at, row in enumerate(found):
        assert float(row['correction']) == pytest.approx(-x[120 * at:120 * at + 120].mean(),
                                                         abs=1e-4)
        assert float(row['mean_hdg']) == pytest.approx(100.3, abs=0.1)
        assert (row['num'], row['flag']) == ('120', '0')
    assert float(found[0]['dday']) == pytest.approx(212.0 + 119.0 / 86400.0, abs=1e-6)
    assert found[0]['utc'] == '2014-08-01 00:01:59.000'


def test_the_running_correction_is_the_mean_of_its_window(tmp_path, rng):
    """In the middle fifteen ensembles, 7 before and 7 after; at the ends half of them."""
    x = 0.3 + 0.1 * rng.standard_normal(7200)
    found = rows(tmp_path / 'c.csv', pairs_of(x))
    corrections = [float(row['correction']) for row in found]
    assert [int(found[at]['running_num']) for at in (0, 30, 59)] == [8, 15, 8]
    assert float(found[30]['running']) == pytest.approx(np.mean(corrections[23:38]), abs=1e-4)
    assert float(found[30]['u']) == pytest.approx(np.std(corrections[23:38], ddof=1), abs=1e-4)
    assert float(found[30]['running_low']) < float(found[30]['running']) < float(
        found[30]['running_high'])


@pytest.mark.parametrize('tau_s', [0.1, 10.0, 60.0])
def test_the_running_interval_holds_for_correlated_errors(tmp_path, rng, tau_s):
    """Four days, every half an hour: 95 % of the intervals, within six errors of a count."""
    phi = math.exp(-1.0 / tau_s)
    x = 0.3 * math.sqrt(1.0 - phi * phi) * lfilter([1.0], [1.0, -phi],
                                                   rng.standard_normal(4 * 86400))
    found = rows(tmp_path / 'c.csv', pairs_of(x))[::15]
    held = [float(row['running_low']) < 0.0 < float(row['running_high']) for row in found]
    assert len(found) == 192
    assert np.mean(held) == pytest.approx(0.95, abs=6.0 * math.sqrt(0.95 * 0.05 / 192))


def test_each_fault_of_an_ensemble_is_flagged_and_left_out_of_the_running_one(tmp_path, rng):
    """Ensemble 3 scatters, in 5 the ship turns by 60 deg, and a silence cuts 8 short."""
    x = 0.1 + 0.05 * rng.standard_normal(1920)
    x[360:480] += 5.0 * rng.standard_normal(120)
    rs_deg = np.full(1920, 10.0) + np.clip(np.arange(1920) - 600, 0, 60)
    t_s = np.arange(1920.0)
    t_s[990:] += 300.0
    found = rows(tmp_path / 'c.csv', pairs_of(x, rs_deg, t_s))
    assert [row['flag'] for row in found[:10]] == ['0', '0', '0', '2', '0', '4', '0', '0', '1',
                                                   '0']
    good = [float(row['correction']) for row in found if row['flag'] == '0']
    assert float(found[7]['running_num']) < 16
    assert max(abs(float(row['running']) + 0.1) for row in found) < 0.02
    assert np.mean(good) == pytest.approx(-0.1, abs=0.01)


@pytest.mark.parametrize('chunk', [1, 77, 500])
def test_chunks_do_not_matter(tmp_path, rng, chunk):
    pairs = pairs_of(0.1 * rng.standard_normal(1500))
    whole = rows(tmp_path / 'whole.csv', pairs)
    assert rows(tmp_path / 'cut.csv', pairs, chunk) == whole


def test_two_ensembles_have_no_interval_and_no_pairs_no_row(tmp_path):
    few = rows(tmp_path / 'c.csv', pairs_of(np.full(240, 0.2)))
    assert [(row['running_num'], row['u'], row['running_low']) for row in few] == [
        ('2', 'nan', 'nan')] * 2
    assert rows(tmp_path / 'none.csv', Pairs.empty()) == []
    assert (tmp_path / 'none.csv').read_text() == ','.join(COLUMNS) + '\n'


def test_across_north_and_the_seam_the_sign_stays(tmp_path):
    found = rows(tmp_path / 'c.csv', pairs_of(np.full(1200, -0.2), 0.05))
    assert {row['correction'] for row in found} == {'0.2000'}
    assert {row['mean_hdg'] for row in found} == {'359.8500'}


def test_a_window_shorter_than_an_ensemble_is_refused(tmp_path):
    with pytest.raises(ValueError, match='running window = 60.0 s: must be at least'):
        rows(tmp_path / 'c.csv', Pairs.empty(), running_s=60.0)
