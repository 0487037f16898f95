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

"""The pairs of a run with its time skew removed, by reading the RS earlier."""

from __future__ import annotations

import numpy as np

from heading_intercompare.core.angles import unwrap_deg
from heading_intercompare.core.pairing.direction import usual_step_ns
from heading_intercompare.core.pairing.interpolation_kernel import interpolate, longest_step_ns

_FEW_STEPS = 5.0


def realign(stamp_ns: np.ndarray, x_deg: np.ndarray, rs_deg: np.ndarray,
            late_s: float | np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
    """
    Return the differences that the pairs would have if the TS were not late.

    Parameters
    ----------
    stamp_ns : ndarray of int64, shape (n,)
        Stamps of the pairs in increasing order, nanoseconds.
    x_deg, rs_deg : ndarray, shape (n,)
        Differences and RS headings, finite, degrees.
    late_s : float or ndarray, shape (n,)
        Lateness of the TS, seconds: the RS is read this much earlier. May change with time.

    Returns
    -------
    stamp_ns, x_deg : ndarray, shape (m,)
        Stamps and differences, m <= n. Left out are pairs whose earlier time lies before the
        first pair, after the last, or between two pairs more than five typical steps apart.
    factor : float
        Factor by which interpolation changes the variance of white RS errors; 1 for m = 0.

    """
    if not stamp_ns.size:
        return stamp_ns, x_deg, 1.0
    stays, rs, earlier_rs, factor = _read_earlier(stamp_ns, rs_deg, late_s)
    x = (x_deg + rs - earlier_rs)[stays]
    return stamp_ns[stays], x, float(np.mean(factor[stays])) if x.size else 1.0


def move_pairs(stamp_ns: np.ndarray, x_deg: np.ndarray, rs_deg: np.ndarray,
               late_s: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """
    Return the pairs that there would be if the TS were not late.

    Parameters
    ----------
    stamp_ns, x_deg, rs_deg, late_s
        As for `realign`.

    Returns
    -------
    stamp_ns, x_deg, rs_deg : ndarray, shape (m,)
        Stamps, differences and headings of the RS, m <= n, as `realign` selects them. The
        headings of the RS are unwrapped, degrees.

    """
    if not stamp_ns.size:
        return stamp_ns, x_deg, rs_deg
    stays, rs, earlier_rs, _ = _read_earlier(stamp_ns, rs_deg, late_s)
    return stamp_ns[stays], (x_deg + rs - earlier_rs)[stays], earlier_rs[stays]


def _read_earlier(stamp_ns: np.ndarray, rs_deg: np.ndarray, late_s: float | np.ndarray,
                  ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return which pairs stay, the RS, the RS read earlier, and the factors of its noise."""
    earlier_ns = stamp_ns - np.round(1e9 * np.asarray(late_s)).astype(np.int64)
    rs = unwrap_deg(rs_deg)
    t, earlier = ((ns - stamp_ns[0]) / 1e9 for ns in (stamp_ns, earlier_ns))
    left = np.clip(np.searchsorted(stamp_ns, earlier_ns, side='right') - 1, 0, t.size - 1)
    right = np.minimum(left + 1, t.size - 1)
    is_between = (stamp_ns[left] < earlier_ns) & (earlier_ns < stamp_ns[right])
    stays = is_between | (stamp_ns[left] == earlier_ns)
    steps_ns = np.diff(stamp_ns)
    if steps_ns.size:
        wide = steps_ns > _FEW_STEPS * np.median(steps_ns)
        stays &= ~is_between | ~np.append(wide, False)[left]
    value = np.interp(earlier, t, rs)
    factor = np.ones(t.shape)
    at = np.flatnonzero(stays & is_between)
    if at.size:
        w = (earlier[at] - t[left[at]]) / (t[right[at]] - t[left[at]])
        factor[at] = (1.0 - w) ** 2 + w ** 2
        step_ns = usual_step_ns(stamp_ns) or 0
        interpolated = interpolate(stamp_ns, rs, steps_ns <= longest_step_ns(step_ns), left[at],
                                   earlier_ns[at], step_ns)
        # Where readings are missing, the line is better than nothing.
        good = interpolated.side > 0
        value[at[good]] = interpolated.heading_deg[good]
        factor[at[good]] = interpolated.factor[good]
    return stays, rs, value, factor
