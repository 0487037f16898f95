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

"""The sentences that tell the motion and the attitude of the ship."""

from __future__ import annotations

from functools import lru_cache
import math
import re
from typing import Callable, Mapping, NamedTuple

from heading_intercompare.core.motion.moved_rows import (
    make_attitude,
    make_position,
    make_rate,
    make_velocity,
    MovedRow,
)
from heading_intercompare.core.records import KNOT_M_S
from heading_intercompare.drivers.sentences import field_of, identify, is_number, Name, Rejected

MOTION_WORDS = {'fix': 'position', 'velocity': 'course', 'rate': 'rate'}
"""What a sentence tells, in a word for people."""

_KM_H_KN = 1.852

_is_angle = re.compile(rb'(\d{2,3})(\d\d(?:\.\d*)?)\Z').match


class Family(NamedTuple):
    """
    Sentences that tell one kind of record.

    Attributes
    ----------
    identify
        Returns the name of a sentence, None for a sentence of another family.
    parsers
        The parser of each kind of sentence, from its fields to rows; it raises `Rejected`. Of two
        kinds that tell one thing, the earlier is preferred.

    """

    identify: Callable[[bytes], Name | None]
    parsers: Mapping[str, Callable[[list[bytes]], list[MovedRow | None]]]

    def parse(self, name: Name, text: bytes) -> list[MovedRow]:
        """
        Return what a sentence of the family tells.

        Raises
        ------
        Rejected
            If it tells nothing; `reason` says why.

        """
        rows = [row for row in self.parsers[name.kind](text.split(b',')) if row is not None]
        if not rows:
            raise Rejected('out_of_range')
        return rows


def _number(fields: list[bytes], index: int) -> float:
    text = field_of(fields, index)
    if not is_number(text):
        raise Rejected('bad_field' if text.strip() else 'empty')
    return float(text)


def _angle(fields: list[bytes], index: int, sides: bytes) -> float:
    """Return an angle written as degrees and minutes, and its side; degrees."""
    text, side = (field_of(fields, at).strip() for at in (index, index + 1))
    if not text:
        raise Rejected('empty')
    match = _is_angle(text)
    if match is None or len(side) != 1 or side not in sides or float(match[2]) >= 60.0:
        raise Rejected('bad_field')
    angle = float(match[1]) + float(match[2]) / 60.0
    return -angle if side in b'SW' else angle


def _position(fields: list[bytes], index: int) -> MovedRow | None:
    return make_position(_angle(fields, index, b'NS'), _angle(fields, index + 2, b'EW'))


def _course(fields: list[bytes], index: int, speed_kn: float) -> MovedRow | None:
    course_deg = _number(fields, index)
    return None if course_deg > 360.0 else make_velocity(math.radians(course_deg),
                                                         speed_kn * KNOT_M_S)


def _check_mode(fields: list[bytes], index: int) -> None:
    """Reject a mode that says that the data are not measured: N, E, M, S."""
    if len(fields) > index and fields[index].strip()[:1] in (b'N', b'E', b'M', b'S'):
        raise Rejected('invalid_mode')


def _parse_vtg(fields: list[bytes]) -> list[MovedRow | None]:
    """Read `xxVTG,course,T,course,M,speed,N,speed,K,mode`; the speed in km/h if no other is."""
    _check_mode(fields, 9)
    if field_of(fields, 2).strip() != b'T':
        raise Rejected('not_true')
    _number(fields, 1)
    has_knots = field_of(fields, 5).strip()
    speed_kn = _number(fields, 5) if has_knots else _number(fields, 7) / _KM_H_KN
    return [_course(fields, 1, speed_kn)]


def _parse_rmc(fields: list[bytes]) -> list[MovedRow | None]:
    """Read `xxRMC,time,A,latitude,N,longitude,E,speed,course,date,variation,E,mode`."""
    if field_of(fields, 2).strip() != b'A':
        raise Rejected('invalid_mode')
    _check_mode(fields, 12)
    position = _position(fields, 3)
    if field_of(fields, 7).strip() and field_of(fields, 8).strip():
        course = _course(fields, 8, _number(fields, 7))
        return [position, course] if position and course else []
    return [position]


def _parse_gga(fields: list[bytes]) -> list[MovedRow | None]:
    """Read `xxGGA,time,latitude,N,longitude,E,quality,...`; 0, 6, 7 and 8 are no fixes."""
    if field_of(fields, 6).strip() in (b'', b'0', b'6', b'7', b'8'):
        raise Rejected('invalid_mode')
    return [_position(fields, 2)]


def _parse_gns(fields: list[bytes]) -> list[MovedRow | None]:
    """Read `xxGNS,time,latitude,N,longitude,E,modes,...`; a mode per system, N for no fix."""
    if not set(field_of(fields, 6).strip()) - set(b'NEMS'):
        raise Rejected('invalid_mode')
    return [_position(fields, 2)]


def _parse_gll(fields: list[bytes]) -> list[MovedRow | None]:
    """Read `xxGLL,latitude,N,longitude,E,time,A,mode`."""
    if len(fields) > 6 and fields[6].strip() == b'V':
        raise Rejected('invalid_mode')
    _check_mode(fields, 7)
    return [_position(fields, 1)]


def _parse_rot(fields: list[bytes]) -> list[MovedRow | None]:
    """Read `xxROT,rate,A`: degrees per minute, negative to port."""
    if field_of(fields, 2).strip() != b'A':
        raise Rejected('invalid_mode')
    return [make_rate(_number(fields, 1) / 60.0)]


def _parse_pashr(fields: list[bytes]) -> list[MovedRow | None]:
    """Read `PASHR,time,heading,T,roll,pitch,...`; the order of PASHR,ATT differs by maker."""
    if fields[1] == b'ATT':
        raise Rejected('unknown_form')
    return [make_attitude(_number(fields, 4), _number(fields, 5))]


def _parse_psxn23(fields: list[bytes]) -> list[MovedRow | None]:
    """Read `PSXN,23,roll,pitch,heading,heave`."""
    return [make_attitude(_number(fields, 2), _number(fields, 3))]


def _identify_motion(text: bytes) -> Name | None:
    return None if text[:1] == b'P' else _parse_name(text[:6])


@lru_cache(maxsize=256)
def _parse_name(start: bytes) -> Name | None:
    kind = start[2:5].decode('latin-1')
    is_motion = kind in MOTION.parsers and start[5:] == b','
    return Name(kind, start[:2].decode('latin-1')) if is_motion else None


MOTION = Family(_identify_motion, {
    'VTG': _parse_vtg, 'GNS': _parse_gns, 'GGA': _parse_gga, 'RMC': _parse_rmc,
    'GLL': _parse_gll, 'ROT': _parse_rot})
"""The sentences of positions, velocities over ground and rates of turn."""

ATTITUDE = Family(identify, {'PSXN,23': _parse_psxn23, 'PASHR': _parse_pashr})
"""The sentences of roll and pitch; both have roll with starboard down, and pitch with bow up."""
