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

"""Where a continuous function crosses zero, without the optimizers of scipy, which load slowly."""

from __future__ import annotations

import math
from typing import Callable

#: The step from 1 to the next number of 64 bits.
_EPSILON = 2.0 ** -52
#: Steps that may leave more than half of the interval.
_MOST_STEPS = 3


def find_root(f: Callable[[float], float], low: float, high: float, *,
              tolerance: float = 2e-12) -> float:
    """
    Return where a continuous function crosses zero between two arguments.

    Parameters
    ----------
    f
        The function; its values at `low` and `high` have different signs, or one is zero.
    low, high
        Two arguments.
    tolerance
        The root is known to within this, and the last digit of a float.

    Raises
    ------
    ValueError
        If both values have the same sign, or one is not a number.

    References
    ----------
    Chandrupatla, A new hybrid quadratic/bisection algorithm for finding the zero of a nonlinear
    function without using derivatives, Advances in Engineering Software 28 (1997) 145-149.

    Examples
    --------
    >>> round(find_root(lambda x: x * x - 2.0, 0.0, 2.0), 9)
    1.414213562

    """
    newest, before = float(high), float(low)
    f_newest, f_before = float(f(newest)), float(f(before))
    if f_newest == 0.0 or f_before == 0.0:
        return newest if f_newest == 0.0 else before
    if not f_newest * f_before < 0.0:
        raise ValueError(f'the values at {low} and {high} must have different signs; they are '
                         f'{f_before} and {f_newest}')
    share, halved, steps = 0.5, math.inf, 0
    while True:
        x = newest + share * (before - newest)
        f_x = float(f(x))
        if (f_x > 0.0) == (f_newest > 0.0):
            third, f_third = newest, f_newest
        else:
            third, f_third, before, f_before = before, f_before, newest, f_newest
        newest, f_newest = x, f_x
        best, f_best = ((newest, f_newest) if abs(f_newest) < abs(f_before)
                        else (before, f_before))
        if f_best == 0.0:
            return best
        width = abs(before - newest)
        least = (2.0 * _EPSILON * abs(best) + 0.5 * tolerance) / width
        if least > 0.5:
            return best
        steps += 1
        if width <= 0.5 * halved:
            halved, steps = width, 0
        # The inverse quadratic through the points, where it is monotone, otherwise the middle.
        # At a jump it would creep, so the middle is taken where steps do not halve the interval.
        share = 0.5
        xi = (newest - before) / (third - before)
        phi = (f_newest - f_before) / (f_third - f_before)
        if steps < _MOST_STEPS and phi * phi < xi and (1.0 - phi) ** 2 < 1.0 - xi:
            share = (f_newest / (f_before - f_newest) * f_third / (f_before - f_third)
                     + (third - newest) / (before - newest) * f_newest / (f_third - f_newest)
                     * f_before / (f_third - f_before))
        share = min(1.0 - least, max(least, share))
