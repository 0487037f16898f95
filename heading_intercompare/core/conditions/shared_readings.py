#!/usr/bin/env python3
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
"""
Whether two runs, or two parts of one, hold the same readings, under whatever dates.

Two recorders of one trial, a record under another date and a block that was pasted show the same
errors twice. Their stamps, their last digits and an offset may differ.
"""

from __future__ import annotations

from base64 import b85decode, b85encode
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from typing import Callable, NamedTuple
import zlib

import numpy as np

from heading_intercompare.core import lazy_scipy as scipy
from heading_intercompare.core.angles import unwrap_pieces
from heading_intercompare.core.records import Integers, Reals

#: Differences are averaged over four grains of half a second, or of a multiple by a power of two.
_GRAIN_S, _GRAINS = 0.5, 4
_MOST_GRAINS = 1 << 14
#: A bin holds at least two of the usual steps of the pairs.
_STEPS = 2.0
#: What this number of averages before tells is removed; the rest is compared in blocks.
_ORDER, _BLOCK = 16, 64
#: Blocks of a run that are sought in another one, evenly spread over it.
_MOST_BLOCKS = 48
#: Most bins in which they are sought at once.
_AT_ONCE = 8192
#: Pairs whose steps are computed at once.
_PIECE = 1 << 15
#: Shared readings: a block whose correlation is this, or some together at one lag.
_ALIKE, _TOGETHER, _SOME = 0.75, 0.45, 4
#: Whitened averages in memory, at most 32 kB each: a campaign compares each run with all others.
_MOST_WHITENED = 4096
#: A block belongs to them if it correlates nearly as well as the best one.
_MOSTLY = 0.85
#: Larger rests count as this multiple of their 0.9 quantile, 2.5 standard deviations.
_MOST_OF_ONE = 1.5
#: Readings of a block that are there, and the share of the variance that is no pattern.
_THERE, _LEAST_REST = 0.75, 1e-4


_KINDS = ('<f4', '<f4', '<u4')


def _short(column: np.ndarray) -> Reals:
    """Return a column in the precision in which it is kept."""
    return np.asarray(column.astype(np.float32), np.float64)


@dataclass(frozen=True, slots=True, eq=False)
class Fingerprint:
    """
    The differences of a run, averaged over short times.

    Attributes
    ----------
    start_ns
        Stamp of the first difference, nanoseconds.
    grain_s
        Length of a grain, seconds.
    least_bin_s
        Shortest bin that holds two of the usual steps, seconds.
    total_deg : ndarray of float64, shape (n,)
        Sum of the differences of each grain.
    count : ndarray of int64, shape (n,)
        Number of the differences of each grain.
    rs_deg : ndarray of float64, shape (n,)
        Heading of the RS, unwrapped, averaged over each grain; interpolated where there is none.

    """

    start_ns: int
    grain_s: float
    least_bin_s: float
    total_deg: Reals
    count: Integers
    rs_deg: Reals

    @classmethod
    def of(cls, stamp_ns: Integers, x_deg: Reals, rs_deg: Reals) -> 'Fingerprint | None':
        """Return the fingerprint of a run by its differences and the RS; None if too short."""
        if len(stamp_ns) < 2 * _BLOCK:
            return None
        # In pieces and in place: a run of days has many pairs.
        steps_s = np.empty(len(stamp_ns) - 1)
        for lo in range(0, len(steps_s), _PIECE):
            since_s = (stamp_ns[lo:lo + _PIECE + 1] - stamp_ns[0]) / 1e9
            steps_s[lo:lo + _PIECE] = since_s[1:] - since_s[:-1]
        step_s = float(np.quantile(steps_s, 0.6, overwrite_input=True))
        del steps_s
        grain_s, span_s = _GRAIN_S, int(stamp_ns[-1] - stamp_ns[0]) / 1e9
        while span_s / grain_s >= _MOST_GRAINS:
            grain_s *= 2.0
        n = int(span_s / grain_s) + 1
        count, total_deg, turned_deg = np.zeros(n, np.int64), np.zeros(n), np.zeros(n)
        usual_deg, lo = float(np.median(x_deg)), 0
        for unwrapped in unwrap_pieces(rs_deg):
            piece = slice(lo, lo + unwrapped.size)
            at = ((stamp_ns[piece] - stamp_ns[0]) / 1e9 / grain_s).astype(np.int64)
            # In the order of the pairs, so that no sum depends on the pieces.
            np.add.at(count, at, 1)
            np.add.at(total_deg, at, x_deg[piece] - usual_deg)
            np.add.at(turned_deg, at, unwrapped)
            lo = piece.stop
        occupied = np.flatnonzero(count)
        around = np.interp(np.arange(n), occupied, turned_deg[occupied] / count[occupied])
        # As it is kept, so that a restart changes nothing.
        return cls(int(stamp_ns[0]), grain_s, _STEPS * step_s, _short(total_deg), count,
                   _short(around))

    def to_text(self) -> str:
        """Return the fingerprint as text; `from_text` gives the same to the bit."""
        columns = b''.join(column.astype(kind).tobytes() for column, kind in zip(
            (self.total_deg, self.rs_deg, self.count), _KINDS))
        text = b85encode(zlib.compress(columns)).decode()
        return f'{self.start_ns} {self.grain_s!r} {self.least_bin_s!r} {len(self.count)} {text}'

    @classmethod
    def from_text(cls, text: str) -> 'Fingerprint':
        """Return the fingerprint in a text of `to_text`."""
        start_ns, grain_s, least_bin_s, n, packed = text.split(' ', 4)
        data, at = zlib.decompress(b85decode(packed)), 0
        columns = []
        for kind in _KINDS:
            columns.append(np.frombuffer(data, kind, int(n), at))
            at += columns[-1].nbytes
        return cls(int(start_ns), float(grain_s), float(least_bin_s), columns[0].astype(float),
                   columns[2].astype(np.int64), columns[1].astype(float))

    def shorten(self, most: int) -> 'Fingerprint':
        """Return the same with at most this many grains, each longer by a power of two."""
        times = 1
        while len(self.count) > most * times:
            times *= 2
        return self.coarsen(times * self.grain_s)

    def coarsen(self, grain_s: float) -> 'Fingerprint':
        """Return the same with grains longer by a power of two."""
        times = round(grain_s / self.grain_s)
        if times == 1:
            return self
        def add_up(column: np.ndarray) -> np.ndarray:
            return np.add.reduceat(column, np.arange(0, len(column), times))
        return Fingerprint(self.start_ns, grain_s, self.least_bin_s, add_up(self.total_deg),
                           add_up(self.count),
                           add_up(self.rs_deg) / add_up(np.ones(len(self.rs_deg))))

    def average(self, phase: int) -> Reals:
        """Return the averages of bins that begin `phase` grains late; nan where there is none."""
        n = (len(self.count) - phase) // _GRAINS * _GRAINS
        total, count = (column[phase:phase + n].reshape(-1, _GRAINS).sum(1)
                        for column in (self.total_deg, self.count))
        averages: Reals = np.divide(total, count, out=np.full(len(total), np.nan), where=count > 0)
        return averages


@dataclass(frozen=True, slots=True)
class Shared:
    """
    Readings that two runs share.

    Attributes
    ----------
    first_ns, other_ns
        Where the readings begin in the first run and in the other run, about; stamps.
    span_s
        For how long they were found, seconds.
    correlation
        Largest correlation of the whitened differences, over two minutes or more.

    """

    first_ns: int
    other_ns: int
    span_s: float
    correlation: float


class _Rests(NamedTuple):
    """What is compared of a run: its start, its grain, its shortest bin, and its `_whiten`."""

    start_ns: int
    grain_s: float
    least_bin_s: float
    whiten: Callable[[float, int], Reals | None]


def _whiten(run: Fingerprint, phase: int) -> Reals | None:
    """
    Return what earlier differences and the motion do not tell of the averages of a run.

    The averages are regressed on those before, on the heading around each, which holds any skew
    and interpolation, and on the deviation of a compass. nan where there is no average.
    """
    x = run.average(phase)
    valid = np.isfinite(x)
    valid[:_ORDER] = False
    if valid.sum() < 2 * _BLOCK:
        return None
    centred = np.where(np.isfinite(x), x - np.nanmean(x), 0.0)
    # A step or a glitch must not make the filter, nor all of the correlation.
    scale = float(np.quantile(np.abs(centred[valid]), 0.9))
    if scale == 0.0:
        return None
    centred = np.clip(centred, -4.0 * scale, 4.0 * scale)
    before = [np.concatenate((np.zeros(lag), centred[:-lag])) for lag in range(1, _ORDER + 1)]
    at = phase + _GRAINS * np.arange(len(x))[:, None] + np.arange(-_GRAINS, 2 * _GRAINS)
    around = run.rs_deg[np.clip(at, 0, len(run.rs_deg) - 1)]
    turned = np.radians(around).reshape(len(x), 3, _GRAINS)
    deviation = [shape(order * turned).mean(axis=2) for order in (1.0, 2.0)
                 for shape in (np.sin, np.cos)]
    around = around - around[:, _GRAINS:2 * _GRAINS].mean(axis=1, keepdims=True)
    regressors = np.column_stack((*before, around, *deviation, np.ones(len(x))))
    weights = scipy.linalg.lstsq(regressors[valid], centred[valid], lapack_driver='gelsy')[0]
    rest: Reals = np.where(valid, centred - regressors @ weights, np.nan)
    if float(np.nanvar(rest)) < _LEAST_REST * float(np.var(centred[valid])):
        return None
    # A few spikes, perhaps at even times, are no copy: all averages of a block must agree.
    most = _MOST_OF_ONE * float(np.quantile(np.abs(rest[valid]), 0.9))
    return np.clip(rest, -most, most)


def _normalise(windows: np.ndarray) -> np.ndarray:
    """Return windows, shape (n, block), with mean 0 and sum of squares 1; 0 with many gaps."""
    valid = np.isfinite(windows)
    enough = valid.sum(axis=1) >= _THERE * _BLOCK
    filled = np.where(valid, windows, 0.0)
    mean = filled.sum(axis=1) / np.maximum(valid.sum(axis=1), 1)
    filled = np.where(valid, filled - mean[:, None], 0.0)
    size = np.sqrt(np.einsum('ij,ij->i', filled, filled))
    good = enough & (size > 0.0)
    scale: Reals = np.divide(1.0, size, out=np.zeros(size.shape), where=good)
    return np.asarray(filled * scale[:, None], np.float64)


@lru_cache(maxsize=4096)
def find_shared(first: str, second: str) -> Shared | None:
    """
    Return the readings that two runs share; None if there are none.

    Parameters
    ----------
    first, second
        Fingerprints as text.

    Notes
    -----
    Averages of independent errors are uncorrelated once what the earlier ones and the motion tell
    is removed, so the correlation of a block of 64 is within 0.75 of 0 at every lag. Averages of
    the same readings are correlated nearly in full, also with other last digits and other bins.

    References
    ----------
    E.25 of ``docs/diagnostics.md``.

    """
    return _compare(_read_rests(first), _read_rests(second), 0)


def find_repeats(run: Fingerprint) -> Shared | None:
    """Return readings that a run holds twice, E.25, the first place first; None without any."""
    rests = _Rests(run.start_ns, run.grain_s, run.least_bin_s,
                   lambda grain_s, phase: _whiten(run.coarsen(grain_s), phase))
    shared = _compare(rests, rests, _BLOCK)
    if shared is None or shared.first_ns < shared.other_ns:
        return shared
    return replace(shared, first_ns=shared.other_ns, other_ns=shared.first_ns)


def _read_rests(text: str) -> _Rests:
    start_ns, grain_s, least_bin_s, _ = text.split(' ', 3)
    return _Rests(int(start_ns), float(grain_s), float(least_bin_s),
                  partial(_whiten_text, text))


@lru_cache(maxsize=_MOST_WHITENED)
def _whiten_text(text: str, grain_s: float, phase: int) -> Reals | None:
    return _whiten(Fingerprint.from_text(text).coarsen(grain_s), phase)


def _compare(run: _Rests, partner: _Rests, least_lag: int) -> Shared | None:
    grain_s = max(run.grain_s, partner.grain_s)
    while grain_s * _GRAINS < max(run.least_bin_s, partner.least_bin_s):
        grain_s *= 2.0
    bin_s = grain_s * _GRAINS
    whitened = partner.whiten(grain_s, 0)
    if whitened is None or len(whitened) < _BLOCK:
        return None
    starts = np.unique(np.linspace(0, len(whitened) - _BLOCK, _MOST_BLOCKS).astype(np.int64)
                       if len(whitened) > _MOST_BLOCKS * _BLOCK // 2
                       else np.arange(0, len(whitened) - _BLOCK + 1, _BLOCK // 2))
    blocks = _normalise(whitened[starts[:, None] + np.arange(_BLOCK)])
    usable = blocks.any(axis=1)
    starts, blocks = starts[usable], blocks[usable]
    best: Shared | None = None
    for phase in range(_GRAINS):
        sought = run.whiten(grain_s, phase)
        if sought is None or not len(starts):
            continue
        match = _search(sought, starts, blocks, least_lag)
        if match is not None and (best is None or match[3] > best.correlation):
            at, start, n, correlation = match
            best = Shared(run.start_ns + round((at * bin_s + phase * grain_s) * 1e9),
                          partner.start_ns + round(start * bin_s * 1e9), n * bin_s, correlation)
    return best


def _search(sought: Reals, starts: Integers, blocks: np.ndarray,
            least_lag: int) -> tuple[int, int, int, float] | None:
    """Return where blocks are found: place, place in the other run, bins, and correlation."""
    windows = np.lib.stride_tricks.sliding_window_view(sought, _BLOCK)
    n, offset = len(windows), int(starts[-1])
    # Of each lag the sum of the correlations, and the number of blocks.
    total, count = np.zeros(n + offset), np.zeros(n + offset, np.int64)
    hits: list[np.ndarray] = []
    for lo in range(0, n, _AT_ONCE):
        normal = _normalise(windows[lo:lo + _AT_ONCE])
        alike = normal @ blocks.T
        lags = lo + np.arange(len(normal))[:, None] - starts
        if least_lag:
            alike[np.abs(lags) < least_lag] = 0.0
        total += np.bincount((lags + offset).ravel(), alike.ravel(), total.size)
        count += np.bincount((lags + offset)[normal.any(axis=1)].ravel(), minlength=total.size)
        rows, columns = np.nonzero(alike >= _TOGETHER)
        hits.append(np.column_stack((lo + rows - starts[columns], starts[columns],
                                     alike[rows, columns])))
    mean = np.divide(total, count, out=np.zeros(total.shape), where=count >= _SOME)
    together = int(np.argmax(mean))
    lag, start, correlation = max(np.concatenate(hits).tolist(), key=lambda hit: hit[2],
                                  default=(0.0, 0.0, 0.0))
    if mean[together] > _TOGETHER:
        lag = together - offset
    elif correlation < _ALIKE:
        return None
    at_lag = np.concatenate([hit[hit[:, 0] == lag] for hit in hits])
    if not len(at_lag):
        return None
    at_lag = at_lag[at_lag[:, 2] >= _MOSTLY * at_lag[:, 2].max()]
    first, last = int(at_lag[:, 1].min()), int(at_lag[:, 1].max())
    return first + int(lag), first, last - first + _BLOCK, float(at_lag[:, 2].max())
