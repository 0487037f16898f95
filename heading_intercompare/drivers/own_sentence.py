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

"""A sentence that the user describes in one line of the settings, as a row of `FORMS`."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
import re

from heading_intercompare.core.declared_settings import (
    Checked,
    read_row,
    setting,
    SettingsError,
)
from heading_intercompare.core.units.full_turns import ANGLE_UNITS

from .sentences import Form, OwnSentence

_CLOCKS = ('hhmmss', 'yyyymmddhhmmss', 'epoch', 'week')
_is_kind = re.compile(r'[A-Z0-9]{3}|[A-Z]{2}[A-Z0-9]*(?:,[A-Za-z0-9]+)*').fullmatch


@dataclass(frozen=True, slots=True)
class OwnFields(Checked):
    """The fields of such a sentence; that up to the first comma has number 0."""

    heading: int = setting(0, 'field of the heading', 0, 1000)
    unit: str = setting('deg', 'unit of the heading', choices=(*ANGLE_UNITS,))
    scale: float = setting(1.0, 'what the number is multiplied by to give that unit', 0.0)
    sign: str = setting('+', "'+': the heading grows clockwise, '-': anticlockwise",
                        choices=('+', '-'))
    north: str = setting('true', 'north of the heading; a magnetic one takes `variation_deg`',
                         choices=('true', 'magnetic'))
    quality: int = setting(0, 'field of the quality; 0: none', 0, 1000)
    valid: str = setting('', 'what that field has if the heading is valid; several with commas')
    time: int = setting(0, 'field of the time, UTC; 0: none', 0, 1000)
    clock: str = setting('hhmmss', "what the time is; 'epoch': seconds since 1970, 'week': week "
                         'of GPS, with its second in the next field', choices=_CLOCKS)
    checksum: str = setting(
        'required', "'required': two digits (or one) of exclusive or, four of CRC-16, eight of "
        "CRC-32; 'none': the sentence has none", choices=('required', 'none'))

    def __post_init__(self) -> None:
        """Check what belongs together."""
        Checked.__post_init__(self)
        if self.scale == 0.0:
            raise SettingsError('scale = 0.0: must be greater than 0')
        if bool(self.quality) != bool(self.valid):
            raise SettingsError('quality and valid belong together: quality is the number of a '
                                'field, valid what it has if the heading is valid')
        if self.clock != 'hhmmss' and not self.time:
            raise SettingsError(f'clock = {self.clock!r}: needs time, the field of the time')

    @property
    def form(self) -> Form:
        """Return the row for the table of sentences."""
        valid = '|'.join(re.escape(word) for word in self.valid.split(','))
        scale = self.scale * (360.0 / ANGLE_UNITS[self.unit]) * (-1.0 if self.sign == '-' else 1.0)
        return Form(self.heading, self.quality, rf' *(?:{valid}) *(?:,|\Z)' * bool(self.quality),
                    self.time, self.clock, scale=scale, magnetic=self.north == 'magnetic',
                    checksum=self.checksum == 'required')


@lru_cache(maxsize=64)
def read_own_sentence(text: str | None) -> OwnSentence | None:
    """
    Return the sentence that a line describes; None if there is no line.

    Parameters
    ----------
    text
        Its identifier, then ``setting=value`` of `OwnFields` in any order. An identifier of three
        characters comes after any talker; another one is the start of the sentence.

    Raises
    ------
    ValueError
        If the line is wrong: what, where, what is allowed.

    Examples
    --------
    >>> own = read_own_sentence('PXYZ,ATT heading=3 scale=0.01 sign=-')
    >>> own.kind, own.form.heading, own.form.scale
    ('PXYZ,ATT', 3, -0.01)

    """
    if text is None:
        return None
    kind, fields = read_row(text, OwnFields)
    if not _is_kind(kind):
        raise ValueError(f'{kind!r}: the line begins with the identifier of the sentence, without '
                         '$: XYZ after any talker, or its start up to a comma, such as PXYZ,ATT')
    numbers = (fields.heading, fields.quality, fields.time)
    if not fields.heading:
        raise ValueError('heading is missing: the number of the field of the heading; the field '
                         'up to the first comma has number 0')
    if in_kind := [number for number in numbers if 0 < number <= kind.count(',')]:
        raise ValueError(f'field {in_kind[0]} is part of the identifier {kind}; the field up to '
                         'the first comma has number 0')
    if len({*filter(None, numbers)}) < len([*filter(None, numbers)]):
        raise ValueError('two of heading, quality and time are the same field')
    return OwnSentence(kind, fields.form)
