# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Faults of a heading sensor as they are seen from outside: frozen, turned, mirrored, silent."""

from __future__ import annotations

from dataclasses import dataclass
import math

import numpy as np

from heading_intercompare.core.angles import wrap360

__all__ = ['Fault', 'FAULTS', 'Faults']

FAULTS = {
    'freeze': ('repeats its last reading; the value is not used', 0.0),
    'jump': ('adds the value [deg]', 5.0),
    'rotated': ('adds the value [deg], a quarter turn unless given', 90.0),
    'mirrored': ('shows the value minus the heading [deg]: a compass heading published as an '
                 'ENU yaw, or the reverse', 90.0),
    'clock_step': ('adds the value to its stamps [s]', 1.0),
    'silent': ('gives no readings; the value is not used', 0.0),
    'invalid': ('calls its readings invalid; the value is not used', 0.0),
}
"""Kinds of faults: what the sensor does, and the value when none is given."""


@dataclass(frozen=True, slots=True)
class Fault:
    """One fault, from `t_s` for `duration_s` (infinite: to the end)."""

    t_s: float
    kind: str
    value: float
    duration_s: float = math.inf

    def active(self, t_s: np.ndarray) -> np.ndarray:
        """Tell at which instants the fault is present."""
        return (t_s >= self.t_s) & (t_s < self.t_s + self.duration_s)


class Faults:
    """
    The faults of one sensor, put on its readings chunk by chunk.

    Parameters
    ----------
    faults : sequence of Fault
        In any order; they act in the order of their start.

    """

    def __init__(self, faults: tuple[Fault, ...] = ()) -> None:
        self._faults = tuple(sorted(faults, key=lambda fault: fault.t_s))
        self._held_deg: dict[int, float] = {}
        self._passed_deg: dict[int, float] = {}

    def put(self, t_s: np.ndarray, heading_deg: np.ndarray,
            stamp_ns: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """
        Return the readings of one chunk as the faulty sensor gives them.

        Parameters
        ----------
        t_s : ndarray, shape (n,)
            Times of the readings, seconds since the start, going on from the last call.
        heading_deg : ndarray, shape (n,)
            Sound readings, degrees.
        stamp_ns : ndarray of int64, shape (n,)
            Sound stamps.

        Returns
        -------
        heading_deg, stamp_ns : ndarray, shape (n,)
            Readings and stamps with the faults.
        given : ndarray of bool, shape (n,)
            False where the sensor is silent.

        """
        given = np.ones(t_s.shape, dtype=bool)
        if not t_s.size:
            return heading_deg, stamp_ns, given
        for i, fault in enumerate(self._faults):
            at = fault.active(t_s)
            if fault.kind == 'freeze':
                heading_deg = self._frozen(i, at, heading_deg)
            elif not at.any():
                continue
            elif fault.kind in ('jump', 'rotated'):
                heading_deg = np.where(at, wrap360(heading_deg + fault.value), heading_deg)
            elif fault.kind == 'mirrored':
                heading_deg = np.where(at, wrap360(fault.value - heading_deg), heading_deg)
            elif fault.kind == 'clock_step':
                stamp_ns = np.where(at, stamp_ns + round(fault.value * 1e9), stamp_ns)
            elif fault.kind == 'invalid':
                heading_deg = np.where(at, math.nan, heading_deg)
            else:
                given &= ~at
        return heading_deg, stamp_ns, given

    def _frozen(self, i: int, at: np.ndarray, heading_deg: np.ndarray) -> np.ndarray:
        """Hold the reading before the fault, or the first one if there is none before."""
        if at.any() and i not in self._held_deg:
            first = int(np.argmax(at))
            before = (heading_deg[first - 1] if first
                      else self._passed_deg.get(i, heading_deg[0]))
            self._held_deg[i] = float(before)
        self._passed_deg[i] = float(heading_deg[-1])
        return np.where(at, self._held_deg[i], heading_deg) if at.any() else heading_deg
