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

"""Stretches in which two sensors point apart: by hand, over returns, and none in slow errors."""

from __future__ import annotations

import numpy as np
import pytest

from heading_intercompare.core.conditions.partings import cut_spans, find_partings

STAMPS = np.arange(3600) * 10 ** 9


def spans_s(x_deg, stamps=STAMPS, sigma_deg=0.2):
    """Return start and end of the stretches, seconds."""
    return [(p.start_ns // 10 ** 9, p.end_ns // 10 ** 9)
            for p in find_partings(stamps, x_deg, sigma_deg)]


def test_a_stretch_ends_with_its_last_difference(rng):
    x = 0.2 * rng.standard_normal(3600)
    x[1000:1300] += 38.0
    x[2000:2100] -= 20.0
    assert spans_s(x) == [(1000, 1299), (2000, 2099)]


def test_a_short_return_does_not_end_it(rng):
    x = 0.2 * rng.standard_normal(3600)
    x[1000:1300] += 38.0
    x[1100:1105] -= 38.0
    assert spans_s(x) == [(1000, 1299)]


@pytest.mark.parametrize('length', [1, 30, 59])
def test_less_than_a_minute_is_none(length):
    x = np.zeros(3600)
    x[1000:1000 + length] = 38.0
    assert spans_s(x) == []


def test_outliers_in_a_row_are_none():
    x = np.zeros(3600)
    x[1000:1300:8] = 38.0
    assert spans_s(x) == []


def test_slow_errors_of_a_bad_sensor_are_none(rng):
    """A swing of 5 deg is wide, but usual for this sensor."""
    assert spans_s(5.0 * np.sin(STAMPS / 4e11) + 0.2 * rng.standard_normal(3600)) == []


def test_apart_for_most_of_the_time_nobody_knows_what_is_usual():
    assert spans_s(np.where(np.arange(3600) < 2000, 38.0, 0.0)) == [(2000, 3599)]
    assert spans_s(np.where(np.arange(3600) % 1800 < 900, 38.0, 0.0)) == []


@pytest.mark.parametrize('n', [0, 1, 2])
def test_few_differences_show_none(n):
    assert find_partings(STAMPS[:n], np.full(n, 38.0), 0.2) == []


def test_spans_are_cut_with_both_ends():
    stamps, x = cut_spans(np.arange(10), np.arange(10.0), [(2, 4), (9, 12)])
    assert stamps.tolist() == [0, 1, 5, 6, 7, 8] == x.tolist()
