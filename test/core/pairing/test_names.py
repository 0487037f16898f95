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

"""Readings are counted by their names: each once, whoever took them."""

from __future__ import annotations

import numpy as np
import pytest

from heading_intercompare.core.pairing.names import count_unknown, Span


def test_what_two_took_counts_once():
    """A synchronizer took 1 to 60, its successor 41 to 100; the bag ends with 97."""
    taken = [Span('a', 1, 60), Span('a', 41, 100)]
    assert count_unknown(taken, [Span('a', 1, 97)]) == 3
    assert count_unknown(taken, [Span('a', 1, 100)]) == count_unknown([], taken) == 0
    assert count_unknown(taken, []) == 100


def test_the_numbers_of_different_publishers_are_different_names():
    assert count_unknown([Span('a', 1, 60), Span('b', 1, 30)], [Span('a', 1, 60)]) == 30


def test_an_unknown_publisher_may_be_any():
    assert count_unknown([Span('a', 1, 60)], [Span('', 1, 50)]) == 10
    assert count_unknown([Span('', 1, 60)], [Span('b', 11, 50)]) == 20


@pytest.mark.parametrize('seed', range(20))
def test_the_count_is_that_of_sets(seed):
    rng = np.random.default_rng(seed)

    def draw(n):
        spans = []
        for _ in range(n):
            first = int(rng.integers(1, 60))
            spans.append(Span('ab'[rng.integers(2)], first, first + int(rng.integers(-1, 25))))
        return spans

    def names(spans):
        return {(span.publisher, number) for span in spans
                for number in range(span.first, span.last + 1)}
    spans, others = draw(6), draw(4)
    assert count_unknown(spans, others) == len(names(spans) - names(others))
