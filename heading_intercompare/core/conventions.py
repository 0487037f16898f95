# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Whether both sensors report their heading by the same convention, and the mean difference."""

from __future__ import annotations

from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import ArrayLike

from .angles import circular_mean, unwrap_deg, wrap180
from .blocks import block_means, block_size, student_95, sum_covariance

__all__ = ['Convention', 'convention', 'mean_difference', 'MeanDifference']

_CONCENTRATED = 0.9
_ON_SEAM_SIGMAS = 5.0
_TURNED_DEG = 3.0
_CLEAR = 4.0
_LOOKED_AT = 1 << 17
_LEAST_BLOCKS = 8


@dataclass(frozen=True, slots=True)
class Convention:
    """
    Whether one heading is reported by another convention than the other.

    Attributes
    ----------
    kind : {'consistent', 'offset', 'mirrored', 'not_testable'}
        'offset': TS - RS is near 90, -90 or 180. 'mirrored': TS turns against RS, so that the
        difference turns with -2 times the heading. 'not_testable': no samples.
    angle_deg : float or None
        Mean of TS - RS, or of TS + RS if mirrored; degrees.
    spread_deg : float or None
        Circular standard deviation of the same.
    direction : {'with', 'against', 'not_testable'}
        How TS turns: with RS, against it, or unknown since the ship did not turn.
    turned_deg : float
        Range of the heading of the RS, degrees, in the block length that tells the direction
        best; 0 if none does.
    balance : float or None
        There, the square sum of the changes of TS + RS over that of TS - RS: above 4 they turn
        together, below 1/4 against each other. None where the RS did not turn by 3 degrees.

    """

    kind: str
    angle_deg: float | None
    spread_deg: float | None
    direction: str = 'not_testable'
    turned_deg: float = 0.0
    balance: float | None = None


def convention(x_deg: ArrayLike, rs_deg: ArrayLike,
               tolerance_deg: float = 10.0) -> Convention:
    """
    Look for a difference of conventions between the sensors.

    Parameters
    ----------
    x_deg, rs_deg : array_like, shape (n,)
        Differences and headings of the RS, in sample order, finite, degrees.
    tolerance_deg : float
        How near to 90, -90 or 180 a mean difference is suspicious, degrees.

    Returns
    -------
    Convention

    Notes
    -----
    The direction is told by the changes d from block mean to block mean, in the block length
    from 2^l samples in which it is clearest, so that a short turn in a long run suffices: when
    both turn together TS + RS changes by 2 d and TS - RS by the noise, when they turn against
    each other it is the other way round. The blocks of the RS must range over 3 degrees. A yaw
    taken for a heading, TS = 90 - heading, gives 'mirrored' with 90. The means are circular:
    nothing happens at the seam of the wrap. More than 131072 samples are thinned evenly.

    References
    ----------
    E.17 of ``docs/diagnostics.md``.

    """
    x, rs = np.asarray(x_deg, dtype=np.float64), np.asarray(rs_deg, dtype=np.float64)
    if not x.size:
        return Convention('not_testable', None, None)
    every = max(1, -(-x.size // _LOOKED_AT))
    x, rs = x[::every], rs[::every]
    direction, turned, balance = _direction(x, rs)
    mirrored = direction == 'against'
    angle, length = circular_mean(x + 2.0 * rs if mirrored else x)
    off = min(abs(float(wrap180(angle - wrong))) for wrong in (90.0, -90.0, 180.0)) \
        if math.isfinite(angle) else math.inf
    wrong = length > _CONCENTRATED and off <= tolerance_deg
    spread = _spread(length)
    return Convention('mirrored' if mirrored else 'offset' if wrong else 'consistent',
                      angle if math.isfinite(angle) else None,
                      spread if math.isfinite(spread) else None, direction, turned, balance)


def _spread(length: float) -> float:
    """Return the circular standard deviation, degrees."""
    return math.degrees(math.sqrt(-2.0 * math.log(length))) if length > 0.0 else math.inf


def _direction(x: np.ndarray, rs: np.ndarray) -> tuple[str, float, float | None]:
    """Return how TS turns, how far RS turned, and the balance that tells it."""
    rs, x = unwrap_deg(rs), unwrap_deg(x)
    best = 'not_testable', 0.0, None
    clearest = 0.0
    while rs.size >= _LEAST_BLOCKS:
        turned = float(np.ptp(rs))
        if turned < _TURNED_DEG:
            break
        d, d_rs = np.diff(x), np.diff(rs)
        apart = float(d @ d)
        together = float(np.sum((d + 2.0 * d_rs) ** 2))
        if together + apart > 0.0:
            ratio = together / apart if apart > 0.0 else math.inf
            clear = max(ratio, 1.0 / ratio if ratio > 0.0 else math.inf)
            if clear > clearest:
                clearest = clear
                word = 'not_testable' if clear <= _CLEAR else 'with' if ratio > 1.0 else 'against'
                best = word, turned, ratio if math.isfinite(ratio) else None
        if rs.size < 2 * _LEAST_BLOCKS:
            break
        rs, x = block_means(rs, 2), block_means(x, 2)
    return best


@dataclass(frozen=True, slots=True)
class MeanDifference:
    """
    The mean difference on the circle and how well it is known.

    Attributes
    ----------
    n : int
        Number of differences.
    mean_deg : float or None
        Mean of the differences wrapped about their circular mean, in [-180, 180); None for
        n = 0 or if no direction is preferred.
    resultant : float or None
        Length of the mean resultant of up to 131072 of them, in [0, 1]; None for n = 0.
    u_deg : float or None
        Standard uncertainty of the mean, which allows for correlation; None for n < 16.
    interval_deg : pair of float or None
        95 % interval; it is not wrapped.
    seam_share : float
        Share of the differences that the seam of the wrap puts a whole turn away from the others.

    """

    n: int
    mean_deg: float | None = None
    resultant: float | None = None
    u_deg: float | None = None
    interval_deg: tuple[float, float] | None = None
    seam_share: float = 0.0

    def torn(self, wrap_center_deg: float) -> bool:
        """Tell whether the differences lie on both sides of the seam of their wrap."""
        if not self.seam_share or self.resultant <= _CONCENTRATED:
            return False
        away = abs(float(wrap180(self.mean_deg - wrap_center_deg - 180.0)))
        return away <= _ON_SEAM_SIGMAS * _spread(self.resultant)

    def surely_exceeds(self, limit_deg: float) -> bool:
        """Tell whether all of the interval lies outside of plus and minus a limit, degrees."""
        if self.interval_deg is None:
            return False
        low, high = self.interval_deg
        return low > limit_deg or high < -limit_deg


def mean_difference(x_deg: ArrayLike) -> MeanDifference:
    """
    Return the mean difference on the circle.

    Parameters
    ----------
    x_deg : array_like, shape (n,)
        Differences in sample order, finite, degrees; wrapped anywhere.

    Returns
    -------
    MeanDifference

    Notes
    -----
    The uncertainty is that of the mean of the deviations, wrapped about the circular mean, by
    16 to 31 block means; it holds if the correlation is short compared with a block.

    References
    ----------
    E.17 of ``docs/diagnostics.md``.

    Examples
    --------
    >>> found = mean_difference([179.0, -179.0] * 8)
    >>> round(abs(found.mean_deg), 6), found.resultant > 0.999
    (180.0, True)

    """
    x = np.ravel(np.asarray(x_deg, dtype=np.float64))
    if not x.size:
        return MeanDifference(0)
    centre, length = circular_mean(x[::max(1, -(-x.size // _LOOKED_AT))])
    if not math.isfinite(centre):
        return MeanDifference(x.size, None, length)
    off = x - centre
    share = np.count_nonzero(np.abs(off) > 180.0) / x.size
    share = min(share, 1.0 - share)
    off = wrap180(off)
    mean = float(wrap180(centre + off.mean()))
    if not block_size(x.size, 16):
        return MeanDifference(x.size, mean, length, seam_share=share)
    covariance, dof = sum_covariance(off)
    u = math.sqrt(float(covariance)) / x.size
    half = student_95(dof) * u
    return MeanDifference(x.size, mean, length, u, (mean - half, mean + half), share)
