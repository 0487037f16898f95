# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Whether one sensor repeats the other, reading by reading."""

from __future__ import annotations

from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import ArrayLike

from heading_intercompare.core.statistics.resolution import Resolution

__all__ = ['find_same_source', 'SameSource']

_EQUAL_DEG = 1e-7
_LEAST_CHANGES = 300


@dataclass(frozen=True, slots=True)
class SameSource:
    """
    Whether both headings are the same but for a constant.

    Attributes
    ----------
    suspected : bool or None
        None where the headings change too seldom: then two sensors may agree by chance.
    std_deg : float or None
        Standard deviation of the difference; None for n < 2.
    rounding_deg : float
        What rounding of both headings alone gives.

    """

    suspected: bool | None
    std_deg: float | None
    rounding_deg: float


def find_same_source(x_deg: ArrayLike, rs_deg: ArrayLike, ts: Resolution, rs: Resolution,
                     share: float = 0.001) -> SameSource:
    """
    Tell whether one stream repeats the other, reading by reading.

    Parameters
    ----------
    x_deg, rs_deg : array_like, shape (n,)
        Differences and headings of the RS, in sample order, finite, degrees.
    ts, rs : Resolution
        Of the headings of TS and RS.
    share : float
        So many readings may differ, as a share of those that change.

    Returns
    -------
    SameSource

    Notes
    -----
    Two good sensors that round the same motion differ by no more than rounding, whatever their
    noise is, and by less if their steps begin at the same angle: a small difference proves
    nothing. But the errors of two sensors, e apart, part their readings in a share e/q of the
    changes at least, q the coarser step. From 300 changes on, fewer than one in a thousand that
    differ mean errors that agree to a thousandth of a step. A copy that is late, filtered,
    interpolated or rounded again shows in its noise, `core.common_noise`, if it has any.

    """
    x = np.asarray(x_deg, dtype=np.float64)
    rounding = math.sqrt(ts.variance_deg2 + rs.variance_deg2)
    if x.size < 2:
        return SameSource(None, None, rounding)
    x = x - x[0]
    std = float(x.std(ddof=1))
    heading = np.asarray(rs_deg, dtype=np.float64)
    changes = min(_changed(heading), _changed(x + heading))
    if changes < _LEAST_CHANGES:
        return SameSource(None, std, rounding)
    x -= float(np.median(x[::max(1, x.size // 100_000)]))
    return SameSource(_not_zero(x) <= share * changes, std, rounding)


def _changed(heading: np.ndarray) -> int:
    return _not_zero(np.diff(heading))


def _not_zero(difference: np.ndarray) -> int:
    """Count the differences that are none of 0 and 360 degrees."""
    off = np.abs(difference)
    off -= 360.0 * np.rint(off / 360.0)
    return int(np.count_nonzero(np.abs(off) > _EQUAL_DEG))
