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

"""The order in which two streams came, where the stamps of a long chunk go back."""

from __future__ import annotations

from collections import deque
from typing import Iterator, Sequence

import numpy as np

from heading_intercompare.core.records import Headings, Integers

# Far from a step a part is a minute, as a chunk of a bag; around a step it is a second.
_COARSE_NS, _FINE_NS, _AROUND_NS = 60 * 10 ** 9, 10 ** 9, 15 * 10 ** 9
# A clock that is wrong for longer is followed by the minute.
_MOST_FINE_NS = 600 * 10 ** 9
#: Steps that a later one may take back.
_MOST_WAITING = 16
#: Stamps at random must not add up beyond 64 bits.
_LONGEST_NS = 3600 * 10 ** 9


def find_elapsed(stamp_ns: Integers, jump_ns: int) -> tuple[Integers, list[tuple[int, int]]]:
    """
    Return the time that has passed at each reading, without the steps of the clock.

    Parameters
    ----------
    stamp_ns : ndarray of int64, shape (n,)
        Stamps in order of arrival, n >= 1.
    jump_ns
        A longer step is one of the clock if it goes back, or if another one takes it back;
        otherwise it is a silence.

    Returns
    -------
    elapsed_ns : ndarray of int64, shape (n,)
        Since the first reading; never decreases. A silence counts as an hour at most.
    spans : list of (int, int)
        Where the clock was wrong: the indices of the first reading after a step and after the one
        that takes it back, equal for a step back that nothing undoes.

    Examples
    --------
    >>> elapsed_ns, spans = find_elapsed(np.array([0, 1, 102, 103, 4, 5]), 10)
    >>> elapsed_ns.tolist(), spans
    ([0, 1, 1, 2, 2, 3], [(2, 4)])

    """
    steps = np.diff(stamp_ns)
    of_clock = steps < -jump_ns
    undone_by: dict[int, int] = {}
    spans = []
    waiting: deque[int] = deque(maxlen=_MOST_WAITING)
    for at in np.flatnonzero(np.abs(steps) > jump_ns).tolist():
        undone = next((before for before in reversed(waiting)
                       if abs(steps[before] + steps[at]) <= jump_ns), None)
        if undone is None:
            waiting.append(at)
        else:
            waiting.remove(undone)
            undone_by |= {undone: at, at: at}
            spans.append((undone + 1, at + 1))
    spans += [(at + 1, at + 1) for at in np.flatnonzero(of_clock).tolist() if at not in undone_by]
    of_clock[[*undone_by]] = True
    steps[of_clock] = 0
    elapsed: Integers = np.concatenate(([0], np.cumsum(np.clip(steps, 0, _LONGEST_NS))))
    return elapsed, spans


def divide_by_arrival(ts: Headings, rs: Headings, jump_ns: int, *,
                      together: bool) -> Iterator[tuple[Headings, Headings]]:
    """
    Yield the parts of two chunks in the order in which they came, as their stamps show it.

    Parameters
    ----------
    ts, rs
        Chunks in order of arrival.
    jump_ns
        As for `find_elapsed`.
    together
        Both chunks begin at the same time, as those of a stretch of a recording.

    """
    if not (len(ts) and len(rs)):
        yield ts, rs
        return
    (elapsed_ts, spans_ts), (elapsed_rs, spans_rs) = (
        find_elapsed(headings.stamp_ns, jump_ns) for headings in (ts, rs))
    apart_ns = 0 if together else int(rs.stamp_ns[0]) - int(ts.stamp_ns[0])
    if apart_ns > 0:
        elapsed_rs = elapsed_rs + apart_ns
    else:
        elapsed_ts = elapsed_ts - apart_ns
    # A clock may have been set back between this chunk and the one before.
    windows = [(0, _AROUND_NS)]
    for elapsed, spans in ((elapsed_ts, spans_ts), (elapsed_rs, spans_rs)):
        for first, last in spans:
            stop_ns = int(elapsed[last]) + _AROUND_NS
            windows.append((max(int(elapsed[first]) - _AROUND_NS, stop_ns - _MOST_FINE_NS),
                            stop_ns))
    bounds = _list_bounds(np.concatenate((elapsed_ts, elapsed_rs)), windows)
    at_ts, at_rs = (np.searchsorted(elapsed, bounds).tolist()
                    for elapsed in (elapsed_ts, elapsed_rs))
    for lo_ts, hi_ts, lo_rs, hi_rs in zip(at_ts, at_ts[1:], at_rs, at_rs[1:]):
        yield ts[lo_ts:hi_ts], rs[lo_rs:hi_rs]


def _list_bounds(elapsed_ns: Integers, windows: Sequence[tuple[int, int]]) -> Integers:
    """Return where parts that hold readings end: by the second in a window, or by the minute."""
    starts, stops = (np.sort(np.array(ends)) for ends in zip(*windows))
    is_fine = (np.searchsorted(starts, elapsed_ns, 'right')
               > np.searchsorted(stops, elapsed_ns, 'left'))
    size_ns = np.where(is_fine, _FINE_NS, _COARSE_NS)
    ends: Integers = np.unique(elapsed_ns // size_ns * size_ns + size_ns)
    return np.append(-1, ends)
