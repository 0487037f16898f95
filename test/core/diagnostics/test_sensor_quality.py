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

"""What sensors say of their readings beside the pairs of a run."""

from __future__ import annotations

import numpy as np
import pytest

from heading_intercompare.core.diagnostics.sensor_quality import (
    check_quality,
    compare_claim,
    leaves_enough,
    QualityCheck,
    warn_of_claim,
)
from heading_intercompare.core.records import Quality, QUALITY_FLAGS

NORMAL, FLOAT = QUALITY_FLAGS.index('normal'), QUALITY_FLAGS.index('float solution')
STAMPS = np.arange(10, 20)


def said(*rows):
    return Quality.of(*zip(*rows))


def test_a_pair_is_poor_if_a_reading_beside_it_is():
    """Normal at 10 and up to 12, float at 14 and 16, normal from 18: 13 and 17 lie beside."""
    rows = said((10, 0.1, NORMAL), (12, 0.1, NORMAL), (14, 0.5, FLOAT), (16, 0.5, FLOAT),
                (18, 0.1, NORMAL), (19, 0.1, NORMAL))
    check, is_reduced = check_quality({'rs': rows}, STAMPS)
    assert STAMPS[is_reduced].tolist() == [13, 14, 15, 16, 17]
    assert check.ts is None and check.rs.flags == {'normal': 5, 'float solution': 5}
    assert (check.rs.n, check.rs.n_reduced, check.rs.reduced_share) == (10, 5, 0.5)
    assert check.rs.stated_median_deg == pytest.approx(0.3)
    assert check.rs.stated_largest_deg == 0.5 and check.rs.words == 'float solution 5'


def test_the_order_of_the_rows_changes_nothing(rng):
    rows = said((10, 0.1, NORMAL), (13, 0.4, FLOAT), (15, 0.2, NORMAL), (19, 0.1, NORMAL))
    in_order = check_quality({'ts': rows}, STAMPS)
    mixed = check_quality({'ts': rows[rng.permutation(len(rows))]}, STAMPS)
    assert mixed[0] == in_order[0] and np.array_equal(mixed[1], in_order[1])


def test_the_stamps_of_the_ts_are_those_before_the_skew_was_removed():
    rows = said((12, np.nan, NORMAL), (14, np.nan, FLOAT), (16, np.nan, NORMAL))
    for stream, poor in (('ts', [11, 12, 13]), ('rs', [13, 14, 15])):
        _, is_reduced = check_quality({stream: rows}, STAMPS, late_ns=2)
        assert STAMPS[is_reduced].tolist() == poor, stream


@pytest.mark.parametrize('quality', [
    {}, {'rs': Quality.empty()}, {'rs': said((1, 0.1, FLOAT), (9, 0.1, FLOAT))},
    {'rs': said((10, np.nan, 0), (19, np.nan, 0))}])
def test_unknown_quality_is_not_poor_quality(quality):
    assert check_quality(quality, STAMPS) is None
    check, is_reduced = check_quality({'ts': said((10, 0.1, 0), (19, 0.1, 0))}, STAMPS)
    assert check.n_reduced == 0 and not is_reduced.any()


def test_a_run_without_pairs_has_no_quality():
    assert check_quality({'rs': said((10, 0.1, NORMAL), (19, 0.1, NORMAL))}, STAMPS[:0]) is None


@pytest.mark.parametrize('n_poor, enough', [(0, False), (1, True), (72, True), (73, False)])
def test_enough_pairs_must_be_left(n_poor, enough):
    """Of 200 pairs, 128 must be left."""
    stamps = np.arange(200)
    flag = np.where(stamps < n_poor, FLOAT, NORMAL)
    _, is_reduced = check_quality({'rs': Quality.of(stamps, np.full(200, np.nan), flag)}, stamps)
    assert leaves_enough(is_reduced) is enough


@pytest.mark.parametrize('claim_deg, claim, warned', [
    (0.05, 'too_small', True), (0.25, 'agrees', False), (0.4, 'too_large', False)])
def test_the_claim_of_the_ts_is_laid_beside_the_data(claim_deg, claim, warned):
    rows = said((10, claim_deg, NORMAL), (19, claim_deg, NORMAL))
    check, _ = check_quality({'ts': rows}, STAMPS)
    assert compare_claim(check, 0.2, 0.3) == claim
    assert compare_claim(check, None, None) == 'not_testable'
    warnings = warn_of_claim(QualityCheck(ts=check.ts, ts_claim=claim), 0.2, 0.3)
    assert (warnings == ['claim_of_ts: the TS claims 0.05 deg, the data show 0.2 to 0.3 deg']
            ) is warned


@pytest.mark.parametrize('n_rows', [1, 5, 60])
@pytest.mark.parametrize('late_ns', [0, 7])
def test_figures_are_those_of_each_pair_on_its_own(rng, n_rows, late_ns):
    """Some rows have one stamp, some lie outside the run; sums go over stretches of pairs."""
    rows = Quality.of(rng.integers(0, 300, n_rows), rng.choice([np.nan, 0.1, 0.3, 0.4], n_rows),
                      rng.integers(0, len(QUALITY_FLAGS), n_rows))
    stamps = np.unique(rng.integers(50, 250, 151))
    flag, stated_deg = rows.match(stamps + late_ns)
    checked = check_quality({'ts': rows}, stamps, late_ns=late_ns)
    if not flag.any() and not np.isfinite(stated_deg).any():
        assert checked is None
        return
    check, is_reduced = checked
    claims = stated_deg[np.isfinite(stated_deg)]
    assert np.array_equal(is_reduced, flag > NORMAL)
    assert check.ts.n == np.count_nonzero((flag > 0) | np.isfinite(stated_deg))
    assert check.ts.flags == {words: np.count_nonzero(flag == number)
                              for number, words in enumerate(QUALITY_FLAGS)
                              if (flag == number).any()}
    assert check.ts.stated_median_deg == (np.median(claims) if claims.size else None)
    assert check.ts.stated_largest_deg == (claims.max() if claims.size else None)
