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

"""Spectrum and autocorrelation of a series of any length, from segments at several rates."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from heading_intercompare.core.records import Integers, Reals

SEGMENT = 4096
"""Samples in a segment."""

LAGS = 512
"""Largest lag within a segment, in its samples."""

JOINED = 8
"""Samples of a level that are averaged to one of the next."""

_LEAST = 64
_LEVELS = 8
_AT_ONCE = 32
_WINDOW = np.hanning(SEGMENT + 1)[:-1]


@dataclass(frozen=True, slots=True)
class Level:
    """
    Spectrum and autocovariance at one rate.

    Attributes
    ----------
    joined
        Samples of the series in each sample of the level: a power of 8.
    power_deg2 : ndarray, shape (k,)
        One-sided spectrum times the rate: square degrees per cycle a sample of the level. Entry
        j is at j / length cycles a sample.
    length
        Samples in a segment.
    covariance_deg2 : ndarray, shape (m + 1,)
        Autocovariance at lags of 0 to m samples of the level, about the mean of each end.

    """

    joined: int
    segments: int
    power_deg2: Reals
    length: int
    covariance_deg2: Reals


class _Sums:
    """Sums over the segments of one level, and the samples of the segment to come."""

    def __init__(self) -> None:
        self.rest = np.zeros(0)
        self.longest = np.zeros(0)
        self.segments = 0
        self.power = np.zeros(SEGMENT // 2 + 1)
        self.products = np.zeros(LAGS + 1)
        self.places = np.zeros(SEGMENT)

    def take(self, x: Reals) -> None:
        """Take samples; whole segments go into the sums."""
        x = np.concatenate((self.rest, x))
        whole = len(x) // SEGMENT
        for lo in range(0, whole, _AT_ONCE):
            hi = min(whole, lo + _AT_ONCE)
            self._add(x[lo * SEGMENT:hi * SEGMENT].reshape(-1, SEGMENT))
        self.rest = x[whole * SEGMENT:].copy()

    def _add(self, segments: Reals) -> None:
        power, products = _transform(segments, _WINDOW, LAGS)
        self.power += power
        self.products += products
        self.places += segments.sum(axis=0)
        self.segments += len(segments)

    def forget(self) -> None:
        """Begin a segment again, after a silence."""
        if len(self.rest) > len(self.longest):
            self.longest = self.rest
        self.rest = np.zeros(0)

    def level(self, joined: int) -> Level | None:
        """Return the sums as a level; None if the samples are too few."""
        if self.segments:
            return Level(joined, self.segments, self.power / self.segments, SEGMENT,
                         _covariance(self.products, self.places, self.segments))
        x = max(self.rest, self.longest, key=len)
        n = len(x)
        if n < _LEAST:
            return None
        lags = min(LAGS, n // 8)
        power, products = _transform(x[None, :], np.hanning(n + 1)[:-1], lags)
        return Level(joined, 1, power, n, _covariance(products, x, 1))


def _transform(segments: Reals, window: Reals, lags: int) -> tuple[Reals, Reals]:
    """Return the sums over segments of the spectrum, and of the products at each lag."""
    n = segments.shape[1]
    steady = segments - segments.mean(axis=1, keepdims=True)
    lines = np.fft.rfft(steady * window)
    power: Reals = 2.0 * np.square(np.abs(lines)).sum(axis=0) / float(window @ window)
    size = 1 << (n + lags - 1).bit_length()
    whole = np.square(np.abs(np.fft.rfft(segments, size))).sum(axis=0)
    products: Reals = np.fft.irfft(whole, size)[:lags + 1]
    return power, products


def _covariance(products: Reals, places: Reals, segments: int) -> Reals:
    """Return the autocovariance from sums of products and the sums at each place."""
    n, lag = len(places), np.arange(len(products))
    heads = np.cumsum(places)[n - 1 - lag]
    tails = np.cumsum(places[::-1])[n - 1 - lag]
    count = segments * (n - lag)
    covariance: Reals = products / count - heads / count * (tails / count)
    return covariance


class Spectra:
    """
    Sums over segments of 4096 samples: of a series, of its means over 8 samples, over 64, ...

    Notes
    -----
    A series of any length takes 1 MB at most. The steps between samples count as equal, except
    that a silence begins a segment again.

    """

    def __init__(self, silence_s: float) -> None:
        self._silence_ns = round(silence_s * 1e9)
        self._levels = [_Sums() for _ in range(_LEVELS)]
        self._joining = [np.zeros(0) for _ in range(_LEVELS)]
        self._newest_ns: int | None = None
        self._reference_deg = 0.0

    def update(self, stamp_ns: Integers, x_deg: Reals) -> None:
        """Take finite differences in stamp order."""
        if not len(x_deg):
            return
        newest = self._newest_ns
        if newest is None:
            newest, self._reference_deg = int(stamp_ns[0]), float(x_deg[0])
        cuts = np.flatnonzero(np.diff(stamp_ns, prepend=newest) > self._silence_ns)
        for at, part in enumerate(np.split(x_deg - self._reference_deg, cuts)):
            if at:
                self._forget()
            self._take(part, 0)
        self._newest_ns = int(stamp_ns[-1])

    def _take(self, x: Reals, at: int) -> None:
        """Hand samples to a level, and their means to the next."""
        self._levels[at].take(x)
        if at + 1 == _LEVELS:
            return
        x = np.concatenate((self._joining[at], x))
        whole = len(x) // JOINED * JOINED
        self._joining[at] = x[whole:].copy()
        if whole:
            self._take(x[:whole].reshape(-1, JOINED).mean(axis=1), at + 1)

    def _forget(self) -> None:
        for at, level in enumerate(self._levels):
            level.forget()
            self._joining[at] = np.zeros(0)

    def levels(self) -> list[Level]:
        """Return the levels from the full rate down; none for fewer than 64 samples."""
        levels = (sums.level(JOINED ** at) for at, sums in enumerate(self._levels))
        return [level for level in levels if level is not None]
