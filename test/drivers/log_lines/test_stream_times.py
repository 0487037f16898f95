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

"""Logs without stamps: the time is in ZDA, RMC, GGA or PASHR of the same stream."""

from __future__ import annotations

from checksums import with_checksum, with_long_checksum
import pytest

from heading_intercompare.core.records import Headings
from heading_intercompare.drivers.log_lines.stream_times import find_kind
from heading_intercompare.drivers.logs import LogReader, read_log
from heading_intercompare.drivers.nmea import NmeaDecoder
from heading_intercompare.drivers.settings import DriverSettings

MIDNIGHT = 1772323200 * 10**9   # 2026-03-01T00:00:00Z
S = 10**9
TIMES = {'ZDA': 'GPZDA,{:s},{:s},,', 'RMC': 'GPRMC,{:s},A,1,N,2,E,3,4,{:s},,',
         'GGA': 'GPGGA,{:s},1,N,2,E,1,8,1,2,M,3,M,,'}
SECONDS = (-2, -1, 0, 1)


def sentence(text: str) -> str:
    """Return a sentence with its checksum, and its line end."""
    return f'{with_checksum(text)}\r\n'


def telling(kind: str, second: int) -> str:
    """Return the sentence that tells a second from midnight on."""
    clock = f'{second % 86400 // 3600:02d}{second % 3600 // 60:02d}{second % 60:02d}.00'
    after = second >= 0
    date = {'ZDA': '01,03,2026' if after else '28,02,2026', 'RMC': '010326' if after else '280226',
            'GGA': ''}[kind]
    return sentence(TIMES[kind].format(clock, date))


def bare_log(kind: str) -> str:
    """Return a log over midnight in which each second is told before its heading."""
    return ''.join(telling(kind, k) + sentence(f'HEHDT,{k + 10}.0,T') for k in SECONDS)


@pytest.mark.parametrize('kind, date', [('ZDA', None), ('RMC', None), ('GGA', '2026-02-28')])
def test_a_log_without_stamps_takes_the_time_of_its_stream(kind, date, tmp_path):
    (tmp_path / 'a.log').write_text(bare_log(kind))
    headings, counts = read_log(tmp_path / 'a.log', DriverSettings(time='validity', date=date))
    assert headings.stamp_ns.tolist() == [MIDNIGHT + k * S for k in SECONDS]
    assert counts == {'not_heading': 4}
    assert len(read_log(tmp_path / 'a.log', DriverSettings(date=date))[0]) == 0


def test_the_name_of_a_file_says_the_date_of_gga(tmp_path):
    (tmp_path / 'gyro_2026-02-28.log').write_text(bare_log('GGA'))
    reader = LogReader(tmp_path / 'gyro_2026-02-28.log', DriverSettings(time='validity'))
    assert [ns for chunk in reader for ns in chunk.stamp_ns.tolist()] == [
        MIDNIGHT + k * S for k in SECONDS]
    assert reader.remarks == ['date by the name of the file']


def test_without_a_date_gga_tells_no_time(tmp_path):
    (tmp_path / 'a.log').write_text(bare_log('GGA'))
    headings, counts = read_log(tmp_path / 'a.log', DriverSettings(time='validity'))
    assert len(headings) == 0 and counts == {'bad_time': 4, 'no_validity_time': 4}


def test_pashr_takes_the_date_given_over_midnight(tmp_path):
    (tmp_path / 'a.log').write_text(''.join(
        sentence(f'PASHR,{clock},{k}.0,T,0,0,0,0,0,0,1,1')
        for k, clock in enumerate(('235959.500', '000000.500', '000001.500'))))
    headings, counts = read_log(tmp_path / 'a.log',
                                DriverSettings(time='validity', date='2026-02-28'))
    assert headings.stamp_ns.tolist() == [MIDNIGHT + k * S + S // 2 for k in (-1, 0, 1)]
    assert counts == {}
    assert read_log(tmp_path / 'a.log', DriverSettings(time='validity'))[1] == {
        'no_validity_time': 3}


@pytest.mark.parametrize('text', [
    'PTNL,AVR,{:s},+90.0,Yaw,0.1,Tilt,,,60.1,3,2.5,6',
    'PTNL,VHD,{:s},093098,90.0,0,0,0,0,0,3,7,2,M', 'PSAT,HPR,{:s},90.0,3.35,,N',
    'PSSN,HRP,{:s},061222,90.0,,0,0,,0,21,2,2.4,E',
    'GNHPR,{:s},90.0,-00.64,000.00,4,46,0.00,0999'])
def test_a_sentence_of_a_maker_takes_its_own_time(text, tmp_path):
    (tmp_path / 'a.log').write_text(''.join(
        sentence(text.format(clock)) for clock in ('235959.50', '000000.50')))
    settings = DriverSettings(time='validity', date='2026-02-28')
    headings, counts = read_log(tmp_path / 'a.log', settings)
    assert headings.stamp_ns.tolist() == [MIDNIGHT - S // 2, MIDNIGHT + S // 2]
    assert headings.heading_deg.tolist() == [90.0, 90.0] and counts == {}


@pytest.mark.parametrize('log', [
    'HEADINGA,COM1,0,1,FINESTEERING,2408,{},0,0,0;SOL_COMPUTED,L1_INT,1,90.0,0,0,0,0',
    'UNIHEADINGA,97,GPS,FINE,2408,{}000,0,0,18,12;SOL_COMPUTED,L1_INT,1,90.0,0,0,0,0',
    'INSATTA,COM1,0,1,UNKNOWN,0,0,0,0,0;2408,{}.000000,0,0,90.0,INS_SOLUTION_GOOD'])
def test_a_log_of_a_receiver_has_the_time_of_gps(log, tmp_path):
    """The first of March 2026 is the start of week 2408, and GPS is 18 s ahead of UTC."""
    text = log.format(18)
    (tmp_path / 'a.log').write_text(f'#{with_long_checksum(text)}\n')
    headings, counts = read_log(tmp_path / 'a.log', DriverSettings(time='validity'))
    assert headings.stamp_ns.tolist() == [MIDNIGHT] and counts == {}


@pytest.mark.parametrize('header', [
    'UNIHEADINGA,97,BDS,FINE,2408,18000,0,0,18,12', 'UNIHEADINGA,97,GPS,UNKNOWN,0,0,0,0,18,12',
    'HEADINGA,COM1,0,1,APPROXIMATE,2408,18.0,0,0,0', 'HEADINGA,COM1,0,1,FINE,2408,604800.0,0,0,0',
    'HEADINGA,COM1,0,1,FINE,,18.0,0,0,0', 'HEADINGA,COM1,0,1,FINE,2408,x,0,0,0',
    'HEADINGA,COM1,0,1,FINE,900,18.0,0,0,0'])
def test_a_log_of_a_receiver_without_a_fine_time_has_no_time_of_validity(header, tmp_path):
    text = f'{header};SOL_COMPUTED,L1_INT,1,90.0,0,0,0,0'
    (tmp_path / 'a.log').write_text(f'#{with_long_checksum(text)}\n')
    headings, counts = read_log(tmp_path / 'a.log', DriverSettings(time='validity'))
    assert len(headings) == 0 and counts == {'no_validity_time': 1}


def test_only_the_best_of_the_sentences_that_tell_the_time_is_used(tmp_path):
    """The receiver of the GGA is half a minute late."""
    text = ''.join(telling('GGA', k - 30) + telling('ZDA', k) + telling('RMC', k - 30)
                   + sentence(f'HEHDT,{k + 10}.0,T') for k in SECONDS)
    (tmp_path / 'a.log').write_text(text)
    headings, _ = read_log(tmp_path / 'a.log', DriverSettings(time='validity'))
    assert headings.stamp_ns.tolist() == [MIDNIGHT + k * S for k in SECONDS]
    whole = text.encode()
    assert find_kind([whole]) == 'ZDA'
    assert find_kind([whole.replace(b'ZDA', b'ZDX')]) == 'RMC'
    cut = whole.find(b'ZDA,') + 2
    assert find_kind([whole[:cut], whole[cut:]]) == 'ZDA' and find_kind([b'HDT,']) is None


@pytest.mark.parametrize('sound, talker', [('RMC', 'GP'), ('ZDA', 'II')])
def test_a_valid_time_goes_before_one_that_is_never_valid(sound, talker, tmp_path):
    """A ZDA with a year of two digits after a sound RMC or ZDA; as a log, and as a stream."""
    text = ''.join(telling(sound, k) + sentence(f'{talker}ZDA,000000,28,02,26,,')
                   + sentence(f'HEHDT,{k + 10}.0,T') for k in SECONDS)
    (tmp_path / 'a.log').write_text(text)
    headings, counts = read_log(tmp_path / 'a.log', DriverSettings(time='validity'))
    assert headings.stamp_ns.tolist() == [MIDNIGHT + k * S for k in SECONDS]
    assert counts == {'not_heading': 8}
    live = NmeaDecoder(DriverSettings(time='validity', sentence='HDT'))
    assert Headings.concatenate([live.feed(text.encode(), 0), live.flush()]) == headings


@pytest.mark.parametrize('text, kind', [
    ('GPZDA,,,,,,', 'ZDA'), ('GPZDA,,,,,,\nGPRMC,,V,,,,,,,,', 'ZDA'),
    ('GPZDA,,,,,,\nGPRMC,,V,,,,,,,,\nGPGGA,010203,1,N,2,E,1', 'GGA'),
    ('GPRMC,010203,A,1,N,2,E,3,4,010326,,\nGPZDA,010203,1,3,2026,,', 'ZDA'),
    ('HEHDT,1.0,T', None)])
def test_the_kind_of_a_log_is_the_best_that_is_ever_valid(text, kind):
    blocks = [with_checksum(line).encode() + b'\r\n' for line in text.split('\n')]
    assert find_kind(blocks) == find_kind([b''.join(blocks)[:-2]]) == kind
    bare = ''.join(f'${line}\n' for line in text.split('\n')).encode()
    assert find_kind([bare]) is None and find_kind([bare], lenient=True) == kind


@pytest.mark.parametrize('bad', ['GPRMC,000000.00,V,,,,,,,010326,,', 'GPRMC,,A,,,,,,,,,'])
def test_after_a_time_that_the_receiver_doubts_a_heading_has_none(bad, tmp_path):
    (tmp_path / 'a.log').write_text(bare_log('RMC') + sentence(bad) + sentence('HEHDT,1.0,T'))
    _, counts = read_log(tmp_path / 'a.log', DriverSettings(time='validity'))
    assert counts == {'bad_time': 1, 'no_validity_time': 1, 'not_heading': 4}
