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

"""How much a count grew lately."""

from __future__ import annotations

from hypothesis import given, strategies as st

from heading_intercompare.core.statistics.recent_count import RecentCount


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
