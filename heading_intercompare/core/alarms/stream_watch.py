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

"""Whether both streams keep coming in time, and whether one clock steps against the other."""

from __future__ import annotations

from collections import deque
from statistics import median
from typing import Sequence

from .alarm import Priority, Rule, Sign

STREAM_RULES = (Rule('ts_silent', clear_s=2.0), Rule('rs_silent', clear_s=2.0),
                Rule('clock_step', clear_s=3.0),
                Rule('overload', Priority.CAUTION, clear_s=3.0))
"""The alarms of the synchronizer."""

# Looks kept for the usual offset, and the least number of them before a step can be seen.
_KEPT, _LEAST, _SPEEDS = 60, 5, 9
# A silence of fewer usual steps is none.
_STEPS, _LEAST_READINGS, _UNKNOWN_S = 3.0, 3, 20.0
# Beyond the steps of both sensors, arrival may be this late; and what a step must last.
_LATE_S, _TWICE = 0.5, 2
# The least share of a step that shows in the stamps of the readings.
_MOVED = 0.5


class StreamWatch:
    """
    Watches the arrival of both streams.

    Parameters
    ----------
    stale_s
        A silence longer than this, and than three usual steps, is a condition, seconds.
    apart_s
        From the start, stamps further apart than this are those of two clocks; later, of a sensor
        that lags, seconds: `pairing.max_wait_s`.

    Notes
    -----
    The offset is the stamp of the last TS reading minus that of the last RS reading. It is usually
    the same to within a step of each sensor. A clock steps if two looks in a row find it further
    from its median than half a second and the steps of both sensors. If stamps pass faster than
    time, as in a fast replay, that bound grows with the speed: readings come in larger pieces.

    Readings that come late put the offset there, too, as after a driver had garbage to read. Their
    stamps go on in usual steps, though. So at least half of the change must show as a step of the
    stamps beyond the usual one of each reading.

    If such readings keep coming and lag those of the other sensor by more than `apart_s`, their
    driver or this computer is overloaded. A sensor that lags so from the start cannot be told from
    one with another clock.

    Stamps far apart give pairs late or never, and a recording has no times of arrival. So no
    detector of the verdict can do this.

    """

    def __init__(self, stale_s: float, apart_s: float) -> None:
        self._stale_s, self._apart_s = stale_s, apart_s
        self._received = [0, 0]
        self._heard_s: list[float | None] = [None, None]
        self._first_s: list[float] = [0.0, 0.0]
        self._look_s: float | None = None
        self._last_ns: list[int] | None = None
        self._counted = [0, 0]
        self._steps: tuple[deque[float], deque[float]] = deque(maxlen=_KEPT), deque(maxlen=_KEPT)
        self._moved_s = 0.0
        self._usual: deque[float] = deque(maxlen=_KEPT)
        self._speeds: deque[float] = deque(maxlen=_SPEEDS)
        self._odd = 0
        self._stepped = False

    def allow(self, stale_s: float) -> None:
        """Change how long silence is allowed, seconds."""
        self._stale_s = stale_s

    def look(self, received: Sequence[int], heard_ns: Sequence[int | None],
             now_s: float) -> dict[str, Sign]:
        """
        Return the signs at a time.

        Parameters
        ----------
        received : pair of int
            Readings of the TS and of the RS so far.
        heard_ns : pair of int or None
            Stamps of the last readings, nanoseconds; None before the first.
        now_s
            A steady clock, seconds; increases from call to call.

        """
        come = [new - old for new, old in zip(received, self._received)]
        self._received = list(received)
        signs = {}
        for at, name in enumerate(('TS', 'RS')):
            if come[at]:
                if self._heard_s[at] is None:
                    self._first_s[at] = now_s
                self._heard_s[at] = now_s
            signs[f'{name.lower()}_silent'] = self._judge_silence(name, at, now_s)
        ts_ns, rs_ns = heard_ns
        before_s, self._look_s = self._look_s, now_s
        if ts_ns is None or rs_ns is None or not min(come) or before_s is None:
            return signs | {'clock_step': Sign(None), 'overload': Sign(None)}
        signs['clock_step'] = self._judge_offset([ts_ns, rs_ns], come, max(now_s - before_s, 0.1))
        signs['overload'] = self._judge_lag((ts_ns - rs_ns) / 1e9)
        return signs

    def _judge_lag(self, offset_s: float) -> Sign:
        """Tell whether one sensor lags, once it is clear that no clock has stepped."""
        if self._stepped or 0 < self._odd < _TWICE or not self._speeds:
            return Sign(None)
        late, early = ('RS', 'TS') if offset_s > 0.0 else ('TS', 'RS')
        return Sign(abs(offset_s) > self._apart_s * max(1.0, median(self._speeds)),
                    f'overload: the readings of the {late} lag those of the {early} by '
                    f'{abs(offset_s):.1f} s; these wait for them', {'lag_s': abs(offset_s)})

    def _judge_silence(self, name: str, at: int, now_s: float) -> Sign:
        heard_s = self._heard_s[at]
        if heard_s is None:
            return Sign(None)
        # A slow sensor is silent between its readings.
        step_s = (heard_s - self._first_s[at]) / max(self._received[at] - 1, 1)
        shows_step = self._received[at] >= _LEAST_READINGS
        allowed_s = max(self._stale_s, _STEPS * step_s if shows_step else _UNKNOWN_S)
        return Sign(now_s - heard_s > allowed_s,
                    f'the {name} has been silent for more than {allowed_s:.3g} s')

    def _judge_offset(self, newest_ns: list[int], come: Sequence[int], passed_s: float) -> Sign:
        offset_s = (newest_ns[0] - newest_ns[1]) / 1e9
        last_ns, self._last_ns = self._last_ns, newest_ns
        n = [new - old for new, old in zip(self._received, self._counted)]
        self._counted = list(self._received)
        if last_ns is None:
            return Sign(None)
        gone_s = [(new - old) / 1e9 for new, old in zip(newest_ns, last_ns)]
        passed = max(gone_s)
        # A step shows in a single look.
        self._speeds.append(passed / passed_s)
        speed = max(1.0, median(self._speeds))
        bound_s = speed * (_LATE_S + sum(passed_s / n for n in come))
        usual_s = median(self._usual) if len(self._usual) >= _LEAST else None
        if usual_s is None:
            far = abs(offset_s) > max(self._apart_s, bound_s)
            size_s = offset_s
        else:
            size_s = offset_s - usual_s
            far = abs(size_s) > (0.5 * bound_s if self._stepped else bound_s)
            beyond_s = [gone - count * median(steps)
                        for gone, count, steps in zip(gone_s, n, self._steps)]
            self._moved_s += beyond_s[0] - beyond_s[1]
        self._odd = self._odd + 1 if far else 0
        if not far:
            self._usual.append(offset_s)
            for steps, gone, count in zip(self._steps, gone_s, n):
                steps.append(gone / max(count, 1))
            self._stepped, self._moved_s = False, 0.0
            return Sign(False)
        has_moved = usual_s is None or self._moved_s / size_s >= _MOVED
        self._stepped = self._stepped or (self._odd >= _TWICE and has_moved)
        if not self._stepped:
            return Sign(None)
        words = (f'the stamps of TS and RS lie {abs(offset_s):.1f} s apart' if usual_s is None else
                 f'the stamps of the TS stepped by {size_s:+.1f} s against those of the RS')
        return Sign(True, words, {'step_s': size_s, 'offset_s': offset_s})
