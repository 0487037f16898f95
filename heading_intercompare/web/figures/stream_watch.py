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

"""One sensor as it reports: its newest heading, age, rate, stamp offset and rate of turn."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np

from heading_intercompare.core.angles import wrap180
from heading_intercompare.core.records import Headings

#: Rates are those of the last seconds; a rate of turn needs a shorter time.
_RATE_S, _TURN_S = 10.0, 4.0
#: A sensor that has missed this number of readings is silent, however slow it is.
_MISSED = 3.0


@dataclass(frozen=True, slots=True)
class SensorView:
    """
    One sensor at a moment.

    Attributes
    ----------
    heading_deg
        Newest valid heading, degrees; None if there is none or the sensor is silent.
    last_deg
        The last valid heading, however old, degrees.
    age_s
        Time since the last reading came, seconds; None before the first.
    rate_hz
        Readings per second lately; None before the second reading.
    offset_s
        Stamp of the last reading minus the time of day at its receipt, seconds.
    turn_deg_min
        Rate of turn, degrees per minute, positive to starboard; None if not known now.
    stale
        The sensor is silent: nothing of this is the state of the ship.
    flagged
        The sensor flags its newest reading as invalid.

    """

    heading_deg: float | None = None
    last_deg: float | None = None
    age_s: float | None = None
    rate_hz: float | None = None
    offset_s: float | None = None
    turn_deg_min: float | None = None
    stale: bool = True
    flagged: bool = False


class StreamWatch:
    """
    Watches the readings of one sensor; memory is bounded.

    Parameters
    ----------
    stale_s
        Silence after which the sensor is called silent, seconds; longer for a slow sensor.

    """

    def __init__(self, stale_s: float) -> None:
        self._stale_s = stale_s
        self._arrivals: deque[tuple[float, int]] = deque(maxlen=2000)
        self._turn: deque[tuple[int, float]] = deque(maxlen=500)
        self._came_s: float | None = None
        self._last_deg: float | None = None
        self._offset_s: float | None = None
        self._flagged = False

    def allow(self, stale_s: float) -> None:
        """Change how long silence is allowed, seconds."""
        self._stale_s = stale_s

    def take(self, headings: Headings, received_ns: int, now_s: float) -> None:
        """
        Take readings.

        Parameters
        ----------
        headings
            n readings in order of arrival; n = 0 changes nothing.
        received_ns
            Time of day at which the last one came, UTC nanoseconds.
        now_s
            The same on a steady clock, seconds.

        """
        if not len(headings):
            return
        self._arrivals.append((now_s, len(headings)))
        self._came_s = now_s
        self._offset_s = (int(headings.stamp_ns[-1]) - received_ns) / 1e9
        valid = np.flatnonzero(np.isfinite(headings.heading_deg))
        self._flagged = not (len(valid) and valid[-1] == len(headings) - 1)
        if not len(valid):
            return
        at = int(valid[-1])
        stamp_ns, self._last_deg = int(headings.stamp_ns[at]), float(headings.heading_deg[at])
        if self._turn and stamp_ns <= self._turn[-1][0]:
            self._turn.clear()
        # A few readings per second say as much about a turn as all of them.
        if not self._turn or stamp_ns - self._turn[-1][0] >= 50_000_000:
            self._turn.append((stamp_ns, self._last_deg))
        while stamp_ns - self._turn[0][0] > _TURN_S * 1e9 and len(self._turn) > 2:
            self._turn.popleft()

    def view(self, now_s: float) -> SensorView:
        """Return the sensor at a time of the steady clock, seconds."""
        if self._came_s is None:
            return SensorView()
        while self._arrivals[0][0] < now_s - _RATE_S and len(self._arrivals) > 2:
            self._arrivals.popleft()
        age_s, rate_hz = now_s - self._came_s, self._rate_hz()
        late_s = 0.0 if rate_hz is None else _MISSED / rate_hz
        stale = age_s > max(self._stale_s, late_s)
        usable = not (stale or self._flagged)
        return SensorView(
            heading_deg=self._last_deg if usable else None, last_deg=self._last_deg, age_s=age_s,
            rate_hz=None if stale else rate_hz, offset_s=self._offset_s,
            turn_deg_min=self._turn_deg_min() if usable else None, stale=stale,
            flagged=self._flagged)

    def _rate_hz(self) -> float | None:
        """Return the rate between the first and the last arrival; the first one only starts it."""
        span_s = self._arrivals[-1][0] - self._arrivals[0][0]
        n = sum(count for _, count in self._arrivals) - self._arrivals[0][1]
        return n / span_s if span_s > 0.0 else None

    def _turn_deg_min(self) -> float | None:
        """Return the slope of the headings of the last seconds."""
        if len(self._turn) < 2:
            return None
        (first_ns, first_deg), (last_ns, last_deg) = self._turn[0], self._turn[-1]
        return 60.0 * float(wrap180(last_deg - first_deg)) / ((last_ns - first_ns) / 1e9)
