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
The motion of the ship in logs of NMEA 2000, written by hand after the public descriptions.

PGN 129026: SID, reference (2 bits), course (0.0001 rad), speed (cm/s). PGN 129025: latitude and
longitude (1e-7 deg). PGN 127251: SID, rate (1/32 of a microradian per second). PGN 129029: SID,
day (2), time (4), latitude, longitude and height (8 each), type and method, ...
"""

from __future__ import annotations

import json
import math

import pytest
from readers.test_nmea2000 import identifier, read_canboat_plain, read_candump, T_NS

from heading_intercompare.readers.nmea2000 import (
    decode_motion_fields,
    decode_motion_pgn,
    read_canboat_json,
)


def signed(value, size):
    return value.to_bytes(size, 'little', signed=True)


def course(rad=1.5, m_s=5.0, reference=0):
    return bytes([1, 0xFC | reference]) + round(rad * 1e4).to_bytes(2, 'little') + round(
        m_s * 100).to_bytes(2, 'little') + b'\xff\xff'


def place(latitude=-33.5, longitude=151.25):
    return signed(round(latitude * 1e7), 4) + signed(round(longitude * 1e7), 4)


def rate(rad_s=-0.01):
    return b'\x01' + signed(round(rad_s * 32e6), 4) + b'\xff\xff\xff'


def fix(latitude=-33.5, longitude=151.25, method=1):
    return (b'\x01' + bytes(6) + signed(round(latitude * 1e16), 8)
            + signed(round(longitude * 1e16), 8) + bytes(8) + bytes([method << 4]) + bytes(11))


BYTES = {129026: course(), 129025: place(), 127251: rate(), 129029: fix()}
VALUES = {129026: ('velocity', 5 * math.sin(1.5), 5 * math.cos(1.5)),
          129025: ('fix', -33.5, 151.25), 127251: ('rate', math.degrees(-0.01)),
          129029: ('fix', -33.5, 151.25)}


@pytest.mark.parametrize('pgn', BYTES)
def test_a_message_is_decoded_by_hand(pgn):
    found = decode_motion_pgn(pgn, BYTES[pgn])
    assert found.what == VALUES[pgn][0]
    assert found.values == pytest.approx(VALUES[pgn][1:], abs=1e-6)


@pytest.mark.parametrize('pgn, data, why', [
    (129026, course(reference=1), 'not_true'), (129026, course()[:7], 'too_few_fields'),
    (129026, b'\x01\xfc\xff\xff\x00\x00\xff\xff', 'empty'),
    (129026, b'\x01\xfc\x00\x00\xff\xff\xff\xff', 'empty'), (129026, course(6.3), 'out_of_range'),
    (129026, course(m_s=90.0), 'out_of_range'), (129025, place(91.0), 'out_of_range'),
    (127251, rate(1.05), 'out_of_range'),
    (129025, b'\xff\xff\xff\x7f' * 2, 'empty'), (127251, b'\x01\xff\xff\xff\x7f', 'empty'),
    (129029, fix(method=0), 'no_fix'), (129029, fix()[:31], 'too_few_fields')])
def test_a_message_that_tells_nothing_says_why(pgn, data, why):
    assert decode_motion_pgn(pgn, data) == why


@pytest.mark.parametrize('fields, why', [
    ({'COG': 90.0, 'SOG': 5.0, 'COG Reference': 'Magnetic'}, 'not_true'),
    ({'COG': 90.0, 'COG Reference': 'True'}, 'empty'),
    ({'COG': 'north', 'SOG': 5.0, 'COG Reference': 'True'}, 'bad_field')])
def test_fields_that_tell_nothing_say_why(fields, why):
    assert decode_motion_fields(129026, fields, math.radians(1.0)) == why


def candump(tmp_path):
    text = ''.join(f'(1436509052.{second}00000) can0 {identifier(5, pgn)}#{data.hex()}\n'
                   for second in range(3) for pgn, data in BYTES.items() if pgn != 129029)
    (tmp_path / 'log').write_text(text)
    return read_candump(str(tmp_path / 'log'))


def plain(tmp_path):
    text = ''.join(f'2015-07-10T06:17:3{second}.000Z,2,{pgn},5,255,{len(data)},'
                   f'{data.hex(",")}\n' for second in range(3) for pgn, data in BYTES.items())
    (tmp_path / 'log').write_text(text)
    return read_canboat_plain(str(tmp_path / 'log'))


def analysed(tmp_path, units):
    turn = 1.0 if units == 'si' else 180.0 / math.pi
    fields = {129026: {'COG Reference': 'True', 'COG': 1.5 * turn, 'SOG': 5.0},
              129025: {'Latitude': -33.5, 'Longitude': 151.25}, 127251: {'Rate': -0.01 * turn},
              129029: {'Latitude': {'value': -33.5}, 'Longitude': 151.25}}
    rows = [{'version': '6.0', 'units': units}, *(
        {'timestamp': f'2015-07-10T06:17:3{second}.000Z', 'src': 5, 'pgn': pgn, 'fields': told}
        for second in range(3) for pgn, told in fields.items())]
    (tmp_path / 'log').write_text('\n'.join(map(json.dumps, rows)))
    return read_canboat_json(str(tmp_path / 'log'))


@pytest.mark.parametrize('make', [candump, plain, lambda path: analysed(path, 'std'),
                                  lambda path: analysed(path, 'si')],
                         ids=['candump', 'plain', 'json', 'json in si'])
def test_each_form_of_log_gives_the_motion_the_preferred_message_first(tmp_path, make):
    found = make(tmp_path).motion()
    assert list(found['fix'])[0] == 'PGN 129025 of 5'
    assert found['fix']['PGN 129025 of 5'].longitude_deg == pytest.approx([151.25] * 3)
    velocity = found['velocity']['PGN 129026 of 5']
    assert velocity.course_deg == pytest.approx([math.degrees(1.5)] * 3)
    assert velocity.east_m_s == pytest.approx([5 * math.sin(1.5)] * 3)
    assert found['rate']['PGN 127251 of 5'].rate_deg_s == pytest.approx([math.degrees(-0.01)] * 3)
    assert velocity.stamp_ns[0] // 10 ** 12 == T_NS // 10 ** 12


def test_what_tells_nothing_is_counted_by_message(tmp_path):
    (tmp_path / 'log').write_text(
        f'(1436509052.1) can0 {identifier(5, 129026)}#{course(reference=1).hex()}\n')
    found = read_candump(str(tmp_path / 'log'))
    assert dict(found.not_taken) == {'PGN 129026.not_true': 1} and found.motion() == {}


def frames(data, sequence=2):
    """Return the frames of a fast packet by hand: number, length and 6 bytes, then 7 each."""
    parts = [bytes([len(data)]) + data[:6], *(
        data[at:at + 7].ljust(7, b'\xff') for at in range(6, len(data), 7))]
    return [bytes([sequence << 5 | number]) + part for number, part in enumerate(parts)]


def in_candump(sent):
    return ''.join(f'(1436509052.{n:06d}) can0 {identifier(source, 129029)}#{one.hex()}\n'
                   for n, (source, one) in enumerate(sent)), read_candump


def in_plain(sent):
    return ''.join(f'2015-07-10T06:17:32.{n:06d}Z,3,129029,{source},255,8,{one.hex(",")}\n'
                   for n, (source, one) in enumerate(sent)), read_canboat_plain


@pytest.mark.parametrize('write', [in_candump, in_plain])
def test_positions_in_several_frames_are_joined(tmp_path, write):
    """Two sources at once, and one whose packets follow each other; the stamp is of the end."""
    first, second = frames(fix(10.0, 20.0)), frames(fix(-30.0, -40.0), 7)
    sent = [one for pair in zip(((5, one) for one in first), ((6, one) for one in second))
            for one in pair] + [(5, one) for one in frames(fix(11.0, 21.0), 3)]
    text, reader = write(sent)
    (tmp_path / 'log').write_text(text)
    found = reader(str(tmp_path / 'log'))
    told = {name: (rows.stamp_ns.tolist(), rows.latitude_deg.tolist(),
                   rows.longitude_deg.tolist()) for name, rows in found.motion()['fix'].items()}
    second_ns = 1436509052 * 10 ** 9
    assert len(first) == 7 and not found.not_taken
    assert told['PGN 129029 of 5'] == ([second_ns + 12_000, second_ns + 20_000],
                                       pytest.approx([10, 11]), pytest.approx([20, 21]))
    assert told['PGN 129029 of 6'] == ([second_ns + 13_000], pytest.approx([-30]),
                                       pytest.approx([-40]))


@pytest.mark.parametrize('lost, fixes, broken', [
    ([], 3, 0), ([0], 2, 1), ([0, 1, 2], 2, 1), ([3], 2, 1), ([3, 5], 2, 1), ([9], 2, 1),
    ([20], 2, 1), ([4, 20], 1, 2), (range(7, 14), 2, 0)])
def test_a_packet_without_a_frame_is_counted_once_and_never_joined_with_another(
        tmp_path, lost, fixes, broken):
    sent = [(5, one) for n in range(3) for one in frames(fix(10.0 + n), 6)]
    text, reader = in_candump([one for n, one in enumerate(sent) if n not in lost])
    (tmp_path / 'log').write_text(text)
    found = reader(str(tmp_path / 'log'))
    rows = found.motion().get('fix', {}).get('PGN 129029 of 5')
    assert set(rows.latitude_deg.round(9)) <= {10.0, 11.0, 12.0} and len(rows) == fixes
    assert found.not_taken.get('PGN 129029.incomplete', 0) == broken


@pytest.mark.parametrize('frame', ['40', '40ff010203040506', '4120010203040506'])
def test_a_frame_that_begins_no_packet_is_counted(tmp_path, frame):
    text, reader = in_candump([(5, bytes.fromhex(frame))])
    (tmp_path / 'log').write_text(text)
    found = reader(str(tmp_path / 'log'))
    assert dict(found.not_taken) == {'PGN 129029.incomplete': 1} and found.motion() == {}
