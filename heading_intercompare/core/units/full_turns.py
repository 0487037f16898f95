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
"""The units of angles by their names, without numpy: settings and completion need only these."""

import math
import re

ANGLE_UNITS = {'deg': 360.0, 'rad': 2.0 * math.pi, 'rev': 1.0}
"""A full turn in each unit."""

_SCALED = re.compile(r'(\d+(?:\.\d+)?(?:[eE][+-]?\d+)?)([a-z]+)')


def full_turn(unit: str) -> float:
    """
    Return a full turn in a unit, which a number before its name may scale.

    Raises
    ------
    ValueError
        If there is no such unit.

    Examples
    --------
    >>> full_turn('deg'), full_turn('0.01deg'), full_turn('1e-5deg')
    (360.0, 36000.0, 36000000.0)

    """
    scaled = _SCALED.fullmatch(unit)
    scale, name = (float(scaled[1]), scaled[2]) if scaled else (1.0, unit)
    if name not in ANGLE_UNITS or not 0.0 < scale < math.inf:
        raise ValueError(f'unit {unit!r} must be one of {", ".join(ANGLE_UNITS)}, or a number '
                         'before one, such as 0.01deg')
    return ANGLE_UNITS[name] / scale
