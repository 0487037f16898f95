# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The work of running nodes: publish, watch, report."""

from typing import TYPE_CHECKING

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'driver_motion': ('DriverMotion',),
    'health': ('Health',),
    'motion_sender': ('MotionSender',),
    'note_publisher': ('publish_note',),
    'publishing': ('Allowance', 'Audience', 'await_acknowledgement'),
    'replayed_beside': ('publish_marks', 'ReplayedMotion'),
    'source_thread': ('Reading',),
})

if TYPE_CHECKING:
    # The same names for type checkers, by ``make docs``.
    from .driver_motion import DriverMotion as DriverMotion
    from .health import Health as Health
    from .motion_sender import MotionSender as MotionSender
    from .note_publisher import publish_note as publish_note
    from .publishing import (
        Allowance as Allowance,
        Audience as Audience,
        await_acknowledgement as await_acknowledgement,
    )
    from .replayed_beside import publish_marks as publish_marks, ReplayedMotion as ReplayedMotion
    from .source_thread import Reading as Reading
