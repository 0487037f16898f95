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

A heading is a number from 0 to 360; 360 is read as 0. Fields may be padded with blanks.
"""

from __future__ import annotations

from functools import lru_cache
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
    and as PASHR,ATT. Other PASHR sentences are not headings.

    Examples
    --------
    >>> identify(b'HEHDT,218.53,T')
    Name(kind='HDT', talker='HE')

    """
    if text[:1] != b'P':
        return _parse_name(text[:6])
    if _is_pashr(text):
        return Name('PASHR', '')
    for start, name in _PROPRIETARY.items():
        if text.startswith(start):
            return name
    return None


@lru_cache(maxsize=256)
def _parse_name(start: bytes) -> Name | None:
    kind = start[2:5].decode('latin-1')
    if kind in PARSERS and start[5:] == b',' and start[:2].isalnum():
        return Name(kind, start[:2].decode('latin-1'))
    return None


def may_lack_checksum(name: Name | None) -> bool:
    """Tell whether sentences of this name never have a checksum: PUHAW,UVH."""
    return name is not None and name.kind == 'PUHAW,UVH'


def field_of(fields: list[bytes], index: int) -> bytes:
    """Return a field of a sentence; raises Rejected if the sentence is too short."""
    if len(fields) <= index:
        raise Rejected('too_few_fields')
    return fields[index]


def _heading(fields: list[bytes], index: int) -> float:
    text = field_of(fields, index)
    if not is_number(text):
        raise Rejected('bad_field' if text.strip() else 'empty_heading')
    heading_deg = float(text)
    if not -180.0 <= heading_deg <= 360.0:
        raise Rejected('out_of_range')
    # Some devices count from minus 180.
    return heading_deg % 360.0


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

    The status flags of the first form are not used: their meaning differs from maker to maker.
    """
    return _heading(fields, 3) if fields[1] == b'ATT' else _true_heading(fields, 2)


def _parse_psxn23(fields: list[bytes]) -> float:
    """Read `PSXN,23,roll,pitch,heading,heave`."""
    return _heading(fields, 4)


def _parse_uvh(fields: list[bytes]) -> float:
    """Read `PUHAW,UVH,u,v,heading`, which UHDAS writes with its currents."""
    return _heading(fields, 4)


def _east(fields: list[bytes], index: int) -> float | None:
    """Return a value and its side, E or W, as degrees to the east; None if empty."""
    text, side = field_of(fields, index), field_of(fields, index + 1).strip()
    if not text.strip():
        return None
    value_deg = float(text) if is_number(text) else float('nan')
    if not -180.0 <= value_deg <= 180.0 or (side not in (b'E', b'W') and value_deg != 0.0):
        raise Rejected('bad_field')
    return -value_deg if side == b'W' else value_deg


def _parse_hdg(fields: list[bytes]) -> float:
    """
    Read `xxHDG,sensor heading,deviation,E/W,variation,E/W`; E is added, W subtracted.

    An empty deviation counts as 0. Without variation the true heading is unknown.
    """
    sensor_deg = _heading(fields, 1)
    deviation_deg, variation_deg = _east(fields, 2), _east(fields, 4)
    if variation_deg is None:
        raise Rejected('no_variation')
    heading_deg = (sensor_deg + (deviation_deg or 0.0) + variation_deg) % 360.0
    # A tiny negative angle rounds to 360. `wrap360` would load numpy, which settings do without.
    return 0.0 if heading_deg == 360.0 else heading_deg


#: Kind of sentence -> its parser, from fields with the address to heading [deg]; raises Rejected.
#: The best kind comes first; one with a comma is the start of a proprietary sentence.
PARSERS: dict[str, Callable[[list[bytes]], float]] = {
    'THS': _parse_ths,
    'HDT': _parse_hdt,
    'PASHR': _parse_pashr,
    'PSXN,23': _parse_psxn23,
    'PUHAW,UVH': _parse_uvh,
    'HDG': _parse_hdg,
}


_PROPRIETARY = {f'{kind},'.encode(): Name(kind, '') for kind in PARSERS if ',' in kind}


@lru_cache(maxsize=1 << 16)
def heading_of(text: bytes) -> float:
    """
    Return the heading in a sentence.

    Parameters
    ----------
    text
        The text between `$` and `*` of a sentence that `identify` knows. A gyrocompass repeats
        itself, so the last 65536 texts are cached (16 MB).

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
    name = identify(text)
    assert name is not None
    return PARSERS[name.kind](text.split(b','))
