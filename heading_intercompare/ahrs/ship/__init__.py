# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The ship: the Earth under it, the sea, its motion."""

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'earth': ('earth_rate', 'EARTH_RATE_RAD_S', 'gravity', 'KNOT_M_S', 'RAD_PER_DEG_H',
              'RAD_PER_DEG_SQRT_H', 'radii', 'UG_M_S2'),
    'seaway': ('BLOCK_STEPS', 'GRID_S', 'SEAWAYS'),
    'ship_motion': ('Leg', 'ShipBlock', 'ShipTruth'),
})
