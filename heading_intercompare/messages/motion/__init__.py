# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The motion of the ship in standard messages: positions, velocities, rates of turn."""

from typing import TYPE_CHECKING

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'motion_messages': ('decode_motion', 'encode_motion', 'FIX', 'FIX_TYPES', 'MOTION_TYPES',
                        'PUBLISHED_TYPES', 'RATE_TYPES', 'read_motion_messages', 'read_told',
                        'split_motion', 'VELOCITY_TYPES'),
})
if TYPE_CHECKING:
    # The same names for type checkers, by ``make docs``.
    from .motion_messages import (
        decode_motion as decode_motion,
        encode_motion as encode_motion,
        FIX as FIX,
        FIX_TYPES as FIX_TYPES,
        MOTION_TYPES as MOTION_TYPES,
        PUBLISHED_TYPES as PUBLISHED_TYPES,
        RATE_TYPES as RATE_TYPES,
        read_motion_messages as read_motion_messages,
        read_told as read_told,
        split_motion as split_motion,
        VELOCITY_TYPES as VELOCITY_TYPES,
    )
