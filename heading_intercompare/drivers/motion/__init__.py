# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The motion of the ship in NMEA sentences: positions, courses over ground, rates of turn."""

from typing import TYPE_CHECKING

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'attitude_log': ('LoggedAttitude', 'read_log_attitude'),
    'motion_decoder': ('MotionDecoder',),
    'motion_lines': ('MotionLines',),
    'motion_log': ('LoggedMotion', 'read_log_motion'),
    'motion_sentences': ('MOTION_KINDS', 'parse_motion'),
})
if TYPE_CHECKING:
    # The same names for type checkers, by ``make docs``.
    from .attitude_log import (
        LoggedAttitude as LoggedAttitude,
        read_log_attitude as read_log_attitude,
    )
    from .motion_decoder import MotionDecoder as MotionDecoder
    from .motion_lines import MotionLines as MotionLines
    from .motion_log import LoggedMotion as LoggedMotion, read_log_motion as read_log_motion
    from .motion_sentences import MOTION_KINDS as MOTION_KINDS, parse_motion as parse_motion
