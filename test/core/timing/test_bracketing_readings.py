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

"""A slow sensor is told by its pairs: by lines, by repeated values, or by the factors."""

from __future__ import annotations

import numpy as np
import pytest

from heading_intercompare.core.timing.bracketing_readings import (
    pairs_per_reading,
    readings_per_pair,
)


def stamps_of(t):
    return np.rint(t * 1e9).astype(np.int64)


@pytest.mark.parametrize('per', [3, 5, 10, 25])
def test_the_number_of_pairs_a_reading_is_found(per, rng):
    t = np.arange(4000) / 10.0
    rs = np.cumsum(rng.standard_normal(4000 // per + 2))
    node = np.arange(rs.size) * per / 10.0 - 0.03
    for shown in (np.interp(t, node, rs), np.repeat(rs, per)[:4000]):
        assert readings_per_pair(stamps_of(t), shown % 360.0) == pytest.approx(per, rel=0.1)


def test_a_sensor_as_fast_as_the_pairs_has_one_reading_a_pair(rng):
    t = np.arange(4000) / 10.0
    heading = 100.0 + 0.1 * rng.standard_normal(4000)
    assert readings_per_pair(stamps_of(t), heading) == 1
    between = 0.5 * (heading[1:] + heading[:-1])
    assert readings_per_pair(stamps_of(t[1:]), between) == 1


@pytest.mark.parametrize('n', [0, 1, 2, 10])
def test_too_few_pairs_and_a_constant_heading_show_no_slow_sensor(n):
    assert readings_per_pair(np.arange(n), np.zeros(n)) == 1


@pytest.mark.parametrize('decimals', [1, 2])
def test_rounding_that_repeats_values_or_lines_makes_no_slow_sensor(decimals, rng):
    """A random walk that most often stays within its step."""
    heading = np.round(np.cumsum(0.3 * 10.0 ** -decimals * rng.standard_normal(4000)), decimals)
    assert readings_per_pair(np.arange(4000) * 10 ** 8, heading % 360.0) == 1


@pytest.mark.parametrize('least', [0.5, 0.64, 0.79])
@pytest.mark.parametrize('ratio', [1.3, 1.4, 1.7, 2.0])
def test_the_factors_of_interpolation_tell_a_slower_sensor(ratio, least, rng):
    """Those of the line, of a cubic and of the longest kernel, in the middle of two readings."""
    w = (0.1 + np.arange(3000) / ratio + 0.01 * rng.standard_normal(3000)) % 1.0
    factor = 1.0 - 4.0 * (1.0 - least) * w * (1.0 - w)
    assert pairs_per_reading(factor) == pytest.approx(ratio, rel=0.01)


def test_factors_of_equal_rates_tell_nothing(rng):
    """Constant, slowly drifting, or of no order; and too few."""
    for w in (np.full(3000, 0.3), 0.3 + 1e-4 * np.arange(3000), rng.random(3000)):
        found = pairs_per_reading((1.0 - w % 1.0) ** 2 + (w % 1.0) ** 2)
        assert found == pytest.approx(1.0, abs=0.002)
    # What single precision leaves of a constant may repeat itself.
    w = 0.4 + 1e-7 * np.cos(2.0 * np.pi * 0.37 * np.arange(3000))
    assert pairs_per_reading((1.0 - w) ** 2 + w ** 2) == 1.0
    assert pairs_per_reading(np.full(100, 0.7)) == pairs_per_reading([]) == 1.0
