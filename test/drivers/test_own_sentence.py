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

"""A sentence that the user describes: its fields, its talker, its time, and what is refused."""

from __future__ import annotations

from binascii import crc_hqx
import math

from checksums import with_checksum, with_long_checksum
import pytest

from heading_intercompare.cli.program import main
from heading_intercompare.core.declared_settings import SettingsError
from heading_intercompare.drivers.logs import read_log
from heading_intercompare.drivers.nmea import NmeaDecoder
from heading_intercompare.drivers.own_sentence import read_own_sentence
from heading_intercompare.drivers.sentences import Compass, heading_of, Name, Rejected
from heading_intercompare.drivers.settings import DriverSettings

SECOND_NS = 1_000_000_000
#: 2026-03-01T12:00:00Z
NOON_NS = 1_772_366_400 * SECOND_NS


@pytest.mark.parametrize('line, text, heading_deg', [
    ('PXYZ,ATT heading=3', 'PXYZ,ATT,1.0,218.5', 218.5),
    ('PXYZ,ATT heading=3', 'PXYZ,ATT,1.0,-1.5', 358.5),
    ('PXYZ heading=1 scale=0.01', 'PXYZ,21853', 218.53),
    ('PXYZ heading=1 unit=rad', 'PXYZ,3.1416', math.degrees(3.1416)),
    ('PXYZ heading=1 unit=rad', 'PXYZ,6.2832', math.degrees(6.2832) - 360.0),
    ('PXYZ heading=1 unit=rev', 'PXYZ,0.25', 90.0),
    ('PXYZ heading=1 sign=-', 'PXYZ,90', 270.0),
    ('PXYZ heading=1 sign=-', 'PXYZ,0', 0.0),
    ('PXYZ heading=1 scale=0.05625', 'PXYZ,1600', 90.0),
    ('ATT heading=1', 'HEATT,12.5', 12.5),
    ('GNATT heading=1', 'GNATT,12.5', 12.5),
    ('PXYZ heading=1 quality=2 valid=A,D', 'PXYZ,1.5, D,x', 1.5),
    ('PXYZ heading=1 quality=2 valid=A.', 'PXYZ,1.5,A.', 1.5),
    # Kinds of the table with fields of another order.
    ('HDT heading=2', 'HEHDT,T,218.5', 218.5),
    ('PSXN,23 heading=2', 'PSXN,23,218.5,0,0,0', 218.5),
    ('YAWA heading=10', '#YAWA,COM1,0,0,FINE,1,2.0,0,0,0;218.5', 218.5),
])
def test_an_own_sentence_gives_its_heading(line, text, heading_deg):
    own = read_own_sentence(line)
    assert heading_of(text.encode(), own_sentence=own) == pytest.approx(heading_deg, abs=1e-9)


@pytest.mark.parametrize('line, text, reason', [
    ('PXYZ heading=1', 'PXYZ,', 'empty_heading'),
    ('PXYZ heading=1', 'PXYZ,1e2', 'bad_field'),
    ('PXYZ heading=2', 'PXYZ,1.0', 'too_few_fields'),
    ('PXYZ heading=1 scale=0.01', 'PXYZ,36100', 'out_of_range'),
    ('PXYZ heading=1 unit=rad', 'PXYZ,6.3', 'out_of_range'),
    ('PXYZ heading=1 unit=rev', 'PXYZ,-0.6', 'out_of_range'),
    ('PXYZ heading=1 quality=2 valid=A', 'PXYZ,1.0,AB', 'invalid_quality'),
    ('PXYZ heading=1 quality=2 valid=A.', 'PXYZ,1.0,AB', 'invalid_quality'),
    ('PXYZ heading=1 quality=2 valid=A', 'PXYZ,1.0', 'too_few_fields'),
    ('PXYZ heading=1 north=magnetic', 'PXYZ,1.0', 'no_variation')])
def test_an_own_sentence_without_a_heading_says_why(line, text, reason):
    with pytest.raises(Rejected) as caught:
        heading_of(text.encode(), own_sentence=read_own_sentence(line))
    assert caught.value.reason == reason


def test_a_magnetic_one_takes_the_stated_variation():
    own = read_own_sentence('PXYZ heading=1 north=magnetic')
    assert heading_of(b'PXYZ,1.0', Compass(-2.5), own) == 358.5


@pytest.mark.parametrize('line, text, name', [
    ('PXYZ,ATT heading=2', b'PXYZ,ATT,1', Name('PXYZ,ATT', '')),
    ('PXYZ,ATT heading=2', b'PXYZ,ATTX,1', None), ('PXYZ,ATT heading=2', b'PXYZ,POS,1', None),
    ('PXYZ heading=2', b'PXYZ', None), ('ATT heading=1', b'HEATT,1', Name('ATT', 'HE')),
    ('ATT heading=1', b'HEHDT,1,T', Name('HDT', 'HE'))])
def test_it_is_identified_and_others_stay_what_they_are(line, text, name):
    assert read_own_sentence(line).identify(text) == name


@pytest.mark.parametrize('line, says', [
    ('', 'begins with the identifier'), ('$PXYZ heading=1', 'without $'),
    ('pxyz heading=1', 'begins with the identifier'), ('PXYZ', 'heading is missing'),
    ('PXYZ heading', "'heading': must be setting=value"), ('PXYZ heading=x', "heading = 'x'"),
    ('PXYZ heading=1 units=rad', "did you mean 'unit'"), ('PXYZ heading=1 unit=grad', "'rad'"),
    ('PXYZ heading=1 heading=2', 'given twice'), ('PXYZ heading=1 scale=0', 'greater than 0'),
    ('PXYZ heading=1 scale=-1', 'scale = -1.0'), ('PXYZ heading=1 sign=left', "'+' or '-'"),
    ('PXYZ heading=1 quality=2', 'belong together'), ('PXYZ heading=1 valid=A', 'belong together'),
    ('PXYZ heading=1 clock=week', 'needs time'), ('PXYZ,ATT heading=1', 'part of the identifier'),
    ('PXYZ heading=1 time=1', 'the same field'), ('PXYZ heading=1.5', 'heading = 1.5'),
    ("PXYZ heading='1", 'quotation'), ('PXYZ heading=1 checksum=crc', "'none'")])
def test_a_line_that_is_wrong_is_refused_with_what_is_allowed(line, says):
    with pytest.raises(SettingsError, match='own_sentence = ') as caught:
        DriverSettings(own_sentence=line)
    assert says in str(caught.value) and '\n' not in str(caught.value)


def test_a_kind_is_stated_only_once():
    with pytest.raises(SettingsError, match='state only one of them'):
        DriverSettings(sentence='HDT', own_sentence='PXYZ heading=1')


@pytest.mark.parametrize('fields, text, valid_ns', [
    ('time=2', 'PXYZ,1.5,120000.25', NOON_NS + SECOND_NS // 4),
    ('time=2 clock=yyyymmddhhmmss', 'PXYZ,1.5,20260301120000.25', NOON_NS + SECOND_NS // 4),
    ('time=2 clock=epoch', 'PXYZ,1.5,1772366400.25', NOON_NS + SECOND_NS // 4),
    ('time=2 clock=epoch', 'PXYZ,1.5,1772366400250', NOON_NS + SECOND_NS // 4),
    ('time=2 clock=week', 'PXYZ,1.5,2408,43218.25', NOON_NS + SECOND_NS // 4),
    ('time=2', 'PXYZ,1.5,12:00', None), ('time=4', 'PXYZ,1.5', None),
    ('time=2 clock=epoch', 'PXYZ,1.5,17', None),
    ('time=2 clock=yyyymmddhhmmss', 'PXYZ,1.5,20260230120000', None),
    ('time=2 clock=week', 'PXYZ,1.5,2408', None)])
def test_its_own_time_is_the_time_of_validity(fields, text, valid_ns, tmp_path):
    log = tmp_path / 'a.log'
    log.write_text(with_checksum(text) + '\n')
    headings, counts = read_log(log, DriverSettings(
        own_sentence=f'PXYZ heading=1 {fields}', time='validity', date='2026-03-01'))
    assert headings.stamp_ns.tolist() == ([] if valid_ns is None else [valid_ns])
    assert sum(counts.values()) == (valid_ns is None)


@pytest.mark.parametrize('line, checksum, n', [
    ('PXYZ,1.5*{:02X}', 'required', 1), ('PXYZ,1.5', 'required', 0), ('PXYZ,1.5', 'none', 1),
    ('PXYZ,1.5*00', 'none', 0), ('PXYZ,1.5*{1:04X}', 'required', 1),
    ('PXYZ,1.5*{1:04X}x', 'required', 1), ('PXYZ,1.5*1234', 'required', 0),
    (with_long_checksum('PXYZ,1.5'), 'required', 1)])
def test_its_checksum_is_told_by_its_form(line, checksum, n):
    body = b'PXYZ,1.5'
    line = line.format(int(with_checksum(body.decode())[-2:], 16), crc_hqx(body, 0))
    decoder = NmeaDecoder(DriverSettings(
        own_sentence=f'PXYZ heading=1 checksum={checksum}', learn_s=0.0))
    chunk = decoder.feed(f'${line}\r\n'.encode(), NOON_NS)
    assert chunk.heading_deg.tolist() == [1.5] * n


def test_it_is_the_sentence_that_is_read():
    """Also of a line that has kinds of the table, and from the talker stated."""
    data = ''.join(with_checksum(text) + '\r\n' for text in (
        'HEHDT,1.0,T', 'HEATT,2.0', 'GPATT,3.0', 'HETHS,4.0,A')).encode()
    decoder = NmeaDecoder(DriverSettings(own_sentence='ATT heading=1', talker='GP', learn_s=0.0))
    assert decoder.feed(data, NOON_NS).heading_deg.tolist() == [3.0]
    assert decoder.counts == {'other_sentence.HDT': 1, 'other_sentence.THS': 1,
                              'other_talker.HE': 1}


@pytest.fixture
def log(tmp_path):
    """Return the path of a log of a sentence that no table has."""
    path = tmp_path / 'a.log'
    path.write_text(''.join(f'2026-03-01T12:00:{k:02d}Z {with_checksum(f"PXYZ,ATT,{k},21853")}\n'
                            for k in range(20)))
    return str(path)


def test_two_logs_are_imported_each_with_its_sentence(log, tmp_path, capsys):
    bag = tmp_path / 'bag'
    assert main(['import-nmea', '--ts', log, '--rs', log, '-o', str(bag),
                 '--ts-own-sentence', 'PXYZ,ATT heading=3 scale=0.01',
                 '--rs-own-sentence', 'PXYZ,ATT heading=2']) == 0
    assert '20 headings' in capsys.readouterr().out


@pytest.mark.parametrize('option, says', [
    ([], 'describe another one with --ts-own-sentence'),
    (['--ts-own-sentence', 'PXYZ,ATT heading=9'],
     'too_few_fields; correct the numbers of fields in --ts-own-sentence'),
    (['--ts-own-sentence', 'PXYZ heading=0'], 'heading is missing'),
    (['--ts-own-sentence', 'PXYW heading=2'], 'which gives no heading')])
def test_what_gives_no_heading_is_one_line_that_says_what_to_set(option, says, log, tmp_path,
                                                                 capsys):
    assert main(['import-nmea', '--ts', log, '--rs', log, '-o', str(tmp_path / 'b'), *option]) == 2
    err = capsys.readouterr().err
    assert says in err and err.count('\n') == 1
