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

"""Columns in pages, in memory or elsewhere, hold the values appended; counts are exact."""

from __future__ import annotations

import numpy as np
import pytest

from heading_intercompare.core.records import Headings
from heading_intercompare.core.runs.growing_columns import Column, GrowingHeadings, Tails
from heading_intercompare.core.statistics.moments import count_outside

PAGE = 65536


def elsewhere(page: np.ndarray):
    """Keep a page as bytes."""
    data = page.tobytes()
    return lambda: np.frombuffer(data, page.dtype)


@pytest.mark.parametrize('keep', [None, elsewhere])
@pytest.mark.parametrize('chunks', [(0, 1, 1000, 5000, 3), (PAGE,), (PAGE - 1, 1, 1),
                                    (3 * PAGE + 17,), (70_000, 1, 200_000)])
def test_a_column_grows_without_changing(rng, chunks, keep):
    column, parts = Column(np.float64, keep), []
    for n in chunks:
        parts.append(rng.standard_normal(n))
        column.append(parts[-1])
        expected = np.concatenate(parts)
        assert len(column) == len(expected)
        assert np.array_equal(column.values, expected)
    assert (column.first, column.last) == (expected[0], expected[-1])
    for number in range(0 if keep is None else len(expected) // PAGE):
        assert np.array_equal(column.page(number), expected[number * PAGE:(number + 1) * PAGE])
    with pytest.raises(ValueError):
        column.values[0] = 1.0


def test_an_empty_column_has_no_values():
    column = Column(np.int64)
    assert (len(column), column.first, column.last, column.values.tolist()) == (0, None, None, [])


@pytest.mark.parametrize('keep', [None, elsewhere])
@pytest.mark.parametrize('values', ['normal', 'steps', 'constant', 'drift'])
def test_counts_of_pages_are_those_of_all_values(rng, values, keep):
    n = 2 * PAGE + 11
    x = {'normal': rng.standard_normal(n), 'steps': np.round(rng.standard_normal(n), 1),
         'constant': np.full(n, 0.7), 'drift': np.linspace(-5.0, 5.0, n)}[values]
    tails = Tails()
    column = Column(np.float64, keep, tails.take)
    column.append(x)
    for center in (0.0, 0.1, float(x.mean()), -40.0):
        for limit in (0.0, 0.3, 0.6, 2.0, 3.0, 4.9, 100.0):
            found = tails.count_outside(column, center, limit) + count_outside(
                column.newest, center, limit)
            assert found == count_outside(x, center, limit)


def test_limits_beyond_the_tails_need_no_page(rng):
    tails = Tails()
    column = Column(np.float64, elsewhere, tails.take)
    column.append(rng.standard_normal(PAGE))
    column.page = None
    assert 0 < tails.count_outside(column, 0.0, 3.0) < PAGE // 100


def test_readings_that_grow_by_chunks_are_those_joined(rng):
    chunks = [Headings.as_sent(rng.integers(1, 10 ** 18, n), rng.uniform(0.0, 360.0, n))
              for n in (0, 1, 5000, 0, 70_000, 3)]
    growing = GrowingHeadings()
    assert len(growing.headings) == 0
    for chunk in chunks:
        growing.append(chunk)
    assert growing.headings == Headings.concatenate(chunks)
