# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""
Pairing of TS with RS readings by stamp, every reading accounted for.

The pairs depend on the two streams alone: not on how they are cut into chunks, nor on which
stream runs ahead. Only a waiting limit on a live clock can change that, and it is counted.
"""

from __future__ import annotations

import numpy as np

from heading_intercompare.core.angles import wrap180, wrap360
from heading_intercompare.core.records import Headings, Pairs
from heading_intercompare.core.settings import Settings

from .direction import Direction
from .ledger import Ledger, LedgerKey
from .pending_readings import BRACKET, NEVER, PAIRED, Stream

__all__ = ['pair', 'Pairer']


class Pairer:
    """
    Pair two streams of headings as they come.

    Parameters
    ----------
    settings : Settings
        `pairing`, `alignment.skew_s` (subtracted from the TS stamps) and `runs.gap_s` (where the
        ledger opens a segment, and 'auto' chooses again) are used.

    Attributes
    ----------
    ledger : Ledger
        What became of every reading.

    Notes
    -----
    ``interpolate``: the RS heading is interpolated linearly on the circle between the two RS
    readings around the TS stamp, at most `pairing.max_gap_s` apart and never beyond the first
    or last one; a TS stamp that meets an RS stamp takes that reading whatever the gap.
    ``interpolate_ts``: the same with TS and RS exchanged, so the pairs have the stamps of the RS.
    ``auto``: one of these for each stretch of the streams, see `direction.Direction`; until it
    is chosen the readings wait, and count as pending.
    ``nearest``: a TS and an RS reading pair if each is the nearest to the other (ties go to the
    earlier one) and they are at most `pairing.tolerance_s` apart.

    A reading whose stamp does not increase within its stream is rejected, the first kept.

    """

    def __init__(self, settings: Settings) -> None:
        rule = settings.pairing
        self.ledger = Ledger()
        self._method = rule.method
        self._max_gap_ns = round(rule.max_gap_s * 1e9)
        self._tolerance_ns = round(rule.tolerance_s * 1e9)
        self._max_wait_s = rule.max_wait_s
        self._max_wait_ns = round(rule.max_wait_s * 1e9)
        self._run_gap_ns = round(settings.runs.gap_s * 1e9)
        self._ts = Stream('ts', round(settings.alignment.skew_s * 1e9), self.ledger)
        self._rs = Stream('rs', 0, self.ledger)
        self._direction = Direction(rule, self._run_gap_ns) if rule.method == 'auto' else None
        self._at, self._of = self._ts, self._rs
        if rule.method == 'interpolate_ts':
            self._at, self._of = self._rs, self._ts
        self._last_settled_ns = NEVER
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
        for stream, headings in ((self._ts, ts), (self._rs, rs)):
            if headings is not None and len(headings):
                stamp_ns = stream.take(headings, came_s)
                if self._direction and len(stamp_ns):
                    self._direction.note(stream.name, stamp_ns)
        pairs = self._pair(end=False)
        if now_s is not None:
            self._expire(now_s - self._max_wait_s)
        self._forget()
        return pairs

    def flush(self) -> Pairs:
        """End both streams: decide all that waits and return the last pairs."""
        pairs = self._pair(end=True)
        for stream in (self._ts, self._rs):
            stream.release(len(stream))
        if self._last_pair_ns is not None:
            self.ledger.cut(self._last_pair_ns + 1)
        self._forget()
        return pairs

    def _pair(self, end: bool) -> Pairs:
        """Return the pairs that are decided, one stretch after the other."""
        if self._method == 'nearest':
            return self._settle(*self._nearest(end))
        found = []
        while self._chosen(end):
            found.append(self._settle(*self._interpolate(end)))
            direction = self._direction
            limit_ns = direction.limit_ns if direction else None
            if direction is None or limit_ns is None or not (end or direction.heard(limit_ns)):
                break
            direction.leave()
        return Pairs.concatenate(found)

    def _chosen(self, end: bool) -> bool:
        """Tell whether it is known which sensor is interpolated; choose it if it can be."""
        choice = self._direction
        if choice is None or choice.interpolates_ts is not None:
            return True
        if not choice.choose(end):
            return False
        at, of = (self._rs, self._ts) if choice.interpolates_ts else (self._ts, self._rs)
        if at is not self._at:
            self._at, self._of = at, of
            if self._last_settled_ns != NEVER and choice.start_ns is not None:
                # Both sensors give up what they had before: no bracket reaches over the change.
                for stream in (at, of):
                    stream.release(int(np.searchsorted(stream.stamp_ns, choice.start_ns)))
        return True

    def _interpolate(self, end: bool) -> tuple[int, np.ndarray, Pairs]:
        """Return how many readings are decided, which of them pair, and the pairs."""
        at, of = self._at, self._of
        ready, n = len(at), len(of)
        if self._direction and self._direction.limit_ns is not None:
            ready = int(np.searchsorted(at.stamp_ns, self._direction.limit_ns))
        if not end:
            ready = min(ready, int(np.searchsorted(at.stamp_ns, of.last_ns, side='right')))
        if ready == 0 or n == 0:
            return ready, np.empty(0, np.int64), Pairs.empty()
        t = at.stamp_ns[:ready]
        left = np.searchsorted(of.stamp_ns, t, side='right') - 1
        right = np.minimum(left + 1, n - 1)
        gap = of.stamp_ns[right] - of.stamp_ns[left]
        node = of.stamp_ns[left] == t
        bridged = (right > left) & (gap <= self._max_gap_ns) & ~of.broken[right]
        which = np.flatnonzero((left >= 0) & (node | bridged))
        left, right, gap, node, t = left[which], right[which], gap[which], node[which], t[which]
        w = np.where(node, 0.0, (t - of.stamp_ns[left]) / np.where(gap > 0, gap, 1))
        step = wrap180(of.heading_deg[right] - of.heading_deg[left])
        of_deg = wrap360(of.heading_deg[left] + w * step)
        for ends in (left[~node], right[~node]):
            of.role[ends] = np.maximum(of.role[ends], BRACKET)
        of.role[left[node]] = PAIRED
        at_deg, lag_ns = at.heading_deg[which], np.zeros(t.shape, np.int64)
        factor, one = (1.0 - w) ** 2 + w ** 2, np.ones(t.shape)
        if at is self._ts:
            return ready, which, Pairs(t, at_deg, of_deg, lag_ns, factor, one)
        return ready, which, Pairs(t, of_deg, at_deg, lag_ns, one, factor)

    def _nearest(self, end: bool) -> tuple[int, np.ndarray, Pairs]:
        """Return how many TS readings are decided, which of them pair, and the pairs."""
        ts, rs = self._ts, self._rs
        t, r = ts.stamp_ns, rs.stamp_ns
        if len(t) == 0 or len(r) == 0:
            return (len(t) if end else 0), np.empty(0, np.int64), Pairs.empty()
        partner, closed = _nearest_index(r, t)
        rivals = np.concatenate(([self._last_settled_ns], t)) \
            if self._last_settled_ns != NEVER else t
        offset = len(rivals) - len(t)
        wanted, heard = _nearest_index(rivals, r[partner])
        decided = closed & heard
        ready = len(t) if end or decided.all() else int(np.argmin(decided))
        lag = r[partner] - t
        good = (wanted == np.arange(len(t)) + offset) & (np.abs(lag) <= self._tolerance_ns)
        which = np.flatnonzero(good[:ready])
        rs.role[partner[which]] = PAIRED
        pairs = Pairs.of(t[which], ts.heading_deg[which], rs.heading_deg[partner[which]],
                         lag[which])
        return ready, which, pairs

    def _settle(self, ready: int, which: np.ndarray, pairs: Pairs) -> Pairs:
        """Book the decided readings; cut the ledger where the pairs begin and fall silent."""
        if ready == 0:
            return pairs
        self._at.role[which] = PAIRED
        self._last_settled_ns = int(self._at.release(ready)[-1])
        if len(pairs):
            self.ledger.add(LedgerKey.PAIRED, pairs.stamp_ns)
            first = int(pairs.stamp_ns[0])
            if self._last_pair_ns is None:
                self.ledger.cut(first)
                self._last_pair_ns = first
            before = np.concatenate(([self._last_pair_ns], pairs.stamp_ns[:-1]))
            for at in np.flatnonzero(pairs.stamp_ns - before > self._run_gap_ns):
                self.ledger.cut(int(before[at]) + 1)
                self.ledger.cut(int(pairs.stamp_ns[at]))
            self._last_pair_ns = int(pairs.stamp_ns[-1])
        return pairs

    def _expire(self, before_s: float) -> None:
        """Give up readings that came before a time of the steady clock, and are old by stamp."""
        before_ns = max(self._ts.last_ns, self._rs.last_ns) - self._max_wait_ns
        is_open = self._direction is not None and self._direction.interpolates_ts is None
        for stream, other in ((self._ts, self._rs), (self._rs, self._ts)):
            late = (stream.came_s < before_s) & (stream.stamp_ns <= before_ns)
            if self._method != 'nearest' or stream is self._rs:
                # What the other sensor has come up to waits for nothing but a choice, and with it
                # the reading that ends the last bracket.
                come = int(np.searchsorted(stream.stamp_ns, other.last_ns, side='right'))
                late[:come + 1 if is_open and come else come] = False
            given_up = np.flatnonzero(late)
            if given_up.size:
                if self._direction:
                    self._direction.forget()
                first = int(given_up[0]) == 0
                stamps = stream.give_up(given_up)
                if stream is self._at and first:
                    self._last_settled_ns = int(stamps[-1])

    def _forget(self) -> None:
        """Release the readings that can only be brackets, and of none that may still come."""
        at, of = self._at, self._of
        if self._direction is None or self._direction.interpolates_ts is not None:
            oldest = int(at.stamp_ns[0]) if len(at) else at.last_ns
            limit_ns = self._direction.limit_ns if self._direction else None
            if limit_ns is not None:
                oldest = min(oldest, limit_ns)
            of.release(max(0, int(np.searchsorted(of.stamp_ns, oldest, side='right')) - 1))
        self.ledger.pending('ts', len(self._ts))
        self.ledger.pending('rs', len(self._rs))
        if self._last_settled_ns != NEVER:
            # What was given up behind the last pair belongs to no run: cut before it is folded.
            if (self._last_pair_ns is not None
                    and self._last_settled_ns - self._last_pair_ns > self._run_gap_ns):
                self.ledger.cut(self._last_pair_ns + 1)
            self.ledger.settle(self._last_settled_ns)


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
