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

"""Means of groups of a correlated series, such as sectors of the heading, with their intervals."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from heading_intercompare.core.records import Integers, Reals

from .blocking import student_95

_WINDOW = 5.0
_LEAST_DOF = 10.0
_MOST_ABSORBED = 0.5


@dataclass(frozen=True, slots=True, eq=False)
class GroupMeans:
    """
    Means of groups.

    Attributes
    ----------
    n : ndarray, shape (k,)
        Weight of each group.
    mean_deg : ndarray, shape (k,)
        Its mean; nan for an empty group.
    half_width_deg : ndarray, shape (k,)
        Half of the 95 % interval of the mean; nan where it cannot be said.

    """

    n: Reals
    mean_deg: Reals
    half_width_deg: Reals


def estimate_group_means(x_deg: Reals, group: Integers, weight: Reals, count: int,
                         systematic_deg: Reals) -> GroupMeans:
    """
    Return the means of groups with intervals that allow for correlation in time.

    Parameters
    ----------
    x_deg : ndarray, shape (n,)
        Values at equal steps of time.
    group : ndarray of int, shape (n,)
        Group of each value, from 0; -1 is none, also where a value is missing.
    weight : ndarray, shape (n,)
        Weight of each value.
    count
        Number of groups.
    systematic_deg : ndarray, shape (n,)
        The part of each value that is no error in time. The means hold it, the intervals do not.

    Notes
    -----
    The autocovariance C of the values about the means of their groups is that of all groups
    together, up to a window of five correlation times. The variance of the mean of a group is
    then the sum of w_i w_j C(i - j) over its values within that window, over the square of its
    weight. So a group may be one long stretch, or many short ones.

    The means take a part of the slow errors away from C: on average the variance of a mean. It is
    added back. If more than half would be added, or the values are worth fewer than ten
    independent ones beyond the groups, the errors are too slow, and there is no interval. A group
    that scatters more than all together has a wider one.

    References
    ----------
    Window: Sokal 1997. E.29 of ``docs/diagnostics.md`` has the share of intervals that hold.

    """
    member = group >= 0
    label, w = group[member], np.where(member, weight, 0.0)
    n: Reals = np.bincount(label, weights=w[member], minlength=count).astype(np.float64)

    def average(values: Reals) -> Reals:
        sums = np.bincount(label, weights=w[member] * values[member], minlength=count)
        with np.errstate(invalid='ignore', divide='ignore'):
            means: Reals = sums / n
        return means

    random_deg = x_deg - systematic_deg
    rest = np.zeros(x_deg.size)
    rest[member] = random_deg[member] - average(random_deg)[label]
    return GroupMeans(n, average(x_deg), _half_widths(rest, group, w, n))


def _half_widths(rest: Reals, group: Integers, weight: Reals, n: Reals) -> Reals:
    """Return half of the 95 % interval of each mean, by the values about their means."""
    none: Reals = np.full(n.size, np.nan)
    member = group >= 0
    number = int(np.count_nonzero(member))
    if number < _LEAST_DOF:
        return none
    pairs = _sum_products(member.astype(np.float64))
    covariance = np.where(pairs > 0.5, _sum_products(rest) / np.maximum(pairs, 1.0), 0.0)
    if covariance[0] <= 0.0:
        return none
    tau = 0.5 + np.cumsum(covariance[1:] / covariance[0])
    wide = np.flatnonzero(np.arange(1, tau.size + 1) >= _WINDOW * tau)
    window = int(wide[0]) + 1 if wide.size else tau.size
    variance, share = none.copy(), none.copy()
    for at in np.flatnonzero(n).tolist():
        near = _sum_products(np.where(group == at, weight, 0.0))[:window + 1] / n[at] ** 2
        near[1:] *= 2.0
        variance[at], share[at] = near @ covariance[:window + 1], near.sum()
    absorbed = float(np.nansum(n * share) / n.sum())
    dof = number / (2.0 * max(0.5, tau[window - 1])) * (1.0 - absorbed) - np.count_nonzero(n)
    if absorbed > _MOST_ABSORBED or dof < _LEAST_DOF:
        return none
    variance += share * float(np.nansum(n * variance) / n.sum()) / (1.0 - absorbed)
    scatter = (np.bincount(group[member], weights=rest[member] ** 2, minlength=n.size)
               / np.maximum(np.bincount(group[member], minlength=n.size), 1))
    wider = np.maximum(1.0, scatter / covariance[0])
    half_width: Reals = student_95(dof) * np.sqrt(np.maximum(variance * wider, 0.0))
    return half_width


def _sum_products(values: Reals) -> Reals:
    """Return the sums of products of all values at each lag."""
    size = 1 << (2 * values.size - 1).bit_length()
    power = np.abs(np.fft.rfft(values, size)) ** 2
    products: Reals = np.fft.irfft(power, size)[:values.size]
    return products
