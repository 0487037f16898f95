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

"""The differences by heading: a row for each sector of 45 degrees, centred on N, NE, E..."""

from __future__ import annotations

from heading_intercompare.core.diagnostics.by_motion import BySector
from heading_intercompare.report.formatting import ABSENT, bounds, number, rounded

from .tables import Table

_NAMES = ('N', 'NE', 'E', 'SE', 'S', 'SW', 'W', 'NW')
_HALF_DEG = 180.0 / len(_NAMES)
_HEAD = ('heading of the RS [deg]', 'differences', 'time [s]', 'mean TS - RS [deg]',
         '95 % interval [deg]', 'standard deviation [deg]')


def tabulate_sectors(sectors: BySector) -> Table:
    """Return the table of a run."""
    rows = [[f'{name}: {(middle - _HALF_DEG) % 360.0:g} to {middle + _HALF_DEG:g}', str(n),
             number(duration_s), ABSENT if mean is None else rounded(
                 mean, None if low is None else mean - low), bounds(low, up),
             ABSENT if std is None else rounded(std, 0.1 * std)]
            for name, middle, n, duration_s, mean, std, low, up in zip(
                _NAMES, sectors.heading_deg, sectors.n, sectors.duration_s, sectors.mean_deg,
                sectors.std_deg, sectors.low_deg, sectors.up_deg)]
    return Table(_HEAD, rows)
