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

"""The differences by heading, on steady headings, and by the rate of turn."""

from __future__ import annotations

from dataclasses import dataclass
import math
from typing import Iterator, NamedTuple

import numpy as np

from heading_intercompare.core.declared_figures import figure
from heading_intercompare.core.records import Integers, Reals
from heading_intercompare.core.statistics.group_means import estimate_group_means

from .averaged_pairs import AveragedPairs
from .deviation import deviation_at, HeadingDependence

SECTORS_DEG = tuple(45.0 * k for k in range(8))
"""Middles of the sectors, degrees."""

_FASTEST_DEG_S = 20.0
_ENDS_DEG_S = (-_FASTEST_DEG_S, -10.0, -5.0, -2.0, -1.0, -0.5, 0.0, 0.5, 1.0, 2.0, 5.0, 10.0,
               _FASTEST_DEG_S)
BANDS_DEG_S = tuple(zip(_ENDS_DEG_S, _ENDS_DEG_S[1:]))
"""Lower and upper ends of the bands of the rate of turn; starboard is positive, deg/s."""

_BLOCK_S, _LONGER = 1.0, (1.0, 2.0, 4.0)
_LONGEST_STEP_S = 10.0
_RATE_NOISE_DEG_S = 0.1
_MAD = 1.4826
_SMOOTHED_S, _STEADY_DEG, _PRESENT = 20.0, 4.0, 0.75


@dataclass(frozen=True, slots=True)
class BySector:
    """The differences on steady headings; keys of the JSON, an item for each sector of 45 deg."""

    heading_deg: tuple[float, ...] = figure('heading', 'middle of the sector, of the RS')
    n: tuple[int, ...] = figure('differences', 'on steady headings', row='n')
    duration_s: tuple[float, ...] = figure('time in the sector', row='time')
    mean_deg: tuple[float | None, ...] = figure('mean difference', 'null without differences',
                                                row='mean')
    std_deg: tuple[float | None, ...] = figure('standard deviation', row='sd')
    low_deg: tuple[float | None, ...] = figure(
        'mean, 95 % from', 'the interval holds for errors that are correlated in time; null where '
        'they are too slow to say', row='95 % from')
    up_deg: tuple[float | None, ...] = figure('mean, 95 % to', row='95 % to')


@dataclass(frozen=True, slots=True)
class ByRate:
    """The differences by the rate of turn; keys of the JSON, an item for each band."""

    from_deg_s: tuple[float, ...] = figure('rate of turn from', 'of the RS, starboard is positive',
                                           row='rate from', default=())
    to_deg_s: tuple[float, ...] = figure('rate of turn to', row='to', default=())
    n: tuple[int, ...] = figure('differences', row='n', default=())
    duration_s: tuple[float, ...] = figure('time in the band', row='time', default=())
    rate_deg_s: tuple[float, ...] = figure('mean rate of turn', row='mean rate', default=())
    mean_deg: tuple[float | None, ...] = figure('mean difference', row='mean', default=())
    std_deg: tuple[float | None, ...] = figure('standard deviation', row='sd', default=())
    low_deg: tuple[float | None, ...] = figure('mean, 95 % from', 'as for a sector',
                                               row='95 % from', default=())
    up_deg: tuple[float | None, ...] = figure('mean, 95 % to', row='95 % to', default=())


@dataclass(frozen=True, slots=True)
class ByMotion:
    """The differences by heading and by the rate of turn; keys of the JSON."""

    smoothed_s: float = figure('time before and after, whose mean headings are close on a steady '
                               'heading', 'by 4 degrees at most')
    rate_span_s: float = figure('span of the rates of turn', 'longer for noisy headings')
    sectors: BySector = figure('by heading', 'eight sectors on steady headings')
    turns: ByRate = figure('by rate of turn', 'the bands that have differences, from port to '
                           'starboard')


@dataclass(frozen=True, slots=True, eq=False)
class _Blocks:
    """Means over blocks of equal time; a block without pairs has n = 0 and holds nan."""

    span_s: float
    n: Reals
    t_s: Reals
    x_deg: Reals
    rs_deg: Reals
    squares_deg2: Reals

    @classmethod
    def of(cls, pairs: AveragedPairs, span_s: float) -> '_Blocks':
        """Join averages to blocks of at least their usual step."""
        at = ((pairs.t_s - pairs.t_s[0]) / span_s).astype(np.int64)
        count = int(at[-1]) + 1
        n = np.bincount(at, minlength=count)

        def sums(values: Reals) -> Reals:
            total: Reals = np.bincount(at, weights=values, minlength=count).astype(np.float64)
            return total

        with np.errstate(invalid='ignore', divide='ignore'):
            t_s, x_deg, rs_deg = (sums(column) / n
                                  for column in (pairs.t_s, pairs.x_deg, pairs.rs_deg))
        squares = sums(pairs.x_deg ** 2) + n * pairs.within_deg2
        return cls(span_s, pairs.size * n.astype(np.float64), t_s, x_deg, rs_deg,
                   pairs.size * squares)

    @property
    def noise_deg(self) -> float:
        """Noise of a block mean of the differences, by neighbours, degrees."""
        bend = np.abs(np.diff(self.x_deg, 2))
        bend = bend[np.isfinite(bend)]
        return _MAD * float(np.median(bend)) / math.sqrt(6.0) if bend.size else 0.0

    def rate_deg_s(self) -> Reals:
        """Return the rate of turn at each block, from the one before to the one after."""
        rate: Reals = np.full(self.n.size, np.nan)
        at = np.flatnonzero(self.n)
        step_s = self.t_s[at[2:]] - self.t_s[at[:-2]]
        near = step_s <= max(_LONGEST_STEP_S, 3.0 * self.span_s)
        middle = at[1:-1][near]
        rate[middle] = ((self.rs_deg[at[2:]] - self.rs_deg[at[:-2]])[near] / step_s[near])
        return rate

    def is_steady(self, smoothed_s: float) -> np.ndarray:
        """Tell at which blocks the mean headings of the time before and after are close."""
        at = np.flatnonzero(self.n)
        t_s = self.t_s[at]
        sums = np.concatenate(([0.0], np.cumsum(self.rs_deg[at] - self.rs_deg[at[0]])))
        here = np.arange(at.size)
        first = np.searchsorted(t_s, t_s - smoothed_s)
        end = np.searchsorted(t_s, t_s + smoothed_s, side='right')
        before, after = here - first, end - here - 1
        enough = np.minimum(before, after) >= _PRESENT * smoothed_s / self.span_s
        turned_deg = ((sums[end] - sums[here + 1]) / np.maximum(after, 1)
                      - (sums[here] - sums[first]) / np.maximum(before, 1))
        steady = np.zeros(self.n.size, bool)
        steady[at] = enough & (np.abs(turned_deg) <= _STEADY_DEG)
        return steady


def divide_by_motion(pairs: AveragedPairs | None,
                     dependence: HeadingDependence) -> ByMotion | None:
    """
    Return the differences by heading and by the rate of turn.

    Parameters
    ----------
    pairs
        The analysed pairs of a run, averaged over a fraction of a second; None for fewer than 64.
    dependence
        The dependence on the heading: it is no error that a mean over a band may be blurred by.

    Notes
    -----
    The sectors hold steady headings alone, so that a follow-up error does not bend their means:
    the mean headings of the 20 s before and after differ by at most 4 degrees. A swell of usual
    periods does not count as a turn, nor does a helmsman.

    The rate of turn is the slope from the mean RS heading of the second before to that of the
    second after. So the noise of the RS in a difference does not stand in its rate. A noisy RS has
    longer blocks, up to 4 s, until the noise of a rate is below 0.1 deg/s.

    The mean in a band holds the deviation on the headings of its turns. Its interval is that of
    the other errors.

    References
    ----------
    E.29 of ``docs/diagnostics.md``.

    """
    if pairs is None:
        return None
    least_s = max(_BLOCK_S, float(np.median(np.diff(pairs.t_s))))
    for factor in _LONGER:
        blocks = _Blocks.of(pairs, factor * least_s)
        if blocks.noise_deg / (math.sqrt(2.0) * blocks.span_s) <= _RATE_NOISE_DEG_S:
            break
    smoothed_s = max(_SMOOTHED_S, 2.0 * blocks.span_s)
    sector = np.where(blocks.is_steady(smoothed_s), np.floor(
        np.nan_to_num(blocks.rs_deg) % 360.0 / 45.0 + 0.5) % len(SECTORS_DEG), -1).astype(np.int64)
    rate_deg_s = blocks.rate_deg_s()
    band = np.searchsorted(_ENDS_DEG_S, rate_deg_s, side='right') - 1
    band[~(np.abs(rate_deg_s) < _FASTEST_DEG_S)] = -1
    deviation_deg = np.nan_to_num(deviation_at(dependence, blocks.rs_deg)[0])
    sectors = _summarise(blocks, sector, len(SECTORS_DEG), np.zeros(blocks.n.size))
    turns = _summarise(blocks, band, len(BANDS_DEG_S), deviation_deg)
    rates = _mean_rates(blocks, band, rate_deg_s)
    return ByMotion(
        smoothed_s=smoothed_s, rate_span_s=2.0 * blocks.span_s,
        sectors=BySector(*zip(*((middle, *row) for middle, row in zip(SECTORS_DEG, sectors)))),
        turns=ByRate(*zip(*((*ends, row.n, row.duration_s, rate, *row[2:])
                            for ends, rate, row in zip(BANDS_DEG_S, rates, turns) if row.n))))


class _Row(NamedTuple):
    """The figures of a sector or of a band."""

    n: int
    duration_s: float
    mean_deg: float | None
    std_deg: float | None
    low_deg: float | None
    up_deg: float | None


def _summarise(blocks: _Blocks, group: Integers, count: int,
               deviation_deg: Reals) -> Iterator[_Row]:
    """Yield the figures of each group of blocks, whose intervals are without a deviation."""
    means = estimate_group_means(blocks.x_deg, group, blocks.n, count, deviation_deg)
    member = group >= 0
    squares = np.bincount(group[member], weights=blocks.squares_deg2[member], minlength=count)
    durations = blocks.span_s * np.bincount(group[member], minlength=count)
    for n, duration_s, mean, half_width, square in zip(*(column.tolist() for column in (
            means.n, durations, means.mean_deg, means.half_width_deg, squares))):
        std = math.sqrt(max(0.0, square - n * mean ** 2) / (n - 1.0)) if n > 1.0 else None
        ends = (None, None) if math.isnan(half_width) else (mean - half_width, mean + half_width)
        yield _Row(round(n), duration_s, mean if n else None, std, *ends)


def _mean_rates(blocks: _Blocks, band: Integers, rate_deg_s: Reals) -> Iterator[float]:
    """Yield the mean rate of turn in each band; 0 in an empty one."""
    member, count = band >= 0, len(BANDS_DEG_S)
    n, sums = (np.bincount(band[member], weights=weights[member], minlength=count).tolist()
               for weights in (blocks.n, blocks.n * rate_deg_s))
    for number, rate_sum in zip(n, sums):
        yield rate_sum / max(number, 1.0)
