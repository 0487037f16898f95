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
