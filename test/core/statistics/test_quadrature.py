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

"""The Gauss-Legendre quadrature."""

from __future__ import annotations

import numpy as np
import pytest

from heading_intercompare.core.statistics.quadrature import gauss_legendre


@pytest.mark.parametrize('n', [1, 2, 5, 20, 40])
def test_n_points_integrate_powers_up_to_2n_minus_1_exactly(n):
    """The integral of x^p over [-1, 1] is 2 / (p + 1) for even p, and 0 for odd p."""
    nodes, weights = gauss_legendre(n)
    for power in range(2 * n):
        expected = 0.0 if power % 2 else 2.0 / (power + 1)
        assert np.dot(weights, nodes ** power) == pytest.approx(expected, abs=1e-13)


def test_the_points_of_two_by_hand():
    """The zeros of (3 x^2 - 1) / 2 are -1/sqrt 3 and 1/sqrt 3, both of weight 1."""
    nodes, weights = gauss_legendre(2)
    assert nodes == pytest.approx([-3.0 ** -0.5, 3.0 ** -0.5])
    assert weights == pytest.approx([1.0, 1.0])
