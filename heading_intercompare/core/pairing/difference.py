# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The difference of TS and RS, GK (1)."""

from __future__ import annotations

import numpy as np

from heading_intercompare.core.angles import wrap180
from heading_intercompare.core.records import Differences, Pairs

__all__ = ['subtract']


def subtract(pairs: Pairs, installation_offset_deg: float = 0.0,
             wrap_center_deg: float = 0.0) -> Differences:
    """
    Return the differences of the readings.

    Parameters
    ----------
    pairs : Pairs
        Pairs of readings; n >= 0.
    installation_offset_deg : float
        Known angle TS - RS as mounted, degrees; removed.
    wrap_center_deg : float
        Differences are reduced to [c - 180, c + 180), degrees.

    Returns
    -------
    Differences
        x = TS - RS - offset, wrapped; nan where a reading is nan.

    References
    ----------
    GK (1).

    Examples
    --------
    >>> subtract(Pairs.of([1], [1.0], [359.5])).x_deg.tolist()
    [1.5]

    """
    x = np.subtract(pairs.ts_deg, pairs.rs_deg)
    if installation_offset_deg:
        x = x - installation_offset_deg
    return Differences(pairs.stamp_ns, wrap180(x, wrap_center_deg))
