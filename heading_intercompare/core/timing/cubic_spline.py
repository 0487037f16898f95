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

"""A cubic spline through readings, without the parts of scipy that take long to load."""

from __future__ import annotations

import numpy as np

from heading_intercompare.core.records import Reals


class CubicSpline:
    """
    A cubic spline through values at uneven times.

    Parameters
    ----------
    t_s : ndarray, shape (n,)
        Increasing times, seconds; n >= 4.
    values : ndarray, shape (n,) or (n, k)
        What the spline passes through.

    Notes
    -----
    The third derivative does not change at the second and at the last but one time. Outside the
    times, the first and the last piece go on.

    References
    ----------
    de Boor 1978, *A Practical Guide to Splines*, chapter IV, "not-a-knot".

    """

    def __init__(self, t_s: Reals, values: Reals) -> None:
        step = np.diff(t_s)
        wide = step.reshape(-1, *[1] * (values.ndim - 1))
        slope = np.diff(values, axis=0) / wide
        first, last = t_s[2] - t_s[0], t_s[-1] - t_s[-3]
        # The equations of the derivatives at the times; those at both ends are put into the next.
        begin = ((step[0] + 2.0 * first) * step[1] * slope[0] + step[0] ** 2 * slope[1]) / first
        end = ((step[-1] + 2.0 * last) * step[-2] * slope[-1] + step[-1] ** 2 * slope[-2]) / last
        middle = 2.0 * (step[:-1] + step[1:])
        middle[0] -= first
        middle[-1] -= last
        right = 3.0 * (wide[1:] * slope[:-1] + wide[:-1] * slope[1:])
        right[0] -= begin
        right[-1] -= end
        before, after = step[1:].copy(), step[:-1].copy()
        before[0] = after[-1] = 0.0
        rate = np.empty_like(values)
        rate[1:-1] = _solve(before.reshape(wide[1:].shape), middle.reshape(wide[1:].shape),
                            after.reshape(wide[1:].shape), right)
        rate[0] = (begin - first * rate[1]) / step[1]
        rate[-1] = (end - last * rate[-2]) / step[-2]
        bend = (rate[:-1] + rate[1:] - 2.0 * slope) / wide
        self._t_s = t_s
        self._terms = values[:-1], rate[:-1], (slope - rate[:-1]) / wide - bend, bend / wide

    def __call__(self, t_s: Reals) -> Reals:
        """Return the values at times, shape (m,) or (m, k)."""
        at = np.clip(np.searchsorted(self._t_s, t_s, side='right') - 1, 0, self._t_s.size - 2)
        value, rate, square, cube = (term[at] for term in self._terms)
        since = (t_s - self._t_s[at]).reshape(-1, *[1] * (value.ndim - 1))
        result: Reals = ((cube * since + square) * since + rate) * since + value
        return result


def _solve(before: Reals, middle: Reals, after: Reals, right: Reals) -> Reals:
    """
    Solve tridiagonal equations in which the middle of each outweighs its neighbours.

    By cyclic reduction (Hockney 1965): each second unknown is put into its neighbours, again and
    again, and then found from them.
    """
    n = len(middle)
    if n == 1:
        return right / middle
    # The unknowns with odd numbers are kept, and those before and after them put into them.
    odd, first, second = slice(1, None, 2), slice(0, n - n % 2, 2), slice(2, None, 2)
    lower = before[odd] / middle[first]
    new_middle = middle[odd] - lower * after[first]
    new_right = right[odd] - lower * right[first]
    new_before, new_after = -lower * before[first], np.zeros_like(new_middle)
    # The last one kept may have none after it.
    inner = slice(0, (n - 1) // 2)
    upper = after[odd][inner] / middle[second]
    new_middle[inner] -= upper * before[second]
    new_right[inner] -= upper * right[second]
    new_after[inner] = -upper * after[second]
    odd_roots = _solve(new_before, new_middle, new_after, new_right)
    rest = right[::2].copy()
    rest[1:] -= before[second] * odd_roots[inner]
    rest[:n // 2] -= after[first] * odd_roots
    roots = np.empty_like(right)
    roots[odd], roots[::2] = odd_roots, rest / middle[::2]
    return roots
