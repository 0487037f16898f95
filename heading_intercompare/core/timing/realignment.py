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

__all__ = ['move_pairs', 'realign']

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
        Factor by which interpolation reduces the variance of white RS errors; 1 for m = 0.

    """
    if not stamp_ns.size:
        return stamp_ns, x_deg, 1.0
    kept, rs, earlier_rs, w = _read_earlier(stamp_ns, rs_deg, late_s)
    x = (x_deg + rs - earlier_rs)[kept]
    w = w[kept]
    return stamp_ns[kept], x, float(np.mean((1.0 - w) ** 2 + w ** 2)) if w.size else 1.0


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
    kept, rs, earlier_rs, _ = _read_earlier(stamp_ns, rs_deg, late_s)
    return stamp_ns[kept], (x_deg + rs - earlier_rs)[kept], earlier_rs[kept]


def _read_earlier(stamp_ns: np.ndarray, rs_deg: np.ndarray, late_s: float | np.ndarray,
                  ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return which pairs stay, the RS, the RS read earlier, and where between two readings."""
    t = (stamp_ns - stamp_ns[0]) / 1e9
    earlier = t - late_s
    steps = np.diff(t)
    place = np.interp(earlier, t, np.arange(t.size, dtype=np.float64))
    left = np.floor(place)
    w = place - left
    kept = (earlier >= t[0]) & (earlier <= t[-1])
    if steps.size:
        wide = np.append(steps > _FEW_STEPS * np.median(steps), False)
        kept &= ~wide[left.astype(np.intp)] | (w == 0.0)
    rs = unwrap_deg(rs_deg)
    return kept, rs, np.interp(earlier, t, rs), w
