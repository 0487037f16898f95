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

"""Two pairs a second out of many: enough to compare sensors whose errors last longer."""

from __future__ import annotations

import numpy as np

from heading_intercompare.core.records import Pairs

STEP_S = 0.5
"""Time in which one pair is kept, seconds."""

_STEP_NS = round(STEP_S * 1e9)


class PairSampler:
    """
    Keep one pair of each half second.

    Notes
    -----
    It keeps the pair that interpolation changed least, the first of several. The choice depends on
    stamps alone, so the variance of the differences stays what it is, and it does not depend on
    how the pairs are cut into chunks. Sensors of up to 2 Hz keep every pair.

    """

    def __init__(self) -> None:
        self._open = Pairs.empty()

    def update(self, pairs: Pairs, end: bool = False) -> Pairs:
        """
        Take pairs in stamp order; return those kept of the half seconds that are over.

        At the `end` the last half second is over, too.
        """
        *ended, pairs = (self._open + pairs).in_segments() or [Pairs.empty()]
        return Pairs.concatenate([*map(_choose, ended), self._keep_open(pairs, end)])

    def _keep_open(self, pairs: Pairs, end: bool) -> Pairs:
        """Return the pairs kept of a segment but for its last half second, unless at the `end`."""
        if end or not len(pairs):
            self._open = Pairs.empty()
            return _choose(pairs)
        last = int(np.searchsorted(pairs.stamp_ns // _STEP_NS, pairs.stamp_ns[-1] // _STEP_NS))
        self._open = pairs[last:]
        return _choose(pairs[:last])


def _choose(pairs: Pairs) -> Pairs:
    """Return the pair of each half second that interpolation changed least."""
    if not len(pairs):
        return pairs
    step = pairs.stamp_ns // _STEP_NS
    factor = np.minimum(pairs.rs_variance_factor, pairs.ts_variance_factor)
    starts = np.flatnonzero(np.diff(step, prepend=step[0] - 1))
    if len(starts) == len(step):
        return pairs
    best = np.maximum.reduceat(factor, starts)
    hits = np.flatnonzero(factor == np.repeat(best, np.diff(starts, append=len(step))))
    # The first hit of each half second.
    return pairs[hits[np.diff(step[hits], prepend=step[0] - 1) > 0]]
