# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The readings behind a heading that was interpolated between them, from its pairs alone."""

from __future__ import annotations

from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import ArrayLike

from .angles import unwrap_deg

__all__ = ['Brackets', 'brackets', 'readings_per_pair']

_SLOPE = 1e-6
_EQUAL_DEG = 1e-7
_LOOKED_AT = 100_000
_LEAST_SHARE = 0.25


@dataclass(frozen=True, slots=True, eq=False)
class Brackets:
    """
    Straight pieces of an interpolated heading, of three pairs or more each.

    Attributes
    ----------
    first, last : ndarray of int64, shape (b,)
        Pairs between which the heading is a straight line, in order.
    node_s, node_deg : ndarray, shape (b - 1,)
        Where the lines of neighbouring pieces meet: the reading between them. Seconds after the
        first stamp, unwrapped degrees; nan if they are more than one reading apart or in line.

    """

    first: np.ndarray
    last: np.ndarray
    node_s: np.ndarray
    node_deg: np.ndarray


def _slopes(stamp_ns: np.ndarray, heading: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the slopes from pair to pair, deg/s, and where three pairs are not in line."""
    slope = np.diff(heading) / np.maximum(np.diff(stamp_ns) / 1e9, 1e-9)
    kink = np.abs(np.diff(slope)) > _SLOPE * (1.0 + np.abs(slope[1:]))
    return slope, kink


def brackets(stamp_ns: ArrayLike, heading_deg: ArrayLike) -> Brackets:
    """
    Find the straight pieces of a heading that was interpolated linearly.

    Parameters
    ----------
    stamp_ns : array_like of int, shape (n,)
        Stamps in increasing order, nanoseconds.
    heading_deg : array_like, shape (n,)
        The interpolated heading, finite, degrees.

    Returns
    -------
    Brackets
        Empty if no three pairs in a row lie between the same two readings.

    Examples
    --------
    >>> found = brackets([0, 10**9, 2 * 10**9, 4 * 10**9, 5 * 10**9, 6 * 10**9],
    ...                  [0.0, 1.0, 2.0, 3.0, 3.0, 3.0])
    >>> found.first.tolist(), found.node_s.tolist(), found.node_deg.tolist()
    ([0, 3], [3.0], [3.0])

    """
    stamps, heading = np.asarray(stamp_ns), unwrap_deg(heading_deg)
    none = np.empty(0, np.int64)
    if stamps.size < 3:
        return Brackets(none, none, np.empty(0), np.empty(0))
    slope, kink = _slopes(stamps, heading)
    straight = np.flatnonzero(~kink)
    begins = np.diff(straight, prepend=-2) > 1
    first = straight[begins]
    last = straight[np.append(begins[1:], True)[:begins.size]] + 2
    t = (stamps - stamps[0]) / 1e9
    a, b = slope[first[:-1]], slope[first[1:]]
    with np.errstate(divide='ignore', invalid='ignore'):
        # The line of each piece through its last, of the next through its first pair.
        lead = (heading[first[1:]] - heading[last[:-1]]
                - b * (t[first[1:]] - t[last[:-1]])) / (a - b)
        node = t[last[:-1]] + lead
        value = heading[last[:-1]] + a * lead
    good = np.isfinite(node) & (first[1:] - last[:-1] <= 1)
    good &= (node >= t[last[:-1]] - 1e-6) & (node <= t[first[1:]] + 1e-6)
    return Brackets(first, last, np.where(good, node, np.nan), np.where(good, value, np.nan))


def readings_per_pair(stamp_ns: ArrayLike, heading_deg: ArrayLike) -> int:
    """
    Return of how many pairs one holds a new reading of a sensor.

    Parameters
    ----------
    stamp_ns : array_like of int, shape (n,)
        Stamps in increasing order, nanoseconds.
    heading_deg : array_like, shape (n,)
        Headings of the pairs, finite, degrees.

    Returns
    -------
    int
        1 for a sensor as fast as the pairs. Slower ones are known by values that are repeated,
        or that lie in a line between readings; the first 100000 pairs are looked at.

    Examples
    --------
    >>> readings_per_pair(range(0, 10**12, 10**9), [k // 5 for k in range(1000)])
    5

    """
    stamps, heading = np.asarray(stamp_ns)[:_LOOKED_AT], unwrap_deg(heading_deg[:_LOOKED_AT])
    if stamps.size < 3:
        return 1
    changed = float(np.mean(np.abs(np.diff(heading)) > _EQUAL_DEG))
    repeated = max(1, round(1.0 / changed)) if changed > 0.0 else 1
    slope, kink = _slopes(stamps, heading)
    moving = (np.abs(slope) > _SLOPE)[1:]
    if not moving.any() or float(np.mean(kink[moving])) > 1.0 - _LEAST_SHARE:
        return repeated
    # A reading between two pairs makes two kinks in a row, one that meets a pair makes one.
    nodes = int(np.count_nonzero(np.diff(np.flatnonzero(kink), prepend=-2) > 1))
    return max(repeated, math.floor(stamps.size / nodes + 0.5) if nodes else 1)
