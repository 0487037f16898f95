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

"""Ensembles: against a loop over pairs, by hand, and however the pairs are cut into chunks."""

from __future__ import annotations

import cmath
from dataclasses import fields
import math
import statistics

import numpy as np
import pytest

from heading_intercompare.core.pairing.ensembles import Ensembles, Ensembling
from heading_intercompare.core.records import Pairs

S = 1_000_000_000
T0 = 1_406_851_200 * S


def some_pairs(rng, count=3000):
    """Return pairs over all directions, a ship that crosses north, silences, invalid readings."""
    steps_s = rng.uniform(0.05, 0.15, count)
    steps_s[[400, 900, 1700]] = [75.0, 60.0, 20.0]
    steps_s[2000:2004] = 90.0
    stamp_ns = T0 + np.cumsum((steps_s * 1e9).astype(np.int64))
    ts_deg = np.mod(340.0 + 40.0 * np.sin(np.arange(count) / 300.0) + rng.normal(0, 1, count), 360)
    rs_deg = np.mod(ts_deg + rng.normal(0.2, 0.1, count), 360.0)
    ts_deg[::53] = np.nan
    rs_deg[1::71] = np.nan
    ts_deg[2001] = np.nan
    return Pairs.of(stamp_ns, ts_deg, rs_deg)


def by_loop(pairs, span_s, gap_s):
    """Return the rows of the ensembles, pair by pair."""
    groups, anchor_ns, before_ns, number = [], None, None, None
    for row in zip(pairs.stamp_ns.tolist(), pairs.ts_deg.tolist(), pairs.rs_deg.tolist()):
        if before_ns is None or row[0] - before_ns > gap_s * 1e9:
            anchor_ns, number = row[0], None
        here = (row[0] - anchor_ns) // (span_s * S)
        if here != number:
            groups.append([])
        number, before_ns = here, row[0]
        groups[-1].append(row)
    rows = []
    for group in groups:
        good = [(ts, rs) for _, ts, rs in group if math.isfinite(ts) and math.isfinite(rs)]
        x = [(ts - rs + 180.0) % 360.0 - 180.0 for ts, rs in good]
        ts_sum, rs_sum = (sum(cmath.rect(1.0, math.radians(row[at])) for row in good)
                          for at in (0, 1))
        mean = cmath.phase(ts_sum) if good else 0
        rows.append((group[-1][0], math.degrees(mean) % 360.0 if good else math.nan,
                     good[-1][0] if good else math.nan, statistics.fmean(x) if x else math.nan,
                     statistics.stdev(x) if len(x) > 1 else math.nan, len(good),
                     abs(rs_sum) / len(good) if good else math.nan))
    return rows


def rows_of(*made):
    """Return the rows of chunks of ensembles."""
    return [row for chunk in made for row in zip(
        *(getattr(chunk, field.name).tolist() for field in fields(Ensembles)))]


def all_of(pairs, span_s, gap_s, cuts=()):
    """Return the rows of pairs that come in chunks."""
    ensembling = Ensembling(span_s, gap_s)
    bounds = [0, *cuts, len(pairs)]
    made = [ensembling.update(pairs[lo:hi]) for lo, hi in zip(bounds[:-1], bounds[1:])]
    return rows_of(*made, ensembling.finish())


@pytest.mark.parametrize('span_s', [1, 7, 120, 3600])
def test_ensembles_are_those_of_a_loop_over_the_pairs(rng, span_s):
    pairs = some_pairs(rng)
    expected = by_loop(pairs, span_s, 60.0)
    assert len(expected) > 5
    assert any(row[5] == 0 for row in expected) and any(row[5] == 1 for row in expected)
    np.testing.assert_allclose(all_of(pairs, float(span_s), 60.0), expected, rtol=0, atol=1e-9)


def test_ensembles_are_the_same_to_the_bit_however_the_pairs_come(rng):
    pairs = some_pairs(rng)
    expected = all_of(pairs, 20.0, 60.0)
    for chunks in (2, 10, 300):
        cuts = [0, *np.sort(rng.integers(0, len(pairs) + 1, chunks)).tolist()]
        np.testing.assert_array_equal(all_of(pairs, 20.0, 60.0, cuts), expected)
    one_by_one = all_of(pairs[:500], 20.0, 60.0, range(1, 500))
    np.testing.assert_array_equal(one_by_one, all_of(pairs[:500], 20.0, 60.0))


def test_an_ensemble_by_hand():
    """
    350, 10 and 0 point north; 0.5, -0.5 and 1.5 have the mean 0.5 and the variance 1.

    The RS points to -10.5, 10.5 and -1.5: a mean of 0.98872 to north and -0.00873 to east.
    """
    pairs = Pairs.of([T0, T0 + S, T0 + 2 * S], [350.0, 10.0, 0.0], [349.5, 10.5, 358.5])
    (stamp_ns, mean_ts, last_ts, mean, std, num, rs_length), = all_of(pairs, 10.0, 60.0)
    assert (stamp_ns, last_ts, num) == (T0 + 2 * S, 0.0, 3)
    assert abs((mean_ts + 180.0) % 360.0 - 180.0) < 1e-12
    assert (mean, std) == pytest.approx((0.5, 1.0))
    assert rs_length == pytest.approx(math.hypot(0.98872, -0.00873), abs=1e-5)


def test_a_pair_at_the_end_of_an_ensemble_begins_the_next():
    pairs = Pairs.of([T0, T0 + 10 * S - 1, T0 + 10 * S, T0 + 35 * S], [1.0] * 4, [1.0] * 4)
    assert [(row[0] - T0, row[5]) for row in all_of(pairs, 10.0, 60.0)] == [
        (10 * S - 1, 2), (10 * S, 1), (35 * S, 1)]


def test_no_ensemble_reaches_across_a_silence():
    pairs = Pairs.of([T0, T0 + 60 * S, T0 + 120 * S + 1], [1.0] * 3, [1.0] * 3)
    assert [row[5] for row in all_of(pairs, 3600.0, 60.0)] == [2, 1]


def test_differences_are_wrapped_about_the_centre():
    ensembling = Ensembling(10.0, 60.0, wrap_center_deg=180.0)
    ensembling.update(Pairs.of([T0, T0 + S], [180.1, 179.9], [0.0, 0.0]))
    assert ensembling.finish().mean_deg.tolist() == [180.0]


def test_one_pair_has_no_standard_deviation():
    ensembling = Ensembling(10.0, 60.0)
    ensembling.update(Pairs.of([T0], [5.0], [5.5]))
    one = ensembling.finish()
    assert (one.mean_deg.tolist(), one.num.tolist()) == ([-0.5], [1])
    assert math.isnan(one.std_deg[0])


def test_no_pairs_give_no_ensemble():
    ensembling = Ensembling(10.0, 60.0)
    assert len(ensembling.update(Pairs.empty())) == 0
    assert len(ensembling.finish()) == 0


@pytest.mark.parametrize('span_s', [0.0, 0.5, -3.0, 1e6, math.nan, math.inf])
def test_a_length_that_is_not_allowed_is_refused(span_s):
    with pytest.raises(ValueError, match='length of an ensemble = .*from 1 to 86400'):
        Ensembling(span_s, 60.0)
