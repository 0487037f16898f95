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

"""Pairs averaged over ensembles of a few minutes, as is usual for correcting current profilers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Sequence

import numpy as np

from heading_intercompare.core.angles import wrap360
from heading_intercompare.core.records import Pairs

from .difference import subtract

SHORTEST_S, LONGEST_S = 1.0, 86400.0
"""Shortest and longest ensemble, seconds."""


@dataclass(frozen=True, slots=True, eq=False)
class Ensembles:
    """
    Figures of n >= 0 ensembles, in stamp order.

    Attributes
    ----------
    stamp_ns : ndarray of int64, shape (n,)
        Stamp of the last pair of each ensemble.
    mean_ts_deg : ndarray, shape (n,)
        Direction of the mean of the unit vectors of the TS headings, in [0, 360).
    last_ts_deg : ndarray, shape (n,)
        Last TS heading, in [0, 360).
    mean_deg, std_deg : ndarray, shape (n,)
        Mean of the differences TS - RS, wrapped, with the installation offset not removed; and
        their standard deviation, with num - 1.
    num : ndarray of int64, shape (n,)
        Number of finite pairs. Only these enter the figures, which are nan if there are too few.
    rs_length : ndarray, shape (n,)
        Length of the mean of the unit vectors of the RS headings: 1 if the ship did not turn.

    """

    stamp_ns: np.ndarray
    mean_ts_deg: np.ndarray
    last_ts_deg: np.ndarray
    mean_deg: np.ndarray
    std_deg: np.ndarray
    num: np.ndarray
    rs_length: np.ndarray

    @classmethod
    def concatenate(cls, parts: Sequence['Ensembles']) -> 'Ensembles':
        """Join ensembles in stamp order."""
        return cls(*(np.concatenate([getattr(part, name) for part in parts])
                     for name in cls.__slots__))

    def __len__(self) -> int:
        return len(self.num)


def _summarise(pairs: Pairs, starts: np.ndarray, wrap_center_deg: float) -> Ensembles:
    """Return the figures of the ensembles with these first pairs; the last ends with `pairs`."""
    if not len(pairs):
        none, nowhere = np.zeros(0, np.int64), np.zeros(0)
        return Ensembles(none, nowhere, nowhere, nowhere, nowhere, none, nowhere)
    x = subtract(pairs, wrap_center_deg=wrap_center_deg).x_deg
    finite = np.isfinite(x)
    stops = np.append(starts[1:], len(pairs))

    def sums(values: np.ndarray) -> np.ndarray:
        return np.add.reduceat(np.where(finite, values, 0.0), starts)

    num = np.add.reduceat(finite.astype(np.int64), starts)
    last = np.maximum.reduceat(np.where(finite, np.arange(len(pairs)), -1), starts)
    with np.errstate(invalid='ignore', divide='ignore'):
        angle = np.radians(pairs.ts_deg)
        east, north = sums(np.sin(angle)), sums(np.cos(angle))
        mean = sums(x) / num
        e = x - np.repeat(mean, stops - starts)
        # The second term corrects for the rounding of the mean.
        m2 = np.maximum(sums(e * e) - sums(e) ** 2 / num, 0.0)
        std = np.sqrt(np.where(num > 1, m2 / (num - 1), np.nan))
        rs = np.radians(pairs.rs_deg)
        rs_length = np.hypot(sums(np.sin(rs)), sums(np.cos(rs))) / num
    direction = np.where((east != 0.0) | (north != 0.0), np.degrees(np.arctan2(east, north)),
                         np.nan)
    return Ensembles(pairs.stamp_ns[stops - 1], wrap360(direction),
                     wrap360(np.where(num > 0, pairs.ts_deg[last], np.nan)), mean, std, num,
                     rs_length)


class Ensembling:
    """
    Cuts pairs into ensembles.

    The first pair begins an ensemble, and so does the first pair after a silence; from there on a
    new ensemble begins every `span_s`. No ensemble spans a silence, and none is empty. The
    ensembles are the same to the bit, however the pairs are cut into chunks.

    Parameters
    ----------
    span_s
        Length of an ensemble, seconds.
    gap_s
        Longest time between pairs that is not a silence, seconds: `runs.gap_s`.
    wrap_center_deg
        Differences are reduced to [c - 180, c + 180), degrees.

    Raises
    ------
    ValueError
        If `span_s` is not from `SHORTEST_S` to `LONGEST_S`.

    Notes
    -----
    Keeps only the pairs of the ensemble in progress.

    """

    def __init__(self, span_s: float, gap_s: float, wrap_center_deg: float = 0.0) -> None:
        if not SHORTEST_S <= span_s <= LONGEST_S:
            raise ValueError(f'length of an ensemble = {span_s!r} s: must be from '
                             f'{SHORTEST_S:g} to {LONGEST_S:g}')
        self._span_ns, self._gap_ns = round(span_s * 1e9), round(gap_s * 1e9)
        self._wrap_center_deg = wrap_center_deg
        self._open: list[Pairs] = []
        self._newest_ns = self._anchor_ns = self._number = 0

    def update(self, pairs: Pairs) -> Ensembles:
        """Take pairs with increasing stamps; return the ensembles that they complete."""
        starts = self._starts(pairs.stamp_ns)
        if not len(starts):
            if len(pairs):
                self._open.append(pairs)
            return _summarise(Pairs.empty(), starts, 0.0)
        first, last = int(starts[0]), int(starts[-1])
        done = Pairs.concatenate([*self._open, pairs[:last]])
        # Starts within `done`; the ensemble that was open starts at 0.
        starts = starts[:-1] + (len(done) - last)
        if self._open or first:
            starts = np.append(0, starts)
        self._open = [pairs[last:]]
        return _summarise(done, starts, self._wrap_center_deg)

    def finish(self) -> Ensembles:
        """Return the ensemble in progress, if any; it is the last."""
        done, self._open = Pairs.concatenate(self._open), []
        return _summarise(done, np.zeros(1, np.int64), self._wrap_center_deg)

    def _starts(self, stamp_ns: np.ndarray) -> np.ndarray:
        """Return the indices of the pairs of a chunk that begin an ensemble."""
        if not len(stamp_ns):
            return np.zeros(0, np.int64)
        fresh = not self._open
        before_ns = int(stamp_ns[0]) if fresh else self._newest_ns
        restarts = np.diff(stamp_ns, prepend=before_ns) > self._gap_ns
        restarts[0] |= fresh
        at = np.flatnonzero(restarts)
        anchor_ns = np.full(len(stamp_ns), self._anchor_ns)
        if len(at):
            anchor_ns[at[0]:] = np.repeat(stamp_ns[at], np.diff(at, append=len(stamp_ns)))
        number = (stamp_ns - anchor_ns) // self._span_ns
        begins = restarts | (np.diff(number, prepend=self._number) != 0)
        self._newest_ns, self._anchor_ns = int(stamp_ns[-1]), int(anchor_ns[-1])
        self._number = int(number[-1])
        return np.flatnonzero(begins)
