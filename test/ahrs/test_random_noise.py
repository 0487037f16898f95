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

"""Random numbers of the simulation."""

from __future__ import annotations

import numpy as np
import pytest

from heading_intercompare.ahrs.random_noise import Markov, open_stream, Outages


def test_a_stream_is_known_by_its_name():
    one, same = open_stream(5, 'ts.white'), open_stream(5, 'ts.white')
    other, seeded = open_stream(5, 'rs.white'), open_stream(6, 'ts.white')
    drawn = one.random(4)
    assert np.array_equal(drawn, same.random(4))
    assert not np.array_equal(drawn, other.random(4))
    assert not np.array_equal(drawn, seeded.random(4))


@pytest.mark.parametrize('cuts', [[10, 0, 1, 489, 500], [1] * 1000])
def test_markov_noise_does_not_depend_on_the_chunks(cuts):
    whole = Markov(2.0, 30.0, 0.1, open_stream(1, 'm')).take(1000)
    parts = Markov(2.0, 30.0, 0.1, open_stream(1, 'm'))
    assert np.array_equal(np.concatenate([parts.take(n) for n in cuts]), whole)


def test_markov_noise_has_its_variance_and_correlation():
    """
    2000 independent starts: variance 4, correlation exp(-1) after one correlation time.

    Six standard errors: 4 sqrt(2/2000) 6 = 0.76 and 6 / sqrt(2000) = 0.13; false alarm 1e-8.
    """
    first, last = np.array([Markov(2.0, 3.0, 0.1, open_stream(seed, 'm')).take(31)[[0, 30]]
                            for seed in range(2000)]).T
    assert np.var(last) == pytest.approx(4.0, abs=0.76)
    assert np.mean(first * last) / 4.0 == pytest.approx(np.exp(-1.0), abs=0.13)


def test_noise_of_size_zero_is_zero():
    assert not Markov(0.0, 1.0, 1.0, open_stream(1, 'm')).take(5).any()


@pytest.mark.parametrize('cuts', [[1] * 10, [3000, 7000], [9999, 1]])
def test_outages_do_not_depend_on_the_chunks(cuts):
    t_s = 0.7 * np.arange(10000)
    whole = Outages(50.0, 5.0, open_stream(1, 'o')).cover(t_s)
    parts, at = Outages(50.0, 5.0, open_stream(1, 'o')), np.cumsum([0, *cuts])
    joined = [parts.cover(t_s[a:b]) for a, b in zip(at[:-1], at[1:])]
    assert np.array_equal(np.concatenate(joined), whole[:at[-1]])


def test_outages_have_their_share_and_length():
    """10 of 110 s for 2000 outages: the share to 6 * 0.09 sqrt(2 / 2000) / 1.1 = 0.016."""
    covered = Outages(100.0, 10.0, open_stream(3, 'o')).cover(np.arange(220_000.0))
    assert covered.mean() == pytest.approx(1.0 / 11.0, abs=0.016)
    assert not Outages(0.0, 10.0, open_stream(3, 'o')).cover(np.arange(100.0)).any()
