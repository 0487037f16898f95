#!/usr/bin/env python3
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
"""The units in which callers and files give times and angles."""

from typing import TYPE_CHECKING

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'angle_units': ('AngleWatch', 'find_named_unit', 'read_angles'),
    'full_turns': ('ANGLE_UNITS',),
    'given_stamps': ('find_unit', 'integer_stamps', 'utc_stamps'),
})
if TYPE_CHECKING:
    # The same names for type checkers, by ``make docs``.
    from .angle_units import (
        AngleWatch as AngleWatch,
        find_named_unit as find_named_unit,
        read_angles as read_angles,
    )
    from .full_turns import ANGLE_UNITS as ANGLE_UNITS
    from .given_stamps import (
        find_unit as find_unit,
        integer_stamps as integer_stamps,
        utc_stamps as utc_stamps,
    )
