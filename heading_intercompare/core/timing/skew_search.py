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

"""The search for a time skew, by the correlation of the rates of turn and the least scatter."""

from __future__ import annotations

from dataclasses import dataclass
import math
from typing import NamedTuple, Sequence

import numpy as np

from heading_intercompare.core.statistics.blocking import block_means, block_size

from .cubic_spline import CubicSpline
from .heading_track import Track
from .skew_instrument import Fit, Instrument, LEAST_STRENGTH

REACH_S = 60.0
"""Largest skew ever searched for, in either direction, seconds."""

_GRID_S = 0.25
_HALF_SPAN_STEPS = 2
_SEGMENT = 1 << 14
_MOST_SEGMENTS = 64
_STEPS = 20
_SETTLED_S = 1e-4
_NEAR_S = 0.5
_ALIKE = 0.95
_MOST_STARTS = 4
_LEAST_MET = 0.5
_CLEARLY_LESS, _FAR_LESS = 0.98, 0.7
_AT_END = 0.9
_GLANCED, _WORTH_TRYING = 1024, 0.8
_SLOW_S = 0.4
_BLOCK_S = 64.0
_MOVED = 0.3


def coarsen(track: Track, block_s: float) -> Track:
    """Average a track over blocks of at most `block_s`; return it unchanged if it is as coarse."""
    if len(track) < 2:
        return track
    step = track.step_s
    size = block_size(math.floor(block_s / step), 1) if 0.0 < step < block_s else 1
    if size < 2 or len(track) < 64 * size:
        return track
    return Track.of(block_means(track.t_s, size), block_means(track.heading_deg, size))


@dataclass(frozen=True, slots=True)
class Correlogram:
    """
    The correlation of the rates of turn of both sensors, with the RS shifted.

    Attributes
    ----------
    lag_s : ndarray, shape (k,)
        Delay of the TS against the RS, in increasing order, seconds.
    value : ndarray, shape (k,)
        Correlation; 0 where there are no rates.

    """

    lag_s: np.ndarray
    value: np.ndarray

    def starts(self, near_s: float, low_s: float, high_s: float) -> list[float]:
        """Return the lags of the highest peaks within a range, nearest to `near_s` first."""
        v = self.value
        tops = 1 + np.flatnonzero((v[1:-1] > 0.0) & (v[1:-1] >= v[:-2]) & (v[1:-1] > v[2:]))
        before, top, after = v[tops - 1], v[tops], v[tops + 1]
        lags = self.lag_s[tops] + 0.5 * _GRID_S * (after - before) / (2.0 * top - before - after)
        inside = (lags > low_s) & (lags < high_s)
        lags, top = lags[inside], top[inside]
        if not lags.size:
            return []
        return sorted(lags[top >= _ALIKE * top.max()].tolist(), key=lambda lag: abs(lag - near_s))


def _rates(track: Track, t_s: np.ndarray, max_gap_s: float) -> np.ndarray:
    """Return the rates at even times minus their mean; 0 where there are no rates."""
    half = _HALF_SPAN_STEPS * _GRID_S
    good = track.covers(t_s - half, t_s + half, max_gap_s)
    heading = track.at(np.concatenate((t_s[:1] - half, t_s[:1] - _GRID_S, t_s,
                                       t_s[-1:] + _GRID_S, t_s[-1:] + half)))
    rate = (heading[2 * _HALF_SPAN_STEPS:] - heading[:-2 * _HALF_SPAN_STEPS]) / (2.0 * half)
    return np.where(good, rate - rate[good].mean(), 0.0) if good.any() else np.zeros(t_s.size)


def compute_correlogram(ts: Track, rs: Track, reach_s: float = REACH_S,
                        max_gap_s: float = 3.0) -> Correlogram:
    """
    Correlate the rates of turn of both sensors at all skews within reach.

    Parameters
    ----------
    ts, rs
        Both sensors on common times, at least two readings; the RS may extend further.
    reach_s
        Largest skew, in either direction, seconds.
    max_gap_s
        Rates across a longer silence count as 0, seconds.

    Returns
    -------
    Correlogram
        In steps of a quarter of a second.

    Notes
    -----
    Uses the fast Fourier transform over segments of 4096 s; if there are more than 64, over 64 of
    them, evenly spaced. A TS segment overlaps the RS completely at every skew, so no skew is
    favoured except at the ends of the run.

    """
    m = math.ceil(reach_s / _GRID_S)
    n = max(2, int((ts.t_s[-1] - ts.t_s[0]) / _GRID_S) + 1)
    t = ts.t_s[0] + _GRID_S * np.arange(-m, n + m)
    a, b = _rates(ts, t[m:n + m], max_gap_s), _rates(rs, t, max_gap_s)
    size = min(n, _SEGMENT)
    begins = np.arange(0, n - size + 1, size)
    if begins.size > _MOST_SEGMENTS:
        begins = begins[np.linspace(0, begins.size - 1, _MOST_SEGMENTS).astype(int)]
    width = 1 << (size + 2 * m - 1).bit_length()
    total, power = np.zeros(2 * m + 1), 0.0
    for lo in begins.tolist():
        ts_rate, rs_rate = a[lo:lo + size], b[lo:lo + size + 2 * m]
        total += np.fft.irfft(np.fft.rfft(rs_rate, width) * np.conj(np.fft.rfft(ts_rate, width)),
                              width)[:2 * m + 1]
        rs_inner = rs_rate[m:m + size]
        power += math.sqrt(float(ts_rate @ ts_rate) * float(rs_inner @ rs_inner))
    lag = _GRID_S * np.arange(-m, m + 1)
    if power <= 0.0:
        return Correlogram(lag, np.zeros(2 * m + 1))
    span = ts.t_s[-1] - ts.t_s[0]
    met = np.minimum(ts.t_s[-1], rs.t_s[-1] + lag) - np.maximum(ts.t_s[0], rs.t_s[0] + lag)
    return Correlogram(lag, total[::-1] / (power * np.clip(met / span, _LEAST_MET, 1.0)))


def has_turned(rs: Track, max_gap_s: float = 3.0) -> bool:
    """Tell whether the rates of a sensor show motion, that is, correlate with later ones."""
    # Rates that share a reading, even an interpolated one, correlate by its noise.
    shared_s = 2.0 * (_HALF_SPAN_STEPS * _GRID_S + rs.step_s)
    correlogram = compute_correlogram(rs, rs, shared_s + 20.0, max_gap_s)
    return float(np.abs(correlogram.value[correlogram.lag_s > shared_s]).max()) > _MOVED


def find_skew(instrument: Instrument, near_s: float, range_s: float,
              curve: Correlogram | None = None) -> tuple[float, Fit] | None:
    """
    Return the skew at which the differences scatter least.

    Parameters
    ----------
    instrument
        Scatter of the differences as a function of the skew.
    near_s
        Expected skew, seconds.
    range_s
        Skews within this distance of the expected one are preferred, seconds.
    curve
        Gives further starting points; default that of the tracks of the instrument.

    Returns
    -------
    skew_s : float
    fit : Fit
        The fit at that skew. The result is None if the ship did not turn enough, or nothing
        converges.

    Notes
    -----
    In a swell the estimate converges from within a quarter of a period, but also a period away.
    So the search starts at the expected skew and at the peaks of the correlogram; of more than
    four starts, at the four where the differences scatter least. Of the results within the
    range, the one with the least scatter about means of 64 s wins; it replaces an earlier one
    only if the scatter falls by 2 %. A result beyond the range must scatter 30 % less.

    References
    ----------
    E.8 of ``docs/diagnostics.md``.

    """
    if curve is None:
        curve = compute_correlogram(instrument.ts, instrument.rs, max_gap_s=instrument.max_gap_s)
    low, high = near_s - range_s, near_s + range_s
    best = _find_least(instrument, [near_s, *curve.starts(near_s, low, high)], low, high)
    if best is None:
        ends = [near_s - _AT_END * range_s, near_s + _AT_END * range_s]
        best = _find_least(instrument, ends, low, high)
    reach = float(curve.lag_s[-1])
    near = [near_s, *curve.starts(near_s, low, high)] if best is None else [best.skew_s]
    glance = _Glance(instrument)
    least = min(glance(d) for d in near)
    far = [lag for lag in curve.starts(near_s, -reach, reach)
           if glance(lag) < _WORTH_TRYING * least]
    far_place = _find_least(instrument, far, -reach, reach)
    if far_place is not None and not low <= far_place.skew_s <= high and (
            glance(far_place.skew_s) < _FAR_LESS * least):
        best = far_place
    return None if best is None else (best.skew_s, best.fit)


class _Glance:
    """The scatter at a skew, from a few times; splines treat a slow RS alike at every skew."""

    def __init__(self, instrument: Instrument) -> None:
        ts, rs = instrument.ts, instrument.rs
        every = -(-len(ts) // _GLANCED)
        self.t_s, self.ts_deg = ts.t_s[::every], ts.heading_deg[::every]
        self.from_s, self.to_s = rs.t_s[0], rs.t_s[-1]
        self.rs_at = (CubicSpline(rs.t_s, rs.heading_deg) if rs.step_s > _SLOW_S else rs.at)

    def __call__(self, skew_s: float) -> float:
        """Return the scatter, degrees; infinite outside the RS record."""
        inside = (self.t_s - skew_s >= self.from_s) & (self.t_s - skew_s <= self.to_s)
        t = self.t_s[inside]
        if not t.size:
            return math.inf
        return scatter_deg(t, self.ts_deg[inside] - self.rs_at(t - skew_s))


class _Place(NamedTuple):
    skew_s: float
    fit: Fit
    scatter_deg: float


def _find_least(instrument: Instrument, starts: Sequence[float], low_s: float,
                high_s: float) -> _Place | None:
    """Return the place of least scatter reached from some starts; the earliest of equals."""
    best: _Place | None = None
    settled: list[float] = []
    if len(starts) > _MOST_STARTS:
        scatter = [math.inf if (start_fit := instrument(start)) is None
                   else scatter_deg(start_fit.t_s, start_fit.x) for start in starts]
        chosen = np.sort(np.argsort(scatter, kind='stable')[:_MOST_STARTS])
        starts = [starts[i] for i in chosen.tolist()]
    for start in starts:
        if any(abs(start - d) < _NEAR_S for d in settled):
            continue
        start_place = _settle(instrument, start, low_s, high_s)
        if start_place is None:
            continue
        skew_s, fit = start_place
        settled.append(skew_s)
        place = _Place(skew_s, fit, scatter_deg(fit.t_s, fit.x))
        if best is None or place.scatter_deg < _CLEARLY_LESS * best.scatter_deg:
            best = place
    return best


def _settle(instrument: Instrument, start_s: float, low_s: float,
            high_s: float) -> tuple[float, Fit] | None:
    """Iterate from a start until no skew remains; None if that leaves the range or fails."""
    d = start_s
    for _ in range(_STEPS):
        fit = instrument(d) if low_s <= d <= high_s else None
        if fit is None or not fit.strength >= LEAST_STRENGTH:
            return None
        d += fit.step_s
        if abs(fit.step_s) < _SETTLED_S:
            return d, fit
    return None


def scatter_deg(t_s: np.ndarray, x_deg: np.ndarray) -> float:
    """Return the standard deviation of differences about their means over 64 s; n >= 1."""
    block = ((t_s - t_s[0]) / _BLOCK_S).astype(np.intp)
    mean = np.bincount(block, x_deg) / np.maximum(np.bincount(block), 1)
    return float(np.sqrt(np.mean((x_deg - mean[block]) ** 2)))
