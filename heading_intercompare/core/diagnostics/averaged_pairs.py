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

"""The pairs of a run as averages over a fraction of a second, for what is slower than that."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from heading_intercompare.core.angles import wrap180
from heading_intercompare.core.records import Reals
from heading_intercompare.core.timing.skew_instrument import Tracks


@dataclass(frozen=True, slots=True, eq=False)
class AveragedPairs:
    """
    Averages of consecutive pairs.

    Attributes
    ----------
    size
        Pairs in an average.
    t_s : ndarray, shape (n,)
        Mean times after the first pair, seconds.
    x_deg, rs_deg : ndarray, shape (n,)
        Mean differences, and unwrapped mean headings of the RS, degrees.
    within_deg2
        Mean square of the differences about their averages, square degrees.

    """

    size: int
    t_s: Reals
    x_deg: Reals
    rs_deg: Reals
    within_deg2: float

    @classmethod
    def of(cls, tracks: Tracks, n: int, m2_deg2: float, center_deg: float) -> 'AveragedPairs':
        """Build from the tracks of `n` pairs, whose differences have this sum of squares."""
        # The tracks of a TS that turns against the RS move apart without end.
        x = wrap180(tracks.ts.heading_deg - tracks.rs.heading_deg - center_deg) + center_deg
        return cls(n // len(tracks.rs), tracks.rs.t_s, x, tracks.rs.heading_deg,
                   max(0.0, m2_deg2 / n - float(np.var(x))))
