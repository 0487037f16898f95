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

"""Whether a heading turns as the rate of turn says: the regression of one on the other."""

from __future__ import annotations

from dataclasses import dataclass
import math

import numpy as np

from heading_intercompare.core.angles import wrap180
from heading_intercompare.core.declared_figures import figure
from heading_intercompare.core.records import Integers, Motion, Reals

SPAN_S = 5.0
"""The changes of the heading over spans of this length are compared, seconds."""

FURTHEST_S = 5.0
"""Largest delay of the rate of turn that is allowed for, in either direction, seconds."""

LEAST_TURN_DEG = 0.5
"""Least root mean square of the turns that say anything, degrees in a span."""

PLAIN_TURN_DEG = 2.0
"""A heading that does not follow turns of at least this is wrong, degrees in a span."""

PLAIN_SUM_DEG = 30.0
"""Such turns say so only if they add up to this, whatever their side, degrees."""

_STEP_S = 0.5
_LONGEST_GAP_S = 2.5
_LEAST_SPANS = 24
_FOLLOWS, _ASTRAY = 0.8, 0.3
_LEAST_SLOPE, _MOST_SLOPE = 0.7, 1.4
_SECOND_NS = 10 ** 9


_KINDS = {'follows': 'follows', 'against': 'turns against it',
          'scaled': 'turns by another factor', 'astray': 'does not follow',
          'not_testable': 'not testable'}


@dataclass(frozen=True, slots=True)
class TurnRate:
    """A heading against the rate of turn; keys of the JSON."""

    kind: str = figure('against the rate of turn', choices=_KINDS)
    n: int = figure('spans of 5 s compared', default=0)
    turn_deg: float | None = figure('turn in a span, root mean square', default=None)
    slope: float | None = figure('slope of its turns on the rate of turn', default=None)
    correlation: float | None = figure('their correlation', default=None)
    delay_s: float | None = figure('delay of the heading that fits best', default=None)


def compare_turns(motion: Motion, stamp_ns: Integers, heading_deg: Reals) -> TurnRate:
    """
    Compare the turns of a heading with the rate of turn.

    Parameters
    ----------
    motion
        Rows in stamp order, within the run.
    stamp_ns : ndarray of int64, shape (n,)
        Stamps of the headings in increasing order, nanoseconds.
    heading_deg : ndarray, shape (n,)
        Degrees.

    Returns
    -------
    TurnRate

    Notes
    -----
    The rate is integrated by trapezoids over spans of 5 s without a gap above 2.5 s. The change
    of the heading over each span, read up to 5 s earlier and later, is regressed on it. The delay
    with the largest correlation counts. The heading follows if the correlation is at least 0.8
    and the slope from 0.7 to 1.4. It goes astray if the correlation is below 0.3, and the slope,
    too, over the spans with turns of at least 2 deg, which add up to at least 30 deg.

    """
    rates = motion.rates()
    if len(rates) < 2 or len(stamp_ns) < 2:
        return TurnRate('not_testable')
    start_s, turn = _turns_of(rates)
    origin = int(rates.stamp_ns[0])
    t_s = (stamp_ns - origin) / _SECOND_NS
    best: tuple[float, float, float, int, bool] | None = None
    n, size = turn.size, float(np.sqrt(np.mean(turn ** 2))) if turn.size else 0.0
    if n < _LEAST_SPANS or size < LEAST_TURN_DEG:
        return TurnRate('not_testable', n, size if n else None)
    for step in sorted(range(-round(FURTHEST_S / _STEP_S), round(FURTHEST_S / _STEP_S) + 1),
                       key=abs):
        delay_s = step * _STEP_S
        begin = _heading_at(t_s, heading_deg, start_s + delay_s)
        end = _heading_at(t_s, heading_deg, start_s + SPAN_S + delay_s)
        change = wrap180(end - begin)
        good = np.isfinite(change)
        if np.count_nonzero(good) < _LEAST_SPANS:
            continue
        mine, theirs = change[good], turn[good]
        power = float(theirs @ theirs)
        product = float(mine @ theirs)
        both = math.sqrt(power * float(mine @ mine))
        correlation = product / both if both > 0.0 else 0.0
        if best is None or abs(correlation) > abs(best[0]) + 1e-9:
            slope = product / power if power > 0.0 else 0.0
            best = correlation, slope, delay_s, mine.size, _is_astray(mine, theirs)
    if best is None:
        return TurnRate('not_testable', 0, size)
    correlation, slope, delay_s, n, astray = best
    return TurnRate(_name(correlation, slope, astray), n, size, slope, correlation, delay_s)


def _is_astray(change: Reals, turn: Reals) -> bool:
    """Tell whether the heading does not change where the ship plainly turns."""
    plain = np.abs(turn) >= PLAIN_TURN_DEG
    turn, change = turn[plain], change[plain]
    if float(np.abs(turn).sum()) < PLAIN_SUM_DEG:
        return False
    return abs(float(change @ turn)) < _ASTRAY * float(turn @ turn)


def _name(correlation: float, slope: float, astray: bool) -> str:
    if abs(correlation) >= _FOLLOWS:
        if slope < 0.0:
            return 'against'
        return 'follows' if _LEAST_SLOPE <= slope <= _MOST_SLOPE else 'scaled'
    if abs(correlation) < _ASTRAY and astray:
        return 'astray'
    return 'not_testable'


def _turns_of(rates: Motion) -> tuple[Reals, Reals]:
    """Return the start of each span since the first rate, seconds, and its turn, degrees."""
    t_s = (rates.stamp_ns - rates.stamp_ns[0]) / _SECOND_NS
    keep = np.diff(t_s, prepend=-1.0) > 0.0
    t_s, rate = t_s[keep], rates.rate_deg_s[keep]
    step_s = np.diff(t_s)
    turned = np.concatenate(([0.0], np.cumsum(0.5 * step_s * (rate[1:] + rate[:-1]))))
    gaps = np.concatenate(([0], np.cumsum(step_s > _LONGEST_GAP_S)))
    start = np.arange(0.0, t_s[-1] - SPAN_S + 1e-9, SPAN_S)
    first = np.searchsorted(t_s, start, side='right') - 1
    last = np.minimum(np.searchsorted(t_s, start + SPAN_S), len(t_s) - 1)
    whole = gaps[first] == gaps[last]
    start = start[whole]
    return start, np.interp(start + SPAN_S, t_s, turned) - np.interp(start, t_s, turned)


def _heading_at(t_s: Reals, heading_deg: Reals, at_s: Reals) -> Reals:
    """Return the heading at some times, unwrapped from its bracket; nan beyond a gap."""
    after = np.searchsorted(t_s, at_s).clip(1, len(t_s) - 1)
    before = after - 1
    step_s = t_s[after] - t_s[before]
    good = (at_s >= t_s[before]) & (at_s <= t_s[after]) & (step_s <= _LONGEST_GAP_S)
    share = np.where(good, (at_s - t_s[before]) / np.where(step_s > 0.0, step_s, 1.0), np.nan)
    rise_deg = wrap180(heading_deg[after] - heading_deg[before])
    heading: Reals = heading_deg[before] + share * rise_deg
    return heading
