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

"""Roots of continuous functions, against those that are known and those of scipy."""

from __future__ import annotations

import math

from hypothesis import given, strategies as st
import pytest
import scipy.optimize

from heading_intercompare.core.statistics.root_finding import find_root


@pytest.mark.parametrize(('f', 'low', 'high', 'root'), [
    (lambda x: x - 1.0, 0.0, 4.0, 1.0),
    (lambda x: 1.0 - x, 0.0, 4.0, 1.0),
    (lambda x: x ** 9, -1.0, 2.0, 0.0),
    (lambda x: math.exp(x) - 1e-9, -50.0, 1.0, math.log(1e-9)),
    (lambda x: math.atan(1e6 * (x - 0.3)), 0.0, 1000.0, 0.3),
    (lambda x: math.copysign(1.0, x - 0.7), 0.0, 1.0, 0.7),
    (lambda x: x, 0.0, 1.0, 0.0), (lambda x: x - 1.0, 0.0, 1.0, 1.0),
    (lambda x: 0.0, 2.0, 2.0, 2.0), (lambda x: x - 1e12, 0.0, 1e13, 1e12)])
def test_the_root_is_there(f, low, high, root):
    assert find_root(f, low, high) == pytest.approx(root, abs=1e-3 if root == 0.0 and f(2.0) > 9.0
                                                    else 4e-12, rel=1e-15)


@given(st.floats(-20.0, 20.0), st.floats(0.01, 30.0), st.floats(1e-3, 1e3))
def test_the_root_is_that_of_scipy_with_as_few_calls(middle, slope, width):
    calls = {find_root: 0, scipy.optimize.brentq: 0}

    def f(solve, x):
        calls[solve] += 1
        return math.erf(slope * (x - middle)) + 0.3
    roots = [solve(lambda x, solve=solve: f(solve, x), middle - width - 2.0 / slope,
                   middle + width) for solve in calls]
    assert roots[0] == pytest.approx(roots[1], abs=4e-12, rel=4e-15)
    assert calls[find_root] <= 2 * calls[scipy.optimize.brentq] + 20


@given(st.floats(-10.0, 10.0), st.floats(-5.0, 5.0), st.floats(-5.0, 5.0), st.floats(-9.0, -1e-9),
       st.floats(1e-9, 9.0))
def test_a_jump_is_found_in_few_calls(middle, slope, bend, below, above):
    calls = 0

    def f(x):
        nonlocal calls
        calls += 1
        smooth = (slope + bend * x) * (x - middle) * 1e-3
        return below - abs(smooth) if x < middle else above + abs(smooth)
    assert find_root(f, -20.0, 20.0) == pytest.approx(middle, abs=4e-12)
    assert calls < 250


@pytest.mark.parametrize('f', [lambda x: x * x + 1.0, lambda x: math.nan])
def test_a_function_without_a_change_of_sign_is_refused(f):
    with pytest.raises(ValueError, match='must have different signs'):
        find_root(f, -1.0, 1.0)
