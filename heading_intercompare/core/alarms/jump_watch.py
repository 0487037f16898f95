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

"""Differences that leave their usual spread: one by one, or abruptly and for good."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from heading_intercompare.core.angles import circular_mean, unwrap_deg, wrap180
from heading_intercompare.core.conditions.outliers import find_outliers
from heading_intercompare.core.records import Reals
from heading_intercompare.core.utc_text import utc

from .alarm import Sign
from .pair_window import PairWindow

_RECENT_S, _FEWEST = 1.5, 3
# The usual spread is that of readings older than this, over at least this time.
_OLDER_S, _LEAST_S, _LEAST = 3.0, 10.0, 30
_BASE_EVERY_S = 5.0
# Outliers last no longer than this here: a longer excursion is a jump that returns.
_SINGLE_S, _NAMED_S, _SEARCHED_S = 1.0, 3.0, 10.0
_ABRUPT_S, _SHARE, _BACK = 0.5, 0.5, 0.5
_SWAYS = 64
_NEW_SPREAD_S = 60.0


@dataclass(frozen=True, slots=True)
class _Base:
    """The usual differences: centre, threshold of an outlier, and usual motion of the ship."""

    center_deg: float
    threshold_deg: float
    sway_deg: float


class JumpWatch:
    """
    Looks for outliers and jumps of the difference.

    Parameters
    ----------
    skew_range_s
        Largest skew to allow for, seconds.

    Notes
    -----
    The usual spread and the threshold are those of `find_outliers`, of the readings older than
    three seconds that are not themselves beyond the threshold.

    A turn by itself puts differences there: a late sensor lags. So the threshold grows by the
    range of the RS heading within the skew range, less the range that it usually has.

    A jump is abrupt: the means over half a second move by half of its size from one to the next.
    It lasts until the difference has come back to half of the threshold. The
    detector of the verdict, `find_partings`, needs a minute of it; an alarm must come at once.

    """

    def __init__(self, skew_range_s: float) -> None:
        self._reach_s = skew_range_s
        self.reset()

    def reset(self) -> None:
        """Forget what is usual."""
        self._base: _Base | None = None
        self._next_ns = self._not_before_ns = 0
        self._jumped = False

    def look(self, window: PairWindow, step_deg: float, since_ns: int | None,
             explained: bool, repeats: bool = False) -> dict[str, Sign]:
        """
        Return the signs 'jump' and 'outliers' at the newest pair.

        Parameters
        ----------
        window
            The newest pairs; not empty.
        step_deg
            Step in which the coarser sensor reports, degrees; 0 if unknown.
        since_ns
            Stamp of the newest pair at the last look.
        explained
            Another alarm explains what may be seen here.
        repeats
            A sensor repeats its value and may be frozen: then motion alone looks like a jump.

        """
        newest_ns = int(window.stamp_ns[-1])
        if explained:
            # The newest readings are not the usual readings.
            self._jumped, self._not_before_ns = False, newest_ns
            return {'jump': Sign(False), 'outliers': Sign(False)}
        if repeats and not self._jumped:
            return {'jump': Sign(None), 'outliers': Sign(None)}
        if not self._jumped and newest_ns >= self._next_ns:
            self._next_ns = newest_ns + round(_BASE_EVERY_S * 1e9)
            self._base = self._find_base(window, step_deg) or self._base
        base = self._base
        if base is None:
            return {'jump': Sign(False), 'outliers': Sign(None)}
        jump = self._look_jump(window, base)
        outliers = Sign(False) if jump.active else self._look_outliers(window, base, step_deg,
                                                                       since_ns)
        return {'jump': jump, 'outliers': outliers}

    def _find_base(self, window: PairWindow, step_deg: float) -> _Base | None:
        hi = window.find(_OLDER_S)
        lo = int(np.searchsorted(window.stamp_ns, self._not_before_ns, side='right'))
        stamps, x = window.stamp_ns[lo:hi], window.x_deg[lo:hi]
        base = self._base
        # What was usual before an alarm is better known than what is since then.
        least_s = _LEAST_S if base is None or not self._not_before_ns else _NEW_SPREAD_S
        if hi - lo < _LEAST or (int(stamps[-1]) - int(stamps[0])) / 1e9 < least_s:
            return None
        center = circular_mean(x)[0] if base is None else base.center_deg
        off = wrap180(x - center)
        if base is not None:
            usual = np.abs(off) <= base.threshold_deg
            if np.mean(usual[int(np.searchsorted(
                    stamps, int(stamps[-1]) - round(_NEW_SPREAD_S * 1e9))):]) > 0.5:
                stamps, off = stamps[usual], off[usual]
        if off.size < _LEAST:
            return None
        outliers = find_outliers(stamps, off, longest_s=_SINGLE_S, step_deg=step_deg)
        if outliers.threshold_deg is None:
            return None
        begins = np.linspace(int(window.stamp_ns[0]), int(window.stamp_ns[hi - 1])
                             - round(self._span_s * 1e9), _SWAYS).astype(np.int64)
        sways = [self._sway(window, int(begin), int(begin) + round(self._span_s * 1e9))
                 for begin in begins]
        return _Base(float(wrap180(center + float(np.median(off)))), outliers.threshold_deg,
                     float(np.median(sways)))

    @property
    def _span_s(self) -> float:
        return _RECENT_S + self._reach_s

    @staticmethod
    def _sway(window: PairWindow, from_ns: int, to_ns: int) -> float:
        """Return the range of the RS heading between two stamps, degrees."""
        lo, hi = np.searchsorted(window.stamp_ns, [from_ns, to_ns + 1]).tolist()
        return float(np.ptp(unwrap_deg(window.rs_deg[lo:hi]))) if hi - lo > 1 else 0.0

    def _allow(self, window: PairWindow, base: _Base, from_ns: int, to_ns: int) -> float:
        """Return the threshold, with what the motion of the ship may add; degrees."""
        reach_ns = round(self._reach_s * 1e9)
        sway = self._sway(window, from_ns - reach_ns, to_ns + reach_ns)
        return base.threshold_deg + max(0.0, sway - base.sway_deg)

    def _look_jump(self, window: PairWindow, base: _Base) -> Sign:
        at = max(0, min(window.find(_RECENT_S), len(window) - _FEWEST))
        off = wrap180(window.x_deg[at:] - base.center_deg)
        size = float(np.median(off))
        back = _BACK * base.threshold_deg
        if self._jumped:
            if abs(size) <= back:
                self._jumped = False
                return Sign(False)
        elif abs(size) <= back:
            return Sign(False)
        else:
            stamps = window.stamp_ns
            if abs(size) <= self._allow(window, base, int(stamps[at]), int(stamps[-1])) \
                    or float((off * np.sign(size)).min()) <= back:
                return Sign(None)
            self._jumped = self._is_abrupt(window, base, size)
            if not self._jumped:
                return Sign(None)
        return Sign(True, f'TS - RS jumped by {size:+.3g} deg from its usual value, '
                    f'{base.center_deg:.2f} deg', {'size_deg': size,
                                                   'threshold_deg': base.threshold_deg})

    @staticmethod
    def _is_abrupt(window: PairWindow, base: _Base, size: float) -> bool:
        lo = window.find(_RECENT_S + 2.0 * _OLDER_S)
        keys = window.stamp_ns[lo:] // round(_ABRUPT_S * 1e9)
        begins = np.flatnonzero(np.diff(keys, prepend=keys[0] - 1))
        off = wrap180(window.x_deg[lo:] - base.center_deg)
        means = np.add.reduceat(off, begins) / np.diff(np.append(begins, off.size))
        # Half a second may hold both sides of the jump.
        steps = np.abs(means[2:] - means[:-2]) if means.size > 2 else np.abs(np.diff(means))
        return bool(steps.size and steps.max() > _SHARE * abs(size))

    def _look_outliers(self, window: PairWindow, base: _Base, step_deg: float,
                       since_ns: int | None) -> Sign:
        newest_ns = int(window.stamp_ns[-1])
        named_ns = min(newest_ns - round(_NAMED_S * 1e9), newest_ns if since_ns is None
                       else since_ns - round(_SINGLE_S * 1e9))
        searched = window.find(max(_SEARCHED_S, (newest_ns - named_ns) / 1e9 + _SINGLE_S))
        off: Reals = wrap180(window.x_deg - base.center_deg)
        recent_off = off[searched:]
        if float(np.abs(recent_off).max()) <= 0.5 * base.threshold_deg:
            return Sign(False)
        usual = np.flatnonzero(np.abs(off[:searched]) <= base.threshold_deg)
        rows = np.concatenate((usual, np.arange(searched, len(window))))
        outliers = find_outliers(window.stamp_ns[rows], off[rows], longest_s=_SINGLE_S,
                                 step_deg=step_deg)
        # What has not come back yet may be a jump.
        back = np.flatnonzero(np.abs(off) <= base.threshold_deg)
        back_ns = int(window.stamp_ns[back[-1]]) if back.size else 0
        which = rows[outliers.index]
        stamps = window.stamp_ns[which]
        new = [at for at in which[(stamps > named_ns) & (stamps < back_ns)].tolist()
               if self._stands_out(window, base, at, float(off[at]))]
        if not new:
            return Sign(False)
        at = max(new, key=lambda row: abs(off[row]))
        return Sign(True, 'isolated differences stand out, the largest by '
                    f'{off[at]:+.3g} deg at {utc(int(window.stamp_ns[at]))} UTC',
                    {'size_deg': float(off[at]), 'threshold_deg': outliers.threshold_deg})

    def _stands_out(self, window: PairWindow, base: _Base, at: int, size_deg: float) -> bool:
        stamp_ns = int(window.stamp_ns[at])
        return abs(size_deg) > self._allow(window, base, stamp_ns, stamp_ns)
