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

"""What the sensors of a simulated trial showed, gathered for its figures in bounded memory."""

from __future__ import annotations

import numpy as np

from heading_intercompare.ahrs.sensors import Readings
from heading_intercompare.ahrs.ship.ship_motion import ShipTruth
from heading_intercompare.ahrs.simulator import SimulatedChunk
from heading_intercompare.core.angles import wrap180
from heading_intercompare.report.sketching.track import Trace

COLUMNS = 1200


class TrialTraces:
    """
    Gathers truth, readings, errors and modes of every sensor in columns of equal time.

    Parameters
    ----------
    ship
        The ship of the trial, which knows its heading at any instant.
    duration_s
        Length of the trial, seconds.

    """

    def __init__(self, ship: ShipTruth, duration_s: float) -> None:
        self._ship, self._duration_s = ship, duration_s
        self._gathered: dict[str, _Gathered] = {}

    def take(self, chunk: SimulatedChunk) -> None:
        """Take what was delivered in one span; call it with the spans in order."""
        for name, (readings, statuses) in chunk.sent.items():
            gathered = self._gathered.setdefault(name, _Gathered())
            gathered.take(readings, self._ship, self._duration_s)
            for status in statuses:
                mode = (status.mode if status.validity == 'VALID'
                        else f'{status.mode}, {status.validity.lower()}')
                if not gathered.modes or gathered.modes[-1][1] != mode:
                    gathered.modes.append((status.t_s / 3600.0, mode))

    def traces(self) -> tuple[Trace, ...]:
        """Return the traces so far, the TS and the RS first."""
        t_h = (np.arange(COLUMNS) + 0.5) * self._duration_s / COLUMNS / 3600.0
        return tuple(gathered.trace(name.upper() if name in ('ts', 'rs') else name, t_h)
                     for name, gathered in self._gathered.items())


class _Gathered:
    """The columns of one sensor; nan where nothing was delivered."""

    def __init__(self) -> None:
        self.n, self.modes = 0, list[tuple[float, str]]()
        self._rows = np.full((5, COLUMNS), np.nan)

    def take(self, readings: Readings, ship: ShipTruth, duration_s: float) -> None:
        """Take readings; those without a heading leave no trace."""
        self.n += len(readings)
        heading_deg = readings.headings.heading_deg
        valid = np.isfinite(heading_deg)
        t_s, heading_deg = readings.t_s[valid], heading_deg[valid]
        if not t_s.size:
            return
        true_deg = ship.heading_deg(t_s)
        error_deg = wrap180(heading_deg - true_deg)
        column = np.minimum((t_s / duration_s * COLUMNS).astype(np.int64), COLUMNS - 1)
        true, heading, low, high, sigma = self._rows
        true[column], heading[column] = true_deg, heading_deg
        np.fmin.at(low, column, error_deg)
        np.fmax.at(high, column, error_deg)
        np.fmax.at(sigma, column, readings.sigma_deg[valid])

    def trace(self, name: str, t_h: np.ndarray) -> Trace:
        """Return the trace of the sensor."""
        true, heading, low, high, sigma = self._rows.copy()
        return Trace(name=name, n=self.n, t_h=t_h, true_deg=true, heading_deg=heading, low_deg=low,
                     high_deg=high, sigma_deg=sigma, modes=tuple(self.modes))
