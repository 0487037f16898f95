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

"""Where the headings of a sensor are: a topic, and what to take from its messages."""

from __future__ import annotations

from typing import NamedTuple

from heading_intercompare.core.declared_settings import SettingsError
from heading_intercompare.core.units.angle_units import find_named_unit
from heading_intercompare.core.units.full_turns import ANGLE_UNITS


class HeadingPlace(NamedTuple):
    """
    Where the headings of a sensor are.

    Attributes
    ----------
    topic
        Name of the topic.
    part
        What to take from its messages: a field, or a sentence; '' for what their type has.
    unit : {'deg', 'rad', 'rev'}
        Unit of that field.

    """

    topic: str
    part: str
    unit: str


def locate_headings(text: str) -> HeadingPlace:
    """
    Return where the headings of a sensor are.

    Parameters
    ----------
    text
        ``TOPIC``, ``TOPIC.PART`` or ``TOPIC.PART@UNIT``. No name of a topic has a dot. Without a
        unit the name of the field says it, or it is degrees.

    Raises
    ------
    SettingsError
        If the unit is unknown.

    Examples
    --------
    >>> locate_headings('gps/attitude.heading@rad')
    HeadingPlace(topic='gps/attitude', part='heading', unit='rad')
    >>> locate_headings('gps/attitude.yaw_rad').unit, locate_headings('nmea.HEHDT').part
    ('rad', 'HEHDT')

    """
    topic, _, part = text.partition('.')
    part, stated, unit = part.partition('@')
    if stated and unit not in ANGLE_UNITS:
        raise SettingsError(f'{text}: unit {unit!r} must be one of {", ".join(ANGLE_UNITS)}')
    return HeadingPlace(topic, part, unit or find_named_unit(part) or 'deg')
