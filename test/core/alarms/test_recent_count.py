# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""How much a count grew lately."""

from __future__ import annotations

from hypothesis import given, strategies as st

from heading_intercompare.core.alarms.recent_count import RecentCount


@given(st.lists(st.integers(0, 5), max_size=50), st.integers(1, 20))
def test_the_growth_is_that_of_the_last_seconds(grown, span_s):
    """By a plain sum: the growth at second k counts until second k + span."""
    count, total = RecentCount(span_s), 0
    for at, n in enumerate(grown):
        total += n
        assert count.take(total, float(at)) == sum(grown[max(0, at - span_s + 1):at + 1])


def test_a_count_that_begins_again_grew_from_0():
    count = RecentCount(10.0)
    assert [count.take(5, 0.0), count.take(2, 1.0)] == [5, 7]
