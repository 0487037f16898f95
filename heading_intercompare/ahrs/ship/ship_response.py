# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""How a ship answers waves: simple response amplitude operators of a box-shaped hull."""

from __future__ import annotations

from dataclasses import dataclass
import math

import numpy as np

from heading_intercompare.core.records import Reals

__all__ = ['Hull', 'respond', 'USUAL_HULL']


@dataclass(frozen=True, slots=True)
class Hull:
    """
    The figures of a ship that its motion at sea depends on.

    Attributes
    ----------
    length_m, breadth_m, draught_m : float
        At the waterline.
    roll_period_s : float
        Natural period of roll.
    roll_damping : float
        Damping of roll as a share of the critical one.

    """

    length_m: float = 80.0
    breadth_m: float = 14.0
    draught_m: float = 4.5
    roll_period_s: float = 11.0
    roll_damping: float = 0.1


USUAL_HULL = Hull()


def respond(hull: Hull, wave_number_1_m: Reals, ahead: Reals, aside: Reals,
            encounter_rad_s: Reals) -> np.ndarray:
    """
    Return the complex response to waves of 1 m amplitude.

    Parameters
    ----------
    hull : Hull
        The ship.
    wave_number_1_m : ndarray, shape (n,)
        Wave numbers, rad/m.
    ahead, aside : ndarray, shape (..., n)
        Components of the unit vector in which a wave goes, along the ship axis and to starboard.
    encounter_rad_s : ndarray, shape (..., n)
        Frequencies as the ship meets the waves, negative if it overtakes them.

    Returns
    -------
    ndarray of complex, shape (6, ..., n)
        Roll (starboard down), pitch (bow up) and yaw (to starboard), rad/m; surge, sway and heave
        (down), 1. The real part of this times exp(j phase) belongs to an elevation cos(phase).

    Notes
    -----
    The hull follows the water averaged over its length, breadth and draught (Froude and Krylov's
    forces on a box, without its own waves). Pitch and yaw are the slopes of the straight line
    that fits the water best along the hull. Only roll resonates.

    References
    ----------
    Jensen, Mansour and Olsen, "Estimation of ship motions using closed-form expressions", Ocean
    Engineering 31 (2004), of which these are the limit for small frequencies.

    """
    k = wave_number_1_m
    along, across = 0.5 * hull.length_m * k * ahead, 0.5 * hull.breadth_m * k * aside
    depth = np.exp(-0.5 * hull.draught_m * k)
    mean = np.sinc(along / math.pi) * np.sinc(across / math.pi) * depth
    slope = _fit_slope(along) * np.sinc(across / math.pi) * depth
    ratio = encounter_rad_s * hull.roll_period_s / (2.0 * math.pi)
    swing = 1.0 / (1.0 - ratio * ratio + 2j * hull.roll_damping * ratio)
    return np.stack((1j * k * aside * mean * swing, -1j * k * ahead * slope,
                     -k * ahead * aside * slope, -1j * ahead * mean, -1j * aside * mean,
                     -mean + 0j))


def _fit_slope(q: Reals) -> Reals:
    """Return 3 (sin q - q cos q) / q^3: the slope of a line fitted to a sinusoid, over its own."""
    small = np.abs(q) < 1e-2
    safe = np.where(small, 1.0, q)
    return np.where(small, 1.0 - 0.1 * q * q, 3.0 * (np.sin(safe) - safe * np.cos(safe))
                    / safe**3)
