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

"""
Whether two streams are one sensor: their changes of value coincide, at one delay.

Two loggers on one sensor write the same sequence of values, late, thinned, offset, repeated or
rounded. No two sensors do. The comparison needs no pairs, and depends on the two streams alone.
"""

from __future__ import annotations

from dataclasses import dataclass, field
import math

import numpy as np

from heading_intercompare.core.angles import unwrap_deg, wrap180
from heading_intercompare.core.records import Headings, Integers, Reals

_EPOCH_NS, _LONGEST_NS, _MARGIN_NS = 60 * 10**9, 600 * 10**9, 15 * 10**9
_CHANGES, _LEAST_CHANGES, _TRIED, _BEST_DELAYS, _MOST_DELAYS = 100, 10, 10, 16, 6000
_RANGE_STEPS, _PER_STEP, _CONSTANTS = 3.0, 4, 3
_UNIT_DEG, _SLACK_DEG = 1e-4, 1e-6
_OFF, _COARSER, _OF_STEP, _EDGE, _STEADY_STEPS = 1e-2, 1.5, 0.02, 0.02, 1.5
_MOST_WAITING = 400_000


def _no_stamps() -> Integers:
    return np.empty(0, np.int64)


@dataclass(frozen=True, slots=True)
class Matched:
    """
    Changes of value that were compared.

    Attributes
    ----------
    compared_ns, differing_ns : ndarray of int64
        Stamps of the changes of the coarser sensor that were compared, and of those at which the
        other one has another value at the best delay, nanoseconds.

    """

    compared_ns: Integers = field(default_factory=_no_stamps)
    differing_ns: Integers = field(default_factory=_no_stamps)


class _Stream:
    """The readings of one sensor that wait to be compared, and the step of all before them."""

    def __init__(self) -> None:
        self.headings = Headings.empty()
        self.units = 0

    def changes(self, from_ns: int, to_ns: int) -> np.ndarray:
        """Return the rows from one stamp to before another whose value differs from before."""
        lo, hi = np.searchsorted(self.headings.stamp_ns, (from_ns, to_ns)).tolist()
        rows = np.arange(max(lo, 1), hi)
        change = wrap180(self.headings.heading_deg[rows] - self.headings.heading_deg[rows - 1])
        changed: np.ndarray = rows[np.abs(change) > _SLACK_DEG]
        return changed

    def take_step(self, rows: np.ndarray) -> None:
        """Take changes into the greatest common divisor of all, units of 1e-4 deg."""
        if self.units == 1:
            return
        heading = self.headings.heading_deg
        change = np.abs(wrap180(heading[rows] - heading[rows - 1])) / _UNIT_DEG
        units = np.rint(change)
        if (np.abs(change - units) > _OFF).any():
            self.units = 1
        elif units.size:
            self.units = math.gcd(self.units, int(np.gcd.reduce(units.astype(np.int64))))

    def spacing_ns(self, from_ns: int, to_ns: int) -> float:
        """Return the usual step of the stamps in a block."""
        lo, hi = np.searchsorted(self.headings.stamp_ns, (from_ns, to_ns)).tolist()
        return float(np.median(np.diff(self.headings.stamp_ns[lo:hi]))) if hi - lo > 1 else 0.0

    def forget(self, before_ns: int) -> None:
        self.headings = self.headings[int(np.searchsorted(self.headings.stamp_ns, before_ns)):]


class SequenceMatch:
    """
    Compare the changes of value of two streams, block by block.

    Parameters
    ----------
    range_s
        Largest delay to try in either direction, seconds; three steps of the slower sensor are
        tried in any case, up to 15 s.

    Notes
    -----
    A block ends at the first whole minute at which both sensors have changed 100 times, or after
    10 min. The first 100 changes of one sensor count: of the coarser one; if both have one step,
    or one changes far less often, of that one. The readings before and after each are compared
    with those of the other sensor that are nearest at a delay, within half a step of the faster
    one. Streams of one step must differ there by one constant. Otherwise the finer value with a
    constant must round to the coarser one; on an edge both fit. The delay counts at which the
    least share of the changes differs. Delays are tried in quarters of a step of the faster
    sensor. A block of a steady turn does not count: there two coarse sensors may change together.

    References
    ----------
    E.27 of ``docs/diagnostics.md``.

    """

    def __init__(self, range_s: float) -> None:
        self._range_ns = range_s * 1e9
        self._margin_ns = max(round(self._range_ns), _MARGIN_NS)
        self._streams = {name: _Stream() for name in ('ts', 'rs')}
        self._from_ns: int | None = None
        self._to_ns = 0

    def take(self, ts: Headings, rs: Headings) -> Matched:
        """Take readings with increasing stamps; return what is now compared."""
        for name, headings in (('ts', ts), ('rs', rs)):
            stream = self._streams[name]
            # Without the other sensor nothing can be compared.
            stream.headings = (stream.headings + headings)[-_MOST_WAITING:]
        return self._compare(end=False)

    def end(self) -> Matched:
        """Compare what is left at the end of both streams."""
        return self._compare(end=True)

    def _compare(self, end: bool) -> Matched:
        streams = self._streams.values()
        if self._from_ns is not None:
            for stream in streams:
                stream.forget(self._from_ns - self._margin_ns)
        if not all(len(stream.headings) for stream in streams):
            return Matched()
        heard_ns = min(int(stream.headings.stamp_ns[-1]) for stream in streams)
        if self._from_ns is None:
            self._begin(max(int(stream.headings.stamp_ns[0]) for stream in streams))
        matches = []
        while (from_ns := self._from_ns) is not None and (
                self._to_ns + self._margin_ns <= heard_ns or end and from_ns < heard_ns):
            to_ns = min(self._to_ns, heard_ns + 1) if end else self._to_ns
            rows = [stream.changes(from_ns, to_ns) for stream in streams]
            is_full = min(map(len, rows)) >= _CHANGES
            if not is_full and self._to_ns - from_ns < _LONGEST_NS and to_ns == self._to_ns:
                self._to_ns += _EPOCH_NS
                continue
            for stream, at in zip(streams, rows):
                stream.take_step(at)
            matches.append(self._match(to_ns, rows))
            self._begin(to_ns)
        compared, differing = (
            np.concatenate([_no_stamps(), *(getattr(match, name) for match in matches)])
            for name in ('compared_ns', 'differing_ns'))
        return Matched(compared, differing)

    def _begin(self, from_ns: int) -> None:
        self._from_ns = from_ns
        self._to_ns = (from_ns // _EPOCH_NS + 1) * _EPOCH_NS
        for stream in self._streams.values():
            stream.forget(from_ns - self._margin_ns)

    def _match(self, to_ns: int, rows: list[np.ndarray]) -> Matched:
        """Compare the changes of a block."""
        assert self._from_ns is not None
        streams = [*self._streams.values()]
        spacing = [stream.spacing_ns(self._from_ns, to_ns) for stream in streams]
        if not all(len(at) and step for at, step in zip(rows, spacing)):
            return Matched()
        units = [stream.units for stream in streams]
        is_equal = max(units) <= _COARSER * min(units)
        coarse, few = int(np.argmax(units)), int(np.argmin([len(at) for at in rows]))
        if is_equal or _COARSER * len(rows[few]) < len(rows[1 - few]):
            coarse = few
        width_deg = _OF_STEP * min(units) * _UNIT_DEG + _SLACK_DEG
        if not is_equal:
            width_deg += 0.5 * max(units) * _UNIT_DEG
        of, at, partner = streams[coarse].headings, rows[coarse][:_CHANGES], streams[1 - coarse]
        if _is_steady_turn(of, at, max(units) * _UNIT_DEG):
            return Matched()
        step_ns = min(spacing)
        most_ns = min(max(self._range_ns, _RANGE_STEPS * max(spacing)), self._margin_ns,
                      _MOST_DELAYS // 2 * step_ns / _PER_STEP)
        n = int(most_ns * _PER_STEP / step_ns)
        delay_ns: Reals = np.arange(-n, n + 1, dtype=np.float64) * (step_ns / _PER_STEP)
        fine_deg = 0.0 if is_equal else min(units) * _UNIT_DEG

        def share(of_rows: np.ndarray, delays: Reals) -> tuple[np.ndarray, np.ndarray]:
            apart = _find_apart(of, of_rows, partner.headings, delays, step_ns)
            return _find_differing(apart, width_deg, fine_deg)

        if len(delay_ns) > _BEST_DELAYS:
            tried = at[np.linspace(0, len(at) - 1, min(_TRIED, len(at))).astype(int)]
            order = np.argsort(_differing_share(*share(tried, delay_ns)), kind='stable')
            delay_ns = delay_ns[np.sort(order[:_BEST_DELAYS])]
        comparable, differs = share(at, delay_ns)
        best = int(np.argmin(_differing_share(comparable, differs)))
        if np.count_nonzero(comparable[:, best]) < min(_LEAST_CHANGES, len(at)):
            return Matched()
        stamp_ns = of.stamp_ns[at]
        return Matched(stamp_ns[comparable[:, best]], stamp_ns[differs[:, best]])


def _is_steady_turn(of: Headings, at: np.ndarray, step_deg: float) -> bool:
    """Tell whether the readings at changes lie on one line, but for their steps."""
    if len(at) < _LEAST_CHANGES:
        return False
    heading = unwrap_deg(of.heading_deg[at])
    t = (of.stamp_ns[at] - of.stamp_ns[at[0]]) / 1e9
    chord = heading - heading[0] - (heading[-1] - heading[0]) / t[-1] * t
    # What is left of any line spans at least the distance of a reading from a chord.
    if np.abs(chord).max() > 1.01 * _STEADY_STEPS * step_deg:
        return False
    slope, start = np.polyfit(t, heading, 1)
    off = np.ptp(heading - slope * t - start)
    return bool(off <= _STEADY_STEPS * step_deg < 0.1 * abs(slope) * t[-1])


def _find_apart(of: Headings, rows: np.ndarray, partner: Headings, delay_ns: Reals,
                step_ns: float) -> Reals:
    """
    Return the headings before and after changes minus the partner's, by change and delay.

    They are nan if the partner has no reading near enough. Delays vary last, so that they are
    searched in order.
    """
    at = np.stack((rows - 1, rows))
    origin_ns = int(of.stamp_ns[0])
    delayed_ns = (of.stamp_ns[at] - origin_ns)[..., None] + delay_ns
    # Only the partner's readings within the delays are searched.
    lo, hi = np.searchsorted(partner.stamp_ns, (
        int(of.stamp_ns[at.min()] + delay_ns.min() - step_ns),
        int(of.stamp_ns[at.max()] + delay_ns.max() + step_ns) + 1)).tolist()
    partner = partner[max(lo - 1, 0):hi + 1]
    stamps = (partner.stamp_ns - origin_ns).astype(np.float64)
    if len(stamps) < 2:
        return np.full(delayed_ns.shape, np.nan)
    # Midway between two readings the earlier one is the nearest.
    nearest = np.searchsorted(0.5 * (stamps[1:] + stamps[:-1]), delayed_ns)
    apart = wrap180(of.heading_deg[at][..., None] - partner.heading_deg[nearest])
    apart[np.abs(stamps[nearest] - delayed_ns) > 0.5001 * step_ns] = np.nan
    return apart


def _find_differing(apart_deg: Reals, width_deg: float,
                    fine_deg: float) -> tuple[np.ndarray, np.ndarray]:
    """Return which changes can be compared at each delay, and which of them differ."""
    has_partner = ~np.isnan(apart_deg)
    ordered = np.sort(apart_deg.reshape(-1, apart_deg.shape[2]), axis=0)
    n = np.count_nonzero(has_partner.reshape(ordered.shape), axis=0)

    def quantile(share: float) -> Reals:
        at = np.maximum(0, np.rint(share * (n - 1))).astype(np.int64)
        return np.where(n > 0, ordered[at, np.arange(len(at))], 0.0)

    constants = [np.zeros(n.shape), quantile(0.5)]
    if fine_deg:
        # On a quiet ship the coarser sensor has two values, and the readings lie at both edges.
        around = quantile(0.5), 0.5 * (quantile(_EDGE) + quantile(1.0 - _EDGE))
        constants += [center + j * fine_deg for center in around
                      for j in range(-_CONSTANTS, _CONSTANTS + 1)]
    least = np.ones(apart_deg.shape[1:], bool)
    for number, constant in enumerate(constants):
        # Without a partner it is nan, and not off.
        off = np.abs(apart_deg - constant) > width_deg
        differs: np.ndarray = off[0] | off[1]
        better = np.count_nonzero(differs, axis=0) < np.count_nonzero(least, axis=0)
        least = differs if not number else np.where(better, differs, least)
    comparable: np.ndarray = has_partner[0] | has_partner[1]
    return comparable, least


def _differing_share(comparable: np.ndarray, differs: np.ndarray) -> np.ndarray:
    """Return the share of changes that differ at each delay; 1 with too few to compare."""
    n = np.count_nonzero(comparable, axis=0)
    enough = n >= max(1, int(n.max(initial=0)) // 2)
    return np.where(enough, np.count_nonzero(differs, axis=0) / np.maximum(n, 1), 1.0)
