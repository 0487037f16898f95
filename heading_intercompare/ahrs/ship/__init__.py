# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The ship, the sea and the Earth: the motion that the sensors measure."""

from typing import TYPE_CHECKING

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'course': ('Course', 'Current'),
    'earth': ('earth_rate', 'EARTH_RATE_RAD_S', 'gravity', 'KNOT_M_S', 'RAD_PER_DEG_H',
              'RAD_PER_DEG_SQRT_H', 'radii', 'UG_M_S2'),
    'seaway': ('BLOCK_STEPS', 'GRID_S', 'SEAWAYS'),
    'ship_motion': ('Leg', 'ShipBlock', 'ShipTruth'),
    'ship_response': ('Hull',),
    'track_course': ('Track',),
    'waves': ('Waves',),
})

if TYPE_CHECKING:
    # The same names for type checkers, by ``make docs``.
    from .course import Course as Course, Current as Current
    from .earth import (
        earth_rate as earth_rate,
        EARTH_RATE_RAD_S as EARTH_RATE_RAD_S,
        gravity as gravity,
        KNOT_M_S as KNOT_M_S,
        RAD_PER_DEG_H as RAD_PER_DEG_H,
        RAD_PER_DEG_SQRT_H as RAD_PER_DEG_SQRT_H,
        radii as radii,
        UG_M_S2 as UG_M_S2,
    )
    from .seaway import BLOCK_STEPS as BLOCK_STEPS, GRID_S as GRID_S, SEAWAYS as SEAWAYS
    from .ship_motion import Leg as Leg, ShipBlock as ShipBlock, ShipTruth as ShipTruth
    from .ship_response import Hull as Hull
    from .track_course import Track as Track
    from .waves import Waves as Waves
