# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""
Pairing of TS with RS readings by stamp, every reading accounted for.

The pairs depend on the two streams alone: not on how they are cut into chunks, nor on which
stream runs ahead. Only a waiting limit on a live clock can change that, and it is counted.
"""

from __future__ import annotations

import numpy as np

from .angles import wrap180, wrap360
from .ledger import Ledger
from .records import Headings, Pairs
from .settings import Settings

__all__ = ['pair', 'Pairer', 'rising']

_NEVER = np.iinfo(np.int64).min


def rising(stamp_ns: np.ndarray, newest_ns: int | None = None) -> np.ndarray:
    """
    Tell which stamps are above all before them; the others are to be rejected.

    Parameters
    ----------
    stamp_ns : ndarray of int64, shape (n,)
        Stamps in the order in which they came, nanoseconds.
    newest_ns : int, optional
        Largest stamp accepted before.

    Returns
    -------
    ndarray of bool, shape (n,)

    Examples
    --------
    >>> rising(np.array([3, 3, 2, 4]), 1).tolist()
    [True, False, False, True]

    """
    before = np.concatenate(([_NEVER if newest_ns is None else newest_ns], stamp_ns[:-1]))
    return stamp_ns > np.maximum.accumulate(before)[:len(stamp_ns)]


class _Stream:
    """The accepted readings of one sensor that may still be needed, and when they came."""

    def __init__(self, name: str, shift_ns: int, ledger: Ledger) -> None:
        self.name = name
        self.shift_ns = shift_ns
        self.ledger = ledger
        self.last_ns = _NEVER
        self.stamp_ns = np.empty(0, np.int64)
        self.heading_deg = np.empty(0)
        self.came_s = np.empty(0)
        self.used = np.empty(0, bool)

    def take(self, headings: Headings, now_s: float) -> None:
        """Reject what cannot be used, keep the rest."""
        stamp = headings.stamp_ns
        heading = headings.heading_deg
        self.ledger.receive(self.name, stamp)
        good = self._reject('no_stamp', stamp > 0, stamp)
        good = self._reject('invalid', np.isfinite(heading), stamp, good)
        good = self._reject('out_of_range', (heading >= 0.0) & (heading <= 360.0), stamp, good)
        stamp, heading = stamp[good] - self.shift_ns, heading[good]
        if stamp.size:
            rises = rising(stamp, self.last_ns)
            if not rises.all():
                self.ledger.add(f'{self.name}_rejected.stamp_not_increasing', stamp[~rises])
                stamp, heading = stamp[rises], heading[rises]
        if stamp.size:
            self.last_ns = int(stamp[-1])
            self.stamp_ns = np.concatenate((self.stamp_ns, stamp))
            self.heading_deg = np.concatenate((self.heading_deg, wrap360(heading)))
            self.came_s = np.concatenate((self.came_s, np.full(stamp.shape, now_s)))
            self.used = np.concatenate((self.used, np.zeros(stamp.shape, bool)))

    def _reject(self, reason: str, passes: np.ndarray, stamp: np.ndarray,
                among: np.ndarray | None = None) -> np.ndarray:
        fails = ~passes if among is None else among & ~passes
        if fails.any():
            self.ledger.add(f'{self.name}_rejected.{reason}', stamp[fails] - self.shift_ns)
        return passes if among is None else among & passes

    def release(self, n: int) -> tuple[np.ndarray, np.ndarray]:
        """Drop the n oldest readings; return their stamps and whether they were used."""
        released = self.stamp_ns[:n], self.used[:n]
        self.stamp_ns = self.stamp_ns[n:]
        self.heading_deg = self.heading_deg[n:]
        self.came_s = self.came_s[n:]
        self.used = self.used[n:]
        return released


class Pairer:
    """
    Pair two streams of headings as they come.

    Parameters
    ----------
    settings : Settings
        `pairing`, `alignment.skew_s` (subtracted from the TS stamps) and `runs.gap_s` (where the
        ledger opens a segment) are used.

    Attributes
    ----------
    ledger : Ledger
        What became of every reading.

    Notes
    -----
    ``interpolate``: the RS heading is interpolated linearly on the circle between the two RS
    readings around the TS stamp, at most `pairing.max_gap_s` apart and never beyond the first
    or last one; a TS stamp that meets an RS stamp takes that reading whatever the gap.
    ``nearest``: a TS and an RS reading pair if each is the nearest to the other (ties go to the
    earlier one) and they are at most `pairing.tolerance_s` apart.

    A reading whose stamp does not increase within its stream is rejected, the first kept.

    """

    def __init__(self, settings: Settings) -> None:
        rule = settings.pairing
        self.ledger = Ledger()
        self._match = {'interpolate': self._interpolate, 'nearest': self._nearest}[rule.method]
        self._max_gap_ns = round(rule.max_gap_s * 1e9)
        self._tolerance_ns = round(rule.tolerance_s * 1e9)
        self._max_wait_s = rule.max_wait_s
        self._max_wait_ns = round(rule.max_wait_s * 1e9)
        self._run_gap_ns = round(settings.runs.gap_s * 1e9)
        self._ts = _Stream('ts', round(settings.alignment.skew_s * 1e9), self.ledger)
        self._rs = _Stream('rs', 0, self.ledger)
        self._last_settled_ns = _NEVER
        self._last_pair_ns: int | None = None

    def update(self, ts: Headings | None = None, rs: Headings | None = None,
               now_s: float | None = None) -> Pairs:
        """
        Take readings and return the pairs that they decide.

        Parameters
        ----------
        ts, rs : Headings, optional
            New readings, in the order in which they came; n >= 0 of each.
        now_s : float, optional
            A steady clock, seconds. With it a reading waits for its partner for
            `pairing.max_wait_s`, by this clock and by the stamps of what comes meanwhile, and is
            then counted as unpaired or unused. While nothing comes, as in a replay that is
            paused, it waits on. Without a clock, none is given up.

        Returns
        -------
        Pairs
            In stamp order, also across calls.

        """
        came_s = np.nan if now_s is None else now_s
        if ts is not None and len(ts):
            self._ts.take(ts, came_s)
        if rs is not None and len(rs):
            self._rs.take(rs, came_s)
        pairs = self._settle(*self._match(end=False))
        if now_s is not None:
            self._expire(now_s - self._max_wait_s)
        self._forget()
        return pairs

    def flush(self) -> Pairs:
        """End both streams: decide all that waits and return the last pairs."""
        pairs = self._settle(*self._match(end=True))
        self._release_rs(len(self._rs.stamp_ns))
        self._forget()
        return pairs

    def _interpolate(self, end: bool) -> tuple[int, np.ndarray, Pairs]:
        """Return how many TS readings are decided, which of them pair, and the pairs."""
        ts, rs = self._ts, self._rs
        n = len(rs.stamp_ns)
        if n == 0:
            return (len(ts.stamp_ns) if end else 0), np.empty(0, np.int64), Pairs.empty()
        ready = int(np.searchsorted(ts.stamp_ns, rs.stamp_ns[-1], side='right'))
        t = ts.stamp_ns[:ready]
        left = np.searchsorted(rs.stamp_ns, t, side='right') - 1
        right = np.minimum(left + 1, n - 1)
        gap = rs.stamp_ns[right] - rs.stamp_ns[left]
        node = rs.stamp_ns[left] == t
        which = np.flatnonzero((left >= 0) & (node | (gap <= self._max_gap_ns)))
        left, right, gap, node, t = left[which], right[which], gap[which], node[which], t[which]
        w = np.where(node, 0.0, (t - rs.stamp_ns[left]) / np.where(gap > 0, gap, 1))
        step = wrap180(rs.heading_deg[right] - rs.heading_deg[left])
        rs_deg = wrap360(rs.heading_deg[left] + w * step)
        rs.used[left] = True
        rs.used[right[~node]] = True
        pairs = Pairs(t, ts.heading_deg[which], rs_deg, np.zeros(t.shape, np.int64),
                      (1.0 - w) ** 2 + w ** 2)
        return (len(ts.stamp_ns) if end else ready), which, pairs

    def _nearest(self, end: bool) -> tuple[int, np.ndarray, Pairs]:
        """Return how many TS readings are decided, which of them pair, and the pairs."""
        ts, rs = self._ts, self._rs
        t, r = ts.stamp_ns, rs.stamp_ns
        if len(t) == 0 or len(r) == 0:
            return (len(t) if end else 0), np.empty(0, np.int64), Pairs.empty()
        partner, closed = _nearest_index(r, t)
        rivals = np.concatenate(([self._last_settled_ns], t)) \
            if self._last_settled_ns != _NEVER else t
        offset = len(rivals) - len(t)
        wanted, heard = _nearest_index(rivals, r[partner])
        decided = closed & heard
        ready = len(t) if end or decided.all() else int(np.argmin(decided))
        lag = r[partner] - t
        good = (wanted == np.arange(len(t)) + offset) & (np.abs(lag) <= self._tolerance_ns)
        which = np.flatnonzero(good[:ready])
        rs.used[partner[which]] = True
        pairs = Pairs.of(t[which], ts.heading_deg[which], rs.heading_deg[partner[which]],
                         lag[which])
        return ready, which, pairs

    def _settle(self, ready: int, which: np.ndarray, pairs: Pairs) -> Pairs:
        """Book the decided TS readings and cut the ledger where the pairs fall silent."""
        if ready == 0:
            return pairs
        stamps, _ = self._ts.release(ready)
        self._last_settled_ns = int(stamps[-1])
        unpaired = np.ones(ready, bool)
        unpaired[which] = False
        self.ledger.add('ts_unpaired', stamps[unpaired])
        if len(pairs):
            self.ledger.add('paired', pairs.stamp_ns)
            before = pairs.stamp_ns[0] if self._last_pair_ns is None else self._last_pair_ns
            silence = np.diff(pairs.stamp_ns, prepend=before)
            for at in np.flatnonzero(silence > self._run_gap_ns):
                self.ledger.cut(int(pairs.stamp_ns[at]))
            self._last_pair_ns = int(pairs.stamp_ns[-1])
        return pairs

    def _expire(self, before_s: float) -> None:
        """Give up readings that came before a time of the steady clock, and are old by stamp."""
        before_ns = max(self._ts.last_ns, self._rs.last_ns) - self._max_wait_ns
        late = int(np.count_nonzero((self._ts.came_s < before_s)
                                    & (self._ts.stamp_ns <= before_ns)))
        if late:
            stamps, _ = self._ts.release(late)
            self._last_settled_ns = int(stamps[-1])
            self.ledger.add('ts_unpaired', stamps)
        rs = self._rs
        late = np.flatnonzero((rs.came_s < before_s) & (rs.stamp_ns > self._ts.last_ns)
                              & (rs.stamp_ns <= before_ns))
        if late.size:
            # All up to the last one go: a bracket must never reach over a dropped reading.
            self._release_rs(int(late[-1]) + 1)

    def _forget(self) -> None:
        """Release the RS readings that no present or future TS reading can need."""
        ts, rs = self._ts, self._rs
        oldest = int(ts.stamp_ns[0]) if len(ts.stamp_ns) else ts.last_ns
        self._release_rs(int(np.searchsorted(rs.stamp_ns, oldest, side='right')) - 1)
        self.ledger.pending('ts', len(ts.stamp_ns))
        self.ledger.pending('rs', len(rs.stamp_ns))
        if self._last_settled_ns != _NEVER:
            self.ledger.settle(self._last_settled_ns)

    def _release_rs(self, n: int) -> None:
        if n > 0:
            stamps, used = self._rs.release(n)
            self.ledger.add('rs_used', stamps[used])
            self.ledger.add('rs_unused', stamps[~used])


def _nearest_index(among_ns: np.ndarray, of_ns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return which stamp is nearest (ties to the earlier), and whether none to come can be."""
    right = np.searchsorted(among_ns, of_ns, side='left')
    closed = right < len(among_ns)
    right = np.minimum(right, len(among_ns) - 1)
    left = np.maximum(right - 1, 0)
    nearer_right = np.abs(among_ns[right] - of_ns) < np.abs(of_ns - among_ns[left])
    return np.where(nearer_right, right, left), closed


def pair(ts: Headings, rs: Headings, settings: Settings | None = None) -> tuple[Pairs, Ledger]:
    """
    Pair two whole streams.

    Parameters
    ----------
    ts, rs : Headings
        All readings of the TS and of the RS, in the order in which they came.
    settings : Settings, optional
        As for `Pairer`.

    Returns
    -------
    pairs : Pairs
        In stamp order.
    ledger : Ledger
        What became of every reading.

    Examples
    --------
    >>> ts = Headings.of([10, 20, 40], [359.0, 1.0, 3.0])
    >>> rs = Headings.of([5, 25], [358.0, 2.0])
    >>> pairs, ledger = pair(ts, rs)
    >>> pairs.rs_deg.tolist(), ledger.total.counts['ts_unpaired']
    ([359.0, 1.0], 1)

    """
    pairer = Pairer(settings or Settings())
    pairs = pairer.update(ts, rs)
    return Pairs.concatenate((pairs, pairer.flush())), pairer.ledger
