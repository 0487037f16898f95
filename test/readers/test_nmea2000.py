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
NMEA 2000 logs, written by hand after the public descriptions.

The fields of PGN 127250 are those of canboat's database: SID, heading (0.0001 rad), deviation,
variation, reference (2 bits). candump writes the identifier of a frame in hexadecimal: three bits
of priority, 18 bits of PGN, eight of source.
"""

from __future__ import annotations

from functools import partial
import json
import math
import re

import pytest

from heading_intercompare.drivers.settings import DriverSettings
from heading_intercompare.readers.nmea2000 import (
    decode_vessel_heading,
    FRAME_FORMS,
    is_canboat_json,
    read_canboat_json,
    read_frames,
)
from heading_intercompare.readers.stream_recording import ReaderError, StreamOptions

CANDUMP, CANBOAT, YACHT_DEVICES, ACTISENSE, SEASMART, MINIPLEX, IKONVERT = FRAME_FORMS
read_candump, read_canboat_plain = (partial(read_frames, form) for form in FRAME_FORMS[:2])
T_NS = 1436509052249713000
DEG = math.degrees(1e-4)


def payload(heading, deviation=0x7FFF, variation=0x7FFF, reference=0):
    """Return the bytes of a vessel heading; reserved bits are set."""
    return (b'\x01' + heading.to_bytes(2, 'little')
            + b''.join(one.to_bytes(2, 'little', signed=True) for one in (deviation, variation))
            + bytes([0xFC | reference]))


def identifier(source, pgn=127250, priority=2):
    """Return the identifier of a frame."""
    return f'{priority << 26 | pgn << 8 | source:08X}'


def read(tmp_path, reader, text):
    """Return the readings by stream as lists, and what was not taken."""
    path = tmp_path / 'n2k.log'
    path.write_text(text)
    found = reader(str(path))
    return ({name: list(zip(h.stamp_ns.tolist(), h.heading_deg.tolist()))
             for name, h in found.streams().items()}, dict(found.not_taken))


def test_the_identifier_of_the_public_example_is_a_vessel_heading():
    assert identifier(0x17) == '09F11217'


@pytest.mark.parametrize('data, expected', [
    (payload(0), (0.0, None, 0)), (payload(31416), (31416 * DEG, None, 0)),
    (payload(62831), (62831 * DEG, None, 0)),
    (payload(10000, 100, -300, 1), (10000 * DEG, -200 * DEG, 1)),
    (payload(10000, variation=300, reference=1), (10000 * DEG, 300 * DEG, 1)),
    (payload(10000, 100, reference=1), (10000 * DEG, None, 1)),
    (payload(10000, reference=3), (10000 * DEG, None, 3)),
    (payload(65535), 'empty_heading'), (payload(65534), 'empty_heading'),
    (payload(65533), 'empty_heading'), (payload(65532), 'out_of_range'),
    (payload(62833), 'out_of_range'), (payload(5)[:7], 'too_few_fields'), (b'', 'too_few_fields')])
def test_a_vessel_heading_is_decoded_by_hand(data, expected):
    found = decode_vessel_heading(data)
    if isinstance(expected, str):
        assert found == expected
    else:
        assert found[2] == expected[2]
        assert found[:2] == pytest.approx(expected[:2], abs=1e-12)


FRAMES = [(0x17, payload(10000)), (0x23, payload(20000, reference=1)),
          (0x23, payload(20000, -100, 600, 1)), (0x17, payload(65535)),
          (0x17, payload(10000, reference=2))]
EXPECTED = {'23': [(T_NS, pytest.approx(10000 * DEG))],
            '35': [(T_NS + 2_000_000, pytest.approx(20500 * DEG))]}
NOT_TAKEN = {'no_variation': 1, 'empty_heading': 1, 'no_reference': 1}


@pytest.mark.parametrize('form', ['-l', '-ta', '-ta -x', '-tA', 'lower'])
def test_candump_in_each_of_its_forms(tmp_path, form):
    lines = []
    for n, (source, data) in enumerate(FRAMES):
        text, frame = f'1436509052.{249713 + n * 1000:06d}', identifier(source)
        if form == 'lower':
            lines.append(f'({text}) can0 {frame.lower()}#{data.hex()}')
        elif form == '-l':
            lines.append(f'({text}) can0 {frame}#{data.hex().upper()}')
        elif form == '-ta -x':
            lines.append(f' ({text})  can0  RX - -  {frame}   [8]  {data.hex(" ").upper()}')
        elif form == '-ta':
            lines.append(f' ({text})  can0  {frame}   [8]  {data.hex(" ").upper()}')
        else:
            lines.append(f' (2015-07-10 06:17:32.{249713 + n * 1000:06d})  vcan1  {frame}   [8]  '
                         f'{data.hex(" ").upper()}')
    other = re.sub(identifier(0x17), identifier(0x17, 130306), lines[0], flags=re.IGNORECASE)
    assert other != lines[0]
    lines.insert(1, other)
    lines.insert(1, '(1436509052.000000) can0 123#0102')
    text = '\n'.join(lines) + '\n'
    assert CANDUMP.is_in(text.encode()) and not CANBOAT.is_in(text.encode())
    assert read(tmp_path, read_candump, text) == (EXPECTED, NOT_TAKEN)


def test_canboat_in_its_plain_form(tmp_path):
    text = ''.join(
        f'{day}06:17:32.{249713 + n * 1000:06d}{end},2,127250,{source},255,8,'
        f'{data.hex(",")}\n' for n, ((source, data), (day, end)) in enumerate(zip(FRAMES, (
            ('2015-07-10T', 'Z'), ('2015-07-10Z', ''), ('2015-07-10-', ''), ('2015-07-10 ', ''),
            ('2015-07-10T', 'Z')))))
    text += '2015-07-10T06:17:33.000Z,2,127251,23,255,8,ff,ff,ff,ff,ff,ff,ff,ff\n'
    assert CANBOAT.is_in(text.encode()) and not CANDUMP.is_in(text.encode())
    assert read(tmp_path, read_canboat_plain, text) == (EXPECTED, NOT_TAKEN)


def test_a_raw_log_of_signal_k_has_the_lines_of_canboat(tmp_path):
    text = ''.join(f'1436509052{249 + n};A;2015-07-10T06:17:32.{249713 + n * 1000:06d}Z,2,127250,'
                   f'{source},255,8,{data.hex(",")}\n' for n, (source, data) in enumerate(FRAMES))
    text = '1436509052248;N;$HEHDT,57.3,T*15\n' + text
    assert CANBOAT.is_in(text.encode())
    assert read(tmp_path, read_canboat_plain, text) == (EXPECTED, NOT_TAKEN)


def write_yacht_devices(clock, source, data):
    """Return a line of a RAW stream of Yacht Devices."""
    return f'{clock} R {identifier(source)} {data.hex(" ").upper()}\r\n'


def write_actisense(clock, source, data):
    """Return a line of N2K ASCII of Actisense; 1F112 is the PGN of a vessel heading."""
    return f'A{clock.replace(":", "")} {source:02X}FF2 1F112 {data.hex().upper()}\r\n'


GATEWAYS = [(YACHT_DEVICES, write_yacht_devices), (ACTISENSE, write_actisense)]


@pytest.mark.parametrize('form, write', GATEWAYS, ids=['Yacht Devices', 'Actisense'])
@pytest.mark.parametrize('zone, hour', [(None, 6), ('+02:00', 8)])
def test_gateways_write_the_time_of_day(tmp_path, form, write, zone, hour):
    text = ''.join(write(f'{hour:02d}:17:32.{249 + n}', source, data)
                   for n, (source, data) in enumerate(FRAMES))
    assert [*filter(lambda other: other.is_in(text.encode()), FRAME_FORMS)] == [form]
    options = StreamOptions(DriverSettings(date='2015-07-10', stamp_zone=zone))
    streams, not_taken = read(tmp_path, partial(read_frames, form, options=options), text)
    first_ns = T_NS // 10 ** 6 * 10 ** 6
    assert streams == {'23': [(first_ns, pytest.approx(10000 * DEG))],
                       '35': [(first_ns + 2 * 10 ** 6, pytest.approx(20500 * DEG))]}
    assert not_taken == NOT_TAKEN


@pytest.mark.parametrize('form, write', GATEWAYS, ids=['Yacht Devices', 'Actisense'])
def test_a_gateway_passes_midnight(tmp_path, form, write):
    text = ''.join(write(clock, 0x23, payload(10000))
                   for clock in ('23:59:59.500', '00:00:00.500', '00:00:01.500'))
    path = tmp_path / 'log_2015-07-09.txt'
    path.write_text(text)
    collected = read_frames(form, str(path))
    stamps = collected.streams()['35'].stamp_ns
    assert stamps.tolist() == [1436486399500000000 + n * 10 ** 9 for n in range(3)]
    assert collected.oddities == ['date by the name of the file']


@pytest.mark.parametrize('form, write', GATEWAYS, ids=['Yacht Devices', 'Actisense'])
def test_times_of_day_without_a_date_are_refused_with_the_option(tmp_path, form, write):
    with pytest.raises(ReaderError, match='n2k.log: the stamps have no date: set --date to that'):
        read(tmp_path, partial(read_frames, form), write('06:17:32.249', 5, payload(10000)))


def test_names_of_fields_in_camel_case_are_those_of_canboat(tmp_path):
    lines = [{'timestamp': '2015-07-10T06:17:32.249Z', 'src': 35, 'pgn': 127250, 'fields': fields}
             for fields in ({'sid': 1, 'heading': 57.3, 'reference': 'True'},
                            {'Sid': 1, 'Heading': 57.3, 'Variation': 1.0, 'Reference': 'Magnetic'},
                            {'sid': 1, 'heading': 57.3, 'variation': -1.0,
                             'reference': {'value': 1, 'name': 'Magnetic'}})]
    text = '{"version":"6.0","units":"std"}\n' + ''.join(f'{json.dumps(row)}\n' for row in lines)
    streams, not_taken = read(tmp_path, read_canboat_json, text)
    assert [heading for _, heading in streams['35']] == pytest.approx([57.3, 58.3, 56.3])
    assert not not_taken


@pytest.mark.parametrize('units', ['std', 'si', None])
@pytest.mark.parametrize('values', ['plain', 'names and values'])
def test_the_json_of_canboat(tmp_path, units, values):
    factor = math.radians(1.0) if units == 'si' else 1.0
    shown = {'True': 0, 'Magnetic': 1}
    lines = [] if units is None else [{'version': '6.1.0', 'units': units,
                                       'showLookupValues': values != 'plain'}]
    fields = [{'Heading': 57.3, 'Reference': 'True'},
              {'Heading': 114.6, 'Reference': 'Magnetic'},
              {'Heading': 114.6, 'Deviation': -0.5, 'Variation': 3.5, 'Reference': 'Magnetic'},
              {'Reference': 'True'}, {'Heading': 1.0}, {'Heading': 'north', 'Reference': 'True'},
              {'Heading': 361.0, 'Reference': 'True'}]
    for n, one in enumerate(fields):
        one = {name: value if isinstance(value, str) else value * factor
               for name, value in one.items()}
        if values != 'plain' and 'Reference' in one:
            one['Reference'] = {'value': shown[one['Reference']], 'name': one['Reference']}
        lines.append({'timestamp': f'2015-07-10T06:17:32.{249 + n}Z', 'prio': 2,
                      'src': 35 if 0 < n < 3 else 23, 'dst': 255, 'pgn': 127250,
                      'description': 'Vessel Heading', 'fields': one})
    text = ''.join(json.dumps(one) + '\n' for one in lines) + '{"pgn":127250, broken\n'
    assert is_canboat_json(text.encode())
    assert read(tmp_path, read_canboat_json, text) == (
        {'23': [(1436509052249000000, pytest.approx(57.3))],
         '35': [(1436509052251000000, pytest.approx(117.6))]},
        {'no_variation': 1, 'empty_heading': 1, 'no_reference': 1, 'bad_field': 2,
         'out_of_range': 1})


def test_a_stamp_that_is_none_is_counted(tmp_path):
    line = '{"timestamp":"soon","src":1,"pgn":127250,"fields":{"Heading":1,"Reference":"True"}}\n'
    assert read(tmp_path, read_canboat_json, line) == ({}, {'no_stamp': 1})


def canboat_lines(headings, first=''):
    """Return JSON of headings, one per second, of the source 35."""
    return first + ''.join(json.dumps({
        'timestamp': f'2015-07-10T06:{k // 60:02d}:{k % 60:02d}.000Z', 'src': 35, 'pgn': 127250,
        'description': 'Vessel Heading', 'fields': {'SID': 1, 'Heading': value,
                                                    'Reference': 'True'}}) + '\n'
        for k, value in enumerate(headings))


@pytest.mark.parametrize('decimals', [1, 3, 4, 6])
@pytest.mark.parametrize('middle_deg', [3.0, 220.0])
@pytest.mark.parametrize('radians', [True, False])
def test_json_without_units_is_in_radians_if_finer_than_the_bus(tmp_path, decimals, middle_deg,
                                                               radians):
    """The bus sends multiples of 1e-4 rad, which are 0.0057 deg: a ship moored on 003 is one."""
    counts = [round((math.radians(middle_deg) + 0.01 * math.sin(k / 7.0)) * 1e4)
              for k in range(600)]
    values = [round(n * 1e-4, 4) if radians else round(math.degrees(n * 1e-4), decimals)
              for n in counts]
    path = tmp_path / 'a.json'
    path.write_text(canboat_lines(values))
    found = read_canboat_json(str(path)).streams()['35'].heading_deg
    assert found == pytest.approx([math.degrees(n * 1e-4) for n in counts], abs=0.06)


@pytest.mark.parametrize('units, factor', [('si', math.degrees(1.0)), ('std', 1.0)])
def test_a_line_of_units_decides(tmp_path, units, factor):
    path = tmp_path / 'a.json'
    path.write_text(canboat_lines([3.0001, 3.0002, 3.0004],
                                  f'{{"version":"5.0","units":"{units}"}}\n'))
    found = read_canboat_json(str(path)).streams()['35'].heading_deg
    assert found == pytest.approx([value * factor for value in (3.0001, 3.0002, 3.0004)])
