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

"""Headings from the positions of two antennas: the direction of the baseline between them."""

from __future__ import annotations

from dataclasses import dataclass
import math

import numpy as np

from heading_intercompare.core.angles import wrap360
from heading_intercompare.core.records import Headings, Integers, Motion, Reals
from heading_intercompare.core.settings import Antennas

from .tangent_plane import steps_m

LONGEST_STEP_S = 2.0
"""Positions of the aft antenna further apart than this are not interpolated, seconds."""

_SECOND_NS = 10 ** 9
#: Of normal values, the median absolute deviation over the standard deviation.
_MAD = 0.6744897501960817
#: Lengths further off than this multiple of their scatter are rejected, and at least so far off.
_TOLERATED, _LEAST_M = 5.0, 0.01


@dataclass(frozen=True, slots=True)
class BaselineHeadings:
    """
    Headings of the baseline between two antennas.

    Attributes
    ----------
    headings
        At the stamps of the fore antenna.
    length_m
        The length that was required: as stated, or the median; None without a pair.
    scatter_m
        Standard deviation of the lengths that were accepted, from their median absolute
        deviation; None for fewer than two.
    sigma_deg
        Standard uncertainty of a heading: that of the length, or of the positions as stated, as
        an angle.
    rejected
        Positions of the fore antenna that gave none: 'no_partner', 'wrong_baseline'.

    """

    headings: Headings
    length_m: float | None
    scatter_m: float | None
    sigma_deg: float | None
    rejected: dict[str, int]


def find_baseline_headings(fore: Motion, aft: Motion, rule: Antennas) -> BaselineHeadings:
    """
    Return the headings of a ship with two antennas.

    Parameters
    ----------
    fore, aft
        Positions of the two antennas, in any order; rows without one do not count.
    rule
        Length and mounting of the baseline.

    Returns
    -------
    BaselineHeadings

    Notes
    -----
    The position of the aft antenna is interpolated to each stamp of the fore one. The azimuth of
    the way from aft to fore, in the tangent plane, plus the angle from the baseline to the bow is
    the heading. Both receivers must tell the time of their positions: a tenth of a second is half
    a metre at 10 knots.

    With the standard deviation s of a position in each direction, that of the baseline is
    sqrt(2) s in each, and that of the heading sqrt(2) s / L radians. The lengths scatter by
    sqrt(2) s, too, so they show it.

    """
    front, back = (_put_in_order(antenna) for antenna in (fore, aft))
    east, north, paired = _baseline_m(front, back)
    length = np.hypot(east, north)
    rejected = {'no_partner': int(np.count_nonzero(~paired))}
    if not paired.any():
        return BaselineHeadings(Headings.empty(), rule.baseline_m, None, None, rejected)
    required = rule.baseline_m
    if required is None:
        required = float(np.median(length[paired]))
    tolerance = rule.tolerance_m
    if tolerance is None:
        tolerance = max(_TOLERATED * (_scatter(length[paired]) or 0.0), _LEAST_M)
    good = paired & (np.abs(length - required) <= tolerance)
    rejected['wrong_baseline'] = int(np.count_nonzero(paired & ~good))
    azimuth = np.degrees(np.arctan2(east[good], north[good]))
    headings = Headings(front.stamp_ns[good], wrap360(azimuth + rule.baseline_angle_deg))
    scatter = _scatter(length[good])
    sigma_m = scatter if rule.position_sigma_m is None else math.sqrt(2.0) * rule.position_sigma_m
    sigma = None if sigma_m is None or required <= 0.0 else math.degrees(sigma_m / required)
    return BaselineHeadings(headings, required, scatter, sigma, rejected)


def _put_in_order(rows: Motion) -> Motion:
    """Return the positions in stamp order, each stamp once."""
    rows = rows.positions().in_order()
    return rows[np.flatnonzero(np.diff(rows.stamp_ns, prepend=-1))]


def _baseline_m(front: Motion, back: Motion) -> tuple[Reals, Reals, np.ndarray]:
    """Return the way from the aft to the fore antenna, and where both have a position."""
    if not len(front) or not len(back):
        return np.zeros(len(front)), np.zeros(len(front)), np.zeros(len(front), bool)
    before, after, share = _bracket(back.stamp_ns, front.stamp_ns)
    aft_deg = back.latitude_deg[before], back.longitude_deg[before]
    east, north = steps_m(aft_deg, (front.latitude_deg, front.longitude_deg))
    step_east, step_north = steps_m(aft_deg, (back.latitude_deg[after], back.longitude_deg[after]))
    paired = np.isfinite(share)
    share = np.where(paired, share, 0.0)
    return east - share * step_east, north - share * step_north, paired


def _bracket(stamp_ns: Integers, wanted_ns: Integers) -> tuple[Integers, Integers, Reals]:
    """Return the stamps around each wanted one, and its share of the way; nan beyond a gap."""
    before = (np.searchsorted(stamp_ns, wanted_ns, side='right') - 1).clip(0)
    exact = stamp_ns[before] == wanted_ns
    after = np.where(exact, before, np.minimum(before + 1, len(stamp_ns) - 1))
    step_ns = stamp_ns[after] - stamp_ns[before]
    inside = (stamp_ns[before] <= wanted_ns) & (wanted_ns <= stamp_ns[after])
    good = inside & (step_ns <= LONGEST_STEP_S * _SECOND_NS)
    share = (wanted_ns - stamp_ns[before]) / np.where(step_ns > 0, step_ns, 1)
    return before, after, np.where(good, share, np.nan)


def _scatter(values: Reals) -> float | None:
    """Return the standard deviation by the median absolute deviation; None for fewer than two."""
    if values.size < 2:
        return None
    return float(np.median(np.abs(values - np.median(values)))) / _MAD
