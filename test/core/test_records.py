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

"""Columns of equal length that are sliced, joined, compared and shown as one."""

from __future__ import annotations

import numpy as np
import pytest

from heading_intercompare.core.records import Differences, Headings, Pairs

S = 10 ** 9
SIX = Headings.as_sent(np.arange(6) * S, np.arange(6.0))


@pytest.mark.parametrize('kind', [Headings, Pairs, Differences])
def test_a_long_chunk_is_shown_in_one_short_line(kind):
    columns = {name: np.arange(100_000) if name.endswith('_ns') else np.zeros(100_000)
               for name in kind.__dataclass_fields__}
    shown = repr(kind(**columns))
    assert shown.startswith(f'{kind.__name__}(n=100000, 1970-01-01 00:00:00.000 to ')
    assert len(shown) < 100 and '\n' not in shown


def test_the_empty_chunk_is_shown_without_a_span():
    assert repr(Headings.empty()) == 'Headings(n=0)'


def test_a_chunk_shows_its_span_whatever_the_order_of_its_stamps():
    assert repr(SIX[::-1]) == repr(SIX)


def test_columns_of_different_length_are_no_chunk():
    with pytest.raises(ValueError, match='Headings: columns differ in shape'):
        Headings(np.arange(3), np.zeros(2))


def test_parts_joined_are_the_whole():
    for at in range(7):
        assert SIX[:at] + SIX[at:] == SIX
    assert Headings.concatenate([]) == Headings.empty()


def test_a_number_takes_a_chunk_of_one_also_from_the_end():
    assert len(SIX[2]) == 1 and SIX[-1] == SIX[5:]


def test_nan_equals_nan_and_another_class_is_not_equal():
    lost = Headings.as_sent([0], [np.nan])
    assert lost == Headings.as_sent([0], [np.nan]) and lost != Headings.as_sent([0], [1.0])
    assert (lost == 3) is False


def test_stamps_are_integers():
    with pytest.raises(ValueError, match='stamps are integer nanoseconds'):
        Headings.as_sent([0.5], [1.0])
