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

"""When the readings of each sensor were made, and why two sensors have no instant in common."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from heading_intercompare.core.units.given_stamps import EARLIEST_NS
from heading_intercompare.core.utc_text import utc_span

_SECOND_NS = 10 ** 9
_HOUR_S, _DAY_S = 3600, 86_400
_ROLLOVER_S = 1024 * 7 * _DAY_S
#: Farther than any time zone from another one that a ship keeps beside UTC.
_LONGEST_ZONE_S = 14 * _HOUR_S
#: Two loggers of one trial start or end within this time of each other.
_TOGETHER_S = 120
_ZONE = 'a time zone?'
_SHIFTS = (
    (_ROLLOVER_S, 2 * _ROLLOVER_S, 'a rollover of the weeks of GPS?'),
    (_HOUR_S // 2, _LONGEST_ZONE_S, _ZONE),
    (_DAY_S, _ROLLOVER_S, 'a wrong date?'))


@dataclass(slots=True)
class StreamSpan:
    """
    The first and the last instant of the readings of a sensor, whatever their order.

    Attributes
    ----------
    first_ns, last_ns
        Nanoseconds UTC; None without a stamped reading.

    """

    first_ns: int | None = None
    last_ns: int | None = None

    def update(self, stamp_ns: NDArray[np.int64]) -> None:
        """Take the stamps of some readings; 0 is none."""
        stamps = stamp_ns[stamp_ns > 0]
        if len(stamps):
            first_ns, last_ns = int(stamps.min()), int(stamps.max())
            self.first_ns = first_ns if self.first_ns is None else min(self.first_ns, first_ns)
            self.last_ns = last_ns if self.last_ns is None else max(self.last_ns, last_ns)

    @property
    def words(self) -> str:
        """Return the span in words."""
        return utc_span(self.first_ns or 0, self.last_ns or 0)


def explain_apart(ts: StreamSpan, rs: StreamSpan, skew_s: float = 0.0,
                  names: tuple[str, str] = ('TS', 'RS')) -> str:
    """
    Return why the readings of two sensors have no instant in common, and what to set.

    Parameters
    ----------
    ts, rs
        Their spans.
    skew_s
        Stated latency of the first, `alignment.skew_s`.
    names
        Their names.

    Returns
    -------
    str
        Empty if the spans meet, or one sensor has no reading.

    Examples
    --------
    >>> explain_apart(StreamSpan(10 ** 18, 10 ** 18 + 10 ** 9),
    ...               StreamSpan(10 ** 18 + 7200 * 10 ** 9, 10 ** 18 + 7201 * 10 ** 9))[-41:]
    'shift with --set alignment.skew_s=-7200.0'

    """
    if ts.first_ns is None or ts.last_ns is None or rs.first_ns is None or rs.last_ns is None:
        return ''
    skew_ns = round(skew_s * _SECOND_NS)
    if rs.first_ns <= ts.last_ns - skew_ns and ts.first_ns - skew_ns <= rs.last_ns:
        return ''
    starts_s = (rs.first_ns - ts.first_ns) / _SECOND_NS
    ends_s = (rs.last_ns - ts.last_ns) / _SECOND_NS
    shown = (f'the stamps of {names[0]} and {names[1]} do not meet: {names[0]} {ts.words}, '
             f'{names[1]} {rs.words}; {names[1]} begins {_show(starts_s)} '
             f'{"after" if starts_s > 0 else "before"} {names[0]}')
    for name, first_ns, other_ns in ((names[0], ts.first_ns, rs.first_ns),
                                     (names[1], rs.first_ns, ts.first_ns)):
        if first_ns < EARLIEST_NS <= other_ns:
            return (f'{shown}; is that of {name} time since a start, or simulation time? record '
                    f'it with UTC, or, if both began together, {_state(starts_s)}')
    shift = _find_shift(starts_s, ends_s)
    if shift is None:
        return f'{shown}; give recordings of the same time, or set the clocks right'
    shift_s, guess = shift
    zone = ('state the zone of stamps without one with --ts-stamp-zone or --rs-stamp-zone, or '
            if guess == _ZONE else '')
    return f'{shown}: {guess} if so, {zone}{_state(shift_s)}'


def _state(shift_s: float) -> str:
    return f'state the shift with --set alignment.skew_s={-shift_s!r}'


def _find_shift(starts_s: float, ends_s: float) -> tuple[float, str] | None:
    """Return the usual shift by which two recordings of one trial lie apart, and what it is."""
    for step_s, most_s, guess in _SHIFTS:
        for apart_s in (starts_s, ends_s):
            shift_s = round(apart_s / step_s) * step_s
            if 0 < abs(shift_s) <= most_s and abs(apart_s - shift_s) <= _TOGETHER_S:
                return float(shift_s), guess
    return None


def _show(apart_s: float) -> str:
    """Return a span of time in the largest unit of which it has two."""
    size_s = abs(apart_s)
    unit_s, unit = next(((unit_s, unit) for unit_s, unit in (
        (_DAY_S, 'days'), (_HOUR_S, 'h'), (60, 'min')) if size_s >= 2 * unit_s), (1, 's'))
    return f'{size_s / unit_s:.6g} {unit}'
