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
import scipy

from heading_intercompare.core.records import Reals

__all__ = ['CubicSpline']


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
        # One diagonal of the equations of the derivatives at the times in each row.
        bands = np.zeros((3, t_s.size))
        bands[0, 1], bands[0, 2:] = first, step[:-1]
        bands[1, 0], bands[1, 1:-1], bands[1, -1] = step[1], 2.0 * (step[:-1] + step[1:]), step[-2]
        bands[2, -2], bands[2, :-2] = last, step[1:]
        right = np.empty_like(values)
        right[0] = ((step[0] + 2.0 * first) * step[1] * slope[0] + step[0] ** 2 * slope[1]) / first
        right[1:-1] = 3.0 * (wide[1:] * slope[:-1] + wide[:-1] * slope[1:])
        right[-1] = ((step[-1] + 2.0 * last) * step[-2] * slope[-1]
                     + step[-1] ** 2 * slope[-2]) / last
        rate = scipy.linalg.solve_banded((1, 1), bands, right, overwrite_ab=True,
                                         overwrite_b=True, check_finite=False)
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
