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

"""What sensors say of their own readings, beside what the data of a run show."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Mapping

import numpy as np
from numpy.typing import NDArray

from heading_intercompare.core.declared_figures import figure
from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.records import (
    Integers,
    NORMAL_QUALITY,
    Quality,
    QUALITY_FLAGS,
    Reals,
    UNKNOWN_QUALITY,
)

_CLAIMS = {'agrees': 'the claim lies within the bounds', 'too_small': 'smaller than the data show',
           'too_large': 'larger than the data show', 'not_testable': 'not testable'}
_LEAST_LEFT = 128


@dataclass(frozen=True, slots=True)
class SensorQuality:
    """What one sensor says of the readings of a run; keys of the JSON."""

    n: int = figure('pairs of whose reading the sensor says something')
    n_reduced: int = figure('of these with a reduced quality')
    reduced_share: float = figure('their share of all pairs', unit='1')
    flags: Mapping[str, int] = figure('pairs by what the sensor says of the quality')
    stated_median_deg: float | None = figure('standard deviation that the sensor claims, median',
                                             default=None)
    stated_largest_deg: float | None = figure('standard deviation that the sensor claims, largest',
                                              default=None)

    @property
    def words(self) -> str:
        """Return the poor readings by what the sensor says of them, the most frequent first."""
        poor = [(n, flag) for flag, n in self.flags.items()
                if QUALITY_FLAGS.index(flag) > NORMAL_QUALITY]
        return ', '.join(f'{flag} {n}' for n, flag in sorted(poor, reverse=True))


@dataclass(frozen=True, slots=True)
class QualityCheck:
    """What the sensors of a run say of their readings; keys of the JSON."""

    ts: SensorQuality | None = figure('what the TS says of its readings', prefix='TS: ',
                                      absent='if it says nothing')
    rs: SensorQuality | None = figure('what the RS says of its readings', prefix='RS: ',
                                      absent='if it says nothing')
    ts_claim: str = figure('claim of the TS beside the bounds of its standard deviation',
                           'a claim that lies outside changes no outcome', choices=_CLAIMS,
                           default='not_testable')
    without_reduced: Outcome | None = figure(
        'outcome without the pairs of reduced quality',
        absent='if there are none, or fewer than 128 others')

    @property
    def n_reduced(self) -> int:
        """Return the number of readings of reduced quality, of both sensors."""
        return sum(sensor.n_reduced for sensor in (self.ts, self.rs) if sensor is not None)

    @property
    def claimed_of_rs_deg(self) -> float | None:
        """Return the standard deviation that the RS claims, degrees; None without a claim."""
        return None if self.rs is None else self.rs.stated_median_deg


def check_quality(quality: Mapping[str, Quality], stamp_ns: Integers, *,
                  late_ns: int = 0) -> tuple[QualityCheck, NDArray[np.bool_]] | None:
    """
    Lay what both sensors say of their readings beside the pairs of a run.

    Parameters
    ----------
    quality
        Of ``'ts'`` and ``'rs'``, as far as they say something; in any order.
    stamp_ns : ndarray of int64, shape (n,)
        Stamps of the pairs in increasing order, nanoseconds; n >= 0.
    late_ns
        By how much the stamps of the TS are earlier in the pairs than in its readings.

    Returns
    -------
    check, is_reduced : QualityCheck, ndarray of bool, shape (n,)
        What they say, and which pairs have a reduced quality: those whose reading has at their
        stamp; between two readings, if one of them has. None if no sensor says anything of them.

    """
    sensors, is_reduced = {}, np.zeros(stamp_ns.shape, bool)
    for sensor, rows in quality.items():
        shift_ns = late_ns if sensor == 'ts' else 0
        first = _cut_at_rows(rows.stamp_ns - shift_ns, stamp_ns)
        flag, stated_deg = rows.match(stamp_ns[first] + shift_ns)
        if flag.any() or np.isfinite(stated_deg).any():
            n = np.diff(first, append=stamp_ns.size)
            sensors[sensor] = _sum_up(flag, stated_deg, n)
            is_reduced |= np.repeat(flag > NORMAL_QUALITY, n)
    if not sensors:
        return None
    return QualityCheck(ts=sensors.get('ts'), rs=sensors.get('rs')), is_reduced


def _cut_at_rows(rows_ns: Integers, stamp_ns: Integers) -> Integers:
    """Return the first pair of each stretch of pairs of which rows with these stamps say one."""
    edges = [np.searchsorted(stamp_ns, rows_ns, side) for side in ('left', 'right')]
    first: Integers = np.unique(np.concatenate([[0], *edges]))
    return first[first < stamp_ns.size]


def _sum_up(flag: Integers, stated_deg: Reals, n: Integers) -> SensorQuality:
    """Return the figures of a sensor from what it says of stretches of n pairs each."""
    has_claim, is_reduced = np.isfinite(stated_deg), flag > NORMAL_QUALITY
    claims = stated_deg[has_claim]
    n_reduced = int(n[is_reduced].sum())
    return SensorQuality(
        n=int(n[(flag != UNKNOWN_QUALITY) | has_claim].sum()),
        n_reduced=n_reduced, reduced_share=n_reduced / int(n.sum()),
        flags={words: int(n[flag == number].sum()) for number, words in enumerate(QUALITY_FLAGS)
               if (flag == number).any()},
        stated_median_deg=_median(claims, n[has_claim]) if claims.size else None,
        stated_largest_deg=float(claims.max()) if claims.size else None)


def _median(values: Reals, n: Integers) -> float:
    """Return the median of values that stand for n each."""
    order = np.argsort(values)
    until = np.cumsum(n[order])
    middle = np.array([until[-1] - 1, until[-1]]) // 2
    return float(values[order][np.searchsorted(until, middle, 'right')].mean())


def leaves_enough(is_reduced: NDArray[np.bool_]) -> bool:
    """Tell whether some pairs have a reduced quality, and enough others do not."""
    n_reduced = int(np.count_nonzero(is_reduced))
    return n_reduced > 0 and is_reduced.size - n_reduced >= _LEAST_LEFT


def compare_claim(check: QualityCheck, lower_deg: float | None,
                  upper_deg: float | None) -> str:
    """Return how the claim of the TS lies to the bounds of its standard deviation."""
    claim_deg = None if check.ts is None else check.ts.stated_median_deg
    if claim_deg is None or lower_deg is None or upper_deg is None:
        return 'not_testable'
    return ('too_small' if claim_deg < lower_deg else 'too_large' if claim_deg > upper_deg
            else 'agrees')


def warn_of_claim(check: QualityCheck | None, lower_deg: float | None,
                  upper_deg: float | None) -> list[str]:
    """Return a warning if the TS claims to be better than the data show; otherwise none."""
    if check is None or check.ts is None or check.ts_claim != 'too_small':
        return []
    return [f'claim_of_ts: the TS claims {check.ts.stated_median_deg:.3g} deg, the data show '
            f'{lower_deg:.3g} to {upper_deg:.3g} deg']
