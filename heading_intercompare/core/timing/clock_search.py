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

"""The search for clocks that lie minutes apart, by the correlation of the motion itself."""

from __future__ import annotations

from dataclasses import dataclass
import math

import numpy as np

from heading_intercompare.core import lazy_scipy as scipy
from heading_intercompare.core.records import Reals

from .heading_track import Track
from .skew_search import coarsen, REACH_S

_GRID_S = 0.5
_LONGEST_S, _SHORT_S = 7200.0, 1800.0
_MINUTE_S = 60.0
_LEAST_S = 120.0
_CLIP = 4.0
_MAD = 1.4826
_CHANCE = 1e-5
_FAR_LESS = 0.5
_ALMOST_ALL = 0.95
_APART_S = 3.0
_AS_GOOD, _AS_GOOD_BY = 1.5, 0.05
_EQUAL, _EQUAL_BY = 1.1, 0.001
_ROUNDING = 1e-9


@dataclass(frozen=True, slots=True)
class ClockOffset:
    """
    A skew far beyond the fine search, at which the motion of both sensors agrees.

    Attributes
    ----------
    skew_s
        Skew, seconds; positive if the TS data are older. Good to a fraction of a second.
    agreement
        Share of the motion that agrees there, at most 1.
    also_s
        Another skew that fits about as well, because the motion repeats itself; seconds.

    """

    skew_s: float
    agreement: float
    also_s: float | None = None


@dataclass(frozen=True, slots=True)
class Band:
    """
    A band of motion to compare.

    Attributes
    ----------
    slow_s
        The mean over this time is left out, seconds.
    least_known
        Least share of that time in which the heading is known.
    part_s
        Length of the parts over which the agreement must be spread, seconds.
    least_parts
        Least number of such parts.

    """

    slow_s: float
    least_known: float
    part_s: float
    least_parts: float


YAW = Band(64.0, 0.5, 60.0, 4.0)
"""Yaw in a swell. Slow errors of a sensor do not look like it."""

# In a turn, the mean over part of the time, say at an end of the record, is off.
TURNS = Band(300.0, 0.9, 150.0, 4.5)
"""Turns, and a slow weave. Where the yaw has one period, only they tell the periods apart."""


@dataclass(frozen=True, slots=True)
class _Motion:
    """The motion at even times, without slow turns; 0 where `covered` is 0."""

    deg: Reals
    covered: Reals


class ClockSearch:
    """
    How well the motion of both sensors agrees at each skew.

    Parameters
    ----------
    ts, rs
        Both sensors with one origin of time, at least two readings each. Their times may differ,
        and overlap in part or not at all.
    range_s
        Largest skew to search for, in either direction, at least a minute; seconds.
    max_gap_s
        Motion across a longer silence is unknown, seconds.
    longest_s
        Of a longer record the part of this length with the most motion is used, seconds.
    band
        The motion to compare.

    Attributes
    ----------
    searched_s : float
        Largest skew beyond a minute at which both sensors share two minutes of known motion, in
        either direction, seconds; 0 if there is none.

    Notes
    -----
    The headings are averaged over half a second, freed of slow motion, and clipped at four
    standard deviations, so that neither a step nor a single turn decides. The agreement at a skew
    is the concordance of both over the times that they share, at least two minutes: twice the
    covariance, divided by the sum of the variances. It is computed at all skews at once by the
    fast Fourier transform.

    References
    ----------
    E.24 of ``docs/diagnostics.md``; masked correlation: Padfield 2012 (IEEE Trans. Image Process.
    21, 2706).

    """

    def __init__(self, ts: Track, rs: Track, range_s: float, max_gap_s: float = 3.0,
                 longest_s: float = _LONGEST_S, band: Band = YAW) -> None:
        self._band = band
        m = math.floor(range_s / _GRID_S)
        ts, rs = coarsen(ts, _GRID_S), coarsen(rs, _GRID_S)
        n = int((ts.t_s[-1] - ts.t_s[0]) / _GRID_S) + 1
        whole = _motion_of(ts, ts.t_s[0] + _GRID_S * np.arange(n), max_gap_s,
                           band)
        lo, hi = _liveliest(whole, longest_s)
        self._ts = _clip(_Motion(whole.deg[lo:hi], whole.covered[lo:hi]))
        self._rs = _clip(_motion_of(rs, ts.t_s[0] + _GRID_S * np.arange(lo - m, hi + m),
                                    max_gap_s, band))
        self._lag_s = _GRID_S * np.arange(-m, m + 1)
        agreement, self._correlation, self._shared = _agree(self._ts, self._rs, m)
        enough = self._shared >= _LEAST_S / _GRID_S
        self._agreement = np.where(enough, agreement, 0.0)
        self._near = np.abs(self._lag_s) <= REACH_S
        self.searched_s = float(np.abs(self._lag_s[enough & ~self._near]).max(initial=0.0))

    def find(self) -> ClockOffset | None:
        """
        Return the skew beyond a minute at which the motion agrees.

        Returns
        -------
        ClockOffset or None
            None if none stands out, or one within a minute explains as much.

        Notes
        -----
        The disagreement there must be half of the least one within a minute, whichever way the
        TS counts. It must be sure, as
        `is_sure` says, and spread over several parts, because two turns look alike. Of
        skews that fit equally well, the nearest is returned.

        """
        v = self._agreement
        tops = _tops(v)
        far = tops[~self._near[tops]]
        if not far.size:
            return None
        best = int(far[np.argmax(v[far])])
        left = 1.0 - float(v[best])
        # A TS that counts the other way shows a weave half a period late.
        nearest = max(float(w[peaks[self._near[peaks]]].max(initial=0.0))
                      for w, peaks in ((v, tops), (-v, _tops(-v))))
        if left > _FAR_LESS * (1.0 - nearest) or not (
                self._is_spread(best) and self._is_sure(best)):
            return None
        far = far[np.argsort(np.abs(self._lag_s[far]), kind='stable')]
        chosen = int(far[v[far] >= 1.0 - _EQUAL * left - _EQUAL_BY][0])
        others = far[(v[far] >= 1.0 - _AS_GOOD * left - _AS_GOOD_BY)
                     & (np.abs(self._lag_s[far] - self._lag_s[chosen]) > _APART_S)]
        return ClockOffset(self._top_s(chosen), float(v[chosen]),
                           self._top_s(int(others[np.argmax(v[others])]))
                           if others.size else None)

    def is_sure(self, skew_s: float) -> bool:
        """
        Tell whether independent sensors would not agree as well as both do at a skew.

        Parameters
        ----------
        skew_s
            Within the range, seconds.

        Notes
        -----
        The risk is 1 in 100000 for all skews of the range together. The number of independent
        readings follows from the autocorrelations of both. Motion of a few frequencies has next
        to none. There, 95 % must agree.

        References
        ----------
        Variance of a correlation: Bartlett 1946 (J. R. Stat. Soc. Suppl. 8, 27).

        """
        at = round((skew_s - float(self._lag_s[0])) / _GRID_S)
        lo = max(0, at - 1)
        return self._is_sure(lo + int(np.argmax(self._agreement[lo:at + 2])))

    def _is_sure(self, at: int) -> bool:
        if self._agreement[at] >= _ALMOST_ALL:
            return True
        a, b = _autocorrelation(self._ts), _autocorrelation(self._rs)
        k = min(a.size, b.size)
        # Twice the sum over positive lags, and lag 0.
        steps = max(1.0, 2.0 * float(a[:k] @ b[:k]) - 1.0)
        dof = float(self._shared[at]) / steps - 3.0
        if dof <= 0.0:
            return False
        z = math.atanh(min(float(self._correlation[at]), 1.0 - _ROUNDING)) * math.sqrt(dof)
        return z > -float(scipy.special.ndtri(_CHANCE / max(1.0, self._lag_s.size / steps)))

    def _is_spread(self, at: int) -> bool:
        """Tell whether the motion agrees in many parts, not in a few turns."""
        begin = self._lag_s.size - 1 - at
        both = self._ts.deg * self._rs.deg[begin:begin + self._ts.deg.size]
        step = int(self._band.part_s / _GRID_S)
        parts = np.add.reduceat(both, np.arange(0, both.size, step))
        return float(parts.sum()) ** 2 >= self._band.least_parts * float(parts @ parts)

    def _top_s(self, at: int) -> float:
        """Return the lag of the parabola through a peak and its neighbours, seconds."""
        before, top, after = self._agreement[at - 1:at + 2].tolist()
        bend = 2.0 * top - before - after
        return float(self._lag_s[at]) + (
            0.5 * _GRID_S * (after - before) / bend if bend > 0.0 else 0.0)


def find_apart(ts: Track, rs: Track, range_s: float,
               max_gap_s: float = 3.0) -> tuple[ClockSearch, ClockOffset | None]:
    """
    Search a record for clocks that lie apart, in its yaw, and if that shows none, in its turns.

    Parameters
    ----------
    ts, rs, range_s, max_gap_s
        As for `ClockSearch`.

    Returns
    -------
    search : ClockSearch
        That of up to two hours.
    offset : ClockOffset or None

    Notes
    -----
    Motion slower than a minute is left out at first, because slow errors look like it. Clocks
    that also drift by seconds an hour, or step, agree in half an hour only. At last, a yaw of one
    period shows no offset by itself, but together with turns over up to five minutes.

    References
    ----------
    E.24 of ``docs/diagnostics.md``.

    """
    search = ClockSearch(ts, rs, range_s, max_gap_s)
    offset = search.find()
    if offset is None and ts.t_s[-1] - ts.t_s[0] > 2.0 * _SHORT_S:
        offset = ClockSearch(ts, rs, range_s, max_gap_s, _SHORT_S).find()
    if offset is None:
        offset = ClockSearch(ts, rs, range_s, max_gap_s, band=TURNS).find()
    return search, offset


def _tops(values: Reals) -> np.ndarray:
    """Return where values peak."""
    return 1 + np.flatnonzero((values[1:-1] >= values[:-2]) & (values[1:-1] > values[2:]))


def _motion_of(track: Track, t_s: Reals, max_gap_s: float, band: Band) -> _Motion:
    """Return the heading at even times, minus its mean over some time about each."""
    gap_s = max(max_gap_s, 4.0 * _GRID_S)
    covered = track.covers(t_s - _GRID_S, t_s + _GRID_S, gap_s).astype(float)
    heading = np.where(covered > 0.0, track.at(t_s), 0.0)
    half = int(0.5 * band.slow_s / _GRID_S)
    at = np.arange(t_s.size)
    lo, hi = np.maximum(at - half, 0), np.minimum(at + half + 1, t_s.size)
    count, total = (np.concatenate(([0.0], np.cumsum(v))) for v in (covered, heading))
    covered *= count[hi] - count[lo] >= band.least_known * (2 * half + 1)
    mean = (total[hi] - total[lo]) / np.maximum(count[hi] - count[lo], 1.0)
    return _Motion(covered * (heading - mean), covered)


def _liveliest(motion: _Motion, longest_s: float) -> tuple[int, int]:
    """Return the bounds of the part with the most motion."""
    n, size = motion.deg.size, int(longest_s / _GRID_S)
    if n <= size:
        return 0, n
    begins = np.linspace(0, n - size, 2 * math.ceil(n / size) - 1).astype(int)
    # The median of the minutes, so that not one turn decides.
    width = int(_MINUTE_S / _GRID_S)
    minutes = np.add.reduceat(np.abs(motion.deg), np.arange(0, n, width))
    lively = [float(np.median(minutes[lo // width:(lo + size) // width])) for lo in begins]
    lo = int(begins[int(np.argmax(lively))])
    return lo, lo + size


def _clip(motion: _Motion) -> _Motion:
    """Return the motion within four standard deviations, those of its middle half."""
    size = np.abs(motion.deg[motion.covered > 0.0])
    most = _CLIP * _MAD * float(np.median(size)) if size.size else 0.0
    return _Motion(np.clip(motion.deg, -most, most), motion.covered) if most > 0.0 else motion


def _agree(ts: _Motion, rs: _Motion, m: int) -> tuple[Reals, Reals, Reals]:
    """Return concordance, correlation and number of shared times at lags of -m to m steps."""
    width = scipy.fft.next_fast_len(rs.deg.size + ts.deg.size, real=True)

    def turned(values: Reals) -> np.ndarray:
        return np.asarray(np.fft.rfft(values, width))
    a, ma, aa = (turned(v) for v in (ts.deg, ts.covered, ts.deg ** 2))
    b, mb, bb = (turned(v) for v in (rs.deg, rs.covered, rs.deg ** 2))

    def along(x: np.ndarray, y: np.ndarray) -> Reals:
        # The RS begins m steps earlier, so a late TS has the lag of a smaller index.
        lagged: Reals = np.fft.irfft(y * np.conj(x), width)[:2 * m + 1][::-1]
        return lagged
    n = np.rint(along(ma, mb))
    shared = np.maximum(n, 1.0)
    mean_a, mean_b = along(a, mb) / shared, along(ma, b) / shared
    both = along(a, b) / shared - mean_a * mean_b
    var_a = np.maximum(along(aa, mb) / shared - mean_a ** 2, 0.0)
    var_b = np.maximum(along(ma, bb) / shared - mean_b ** 2, 0.0)
    least = _ROUNDING * max(float(var_a.max()), float(var_b.max()), 1e-12)
    good = (n > 1.0) & (var_a > least) & (var_b > least)
    agreement = np.where(good, 2.0 * both / np.where(good, var_a + var_b, 1.0), 0.0)
    correlation = np.where(good, both / np.sqrt(np.where(good, var_a * var_b, 1.0)), 0.0)
    return agreement, np.clip(correlation, -1.0, 1.0), n


def _autocorrelation(motion: _Motion) -> Reals:
    """Return the autocorrelation of the motion, up to a quarter of its length."""
    n = motion.deg.size
    width = scipy.fft.next_fast_len(2 * n, real=True)
    spectrum = np.fft.rfft(motion.deg, width)
    power = spectrum.real ** 2 + spectrum.imag ** 2
    correlation: Reals = np.fft.irfft(power, width)[:max(1, n // 4)]
    return correlation / correlation[0] if correlation[0] > 0.0 else np.ones_like(correlation)
