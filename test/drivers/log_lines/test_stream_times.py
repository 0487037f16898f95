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

from checksums import with_checksum
import pytest

from heading_intercompare.drivers.log_lines.stream_times import find_kind
from heading_intercompare.drivers.logs import LogReader, read_log
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


@pytest.mark.parametrize('bad', ['GPRMC,000000.00,V,,,,,,,010326,,', 'GPRMC,,A,,,,,,,,,'])
def test_after_a_time_that_the_receiver_doubts_a_heading_has_none(bad, tmp_path):
    (tmp_path / 'a.log').write_text(bare_log('RMC') + sentence(bad) + sentence('HEHDT,1.0,T'))
    _, counts = read_log(tmp_path / 'a.log', DriverSettings(time='validity'))
    assert counts == {'bad_time': 1, 'no_validity_time': 1, 'not_heading': 4}
