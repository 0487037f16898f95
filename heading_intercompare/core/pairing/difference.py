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

"""The difference of TS and RS, GK (1)."""

from __future__ import annotations

import numpy as np

from heading_intercompare.core.angles import wrap180
from heading_intercompare.core.records import Differences, Pairs


def subtract(pairs: Pairs, installation_offset_deg: float = 0.0,
             wrap_center_deg: float = 0.0) -> Differences:
    """
    Return the differences of the readings.

    Parameters
    ----------
    pairs
        Pairs of readings; n >= 0.
    installation_offset_deg
        Known angle TS - RS as mounted, degrees; removed.
    wrap_center_deg
        Differences are reduced to [c - 180, c + 180), degrees.

    Returns
    -------
    Differences
        x = TS - RS - offset, wrapped; nan where a reading is nan.

    References
    ----------
    GK (1).

    Examples
    --------
    >>> subtract(Pairs.of([1], [1.0], [359.5])).x_deg.tolist()
    [1.5]

    """
    x = np.subtract(pairs.ts_deg, pairs.rs_deg)
    if installation_offset_deg:
        x = x - installation_offset_deg
    return Differences(pairs.stamp_ns, wrap180(x, wrap_center_deg))
