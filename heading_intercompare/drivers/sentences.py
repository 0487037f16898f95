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

"""
The heading sentences: how to recognise and read each kind, and what is rejected.

A heading is a number from 0 to 360; 360 is read as 0. Fields may be padded with blanks. The logs
of NovAtel and Unicore receivers, which begin with `#` or `%`, are sentences too. Their text keeps
that sign, and a semicolon divides fields as a comma does.
"""

from __future__ import annotations

from bisect import bisect_right
from functools import lru_cache, partial
import re
from typing import Callable, NamedTuple


class Rejected(Exception):
    """A sentence gives no heading; `reason` names the count it goes to."""

    def __init__(self, reason: str) -> None:
        super().__init__(reason)
        self.reason = reason


class Name(NamedTuple):
    """Kind of a heading sentence and its talker; a proprietary sentence has none."""

    kind: str
    talker: str

    def __str__(self) -> str:
        """Return the start of the sentence: talker, then kind."""
        return f'{self.talker}{self.kind}'


is_number = re.compile(rb' *[+-]?(?:\d+\.?\d*|\.\d+) *\Z').match
"""Tells whether a field is a number, perhaps padded with blanks."""

_is_pashr = re.compile(rb'PASHR,(?:ATT,|,|\d)').match


def identify(text: bytes) -> Name | None:
    """
    Return the name of a heading sentence, or None for any other sentence.

    PASHR is accepted in the form of POS MV and Seapath, where a time or an empty field follows,
    and as PASHR,ATT. PASHR,HPR and PASHR,AT2 are other kinds; other PASHR are not headings.

    Examples
    --------
    >>> identify(b'HEHDT,218.53,T')
    Name(kind='HDT', talker='HE')

    """
    if text[:1] not in _MAKERS:
        return _parse_name(text[:6])
    if _is_pashr(text):
        return Name('PASHR', '')
    words = text.lstrip(b'#%').split(b',', 2)
    name = _PROPRIETARY.get(b','.join(words[:2])) if len(words) > 2 else None
    if name is None and len(words) > 1:
        name = _PROPRIETARY.get(words[0])
    return name if name or text[:1] == b'P' else _parse_name(text[:6])


@lru_cache(maxsize=256)
def _parse_name(start: bytes) -> Name | None:
    kind = start[2:5].decode('latin-1')
    if kind in PARSERS and start[5:] == b',' and start[:2].isalnum():
        return Name(kind, start[:2].decode('latin-1'))
    return None


def field_of(fields: list[bytes], index: int) -> bytes:
    """Return a field of a sentence; raises Rejected if the sentence is too short."""
    if len(fields) <= index:
        raise Rejected('too_few_fields')
    return fields[index]


def _number(fields: list[bytes], index: int) -> float:
    text = field_of(fields, index)
    if not is_number(text):
        raise Rejected('bad_field' if text.strip() else 'empty_heading')
    return float(text)


def _heading(fields: list[bytes], index: int) -> float:
    heading_deg = _number(fields, index)
    if not -180.0 <= heading_deg <= 360.0:
        raise Rejected('out_of_range')
    # Some devices count from minus 180.
    return heading_deg % 360.0


def _scaled_heading(fields: list[bytes], index: int, scale: float) -> float:
    """Return a heading whose number, times `scale`, is degrees clockwise."""
    heading_deg = _number(fields, index) * abs(scale)
    # Radians of four decimals round a full turn up.
    if not -180.0 <= heading_deg <= 360.036:
        raise Rejected('out_of_range')
    return _wrap(heading_deg if scale > 0.0 else -heading_deg)


def _wrap(heading_deg: float) -> float:
    """Return an angle in [0, 360); `wrap360` would load numpy, which settings do without."""
    wrapped_deg = heading_deg % 360.0
    # A tiny negative angle rounds to 360.
    return 0.0 if wrapped_deg == 360.0 else wrapped_deg


def _true_heading(fields: list[bytes], index: int) -> float:
    """Return a heading whose next field must be T."""
    heading_deg = _heading(fields, index)
    if field_of(fields, index + 1).strip() != b'T':
        raise Rejected('not_true')
    return heading_deg


def _parse_hdt(fields: list[bytes]) -> float:
    """Read `xxHDT,heading,T`."""
    return _true_heading(fields, 1)


def _parse_ths(fields: list[bytes]) -> float:
    """
    Read `xxTHS,heading,mode`; only mode A, autonomous, is a measurement of the sensor.

    V means not valid, S simulator, M manual input, E dead reckoning or a back-up sensor.
    """
    mode = field_of(fields, 2).strip().decode('latin-1')
    if mode != 'A':
        raise Rejected(f'invalid_mode.{mode if mode in ("E", "M", "S", "V") else "other"}')
    return _heading(fields, 1)


def _parse_pashr(fields: list[bytes]) -> float:
    """
    Read `PASHR,time,heading,T,roll,pitch,heave,...` or `PASHR,ATT,time,heading,pitch,roll,...`.

    No flag rejects a heading: their meaning differs from maker to maker. `PASHR_FORMS` has what
    they agree on.
    """
    return _heading(fields, 3) if fields[1] == b'ATT' else _true_heading(fields, 2)


class Form(NamedTuple):
    """
    Which field of a sentence of a maker tells what; the address has number 0.

    Attributes
    ----------
    heading
        Field of the heading.
    quality
        Field of the quality; 0 if there is none.
    measured
        What the sentence begins with from that field on, if the heading is a measurement.
    time
        Field of the time, UTC; 0 if there is none, or if the header of a log has it.
    clock : {'hhmmss', 'yyyymmddhhmmss', 'epoch', 'week'}
        What the time is: a time of day, with its date, seconds since 1970, or the week of GPS,
        whose second is in the next field.
    timed
        What the field after that of the time begins with, if the time is valid; '': anything.
    scale
        Degrees clockwise of one unit of the number.
    magnetic
        Whether the heading is magnetic.
    checksum
        Whether the sentence has one.
    grades
        What the sentence begins with from the field of the quality on, and what that says of a
        measurement, a word of `QUALITY_FLAGS`; the first that fits. Without one it is unknown.
    stated
        Field of the standard deviation that the sensor claims for the heading, degrees; 0 if
        there is none.

    """

    heading: int
    quality: int = 0
    measured: str = ''
    time: int = 0
    clock: str = 'hhmmss'
    timed: str = ''
    scale: float = 1.0
    magnetic: bool = False
    checksum: bool = True
    grades: tuple[tuple[str, str], ...] = ()
    stated: int = 0


_FLOAT, _CODE, _INERTIAL = 'float solution', 'code solution', 'inertial only'
_RTK = (('4', 'normal'), ('5', _FLOAT), ('[123]', _CODE))
_TRIMBLE = (('0*3', 'normal'), ('0*2', _FLOAT), ('0*[14]', _CODE))
_SOLUTION = ((r'\w+, *\w*(INT|FIXED) *,', 'normal'), (r'\w+, *\w*FLOAT *,', _FLOAT),
             (r'\w+, *(SINGLE|PSRDIFF|WAAS|SBAS|PROPAGATED) *,', _CODE))
_INS_STATUS = (('INS_SOLUTION_GOOD', 'normal'), ('INS_SOLUTION_FREE', _INERTIAL))

_SOLVED, _GOOD = 'SOL_COMPUTED,(?!NONE,)', 'INS_SOLUTION_(GOOD|FREE)'

FORMS: dict[str, Form] = {
    'PSXN,23': Form(4),
    'PUHAW,UVH': Form(4, checksum=False),
    # Trimble: 0 is no fix. The yaw is that from one antenna to the other.
    'PTNL,AVR': Form(3, 10, '0*[1-9]', time=2, grades=_TRIMBLE),
    'PTNL,VHD': Form(4, 10, '0*[1-9]', time=2, grades=_TRIMBLE),
    # Hemisphere: N is GNSS; G is a gyro that stands in for it, as E of THS.
    'PSAT,HPR': Form(3, 6, 'N', time=2),
    # Septentrio: 0 is no attitude; 1 and 3 are float, 2 and 4 fixed.
    'PSSN,HRP': Form(4, 11, '0*[1-4]', time=2, stated=7,
                     grades=(('0*[24]', 'normal'), ('0*[13]', _FLOAT))),
    # Unicore: 0 is invalid, 4 fixed, 5 float.
    'HPR': Form(2, 5, '[1-5]', time=1, grades=_RTK),
    'KSXT': Form(5, 11, '[1-3]', time=1, clock='yyyymmddhhmmss',
                 grades=(('3', 'normal'), ('2', _FLOAT), ('1', _CODE))),
    # NovAtel, and what others write in its way. The header has ten fields, or three after `%`.
    'UNIHEADINGA': Form(13, 10, _SOLVED, grades=_SOLUTION, stated=16),
    'HEADINGA': Form(13, 10, _SOLVED, grades=_SOLUTION, stated=16),
    'HEADING2A': Form(13, 10, _SOLVED, grades=_SOLUTION, stated=16),
    'DUALANTENNAHEADINGA': Form(13, 10, _SOLVED, grades=_SOLUTION, stated=16),
    'INSPVAA': Form(20, 21, _GOOD, time=10, clock='week', grades=_INS_STATUS),
    'INSPVAXA': Form(21, 10, _GOOD, grades=_INS_STATUS, stated=30),
    'INSPVASA': Form(13, 14, _GOOD, time=3, clock='week', grades=_INS_STATUS),
    'INSATTA': Form(14, 15, _GOOD, time=10, clock='week', grades=_INS_STATUS),
    'INSATTXA': Form(14, 10, _GOOD, grades=_INS_STATUS, stated=17),
    'INSATTSA': Form(7, 8, _GOOD, time=3, clock='week', grades=_INS_STATUS),
    # Furuno and JRC, and RDI: they leave the heading empty without one.
    'PFEC,GPatt': Form(2),
    'PRDID': Form(3),
    # ComNav, and Unicore: 0 is invalid, 4 fixed, 5 float. YBM has another quality of its position.
    'TRA': Form(2, 5, '[1-5]', time=1, grades=_RTK),
    'YBM': Form(6, 17, '[45]', time=2, grades=_RTK),
    # Quectel: 4 is fixed, 5 float, 6 dead reckoning.
    'PQTMTAR': Form(8, 3, '[45]', time=2, grades=_RTK, stated=11),
    # Ashtech: the last flag of AT2 and PAT is 0 unless the attitude is a rough one.
    'PASHR,HPR': Form(3, time=2),
    'PASHR,AT2': Form(3, 8, '0'),
    'PAT': Form(7, 12, '0', time=1),
    # iXblue: T is valid, E invalid, I initialising; of the time, too.
    'PHOCT': Form(5, 6, 'T', time=2, timed='T'),
    # SBG: 1 is valid, 2 degraded while it aligns. Its time may lack the leap seconds.
    'PSBGB': Form(6, 11, '1', time=2, timed='[12]'),
    # VectorNav: the two lowest bits of the status are 2 while the filter tracks.
    'INS': Form(4, 3, r'[0-9A-Fa-f]{0,3}[26AaEe](?:,|\Z)'),
}
"""The sentences of makers, after their manuals."""

PASHR_FORMS = {
    # Makers agree that 0 is a heading without GNSS. 1 is a sound heading of some, a poor one of
    # others; the flag of the IMU has no meaning in common.
    b'': Form(2, 10, grades=(('0', 'no GNSS aiding'), ('6', _INERTIAL), ('[2-5]', 'normal')),
              stated=9),
    b'ATT': Form(3, 8, grades=(('0', 'normal'), ('1', 'rough attitude'))),
}
"""The quality in the two forms of PASHR, by the field that tells them apart."""


class Compass(NamedTuple):
    """
    What is stated of a magnetic compass, for sentences that do not say it themselves.

    Attributes
    ----------
    variation_deg
        Degrees to the east; None: unknown.
    deviations_deg
        Headings of the compass in rising order, each with the deviation there, degrees to the
        east; empty: it has none.

    """

    variation_deg: float | None = None
    deviations_deg: tuple[tuple[float, float], ...] = ()

    def magnetic_heading(self, compass_deg: float) -> float:
        """Return the magnetic heading; the deviation is interpolated on the circle."""
        rows = self.deviations_deg
        if not rows:
            return compass_deg
        at = bisect_right(rows, (compass_deg, 181.0))
        (low_deg, low), (high_deg, high) = rows[at - 1], rows[at % len(rows)]
        span_deg = (high_deg - low_deg) % 360.0
        share = (compass_deg - low_deg) % 360.0 / span_deg
        return compass_deg + low + (high - low) * share


UNSTATED = Compass()
"""A compass of which nothing is stated."""

_measured = lru_cache(maxsize=256)(lambda form: re.compile(form.measured.encode()).match)


class OwnSentence(NamedTuple):
    """
    A sentence that the user describes; it comes before those of the table.

    Attributes
    ----------
    kind
        Three characters after any talker, or the start of the sentence up to a comma.
    form
        Its fields.

    """

    kind: str
    form: Form

    def identify(self, text: bytes) -> Name | None:
        """Return the name of such a sentence, and of others as `identify` does."""
        has_talker = len(self.kind) == _KIND_LENGTH
        start = text.lstrip(b'#%')[2 * has_talker:]
        if not start.startswith(b'%b,' % self.kind.encode()):
            return identify(text)
        return Name(self.kind, text[:2].decode('latin-1') if has_talker else '')


def form_of(name: Name | None, own_sentence: OwnSentence | None = None) -> Form | None:
    """Return the form of the sentences of this name; None for those with a parser of their own."""
    if own_sentence is not None and name is not None and name.kind == own_sentence.kind:
        return own_sentence.form
    return None if name is None else FORMS.get(name.kind)


def may_lack_checksum(name: Name | None, own_sentence: OwnSentence | None = None) -> bool:
    """Tell whether sentences of this name never have a checksum: PUHAW,UVH."""
    form = form_of(name, own_sentence)
    return form is not None and not form.checksum


def split_fields(text: bytes) -> list[bytes]:
    """Return the fields of a sentence; the header of a log of a receiver ends in a semicolon."""
    return (text.replace(b';', b',') if text[:1] in (b'#', b'%') else text).split(b',')


def find_time(name: Name, text: bytes, own_sentence: OwnSentence | None = None) -> tuple[int, str]:
    """Return the field of the time in a heading sentence, 0 without one, and what the time is."""
    form = form_of(name, own_sentence)
    if form is not None:
        if form.timed and not re.match(form.timed.encode(), field_of(
                split_fields(text), form.time + 1).strip()):
            return 0, form.clock
        return form.time, 'week' if text[:1] in (b'#', b'%') else form.clock
    return int(name.kind == 'PASHR' and not text.startswith(b'PASHR,ATT')), 'hhmmss'


def _parse_form(form: Form, fields: list[bytes], compass: Compass = UNSTATED) -> float:
    """Read a sentence of a maker by its row of `FORMS`."""
    if form.quality:
        field_of(fields, form.quality)
        if not _measured(form)(b','.join(fields[form.quality:])):
            raise Rejected('invalid_quality')
    heading_deg = (_heading(fields, form.heading) if form.scale == 1.0 else
                   _scaled_heading(fields, form.heading, form.scale))
    return _true_of_compass(heading_deg, compass) if form.magnetic else heading_deg


def _east(fields: list[bytes], index: int) -> float | None:
    """Return a value and its side, E or W, as degrees to the east; None if empty."""
    text, side = field_of(fields, index), field_of(fields, index + 1).strip()
    if not text.strip():
        return None
    value_deg = float(text) if is_number(text) else float('nan')
    if not -180.0 <= value_deg <= 180.0 or (side not in (b'E', b'W') and value_deg != 0.0):
        raise Rejected('bad_field')
    return -value_deg if side == b'W' else value_deg


def _add_variation(magnetic_deg: float, variation_deg: float | None) -> float:
    """Return a true heading; raises Rejected without a variation, degrees to the east."""
    if variation_deg is None:
        raise Rejected('no_variation')
    return _wrap(magnetic_deg + variation_deg)


def _true_of_compass(compass_deg: float, compass: Compass) -> float:
    """Return the true heading of a compass of which only that is known which is stated."""
    return _add_variation(compass.magnetic_heading(compass_deg), compass.variation_deg)


def _parse_hdg(fields: list[bytes], compass: Compass = UNSTATED) -> float:
    """
    Read `xxHDG,sensor heading,deviation,E/W,variation,E/W`; E is added, W subtracted.

    An empty deviation is that of the stated table, without one 0. Without variation, also a
    stated one, the true heading is unknown.
    """
    sensor_deg = _heading(fields, 1)
    deviation_deg, variation_deg = _east(fields, 2), _east(fields, 4)
    return _add_variation(compass.magnetic_heading(sensor_deg) if deviation_deg is None
                          else sensor_deg + deviation_deg,
                          compass.variation_deg if variation_deg is None else variation_deg)


def _parse_hdm(fields: list[bytes], compass: Compass = UNSTATED) -> float:
    """Read `xxHDM,heading,M`, a magnetic heading without its variation."""
    magnetic_deg = _heading(fields, 1)
    if field_of(fields, 2).strip() != b'M':
        raise Rejected('bad_field')
    return _true_of_compass(magnetic_deg, compass)


def _parse_vhw(fields: list[bytes], compass: Compass = UNSTATED) -> float:
    """Read `xxVHW,heading,T,heading,M,speed,N,speed,K`; the magnetic one if the true is empty."""
    if field_of(fields, 1).strip() or not field_of(fields, 3).strip():
        return _true_heading(fields, 1)
    return _parse_hdm([fields[0], *fields[3:]], compass)


MAGNETIC: dict[str, Callable[[list[bytes], Compass], float]] = {
    'HDG': _parse_hdg, 'VHW': _parse_vhw, 'HDM': _parse_hdm}
"""Parsers of sentences that may need what is stated of the compass."""


_AS_FORM = {kind: partial(_parse_form, form) for kind, form in FORMS.items()}

#: Kind of sentence -> its parser, from fields with the address to heading [deg]; raises Rejected.
#: The best kind comes first; one with a comma is the start of a proprietary sentence.
PARSERS: dict[str, Callable[[list[bytes]], float]] = {
    'THS': _parse_ths,
    'HDT': _parse_hdt,
    'PASHR': _parse_pashr,
    'PSXN,23': _AS_FORM['PSXN,23'],
    'PUHAW,UVH': _AS_FORM['PUHAW,UVH'],
    'HDG': _parse_hdg,
    **_AS_FORM,
    'VHW': _parse_vhw,
    'HDM': _parse_hdm,
}

#: Kinds of this length come after a talker.
_KIND_LENGTH = 3
_PROPRIETARY = {kind.encode(): Name(kind, '') for kind in FORMS if len(kind) != _KIND_LENGTH}
_MAKERS = frozenset(b'%c' % first for first in b'PK#%')


@lru_cache(maxsize=1 << 16)
def heading_of(text: bytes, compass: Compass = UNSTATED,
               own_sentence: OwnSentence | None = None) -> float:
    """
    Return the heading in a sentence.

    Parameters
    ----------
    text
        The text between `$` and `*` of a sentence that `identify` knows. A gyrocompass repeats
        itself, so the last 65536 texts are cached (16 MB).
    compass
        What is stated for magnetic headings.
    own_sentence
        A sentence that the user describes.

    Returns
    -------
    float
        Degrees in [0, 360).

    Raises
    ------
    Rejected
        If it gives no heading; `reason` says why.

    Examples
    --------
    >>> heading_of(b'SDHDG,229.5,,,1.5,E')
    231.0

    """
    name = identify(text) if own_sentence is None else own_sentence.identify(text)
    assert name is not None
    if own_sentence is not None and name.kind == own_sentence.kind:
        return _parse_form(own_sentence.form, split_fields(text), compass)
    if compass is not UNSTATED and name.kind in MAGNETIC:
        return MAGNETIC[name.kind](split_fields(text), compass)
    return PARSERS[name.kind](split_fields(text))
