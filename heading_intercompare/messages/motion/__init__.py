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
