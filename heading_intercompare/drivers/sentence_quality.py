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

"""What sentences say of the quality of a heading: the flags of a sensor, and its own accuracy."""

from __future__ import annotations

from functools import lru_cache
import math
import re
from typing import Mapping

from heading_intercompare.core.records import (
    ColumnBuffer,
    NORMAL_QUALITY,
    Quality,
    QUALITY_FLAGS,
    UNKNOWN_QUALITY,
)

from .sentences import Form, form_of, is_number, Name, OwnSentence, PASHR_FORMS, split_fields

_NONE = math.nan
_LARGEST_DEG = 180.0
_UNKNOWN = _NONE, UNKNOWN_QUALITY
#: Of PSXN,20: the third figure is that of the heading.
_PSXN = {b'0': 'normal', b'1': 'reduced performance', b'2': 'invalid by PSXN,20'}
#: Whose HDT may be that of the instrument that sends PSXN,20.
_SEAPATH_TALKERS = ('GP', 'GN', 'IN')
_GGA = {**dict.fromkeys((b'1', b'2', b'3', b'4', b'5', b'9'), 'normal'), b'0': 'no position',
        b'6': 'estimated position', b'7': 'position set by hand', b'8': 'simulated position'}

_begins = lru_cache(maxsize=256)(lambda text: re.compile(rf' *(?:{text})'.encode()).match)


def quality_of(name: Name, text: bytes,
               own_sentence: OwnSentence | None = None) -> tuple[float, int]:
    """
    Return what a sentence that gives a heading says of it itself.

    Parameters
    ----------
    name, text
        Of the sentence.
    own_sentence
        A sentence that the user describes.

    Returns
    -------
    stated_deg, flag
        Claimed standard deviation, degrees, nan without one; index of `QUALITY_FLAGS`.

    Examples
    --------
    >>> name = Name('PASHR', '')
    >>> quality_of(name, b'PASHR,120000,74.52,T,-1.63,1.51,0.14,0.020,0.020,0.012,2,1')
    (0.012, 1)
    >>> quality_of(name, b'PASHR,120000,74.52,T,-1.63,1.51,0.14,0.020,0.020,0.350,0,1')
    (0.35, 5)

    """
    form = form_of(name, own_sentence)
    if name.kind == 'PASHR' and form is None:
        form = PASHR_FORMS[b'ATT' if text.startswith(b'PASHR,ATT') else b'']
    if form is None or not (form.grades or form.stated):
        return _UNKNOWN
    fields = split_fields(text)
    return _read_stated(fields, form), _read_flag(fields, form)


def _read_stated(fields: list[bytes], form: Form) -> float:
    """Return the claim; nan without one, and for a number that no claim can be."""
    if not form.stated or len(fields) <= form.stated or not is_number(fields[form.stated]):
        return _NONE
    stated_deg = float(fields[form.stated])
    return stated_deg if 0.0 < stated_deg <= _LARGEST_DEG else _NONE


def _read_flag(fields: list[bytes], form: Form) -> int:
    rest = b','.join(fields[form.quality:])
    return next((QUALITY_FLAGS.index(words) for begin, words in form.grades
                 if _begins(begin)(rest)), UNKNOWN_QUALITY)


class QualityListener:
    """
    Gathers what the sentences of a stream say of the quality of its headings.

    A PSXN,20 holds for the headings of a Seapath until the next one, and a GGA for those of its
    talker: a GNSS compass. Of readings in a row of which it is the same, the first and the last
    have a row.

    Parameters
    ----------
    name
        The sentence of the headings; None if there is none.
    own_sentence
        A sentence that the user describes.

    Attributes
    ----------
    listens : bool
        Whether something was said of the headings to come, or they may say it themselves.

    """

    def __init__(self, name: Name | None, own_sentence: OwnSentence | None = None) -> None:
        self._name, self._own_sentence = name, own_sentence
        form = form_of(name, own_sentence)
        self.listens = name is not None and (
            name.kind == 'PASHR' or form is not None and bool(form.grades or form.stated))
        self._has_psxn = name is not None and (
            name.kind == 'PSXN,23' or name.kind == 'HDT' and name.talker in _SEAPATH_TALKERS)
        self._gga = b'%bGGA,' % name.talker.encode() if name and name.talker else None
        self._by_gga = self._by_psxn = UNKNOWN_QUALITY
        self._rows = ColumnBuffer(2)
        self._said = _UNKNOWN
        self._last_ns: int | None = None

    def note(self, text: bytes) -> None:
        """Take a sentence without a heading: a PSXN,20 or a GGA says something of later ones."""
        if text[:6] == self._gga:
            self._by_gga, self.listens = _look_up(_GGA, text, 6), True
        elif self._has_psxn and text[:8] == b'PSXN,20,':
            self._by_psxn, self.listens = _look_up(_PSXN, text, 4), True

    def hear(self, text: bytes, stamp_ns: int) -> None:
        """Take a sentence that gave a heading with this stamp."""
        assert self._name is not None
        stated_deg, flag = quality_of(self._name, text, self._own_sentence)
        flags = (flag, self._by_psxn, self._by_gga)
        flag = next((poor for poor in flags if poor > NORMAL_QUALITY), max(flags))
        if (stated_deg, flag) == self._said:
            self._last_ns = stamp_ns
            return
        self._add_last()
        self._said = stated_deg, flag
        self._rows.add(stamp_ns, stated_deg, flag)

    def _add_last(self) -> None:
        """Add the last of several readings of which the same was said."""
        if self._last_ns is not None:
            self._rows.add(self._last_ns, *self._said)
        self._last_ns = None

    def drain(self, *, end: bool = False) -> Quality:
        """Return the new rows, and begin again without rows; `end` adds the last reading."""
        if end:
            self._add_last()
        stamp_ns, stated_deg, flag = self._rows.drain()
        return Quality.of(stamp_ns, stated_deg, flag.astype('int64'))


def says_quality(text: bytes) -> bool:
    """Tell whether a sentence without a heading may say something of headings."""
    return text[2:6] == b'GGA,' or text[:8] == b'PSXN,20,'


def _look_up(words_of: Mapping[bytes, str], text: bytes, at: int) -> int:
    """Return the flag that a field of a sentence says."""
    words = words_of.get((text.split(b',') + [b''] * (at + 1))[at].strip())
    return UNKNOWN_QUALITY if words is None else QUALITY_FLAGS.index(words)
