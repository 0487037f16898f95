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

"""The sentences that tell the motion of the ship: VTG, RMC, GNS, GGA, GLL, ROT."""

from __future__ import annotations

import math
import re
from typing import Callable, NamedTuple

from heading_intercompare.core.records import FASTEST_M_S, FASTEST_TURN_DEG_S, KNOT_M_S
from heading_intercompare.drivers.sentences import Rejected

__all__ = ['COURSE', 'MOTION_KINDS', 'parse_motion', 'POSITION', 'RATE', 'Told']

POSITION, COURSE, RATE = 'position', 'course', 'rate'
_FASTEST_KN, _FASTEST_DEG_MIN = FASTEST_M_S / KNOT_M_S, 60.0 * FASTEST_TURN_DEG_S

_is_number = re.compile(rb' *[+-]?(?:\d+\.?\d*|\.\d+) *\Z').match
_is_angle = re.compile(rb'(\d{2,3})(\d\d(?:\.\d*)?)\Z').match


class Told(NamedTuple):
    """
    What a sentence tells.

    Attributes
    ----------
    what : str
        `POSITION`, `COURSE` or `RATE`.
    first, second : float
        Latitude and longitude in degrees; velocity to the east and the north in m/s; or the rate
        of turn in degrees per second to starboard, and nan.

    """

    what: str
    first: float
    second: float


def _number(fields: list[bytes], index: int, least: float, most: float) -> float:
    if len(fields) <= index:
        raise Rejected('too_few_fields')
    text = fields[index]
    if not text.strip():
        raise Rejected('empty')
    if not _is_number(text):
        raise Rejected('bad_field')
    value = float(text)
    if not least <= value <= most:
        raise Rejected('out_of_range')
    return value


def _field(fields: list[bytes], index: int) -> bytes:
    if len(fields) <= index:
        raise Rejected('too_few_fields')
    return fields[index].strip()


def _angle(fields: list[bytes], index: int, sides: bytes, most: float) -> float:
    """Return an angle written as degrees and minutes, and its side; degrees."""
    text, side = _field(fields, index), _field(fields, index + 1)
    if not text:
        raise Rejected('empty')
    match = _is_angle(text)
    if match is None or len(side) != 1 or side not in sides or float(match[2]) >= 60.0:
        raise Rejected('bad_field')
    angle = float(match[1]) + float(match[2]) / 60.0
    if angle > most:
        raise Rejected('out_of_range')
    return -angle if side in b'SW' else angle


def _position(fields: list[bytes], index: int) -> Told:
    return Told(POSITION, _angle(fields, index, b'NS', 90.0),
                _angle(fields, index + 2, b'EW', 180.0))


def _course(course_deg: float, speed_kn: float) -> Told:
    speed, course = speed_kn * KNOT_M_S, math.radians(course_deg)
    return Told(COURSE, speed * math.sin(course), speed * math.cos(course))


def _check_mode(fields: list[bytes], index: int) -> None:
    """Reject a mode that says that the data are not measured: N, E, M, S."""
    if len(fields) > index and fields[index].strip()[:1] in (b'N', b'E', b'M', b'S'):
        raise Rejected('invalid_mode')


def _parse_vtg(fields: list[bytes]) -> list[Told]:
    """Read `xxVTG,course,T,course,M,speed,N,speed,K,mode`; the speed in km/h if no other is."""
    _check_mode(fields, 9)
    if _field(fields, 2) != b'T':
        raise Rejected('not_true')
    course = _number(fields, 1, 0.0, 360.0)
    if _field(fields, 5):
        return [_course(course, _number(fields, 5, 0.0, _FASTEST_KN))]
    return [_course(course, _number(fields, 7, 0.0, 1.852 * _FASTEST_KN) / 1.852)]


def _parse_rmc(fields: list[bytes]) -> list[Told]:
    """Read `xxRMC,time,A,latitude,N,longitude,E,speed,course,date,variation,E,mode`."""
    if _field(fields, 2) != b'A':
        raise Rejected('invalid_mode')
    _check_mode(fields, 12)
    readings = [_position(fields, 3)]
    if _field(fields, 7) and _field(fields, 8):
        readings.append(_course(_number(fields, 8, 0.0, 360.0),
                                _number(fields, 7, 0.0, _FASTEST_KN)))
    return readings


def _parse_gga(fields: list[bytes]) -> list[Told]:
    """Read `xxGGA,time,latitude,N,longitude,E,quality,...`; 0, 6, 7 and 8 are no fixes."""
    if _field(fields, 6) in (b'', b'0', b'6', b'7', b'8'):
        raise Rejected('invalid_mode')
    return [_position(fields, 2)]


def _parse_gns(fields: list[bytes]) -> list[Told]:
    """Read `xxGNS,time,latitude,N,longitude,E,modes,...`; a mode per system, N for no fix."""
    if not set(_field(fields, 6)) - set(b'NEMS'):
        raise Rejected('invalid_mode')
    return [_position(fields, 2)]


def _parse_gll(fields: list[bytes]) -> list[Told]:
    """Read `xxGLL,latitude,N,longitude,E,time,A,mode`."""
    if len(fields) > 6 and fields[6].strip() == b'V':
        raise Rejected('invalid_mode')
    _check_mode(fields, 7)
    return [_position(fields, 1)]


def _parse_rot(fields: list[bytes]) -> list[Told]:
    """Read `xxROT,rate,A`: degrees per minute, negative to port."""
    if _field(fields, 2) != b'A':
        raise Rejected('invalid_mode')
    return [Told(RATE, _number(fields, 1, -_FASTEST_DEG_MIN, _FASTEST_DEG_MIN) / 60.0, math.nan)]


#: Kind of sentence -> what it tells, and its parser; of each, the earlier kind is preferred.
MOTION_KINDS: dict[str, tuple[tuple[str, ...], Callable[[list[bytes]], list[Told]]]] = {
    'VTG': ((COURSE,), _parse_vtg),
    'GNS': ((POSITION,), _parse_gns),
    'GGA': ((POSITION,), _parse_gga),
    'RMC': ((POSITION, COURSE), _parse_rmc),
    'GLL': ((POSITION,), _parse_gll),
    'ROT': ((RATE,), _parse_rot),
}


def parse_motion(text: bytes) -> list[Told]:
    """
    Return what a sentence tells of the motion of the ship.

    Parameters
    ----------
    text : bytes
        The text between `$` and `*`, of a kind in `MOTION_KINDS`.

    Raises
    ------
    Rejected
        If it tells nothing; `reason` says why.

    Examples
    --------
    >>> parse_motion(b'HEROT,-30.0,A')[0].first
    -0.5

    """
    fields = text.split(b',')
    return MOTION_KINDS[fields[0][2:5].decode('latin-1')][1](fields)
