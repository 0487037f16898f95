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

"""Faults of a heading sensor as seen from outside: frozen, rotated, mirrored, silent."""

from __future__ import annotations

from bisect import insort
from dataclasses import dataclass, replace
import math
from typing import Sequence

import numpy as np

from heading_intercompare.core.angles import wrap360
from heading_intercompare.core.records import Integers, Reals

FAULTS = {
    'freeze': ('repeats its last reading; the value is not used', 0.0),
    'jump': ('adds the value [deg]', 5.0),
    'rotated': ('adds the value [deg], by default a quarter turn', 90.0),
    'mirrored': ('shows the value minus the heading [deg]: a compass heading published as an '
                 'ENU yaw, or the reverse', 90.0),
    'clock_step': ('adds the value to its stamps [s]', 1.0),
    'silent': ('gives no readings; the value is not used', 0.0),
    'invalid': ('flags its readings as invalid; the value is not used', 0.0),
}
"""Kinds of faults: what the sensor does, and the default value."""


@dataclass(frozen=True, slots=True)
class Fault:
    """One fault, from `t_s` for `duration_s`; an infinite one lasts to the end."""

    t_s: float
    kind: str
    value: float
    duration_s: float = math.inf

    def is_active(self, t_s: Reals) -> np.ndarray:
        """Tell at which instants the fault is active."""
        return (t_s >= self.t_s) & (t_s < self.t_s + self.duration_s)


class Faults:
    """
    The faults of one sensor, applied to its readings chunk by chunk.

    Parameters
    ----------
    faults
        In any order; they act in the order in which they start.

    """

    def __init__(self, faults: Sequence[Fault] = ()) -> None:
        self._faults = sorted(faults, key=_start)
        self._held_deg: dict[tuple[float, str], float] = {}
        self._last_deg: float | None = None

    def begin(self, fault: Fault) -> None:
        """
        Add a fault, which must not begin before readings already processed.

        Raises
        ------
        ValueError
            If a fault of this kind is active at that time.

        """
        if any(active.kind == fault.kind for active in self.list_active(fault.t_s)):
            raise ValueError(f'{fault.kind} is already present')
        insort(self._faults, fault, key=_start)

    def end(self, kind: str, t_s: float) -> None:
        """
        End the faults of a kind at a time.

        Raises
        ------
        ValueError
            If none is active at that time.

        """
        present = [fault for fault in self.list_active(t_s) if fault.kind == kind]
        if not present:
            raise ValueError(f'{kind} is not present')
        for fault in present:
            self._faults[self._faults.index(fault)] = replace(
                fault, duration_s=t_s - fault.t_s)

    def list_active(self, t_s: float) -> tuple[Fault, ...]:
        """Return the faults that are active at a time."""
        return tuple(fault for fault in self._faults
                     if fault.t_s <= t_s < fault.t_s + fault.duration_s)

    def put(self, t_s: Reals, heading_deg: Reals,
            stamp_ns: Integers) -> tuple[Reals, Integers, np.ndarray]:
        """
        Apply the faults to one chunk of readings.

        Parameters
        ----------
        t_s : ndarray, shape (n,)
            Times of the readings, seconds since the start, later than those of the last call.
        heading_deg : ndarray, shape (n,)
            Readings without faults, degrees.
        stamp_ns : ndarray of int64, shape (n,)
            Stamps without faults, nanoseconds.

        Returns
        -------
        heading_deg, stamp_ns : ndarray, shape (n,)
            Readings and stamps with the faults.
        present : ndarray of bool, shape (n,)
            False where the sensor is silent.

        """
        present = np.ones(t_s.shape, dtype=bool)
        if not t_s.size:
            return heading_deg, stamp_ns, present
        for fault in self._faults:
            at = fault.is_active(t_s)
            if not at.any():
                continue
            if fault.kind == 'freeze':
                heading_deg = self._freeze(fault, at, heading_deg)
            elif fault.kind in ('jump', 'rotated'):
                heading_deg = np.where(at, wrap360(heading_deg + fault.value), heading_deg)
            elif fault.kind == 'mirrored':
                heading_deg = np.where(at, wrap360(fault.value - heading_deg), heading_deg)
            elif fault.kind == 'clock_step':
                stamp_ns = np.where(at, stamp_ns + round(fault.value * 1e9), stamp_ns)
            elif fault.kind == 'invalid':
                heading_deg = np.where(at, math.nan, heading_deg)
            else:
                present &= ~at
        self._last_deg = float(heading_deg[-1])
        return heading_deg, stamp_ns, present

    def _freeze(self, fault: Fault, at: np.ndarray, heading_deg: Reals) -> Reals:
        """Hold the last reading before the fault, or the first one if there is none."""
        # Faults that act after this one had not begun by then, so the last reading of the
        # previous chunk is the one to hold.
        first = int(np.argmax(at))
        before = (heading_deg[first - 1] if first
                  else heading_deg[0] if self._last_deg is None else self._last_deg)
        held_deg = self._held_deg.setdefault((fault.t_s, fault.kind), float(before))
        return np.where(at, held_deg, heading_deg)


def _start(fault: Fault) -> float:
    return fault.t_s
