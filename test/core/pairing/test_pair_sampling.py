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

"""Sampling of pairs: one of each half second, the least interpolated, however they are cut."""

from __future__ import annotations

import numpy as np
import pytest

from heading_intercompare.core.pairing.pair_sampling import PairSampler, STEP_S
from heading_intercompare.core.records import Pairs

STEP_NS = round(STEP_S * 1e9)
T0 = 1_770_000_000 * 10 ** 9


def some_pairs(n=5000, rate_hz=50.0):
    rng = np.random.default_rng(3)
    stamps = T0 + np.cumsum(rng.integers(1, round(2e9 / rate_hz), n))
    ones = np.ones(n)
    return Pairs.of(stamps, rng.random(n), rng.random(n), None,
                    np.round(rng.uniform(0.5, 1.0, n), 2), ones)


def sample(pairs, cuts):
    sampler, found = PairSampler(), []
    for lo, hi in zip([0, *cuts], [*cuts, len(pairs)]):
        found.append(sampler.update(pairs[lo:hi]))
    return Pairs.concatenate([*found, sampler.update(Pairs.empty(), end=True)])


def test_it_keeps_of_each_half_second_the_least_interpolated_the_first_of_several():
    pairs = some_pairs()
    found = sample(pairs, [])
    best = {}
    for at, stamp_ns in enumerate(pairs.stamp_ns.tolist()):
        step, factor = stamp_ns // STEP_NS, pairs.rs_variance_factor[at]
        if step not in best or factor > pairs.rs_variance_factor[best[step]]:
            best[step] = at
    assert found == pairs[np.array([*best.values()])]
    assert len(found) < len(pairs) / 10


@pytest.mark.parametrize('cuts', [[1], [2500], [100, 101, 102, 4000], [*range(1, 5000)]])
def test_the_choice_does_not_depend_on_the_chunks(cuts):
    pairs = some_pairs()
    assert sample(pairs, cuts) == sample(pairs, [])


def test_pairs_of_a_slow_sensor_are_all_kept():
    pairs = Pairs.of(T0 + np.arange(100) * 10 ** 9, np.zeros(100), np.zeros(100))
    assert sample(pairs, [40]) == pairs
    assert sample(Pairs.empty(), []) == Pairs.empty()


def test_the_variance_stays_what_it_is():
    """The least interpolated pair is chosen by its stamps, not by its value."""
    rng = np.random.default_rng(5)
    n = 200_000
    pairs = Pairs.of(T0 + np.arange(n) * 10 ** 7, rng.standard_normal(n), np.zeros(n), None,
                     rng.uniform(0.5, 1.0, n), np.ones(n))
    assert np.var(sample(pairs, []).ts_deg) == pytest.approx(1.0, abs=0.06)
