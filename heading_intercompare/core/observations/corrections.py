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

"""Computed minus observed: the correction of the TS at each instant of an observation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Mapping

import numpy as np

from heading_intercompare.core.angles import circular_mean, wrap180, wrap360
from heading_intercompare.core.records import Headings, Integers, Reals
from heading_intercompare.core.statistics.resolution import find_resolution
from heading_intercompare.core.timing.heading_track import Track

_HALF_SPAN_S = 2.5
_MOST_DECIMALS = 4


class _Columns:
    """A frozen dataclass of equally long columns, checked."""

    __slots__: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Raise ValueError if the columns differ in length."""
        lengths = {name: column.shape for name in self.__slots__
                   if isinstance(column := getattr(self, name), np.ndarray)}
        if len(set(lengths.values())) > 1:
            raise ValueError(f'{type(self).__name__}: columns differ in shape: {lengths}')


@dataclass(frozen=True, slots=True, eq=False)
class Observations(_Columns):
    """
    Observations of the true heading, or of a true bearing that was also read on the TS.

    Attributes
    ----------
    stamp_ns : ndarray of int64, shape (n,)
        UTC nanoseconds, in any order.
    true_deg : ndarray, shape (n,)
        What the TS should show, degrees: the computed C.
    ts_deg : ndarray, shape (n,)
        What the observer read on the TS, degrees: the observed O; nan to take it from the log.
    turn_deg_s : ndarray, shape (n,)
        Rate at which `true_deg` changes for a ship that holds its heading: that of the sun's
        azimuth, 0 for a fixed mark; degrees per second.
    u_deg, time_u_s : ndarray, shape (n,)
        Standard uncertainties of one observation and of its time, apart from what all share.

    """

    stamp_ns: Integers
    true_deg: Reals
    ts_deg: Reals
    turn_deg_s: Reals
    u_deg: Reals
    time_u_s: Reals

    def __len__(self) -> int:
        return len(self.stamp_ns)


@dataclass(frozen=True, slots=True, eq=False)
class Corrections(_Columns):
    """
    Corrections C - O in the order of the observations.

    Attributes
    ----------
    row : ndarray of int64, shape (n,)
        Place of each in the observations.
    stamp_ns : ndarray of int64, shape (n,)
    true_deg, ts_deg : ndarray, shape (n,)
        C, and O with the installation offset removed, degrees.
    c_minus_o_deg : ndarray, shape (n,)
        To be added to the TS reading, wrapped around their mean, degrees.
    rate_deg_s : ndarray, shape (n,)
        Change of C - O per second by which the time of the observation may be wrong.
    u_deg : ndarray, shape (n,)
        Standard uncertainty of each, with that of its time, degrees.
    step_deg
        Step in which the TS reports; None if none was found.
    not_used
        Observations without a TS reading, by reason: 'no_ts_reading', 'outside_the_log',
        'gap_in_the_log'.

    """

    row: Integers
    stamp_ns: Integers
    true_deg: Reals
    ts_deg: Reals
    c_minus_o_deg: Reals
    rate_deg_s: Reals
    u_deg: Reals
    step_deg: float | None
    not_used: Mapping[str, int]

    def __len__(self) -> int:
        return len(self.stamp_ns)

    @property
    def span_s(self) -> float:
        """Time from the first to the last, seconds; 0 for n = 0."""
        return float(np.ptp(self.stamp_ns)) / 1e9 if len(self) else 0.0


def find_corrections(observations: Observations, ts: Headings | None = None, *,
                     max_gap_s: float = 3.0, latency_s: float = 0.0, offset_deg: float = 0.0,
                     step_deg: float | None = None) -> Corrections:
    """
    Return the corrections C - O.

    Parameters
    ----------
    observations
        True headings or bearings, with their uncertainties.
    ts
        Readings of the TS; interpolated to the observations without a reading of their own.
    max_gap_s
        Longest bracket of readings interpolated, seconds, inclusive.
    latency_s
        Known latency of the TS, subtracted from its stamps, seconds.
    offset_deg
        Known installation angle of the TS, degrees.
    step_deg
        Step in which the TS reports, degrees; by default it is found in its readings.

    Returns
    -------
    Corrections

    Examples
    --------
    >>> seen = Observations(np.array([1_000_000_000]), np.array([359.9]), np.array([0.2]),
    ...                     *np.zeros((3, 1)))
    >>> find_corrections(seen).c_minus_o_deg.round(9).tolist()
    [-0.3]

    """
    origin = int(observations.stamp_ns[0]) if len(observations) else 0
    t_s = (observations.stamp_ns - origin) / 1e9
    noted = np.isfinite(observations.ts_deg)
    track = Track(Headings.empty() if ts is None else ts, origin)
    t_log = t_s + latency_s
    covered = track.covers(t_log, t_log, max_gap_s)
    outside = (t_log < track.t_s[0]) | (t_log > track.t_s[-1]) if len(track) else ~noted
    used = noted | covered
    rate, observed = observations.turn_deg_s.copy(), observations.ts_deg.copy()
    if len(track):
        read = ~noted & covered
        observed[read] = track.at(t_log[read])
        after = np.minimum(t_log + _HALF_SPAN_S, track.t_s[-1])
        before = np.maximum(t_log - _HALF_SPAN_S, track.t_s[0])
        length = np.maximum(after - before, 1e-9)
        rate[read] -= ((track.at(after) - track.at(before)) / length)[read]
    row = np.flatnonzero(used)
    observed = wrap360(observed[row] - offset_deg)
    raw = wrap180(observations.true_deg[row] - observed)
    center, length_of_mean = circular_mean(raw)
    c_minus_o = wrap180(raw, center) if length_of_mean > 0.0 else raw
    values = observations.ts_deg[noted] if ts is None else ts.heading_deg
    lacking = {
        'no_ts_reading': int((~used).sum()) if not len(track) else 0,
        'outside_the_log': int((~used & outside).sum()) if len(track) else 0,
        'gap_in_the_log': int((~used & ~outside).sum()) if len(track) else 0}
    return Corrections(
        row=row, stamp_ns=observations.stamp_ns[row], true_deg=observations.true_deg[row],
        ts_deg=observed, c_minus_o_deg=c_minus_o, rate_deg_s=rate[row],
        u_deg=np.hypot(observations.u_deg[row],
                       observations.time_u_s[row] * rate[row]),
        step_deg=_find_step(values[np.isfinite(values)]) if step_deg is None else step_deg,
        not_used={reason: n for reason, n in lacking.items() if n})


def _find_step(heading_deg: Reals) -> float | None:
    """Return the step of the readings; the coarsest decimal one if they hardly change."""
    step = find_resolution(heading_deg).step_deg
    if step is not None or not heading_deg.size:
        return step
    for decimals in range(_MOST_DECIMALS + 1):
        scaled = heading_deg * 10.0 ** decimals
        if (np.abs(scaled - np.round(scaled)) < 1e-4).all():
            return float(10.0 ** -decimals)
    return None
