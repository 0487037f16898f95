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
