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

"""The cubic spline: a cubic is exact, and any values give what scipy gives."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import interpolate

from heading_intercompare.core.timing.cubic_spline import CubicSpline


def test_a_cubic_is_its_own_spline():
    t = np.array([0.0, 0.5, 2.0, 2.5, 4.0])
    at = np.linspace(-1.0, 5.0, 25)
    assert CubicSpline(t, t ** 3 - t)(at) == pytest.approx(at ** 3 - at, abs=1e-12)


@pytest.mark.parametrize('n', [4, 5, 100, 5000])
@pytest.mark.parametrize('columns', [(), (2,)])
def test_the_spline_is_that_of_scipy(n, columns, rng):
    """At the times, between them and a little outside; uneven steps, one and two columns."""
    t = np.cumsum(rng.uniform(0.1, 1.0, n))
    values = 100.0 + rng.standard_normal((n, *columns))
    at = np.concatenate((t, rng.uniform(t[0] - 0.1, t[-1] + 0.1, 300)))
    found = CubicSpline(t, values)(at)
    assert found.shape == (at.size, *columns)
    assert found == pytest.approx(interpolate.CubicSpline(t, values)(at), rel=1e-11)
