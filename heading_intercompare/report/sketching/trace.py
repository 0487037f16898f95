# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""What one sensor of a simulated trial showed, in columns of equal time."""

from __future__ import annotations

from dataclasses import dataclass

from heading_intercompare.core.records import Reals

__all__ = ['Trace']


@dataclass(frozen=True, slots=True, eq=False)
class Trace:
    """
    What one sensor of a trial showed, in columns of equal time.

    Attributes
    ----------
    name : str
        The sensor.
    n : int
        Its readings.
    t_h : ndarray, shape (m,)
        Middle of each column, hours since the start.
    true_deg, heading_deg : ndarray, shape (m,)
        True heading and reading at the last valid reading of each column; nan without one.
    low_deg, high_deg : ndarray, shape (m,)
        Least and greatest error of the readings in each column.
    sigma_deg : ndarray, shape (m,)
        Greatest standard deviation that the sensor claims.
    modes : tuple of (float, str)
        Hour at which each mode begins, and its name; empty for sensors without.

    """

    name: str
    n: int
    t_h: Reals
    true_deg: Reals
    heading_deg: Reals
    low_deg: Reals
    high_deg: Reals
    sigma_deg: Reals
    modes: tuple[tuple[float, str], ...] = ()
