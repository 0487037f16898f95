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

"""The trend of the difference."""

from __future__ import annotations

import numpy as np
import pytest

from heading_intercompare.web.figures.trend import Trend

S = 10 ** 9
T0 = 1_700_000_000 * S


def slow(stamps, x, span_s, n):
    """Return the columns by a plain loop."""
    width = round(span_s * S / n)
    newest = max(stamps) // width
    found = {}
    for stamp, value in zip(stamps, x):
        if newest - stamp // width < n and np.isfinite(value):
            found.setdefault(stamp // width, []).append(value)
    return [((newest - place + 0.5) * width / S, min(values), max(values))
            for place, values in sorted(found.items())]


def test_an_empty_trend_has_no_columns():
    trend = Trend()
    trend.take(np.array([], np.int64), np.array([]))
    assert trend.columns() == ()


@pytest.mark.parametrize('size', [1, 7, 500, 5000])
def test_the_columns_are_the_same_however_the_pairs_are_cut(size, rng):
    stamps = T0 + np.cumsum(rng.integers(1, S, 5000))
    x = rng.normal(0.0, 1.0, 5000)
    x[::97] = np.nan
    trend = Trend(1800.0, 60)
    for at in range(0, 5000, size):
        trend.take(stamps[at:at + size], x[at:at + size])
    assert np.array(trend.columns()) == pytest.approx(
        np.array(slow(stamps.tolist(), x.tolist(), 1800.0, 60)))


def test_a_gap_leaves_columns_out():
    trend = Trend(10.0, 10)
    trend.take(np.array([T0, T0 + 5 * S]), np.array([1.0, 2.0]))
    assert [(c.age_s, c.low_deg) for c in trend.columns()] == [(5.5, 1.0), (0.5, 2.0)]


def test_after_a_day_of_silence_only_the_new_pairs_are_shown():
    trend = Trend(10.0, 10)
    trend.take(T0 + np.arange(10) * S, np.arange(10.0))
    trend.take(np.array([T0 + 86_400 * S]), np.array([7.0]))
    assert [c.low_deg for c in trend.columns()] == [7.0]


def test_a_clock_set_back_begins_the_trend_again():
    trend = Trend(10.0, 10)
    trend.take(np.array([T0]), np.array([1.0]))
    trend.take(np.array([T0 - 3600 * S]), np.array([2.0]))
    assert [c.low_deg for c in trend.columns()] == [2.0]
