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

"""Logs with one JSON object per line: Signal K, gpsd and OpenRVDAS."""

from __future__ import annotations

import json
import math
import re
from typing import Any, Iterator, Mapping, TypeGuard

from heading_intercompare.bags.csv.stamp_cells import nanoseconds, utc_nanoseconds
from heading_intercompare.core.motion.moved_rows import (
    make_position,
    make_rate,
    make_velocity,
    MovedRow,
)
from heading_intercompare.core.records import KNOT_M_S
from heading_intercompare.core.units.angle_units import find_named_unit

from .stream_recording import Collected

_DELTA = re.compile(rb'^[^{\n]*\{.*"updates"\s*:', re.MULTILINE)
_RECORD = re.compile(rb'^\s*\{(?=.*"fields"\s*:)(?=.*"timestamp"\s*:)', re.MULTILINE)
_REPORT = re.compile(rb'\{(?=[^\n]*"class"\s*:\s*"(?:ATT|TPV|VERSION)")', re.MULTILINE)
_HEADING = re.compile(r'heading|hdg|hdt', re.IGNORECASE)
#: Names with these are of something else: rates, errors, qualities, or magnetic headings.
_OTHER = re.compile(r'rate|std|sd\b|sigma|err|acc|qual|flag|stat|mag|hdm|dev|var|valid',
                    re.IGNORECASE)
_TRUE, _MAGNETIC, _VARIATION = ('navigation.headingTrue', 'navigation.headingMagnetic',
                                'navigation.magneticVariation')
_COURSE, _SPEED, _POSITION, _RATE = (
    'navigation.courseOverGroundTrue', 'navigation.speedOverGround', 'navigation.position',
    'navigation.rateOfTurn')
_SELF = ('', 'vessels.self')
#: A course and a speed in two updates belong together if they are at most this far apart.
_TOGETHER_NS = 2 * 10 ** 9
#: A full turn, rounded up by a device that counts 1e-4 rad.
_TURN_RAD = 6.2832


def is_signalk(head: bytes) -> bool:
    """Tell whether a file that begins so has deltas of Signal K."""
    return _DELTA.search(head) is not None


def is_openrvdas(head: bytes) -> bool:
    """Tell whether a file that begins so has records of OpenRVDAS."""
    return _RECORD.search(head) is not None and b'"pgn"' not in head.partition(b'\n')[0]


def is_gpsd(head: bytes) -> bool:
    """Tell whether a file that begins so has reports of gpsd."""
    return _REPORT.search(head) is not None


def is_heading_name(name: str) -> bool:
    """
    Tell from its name whether a column or field is a true heading.

    Examples
    --------
    >>> [is_heading_name(name) for name in ('S330HeadingTrue', 'hdg', 'HeadingRate', 'lat')]
    [True, True, False, False]

    """
    return bool(_HEADING.search(name)) and not _OTHER.search(name)


def _objects(path: str, needed: bytes, collected: Collected) -> Iterator[dict[str, Any]]:
    """Yield the objects of the lines that contain some bytes; a logger may write before them."""
    with open(path, 'rb') as file:
        for line in file:
            at = line.find(b'{')
            if at < 0 or needed not in line:
                continue
            try:
                read = json.loads(line[at:])
            except (ValueError, RecursionError):
                collected.not_taken['bad_field'] += 1
                continue
            if isinstance(read, dict):
                yield read


def _utc_stamp(text: object) -> int | None:
    try:
        return utc_nanoseconds(str(text))
    except ValueError:
        return None


def _is_number(value: object) -> TypeGuard[float]:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and (
        math.isfinite(value))


def read_signalk(path: str) -> Collected:
    """
    Read deltas of Signal K, one per line, also after the time that a server writes.

    A stream is a source with the path, such as ``n2k.35/headingTrue``; one of another vessel
    begins with its context. Angles are radians. A magnetic heading gets the newest
    `navigation.magneticVariation` of its vessel; without one it is not taken.

    Of this vessel alone the motion is taken: `navigation.position`, `courseOverGroundTrue` with
    the newest `speedOverGround` of its source, and `rateOfTurn`.
    """
    collected = Collected()
    speeds: dict[str, tuple[int, float]] = {}
    own_contexts = set(_SELF)
    variations: dict[str, float] = {}
    for delta in _objects(path, b'', collected):
        if isinstance(delta.get('self'), str):
            own_contexts.add(delta['self'])
            own_contexts.add(f'vessels.{delta["self"].removeprefix("vessels.")}')
        context = str(delta.get('context') or '')
        vessel = '' if context in own_contexts else f'{context}/'
        for update in delta.get('updates') or ():
            if isinstance(update, dict):
                _take_update(collected, update, vessel, variations)
                if not vessel:
                    _take_motion(collected, update, speeds)
    return collected


def _take_motion(collected: Collected, update: Mapping[str, Any],
                 speeds: dict[str, tuple[int, float]]) -> None:
    entries = update.get('values') or ()
    values: dict[Any, Any] = {entry.get('path'): entry.get('value') for entry in entries
                              if isinstance(entry, dict)}
    stamp_ns = _utc_stamp(update.get('timestamp'))
    if stamp_ns is None:
        return
    source = _source(update)
    if _is_number(values.get(_SPEED)):
        speeds[source] = stamp_ns, float(values[_SPEED])
    place, course, rate = values.get(_POSITION), values.get(_COURSE), values.get(_RATE)
    if isinstance(place, dict):
        latitude, longitude = place.get('latitude'), place.get('longitude')
        collected.add_motion(
            make_position(latitude, longitude) if _is_number(latitude) and _is_number(longitude)
            else None, f'{source}/position', stamp_ns, why_none='position.bad_field')
    if _is_number(course):
        told_ns, speed = speeds.get(source, (0, 0.0))
        if abs(stamp_ns - told_ns) <= _TOGETHER_NS:
            collected.add_motion(make_velocity(course, speed), f'{source}/courseOverGroundTrue',
                                 stamp_ns, why_none='velocity.out_of_range')
        else:
            collected.not_taken['courseOverGroundTrue.no_speed'] += 1
    if _is_number(rate):
        collected.add_motion(make_rate(math.degrees(rate)), f'{source}/rateOfTurn', stamp_ns,
                             why_none='rateOfTurn.out_of_range')


def _take_update(collected: Collected, update: Mapping[str, Any], vessel: str,
                 variations: dict[str, float]) -> None:
    entries = update.get('values') or ()
    values: dict[Any, Any] = {entry.get('path'): entry.get('value') for entry in entries
                              if isinstance(entry, dict)}
    if _is_number(values.get(_VARIATION)):
        variations[vessel] = values[_VARIATION]
    for path in (_TRUE, _MAGNETIC):
        if path not in values:
            continue
        value, stamp_ns = values[path], _utc_stamp(update.get('timestamp'))
        if not _is_number(value):
            collected.not_taken['empty_heading'] += 1
        elif not -math.pi <= value <= _TURN_RAD:
            collected.not_taken['out_of_range'] += 1
        elif path == _MAGNETIC and vessel not in variations:
            collected.not_taken['no_variation'] += 1
        elif stamp_ns is None:
            collected.not_taken['no_stamp'] += 1
        else:
            turn = variations[vessel] if path == _MAGNETIC else 0.0
            name = f'{vessel}{_source(update)}/{path.rpartition(".")[2]}'
            collected.add(name, 'Signal K', stamp_ns, math.degrees(value + turn))


def _source(update: Mapping[str, Any]) -> str:
    """Return the name of the source of an update."""
    if update.get('$source'):
        return str(update['$source'])
    source = update.get('source')
    if not isinstance(source, dict):
        return 'unknown'
    return '.'.join(str(source[key]) for key in ('label', 'src', 'talker') if source.get(key))


def read_gpsd(path: str) -> Collected:
    """
    Read reports of gpsd, one per line, as `gpspipe -w` writes them.

    A stream is the device of a report of class ATT, whose heading is in degrees from true north.
    Class TPV tells the position, and the velocity, of the ship.
    """
    collected = Collected()
    for report in _objects(path, b'"class"', collected):
        device, stamp_ns = str(report.get('device') or 'gpsd'), _utc_stamp(report.get('time'))
        if report.get('class') == 'ATT':
            heading = report.get('heading')
            if not _is_number(heading):
                collected.not_taken['empty_heading'] += 1
            elif not 0.0 <= heading <= 360.0:
                collected.not_taken['out_of_range'] += 1
            elif stamp_ns is None:
                collected.not_taken['no_stamp'] += 1
            else:
                collected.add(device, 'gpsd', stamp_ns, heading)
        elif report.get('class') == 'TPV' and stamp_ns is not None:
            _take_gpsd_motion(collected, report, device, stamp_ns)
    return collected


def _take_gpsd_motion(collected: Collected, report: Mapping[str, Any], device: str,
                      stamp_ns: int) -> None:
    """Add the position and the velocity in a report with a fix (mode 2 or 3)."""
    if report.get('mode') not in (2, 3):
        return
    latitude, longitude, course_deg, speed_m_s = map(
        report.get, ('lat', 'lon', 'track', 'speed'))
    if _is_number(latitude) and _is_number(longitude):
        collected.add_motion(make_position(latitude, longitude), f'{device}/position', stamp_ns,
                             why_none='position.out_of_range')
    if _is_number(course_deg) and _is_number(speed_m_s):
        collected.add_motion(make_velocity(math.radians(course_deg), speed_m_s),
                             f'{device}/track', stamp_ns, why_none='velocity.out_of_range')


def read_openrvdas(path: str) -> Collected:
    """
    Read records of OpenRVDAS, one JSON object per line.

    A stream is a field whose name says that it is a heading, such as ``s330/S330HeadingTrue``;
    see `is_heading_name`. Headings are degrees, unless their name tells another unit; `timestamp`
    is in seconds.

    Fields such as ``S330Latitude`` and ``S330Longitude``, with ``S330NorS`` and ``S330EorW`` or
    with a sign, tell the position; ``S330CourseTrue`` and ``S330SpeedKt`` tell the velocity. A
    rate of turn has no unit that its name tells, and is not taken.
    """
    collected = Collected()
    for record in _objects(path, b'"fields"', collected):
        fields = record.get('fields')
        if not isinstance(fields, dict):
            continue
        label = f'{record["data_id"]}/' if record.get('data_id') else ''
        stamp_ns = _unix_stamp(record.get('timestamp'))
        for name, value in fields.items():
            if not is_heading_name(name):
                continue
            heading = _real(value)
            if heading is None or stamp_ns is None:
                collected.not_taken['bad_field'] += 1
            else:
                collected.add_angle(f'{label}{name}', 'OpenRVDAS', stamp_ns, heading,
                                    find_named_unit(name))
        if stamp_ns is not None:
            _take_openrvdas_motion(collected, label, stamp_ns, fields)
    return collected


def _unix_stamp(value: object) -> int | None:
    try:
        # The digits of the text, not those of a float, make the stamp.
        return nanoseconds(repr(value))
    except (ValueError, ArithmeticError):
        return None


def _real(value: Any) -> float | None:
    """Return a number, or a text that is one; None for anything else."""
    try:
        return float(value)
    except (TypeError, ValueError):
        return None


def _take_openrvdas_motion(collected: Collected, label: str, stamp_ns: int,
                           fields: Mapping[str, Any]) -> None:
    for name, value in fields.items():
        if name.endswith('Latitude') and value is not None:
            collected.add_motion(_place(name.removesuffix('Latitude'), fields), f'{label}{name}',
                                 stamp_ns, why_none='position.bad_field')
        elif name.endswith('CourseTrue'):
            course_deg = _real(value)
            speed_kn = _real(fields.get(f'{name.removesuffix("CourseTrue")}SpeedKt'))
            if course_deg is not None and speed_kn is not None:
                collected.add_motion(
                    make_velocity(math.radians(course_deg), speed_kn * KNOT_M_S),
                    f'{label}{name}', stamp_ns, why_none='velocity.out_of_range')


def _place(device: str, fields: Mapping[str, Any]) -> MovedRow | None:
    """
    Return the position in a record; None if there is none.

    Definitions of devices give them as decimal degrees or as in a sentence, degrees times 100 plus
    minutes; which it is shows where they exceed 90 or 180. So the latter are read wrongly within
    one degree of the equator and, at the same time, two of the meridian of Greenwich.
    """
    latitude, longitude = (_real(fields.get(f'{device}{name}'))
                           for name in ('Latitude', 'Longitude'))
    if latitude is None or longitude is None:
        return None
    if abs(latitude) > 90.0 or abs(longitude) > 180.0:
        latitude, longitude = map(_degrees_of_minutes, (latitude, longitude))
    if fields.get(f'{device}NorS') == 'S':
        latitude = -abs(latitude)
    if fields.get(f'{device}EorW') == 'W':
        longitude = -abs(longitude)
    return make_position(latitude, longitude)


def _degrees_of_minutes(value: float) -> float:
    degrees, minutes = divmod(abs(value), 100.0)
    return math.copysign(degrees + minutes / 60.0, value) if minutes < 60.0 else math.nan
