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
Logs of NMEA 2000: candump, canboat's plain form and its JSON, the text forms of gateways.

The forms of frames are one table, with the sentences in which gateways wrap them. The logs
give vessel headings (PGN 127250), and the motion of the ship (129025, 129026, 127251, 129029). A
stream is a source address of the bus.
"""

from __future__ import annotations

from base64 import b64decode
from collections import Counter
import json
import math
import re
from typing import Any, Callable, Iterator, Mapping, NamedTuple

import numpy as np

from heading_intercompare.bags.csv.stamp_cells import utc_nanoseconds
from heading_intercompare.core.motion.moved_rows import (
    make_position,
    make_rate,
    make_velocity,
    MovedRow,
)
from heading_intercompare.drivers.framing import Frame, Framer
from heading_intercompare.drivers.log_lines.log_clocks import start_stamps_of_file
from heading_intercompare.drivers.log_lines.log_files import LogFiles
from heading_intercompare.drivers.refused_lines import advise, name_options
from heading_intercompare.drivers.sentences import identify, Rejected

from .stream_recording import Collected, ReaderError, StreamOptions, UNSTATED

#: From here on a field says: not available, out of range, reserved.
_NO_UNSIGNED, _NO_SIGNED = 65533, 32765
_NO_LONG, _NO_LONGER = 0x7FFFFFFD, 0x7FFFFFFFFFFFFFFD
#: What a heading or course refers to: north.
_TRUE, _MAGNETIC = 0, 1

FRAME_BYTES = 8
"""The most bytes of a frame."""

#: 6 bytes in the first frame, 7 in each of 31 others.
_MOST_BYTES = 223


class FastPackets:
    """
    Joins the frames of fast packets, by source, message and sequence.

    Attributes
    ----------
    broken : int
        Packets of which a frame is missing, without those that are still expected.

    Notes
    -----
    The first byte of a frame has the number of the packet (3 bits) and that of the frame (5 bits).
    The second byte of frame 0 is the length of the packet. The bus keeps the order of the frames
    of a source, so a frame out of order means a loss.

    Examples
    --------
    >>> packets = FastPackets()
    >>> packets.add(129029, '5', bytes.fromhex('40 08 01 02 03 04 05 06')) is None
    True
    >>> packets.add(129029, '5', bytes.fromhex('41 07 08 ff ff ff ff ff')).hex()
    '0102030405060708'

    """

    def __init__(self) -> None:
        self.broken = 0
        #: The length, the bytes so far and the frame expected; None while the rest is ignored.
        self._begun: dict[tuple[int, int | str, int], tuple[int, bytearray, int] | None] = {}

    def add(self, pgn: int, source: int | str, frame: bytes) -> bytes | None:
        """Take a frame, and return the bytes of the packet that it completes, or None."""
        if len(frame) < 2:
            self.broken += 1
            return None
        key, number = (pgn, source, frame[0] >> 5), frame[0] & 31
        begun = self._begun.get(key)
        if number == 0:
            self.broken += begun is not None
            begun = (frame[1], bytearray(frame[2:FRAME_BYTES]), 1)
        elif begun is not None and number == begun[2]:
            begun[1].extend(frame[1:FRAME_BYTES])
            begun = (begun[0], begun[1], number + 1)
        else:
            self.broken += begun is not None or key not in self._begun
            self._begun[key] = None
            return None
        length, data, _ = begun
        if length > _MOST_BYTES:
            self.broken += 1
            self._begun[key] = None
            return None
        if len(data) < length:
            self._begun[key] = begun
            return None
        self._begun.pop(key, None)
        return bytes(data[:length])

    def flush(self) -> int:
        """Forget the packets that were begun, and return how many are broken in all."""
        self.broken += sum(packet is not None for packet in self._begun.values())
        self._begun.clear()
        return self.broken


_BEYOND = 'out_of_range'
_RATE_DEG_S = math.degrees(1e-6 / 32.0)


def _signed(data: bytes, at: int, size: int) -> int:
    return int.from_bytes(data[at:at + size], 'little', signed=True)


def _decode_rate(data: bytes) -> MovedRow | str:
    """Read PGN 127251: sequence, rate in 1e-6 / 32 rad/s."""
    rate = _signed(data, 1, 4)
    return 'empty' if rate >= _NO_LONG else make_rate(rate * _RATE_DEG_S) or _BEYOND


def _decode_rapid_position(data: bytes) -> MovedRow | str:
    """Read PGN 129025: latitude and longitude in 1e-7 deg."""
    latitude, longitude = _signed(data, 0, 4), _signed(data, 4, 4)
    if latitude >= _NO_LONG or longitude >= _NO_LONG:
        return 'empty'
    return make_position(latitude * 1e-7, longitude * 1e-7) or _BEYOND


def _decode_course(data: bytes) -> MovedRow | str:
    """Read PGN 129026: sequence, reference, course in 1e-4 rad, speed in cm/s."""
    course, speed = (int.from_bytes(data[at:at + 2], 'little') for at in (2, 4))
    if course >= _NO_UNSIGNED or speed >= _NO_UNSIGNED:
        return 'empty'
    return ('not_true' if data[1] & 3 != _TRUE
            else make_velocity(course * 1e-4, speed * 0.01) or _BEYOND)


def _decode_position(data: bytes) -> MovedRow | str:
    """Read PGN 129029: sequence, day, time, then latitude and longitude in 1e-16 deg."""
    latitude, longitude = _signed(data, 7, 8), _signed(data, 15, 8)
    if latitude >= _NO_LONGER or longitude >= _NO_LONGER:
        return 'empty'
    # The high half of the byte with the method: 0 is no fix.
    if not data[31] >> 4:
        return 'no_fix'
    return make_position(latitude * 1e-16, longitude * 1e-16) or _BEYOND


MOTION_PGNS: dict[int, tuple[int, Callable[[bytes], MovedRow | str]]] = {
    129026: (8, _decode_course), 129025: (8, _decode_rapid_position), 127251: (5, _decode_rate),
    129029: (32, _decode_position)}
"""Bytes needed and decoder, by PGN; of two that tell one thing, the earlier is preferred."""


def decode_motion_pgn(pgn: int, data: bytes) -> MovedRow | str:
    """
    Decode a message; a str says why it tells nothing.

    Parameters
    ----------
    pgn
        One of `MOTION_PGNS`.
    data
        Its bytes; those of a fast packet already joined.

    Examples
    --------
    >>> row = decode_motion_pgn(129026, bytes.fromhex('01 fc 5c 3d e8 03 ff ff'))
    >>> row.what, round(row.values[0], 6)
    ('velocity', 10.0)

    """
    least, decode = MOTION_PGNS[pgn]
    return 'too_few_fields' if len(data) < least else decode(data)


def _value(fields: Mapping[str, Any], name: str) -> Any:
    """Return the value of a field in any spelling of its name; with ``-nv`` a value has a name."""
    field = fields.get(name)
    if field is None:
        # Camel case, of either kind: `cogReference`.
        plain = name.replace(' ', '').lower()
        field = next((value for key, value in fields.items() if key.lower() == plain), None)
    return field.get('value', field.get('name')) if isinstance(field, Mapping) else field


def decode_motion_fields(pgn: int, fields: Mapping[str, Any], radians: float) -> MovedRow | str:
    """
    Decode the fields of a message as canboat's analyzer names them.

    Parameters
    ----------
    pgn
        One of `MOTION_PGNS`.
    fields
        By name, in canboat's spelling or in camel case.
    radians
        Makes radians of their angles.

    """
    names = {129026: ('COG', 'SOG'), 127251: ('Rate',)}.get(pgn, ('Latitude', 'Longitude'))
    values = []
    for name in names:
        value = _value(fields, name)
        if value is None:
            return 'empty'
        if not isinstance(value, (int, float)) or isinstance(value, bool):
            return 'bad_field'
        values.append(float(value))
    if pgn == 127251:
        return make_rate(math.degrees(values[0] * radians)) or _BEYOND
    if pgn != 129026:
        # Positions are degrees in any units.
        return make_position(values[0], values[1]) or _BEYOND
    return ('not_true' if _value(fields, 'COG Reference') not in ('True', _TRUE)
            else make_velocity(values[0] * radians, values[1]) or _BEYOND)


PGN = 127250
"""Vessel heading."""

_KIND = f'PGN {PGN}'
_RAD_DEG = 1e-4 * 180.0 / math.pi
_FULL_TURN = 62832
_SECOND_NS = 1_000_000_000


class FrameForm(NamedTuple):
    """
    How a program writes frames, one per line.

    Attributes
    ----------
    program
        Who writes it.
    line
        Finds a line, with named parts: `stamp` (day and time), or `s` and `decimals` of the time
        since 1970, or `hour`, `minute` and `second` of a day; `identifier` in hexadecimal, or
        `pgn` and `source`, or `pgn_hex` and `source_hex`; `data` in hexadecimal, or `base64`.
    sentence
        The end of the address of a sentence in which each frame is wrapped, with its comma; empty
        for frames that are lines. The logger stamps such a line as that of any sentence.
    has_checksum
        Whether that sentence has one.
    may_reverse
        Whether some programs write the bytes of a frame in reverse.

    """

    program: str
    line: re.Pattern[bytes]
    sentence: bytes = b''
    has_checksum: bool = True
    may_reverse: bool = False

    def is_in(self, head: bytes) -> bool:
        """Tell whether a file that begins so has this form; heading sentences come before it."""
        if not self.sentence:
            return self.line.search(head) is not None
        texts = [text for _, _, text, _, _ in Framer().feed(head, None)
                 ] if self.sentence in head else []
        matches = filter(None, map(self.line.fullmatch, texts))
        return (any(_address(match.groupdict())[0] == PGN for match in matches)
                and not any(map(identify, texts)))


class _Frames:
    """Finds the frames in the blocks of a log, and counts the sentences that hold none."""

    def __init__(self, form: FrameForm, counts: Counter[str], *, lenient: bool) -> None:
        self._form, self._counts, self._lenient = form, counts, lenient
        self._framer = Framer()

    def find(self, block: bytes) -> Iterator[dict[str, bytes]]:
        """Yield the parts of each frame in whole lines."""
        if not self._form.sentence:
            yield from (line.groupdict() for line in self._form.line.finditer(block))
            return
        for frame in self._framer.feed(block, None):
            if frame[2].partition(b',')[0].endswith(self._form.sentence[:-1]):
                yield from self._unwrap(frame)
        if damaged := self._framer.counts.pop('bad_checksum', 0):
            self._counts['bad_checksum'] += damaged

    def _unwrap(self, frame: Frame) -> Iterator[dict[str, bytes]]:
        _, prefix, text, checked, suffix = frame
        match = self._form.line.fullmatch(text)
        if match is None:
            self._counts['bad_field'] += 1
        elif self._form.has_checksum and not (checked or self._lenient):
            self._counts['no_checksum'] += 1
        else:
            yield {**match.groupdict(), 'before': prefix, 'after': suffix}


_BYTES = rb'(?P<data>[0-9A-Fa-f]{2}(?:[ ,]?[0-9A-Fa-f]{2})*)'
FRAME_FORMS = (
    # Of the form of -l, or of the screen with -ta or -tA.
    FrameForm('candump', re.compile(
        rb'^\s*\((?:(?P<s>\d{1,10})\.(?P<decimals>\d{1,9})'
        rb'|(?P<stamp>\d{4}-\d\d-\d\d \d\d:\d\d:\d\d\.\d+))\)\s+\S+(?:\s+[RT]X\s+\S\s+\S)?\s+'
        rb'(?P<identifier>[0-9A-Fa-f]{8})(?:#|\s+\[\d+\]\s+)' + _BYTES, re.MULTILINE)),
    # Time, priority, PGN, source, destination, length, bytes; a raw log of Signal K writes its
    # time and an A before them.
    FrameForm('canboat', re.compile(
        rb'^(?:\d+;A;)?(?P<stamp>\d{4}-\d\d-\d\d[TZ -]\d\d:\d\d:\d\d(?:\.\d+)?Z?),\d,'
        rb'(?P<pgn>\d+),(?P<source>\d+),\d+,\d+,' + _BYTES + rb'\s*$', re.MULTILINE)),
    # The time of day, received or transmitted, identifier, bytes.
    FrameForm('Yacht Devices RAW', re.compile(
        rb'^(?P<hour>\d\d):(?P<minute>\d\d):(?P<second>\d\d(?:\.\d+)?) [RT] '
        rb'(?P<identifier>[0-9A-Fa-f]{8}) ' + _BYTES + rb'\s*$', re.MULTILINE)),
    # The time of day; source, destination and priority; PGN; all bytes of the message.
    FrameForm('Actisense N2K ASCII', re.compile(
        rb'^A(?P<hour>\d\d)(?P<minute>\d\d)(?P<second>\d\d\.\d+) '
        rb'(?P<source_hex>[0-9A-Fa-f]{2})[0-9A-Fa-f]{2}[0-7] (?P<pgn_hex>[0-9A-Fa-f]{5}) '
        + _BYTES + rb'\s*$', re.MULTILINE)),
    # PGN, a time without a known start, source, all bytes of the message.
    FrameForm('SeaSmart', re.compile(
        rb'PCDIN,(?P<pgn_hex>[0-9A-Fa-f]{6}),[0-9A-Fa-f]*,(?P<source_hex>[0-9A-Fa-f]{2}),'
        + _BYTES), b'PCDIN,'),
    # PGN; received, priority and length; source; the bytes of a frame, by MiniPlex in reverse.
    FrameForm('MiniPlex', re.compile(
        rb'..PGN,(?P<pgn_hex>[0-9A-Fa-f]{6}),[0-7][0-9A-Fa-f](?P<source_hex>[0-9A-Fa-f]{2}),'
        + _BYTES), b'PGN,', may_reverse=True),
    # PGN, priority, source, destination, seconds since a start, all bytes of the message.
    FrameForm('iKonvert', re.compile(
        rb'PDGY,(?P<pgn>\d+),\d+,(?P<source>\d+),\d+,[\d.]*,(?P<base64>[0-9A-Za-z+/]+={0,2})'),
        b'PDGY,', has_checksum=False),
)
"""The forms of logs of frames."""

#: Takes several frames.
_FAST_PGN = 129029
_WANTED = re.compile(b'|'.join([b'"units"', *(str(pgn).encode() for pgn in (PGN, *MOTION_PGNS))]))
#: A line of units, or the number of a heading.
_UNITS_OR_HEADING = re.compile(
    rb'"units"\s*:|"[Hh]eading"\s*:\s*(?:\{[^{}]*?"value"\s*:\s*)?(\d+(?:\.\d+)?)')
_MOST_HEADINGS = 100_000
_DAY = re.compile(r'(\d{4}-\d\d-\d\d)[TZ -](\d\d:\d\d:\d\d(?:\.\d+)?)Z?')
_HEAD = re.compile(rb'^\s*\{.*"pgn"\s*:', re.MULTILINE)


def is_canboat_json(head: bytes) -> bool:
    """Tell whether a file that begins so is JSON of canboat's analyzer."""
    return _HEAD.search(head) is not None


def decode_vessel_heading(data: bytes) -> tuple[float, float | None, int] | str:
    """
    Decode the bytes of a vessel heading.

    Parameters
    ----------
    data
        The eight bytes of PGN 127250.

    Returns
    -------
    heading_deg, turn_deg, reference : (float, float or None, int)
        Heading; deviation (0 if not available) plus variation, None without a variation; 0 if the
        heading is true, 1 if it is magnetic. If there is no heading, a str with the reason.

    Examples
    --------
    >>> heading_deg, turn_deg, reference = decode_vessel_heading(
    ...     bytes.fromhex('ff 10 27 ff 7f ff 7f fc'))
    >>> round(heading_deg, 6), turn_deg, reference
    (57.29578, None, 0)
    >>> decode_vessel_heading(bytes.fromhex('ff ff ff ff 7f ff 7f fc'))
    'empty_heading'

    """
    if len(data) < 8:
        return 'too_few_fields'
    heading = int.from_bytes(data[1:3], 'little')
    deviation, variation = (int.from_bytes(data[at:at + 2], 'little', signed=True)
                            for at in (3, 5))
    if heading >= _NO_UNSIGNED:
        return 'empty_heading'
    if heading > _FULL_TURN:
        return 'out_of_range'
    turn_deg = None
    if variation < _NO_SIGNED:
        turn_deg = (variation + (deviation if deviation < _NO_SIGNED else 0)) * _RAD_DEG
    return heading * _RAD_DEG, turn_deg, data[7] & 3


def _take(collected: Collected, source: int | str, stamp_ns: int | None,
          decoded: tuple[float, float | None, int] | str) -> None:
    """Add a decoded heading, or the reason why there is none."""
    if isinstance(decoded, str):
        collected.not_taken[decoded] += 1
        return
    heading_deg, turn_deg, reference = decoded
    if reference not in (_TRUE, _MAGNETIC):
        collected.not_taken['no_reference'] += 1
    elif reference == _MAGNETIC and turn_deg is None:
        collected.not_taken['no_variation'] += 1
    elif stamp_ns is None:
        collected.not_taken['no_stamp'] += 1
    else:
        collected.add(str(source), _KIND, stamp_ns,
                      heading_deg + (turn_deg or 0.0) * (reference == _MAGNETIC))


def _take_motion(collected: Collected, pgn: int, source: int | str, stamp_ns: int | None,
                 decoded: MovedRow | str) -> None:
    """Add what a message tells of the motion of the ship, or the reason why it tells nothing."""
    if isinstance(decoded, str) or stamp_ns is None:
        why = decoded if isinstance(decoded, str) else 'no_stamp'
        collected.not_taken[f'PGN {pgn}.{why}'] += 1
    else:
        collected.add_motion(decoded, f'PGN {pgn} of {source}', stamp_ns,
                             rank=[*MOTION_PGNS].index(pgn))


def _take_frame(collected: Collected, packets: FastPackets, pgn: int, source: int | str,
                stamp_ns: int | None, data: bytes) -> None:
    """Add what a message tells of the motion, or keep a frame of a message of several frames."""
    whole: bytes | None = data
    if pgn == _FAST_PGN and len(data) <= FRAME_BYTES:
        whole = packets.add(pgn, source, data)
    if whole is not None:
        _take_motion(collected, pgn, source, stamp_ns, decode_motion_pgn(pgn, whole))


def _stamp(text: str) -> int | None:
    match = _DAY.fullmatch(text)
    try:
        return utc_nanoseconds(f'{match[1]}T{match[2]}Z') if match else None
    except ValueError:
        return None


def _read_blocks(path: str, take: Callable[[bytes], None]) -> None:
    """Hand over a file in blocks of whole lines."""
    rest = b''
    with open(path, 'rb') as file:
        while block := file.read(1 << 22):
            whole, newline, rest_now = (rest + block).rpartition(b'\n')
            take(whole + newline)
            rest = rest_now
    take(rest)


def read_frames(form: FrameForm, path: str, options: StreamOptions = UNSTATED) -> Collected:
    """
    Read a log of frames.

    The bits of a frame's identifier give the PGN and the source. Messages of several frames may be
    joined or not; with at most 8 bytes they are not. Such a message has the stamp of its last
    frame.

    Parameters
    ----------
    form
        How the frames are written.
    path
        The log.
    options
        Date and zone of a log with times of day.

    Raises
    ------
    OSError
        If the file cannot be read.
    ReaderError
        If nothing tells the date of its times of day, or the order of the bytes of its frames; or
        if none of its sentences has a stamp.

    """
    collected, packets, stamps = Collected(), FastPackets(), _FrameStamps(path, options)
    lenient = options.stamps.checksum == 'if_present'
    reverse = form.may_reverse and _is_reversed(form, path, lenient=lenient)
    frames = _Frames(form, collected.not_taken, lenient=lenient)

    def take(block: bytes) -> None:
        for parts in frames.find(block):
            pgn, source = _address(parts)
            if pgn != PGN and pgn not in MOTION_PGNS:
                continue
            stamp_ns = stamps.read(parts)
            data = _bytes_of(parts)[::-1 if reverse else 1]
            if pgn == PGN:
                _take(collected, source, stamp_ns, decode_vessel_heading(data))
            else:
                _take_frame(collected, packets, pgn, source, stamp_ns, data)

    _read_blocks(path, take)
    take(b'\n')
    if form.sentence and not collected.kinds and collected.not_taken['no_stamp']:
        raise ReaderError(path, 'its lines have no stamp that can be read: record them with one '
                          'before each sentence, or describe its form with --stamp-pattern')
    if broken := packets.flush():
        collected.not_taken[f'PGN {_FAST_PGN}.incomplete'] += broken
    collected.oddities += filter(None, (stamps.origin,))
    return collected


class _FrameStamps:
    """Reads the stamps of the lines of one log of frames."""

    def __init__(self, path: str, options: StreamOptions) -> None:
        self._path = path
        self._days, self._clock = start_stamps_of_file(options.stamps, path,
                                                       lambda: LogFiles(path).bare_blocks())

    @property
    def origin(self) -> str:
        """Return where the date of times of day came from, in words; '' if none was needed."""
        return self._days.origin

    def read(self, parts: Mapping[str, bytes]) -> int | None:
        """Return the stamp of a line, nanoseconds UTC; None if it is none."""
        if 'before' in parts:
            return self._read_clock(parts['before'], parts['after'])
        if parts.get('hour'):
            return self._read_clock(b'%b:%b:%b' % (
                parts['hour'], parts['minute'], parts['second']))
        if parts.get('stamp'):
            return _stamp(parts['stamp'].decode())
        return int(parts['s']) * _SECOND_NS + int(parts['decimals'].ljust(9, b'0'))

    def _read_clock(self, text: bytes, after: bytes = b'') -> int | None:
        try:
            return self._clock.own_ns(text, after)
        except Rejected as rejected:
            if rejected.reason == 'no_date':
                raise ReaderError(self._path, name_options(advise('no_date'), None)) from None
            return None


def _address(parts: Mapping[str, bytes]) -> tuple[int, int]:
    """Return the PGN and the source of a frame."""
    if 'pgn_hex' in parts:
        return int(parts['pgn_hex'], 16), int(parts['source_hex'], 16)
    if 'pgn' in parts:
        return int(parts['pgn']), int(parts['source'])
    number = int(parts['identifier'], 16)
    return number >> 8 & 0x1FFFF, number & 0xFF


def _bytes_of(parts: Mapping[str, bytes]) -> bytes:
    """Return the bytes of a frame; none if they are damaged."""
    if 'base64' in parts:
        try:
            return b64decode(parts['base64'], validate=True)
        except ValueError:
            return b''
    return bytes.fromhex(parts['data'].decode().replace(',', ''))


#: The last byte of a heading: reserved bits, which are set, and the reference.
_LAST_BYTES = (0xFC | _TRUE, 0xFC | _MAGNETIC)


def _is_reversed(form: FrameForm, path: str, *, lenient: bool) -> bool:
    """Tell whether a log has the bytes of its frames in reverse; ReaderError if none can tell."""
    orders: Counter[bool] = Counter()
    frames = _Frames(form, Counter(), lenient=lenient)

    def take(block: bytes) -> None:
        for parts in frames.find(block):
            if _address(parts)[0] == PGN and len(data := _bytes_of(parts)) == FRAME_BYTES:
                first, last = (data[at] in _LAST_BYTES for at in (0, -1))
                orders[first] += first != last

    _read_blocks(path, take)
    take(b'\n')
    if bool(orders[True]) == bool(orders[False]):
        raise ReaderError(path, 'its $MXPGN have the bytes of frames as they are or in reverse, '
                          'and its headings do not tell which: record sentences such as $HEHDT, '
                          'or the frames in another form of docs/bags.md')
    return orders[True] > 0


def _decode_json(fields: Mapping[str, Any], factor: float,
                 ) -> tuple[float, float | None, int] | str:
    """Decode the fields of a vessel heading; `factor` makes degrees of their angles."""
    heading, deviation, variation = (_value(fields, name) for name in (
        'Heading', 'Deviation', 'Variation'))
    if heading is None:
        return 'empty_heading'
    if not all(isinstance(angle, (int, float))
               for angle in (heading, deviation or 0, variation or 0)):
        return 'bad_field'
    if not 0.0 <= heading * factor <= 360.0:
        return 'out_of_range'
    turn_deg = None if variation is None else (variation + (deviation or 0.0)) * factor
    reference = _value(fields, 'Reference')
    reference = {'True': _TRUE, 'Magnetic': _MAGNETIC}.get(reference, reference)
    return heading * factor, turn_deg, reference if reference in (_TRUE, _MAGNETIC) else 2


def _has_radians(path: str) -> bool:
    """Tell whether JSON without a line of units has angles in radians."""
    headings: set[float] = set()
    stated = False

    def take(block: bytes) -> None:
        nonlocal stated
        for match in _UNITS_OR_HEADING.finditer(block):
            stated = stated or match[1] is None
            if not stated and len(headings) < _MOST_HEADINGS:
                headings.add(float(match[1]))
    _read_blocks(path, take)
    if stated or not headings or max(headings) > _FULL_TURN * 1e-4:
        return False
    steps = np.diff(sorted(headings))
    return bool(steps.size and steps.min() < 0.5 * _RAD_DEG)


def read_canboat_json(path: str) -> Collected:
    """
    Read the JSON of canboat's analyzer.

    Angles are degrees, unless the first line says ``"units":"si"``; then they are radians. A file
    without such a line, as other programs write them, has radians if its headings are finer than
    the bus sends them, which are multiples of 1e-4 rad, would be in degrees.
    """
    collected, factor = Collected(), math.degrees(1.0) if _has_radians(path) else 1.0

    def take(block: bytes) -> None:
        nonlocal factor
        for line in block.splitlines():
            if not _WANTED.search(line):
                continue
            try:
                read = json.loads(line)
            except ValueError:
                collected.not_taken['bad_field'] += 1
                continue
            if not isinstance(read, dict):
                continue
            if 'units' in read:
                factor = 180.0 / math.pi if read['units'] == 'si' else 1.0
            if read.get('pgn') == PGN and isinstance(read.get('fields'), Mapping):
                _take(collected, read.get('src', 0), _stamp(str(read.get('timestamp', ''))),
                      _decode_json(read['fields'], factor))
            elif read.get('pgn') in MOTION_PGNS and isinstance(read.get('fields'), Mapping):
                _take_motion(collected, read['pgn'], read.get('src', 0),
                             _stamp(str(read.get('timestamp', ''))),
                             decode_motion_fields(read['pgn'], read['fields'],
                                                  math.radians(factor)))

    _read_blocks(path, take)
    return collected
