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
from heading_intercompare.core.units.full_turns import full_turn

AXES = ('enu', 'ned')
"""World axes: angles from east over north, or from north over east."""

LOG_TIME, PUBLISH_TIME = CLOCKS = ('log_time', 'publish_time')
"""Times that a recording keeps beside a message: when it was written, and when it was sent."""


class HeadingPlace(NamedTuple):
    """
    Where the headings of a sensor are.

    Attributes
    ----------
    topic
        Name of the topic.
    part
        What to take from its messages: a field, a sentence, or the frames of a transform; '' for
        what their type has.
    unit
        Unit of that field (`full_turn`); '' where nobody states it.
    axes : {'', 'enu', 'ned'}
        World axes of that field; '' where nobody states them.
    clock : {'', 'log_time', 'publish_time'}
        Where the stamps come from, if not from the headers.

    """

    topic: str
    part: str
    unit: str = ''
    axes: str = ''
    clock: str = ''

    @property
    def names_frames(self) -> bool:
        """Whether the part is two frames of TF, for whose topic any number of nodes publish."""
        return ':' in self.part


def locate_headings(text: str, unit: str = 'auto') -> HeadingPlace:
    """
    Return where the headings of a sensor are.

    Parameters
    ----------
    text
        ``TOPIC``, ``TOPIC.PART``, or ``TOPIC.PART`` and words after it, each after an @, for unit,
        axes and clock. No name of a topic has a dot.
    unit
        The unit that a setting states, 'auto' if none. Without any the name of the field says it.

    Raises
    ------
    SettingsError
        If a word is unknown, or is one of two of a kind.

    Examples
    --------
    >>> place = locate_headings('gps/attitude.heading@rad@enu')
    >>> place.topic, place.part, place.unit, place.axes
    ('gps/attitude', 'heading', 'rad', 'enu')
    >>> locate_headings('gps/attitude.yaw_rad').unit, locate_headings('nmea.HEHDT').part
    ('rad', 'HEHDT')

    """
    topic, _, part = text.partition('.')
    part, *words = part.split('@')
    stated: dict[str, str] = {}
    for word in words:
        kind = 'axes' if word in AXES else 'clock' if word in CLOCKS else 'unit'
        if stated.setdefault(kind, word) != word:
            raise SettingsError(f'{text}: states both {stated[kind]} and {word}; leave one out')
    try:
        full_turn(stated.get('unit', 'deg'))
    except ValueError as error:
        raise SettingsError(f'{text}: {error}; or one of {", ".join(AXES + CLOCKS)}') from None
    named = find_named_unit(part) or ''
    default = named if unit == 'auto' else unit
    return HeadingPlace(topic, part, stated.get('unit', default), stated.get('axes', ''),
                        stated.get('clock', ''))
