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

"""Stamps of lines: every form, anywhere on the line, exact to the nanosecond."""

from __future__ import annotations

from datetime import datetime, timedelta, timezone

from checksums import with_checksum
from hypothesis import given, strategies as st
import pytest

from heading_intercompare.drivers.log_lines.days import Days
from heading_intercompare.drivers.log_lines.line_stamps import LineStamps
from heading_intercompare.drivers.logs import read_log
from heading_intercompare.drivers.settings import DriverSettings

stamps = st.integers(0, 9_000_000_000 * 10**9)


def when(stamp_ns: int) -> tuple[datetime, int]:
    """Return date and time to the second, and the rest in nanoseconds."""
    seconds, rest_ns = divmod(stamp_ns, 10**9)
    return datetime(1970, 1, 1, tzinfo=timezone.utc) + timedelta(seconds=seconds), rest_ns


def log_stamp_ns(text: bytes, stamp_format: str = 'auto', **settings) -> int | None:
    """Return the stamp in a text, or None."""
    found = LineStamps(DriverSettings(stamp_format=stamp_format, **settings),
                       Days(settings.get('date'))).find(text)
    return found and found.ns


@given(stamps, st.sampled_from([3, 6, 9]), st.sampled_from('T :_'), st.sampled_from(['Z', '']))
def test_iso_stamps_are_exact(stamp_ns, decimals, separator, zulu):
    stamp_ns -= stamp_ns % 10 ** (9 - decimals)
    at, rest_ns = when(stamp_ns)
    text = at.strftime(f'%Y-%m-%d{separator}%H:%M:%S') + f'.{rest_ns:09d}'[:decimals + 1] + zulu
    assert log_stamp_ns(text.encode() + b' ') == stamp_ns
    assert log_stamp_ns(b'gyr1 ' + text.encode() + b',', 'iso') == stamp_ns
    assert log_stamp_ns(text.encode(), 'doy') is None


@given(st.integers(0, 3_100_000_000 * 10**3))
def test_stamps_with_the_day_of_the_year_are_exact(stamp_ms):
    at, rest_ns = when(stamp_ms * 10**6)
    text = at.strftime('%Y+%j:%H:%M:%S') + f'.{rest_ns:09d}'[:4]
    assert log_stamp_ns(text.encode() + b' ') == stamp_ms * 10**6
    short = at.strftime('%y+%j:%H:%M:%S') + f'.{rest_ns:09d}'[:4]
    assert log_stamp_ns(short.encode() + b' ', 'doy') == stamp_ms * 10**6


@given(st.integers(1_000_000_000 * 10**9, 9_000_000_000 * 10**9))
def test_unix_times_are_exact_in_every_unit(stamp_ns):
    text = f'{stamp_ns // 10**9}.{stamp_ns % 10**9:09d}'
    assert log_stamp_ns(text.encode() + b'\t') == stamp_ns
    assert log_stamp_ns(str(stamp_ns).encode(), 'epoch') == stamp_ns
    assert log_stamp_ns(str(stamp_ns // 10**6).encode()) == stamp_ns // 10**6 * 10**6
    assert log_stamp_ns(str(stamp_ns // 10**9).encode()) == stamp_ns // 10**9 * 10**9


@pytest.mark.parametrize('prefix, stamp_ns', [
    (b'2014-08-01T00:00:00.183000Z ', 1406851200183000000),
    (b'19+085:10:05:54.447 ', 1553594754447000000),
    (b'2014-08-01T02:00:00+02:00 ', 1406851200000000000),
    (b'2014-07-31T22:00:00.5-0200 ', 1406851200500000000),
    (b'2014-08-01T00:00:00.1234567891Z ', 1406851200123456789),
    (b'\xef\xbb\xbf2014-08-01T00:00:00Z ', 1406851200000000000),
    (b'1406851200 ', 1406851200000000000),
    (b'68+001:00:00:00 ', 3092601600000000000),
    (b'2016-12-31T23:59:60Z', 1483228800000000000),
])
def test_stamps_by_hand(prefix, stamp_ns):
    assert log_stamp_ns(prefix) == stamp_ns


@pytest.mark.parametrize('prefix', [
    b'', b' ', b'99 bottles ', b'x2014-08-01T00:00:00Z', b'14068512001 ', b'140685120 ',
    b'00:11:22:33:44:55 ', b'192.168.1.5:4001 ', b'12:34 ', b'#17 ', b'200000 '])
def test_what_is_no_stamp_is_none(prefix):
    assert log_stamp_ns(prefix) is None


@pytest.mark.parametrize('prefix', [
    b'2014-13-01T00:00:00Z ', b'2014-02-29T00:00:00Z ', b'2014-08-01T24:00:00Z ',
    b'2014-08-01T00:60:00Z ', b'19+366:00:00:00 ', b'19+000:00:00:00 ', b'9999-01-01T00:00:00Z ',
    b'1969-12-31T23:59:59Z ', b'9999999999 ', b'9999999999999999999 '])
def test_a_stamp_of_no_instant_is_an_error(prefix):
    with pytest.raises(ValueError):
        log_stamp_ns(prefix)


@pytest.mark.parametrize('prefix, stamp_ns', [
    (b'\\g:1-2-73874,n:157036,s:r003669945,c:1241544035*4A\\', 1241544035000000000),
    (b'UdPbC\0\\s:GY0001,n:1,c:1577836800*6B\\', 1577836800000000000),
    (b'\\c:1577836800123*68\\', 1577836800123000000),
    (b'\\c:1577836800123*00\\', None),
    (b'\\g:1-1-7*6A\\\\c:1577836800123*68\\', 1577836800123000000),
    (b'\\s:GY0001*56\\', None),
    (b'\\c:1577836800123*68', None),
])
def test_a_tag_block_gives_its_time_if_its_checksum_is_correct(prefix, stamp_ns):
    assert log_stamp_ns(prefix, 'tag') == stamp_ns
    assert log_stamp_ns(prefix, 'auto') == stamp_ns
    assert log_stamp_ns(prefix, 'iso') is None


def test_a_log_stamp_goes_before_the_tag_block_behind_it():
    prefix = b'2014-08-01T00:00:00Z \\c:1577836800123*68\\'
    assert log_stamp_ns(prefix) == 1406851200000000000
    assert log_stamp_ns(prefix, 'iso') == 1406851200000000000
    assert log_stamp_ns(prefix, 'tag') == 1577836800123000000


NOON = 1772366400 * 10**9   # 2026-03-01T12:00:00Z
S = 10**9


def sentence(text: str) -> str:
    """Return a sentence with its checksum, and its line end."""
    return f'{with_checksum(text)}\n'


def read(tmp_path, text: str, **settings):
    """Return stamps, headings and counts of a log."""
    (tmp_path / 'a.log').write_text(text)
    headings, counts = read_log(tmp_path / 'a.log', DriverSettings(**settings))
    return headings.stamp_ns.tolist(), headings.heading_deg.tolist(), counts


@pytest.mark.parametrize('opening', [
    '1772366400.0 ' + sentence('GPGGA,1,2'), '1772366400.0\n', 'NAV 2026-03-01T12:00:00Z GYRO\n',
    '1772366400.0 ' + sentence('GPHDT,1.0,T'), '1772366400.0 ' + sentence('HEHDT,,T'),
    sentence('GPGGA,1,2').strip() + ',1772366400.0\n'])
def test_a_bare_line_takes_the_stamp_of_its_burst_once(tmp_path, opening):
    text = opening + sentence('GPVTG,1') + sentence('HEHDT,2.0,T') + sentence('HEHDT,3.0,T')
    stamps, headings, counts = read(tmp_path, text, sentence='HDT', talker='HE')
    taken_before = ',,' in opening
    assert (stamps, headings) == (([], []) if taken_before else ([NOON], [2.0]))
    assert counts['burst'] == 1 + taken_before


def test_each_burst_gives_one_stamp_to_each_kind(tmp_path):
    text = ''.join(f'17723664{k:02d}.0 ' + sentence('GPZDA,x') + sentence(f'INHDT,{k}.0,T')
                   + sentence('PSXN,20,0,0,0,0') for k in range(10))
    stamps, headings, counts = read(tmp_path, text)
    assert stamps == [NOON + k * S for k in range(10)] and headings == [*map(float, range(10))]
    assert counts == {'not_heading': 20}


def test_the_stamp_of_a_burst_is_taken_for_all_its_lines_if_told_so(tmp_path):
    text = '1772366400.0\n' + sentence('HEHDT,2.0,T') * 3
    assert read(tmp_path, text, bursts='accept')[0] == [NOON] * 3
    assert read(tmp_path, text)[0::2] == ([NOON], {'burst': 2, 'no_sentence': 1})


def test_a_line_whose_stamp_was_lost_does_not_take_that_of_the_line_before(tmp_path):
    text = ('1772366400 ' + sentence('HEHDT,1.0,T') + sentence('HEHDT,2.0,T')
            + '1772366402 ' + sentence('HEHDT,3.0,T'))
    stamps, headings, counts = read(tmp_path, text)
    assert headings == [1.0, 3.0] and counts == {'burst': 1}


def test_after_an_impossible_stamp_a_burst_has_none(tmp_path):
    text = ('1772366400 ' + sentence('GPVTG,1') + '2026-13-01T12:00:01Z ' + sentence('GPVTG,1')
            + sentence('HEHDT,2.0,T'))
    assert read(tmp_path, text) == ([], [], {'no_stamp': 1, 'not_heading': 2})


def test_the_time_in_a_comment_opens_no_burst(tmp_path):
    text = '# begun 2026-03-01T12:00:00Z\n' + sentence('HEHDT,2.0,T')
    assert read(tmp_path, text) == ([], [], {'no_sentence': 1, 'no_stamp': 1})


@pytest.mark.parametrize('name, date', [('km2014_212_00000.hdg', None), ('a.hdg', '2014-08-01')])
def test_the_lines_of_uhdas_stamp_the_sentences_after_them(tmp_path, name, date):
    """Day 212.5, counted from 0, is noon of 1 August 2014; the year is in the name."""
    (tmp_path / name).write_text(''.join(
        f'$UNIXD,{212.5 + k / 86400:.7f},{212.5 + k / 86400:.7f}\n' + sentence(f'HEHDT,{k}.0,T')
        for k in range(3)))
    headings, counts = read_log(tmp_path / name, DriverSettings(date=date))
    noon = 1406894400 * S
    assert abs(headings.stamp_ns - [noon, noon + S, noon + 2 * S]).max() < 5_000_000
    assert len(headings) == 3 and counts == {'not_heading': 3}


def test_without_a_year_the_lines_of_uhdas_stamp_nothing(tmp_path):
    text = '$UNIXD,212.5,212.5\n' + sentence('HEHDT,2.0,T')
    assert read(tmp_path, text) == ([], [], {'no_stamp': 1, 'not_heading': 1})


def test_a_time_of_day_takes_the_date_given_and_passes_midnight(tmp_path):
    text = ''.join(f'{clock} ' + sentence('HEHDT,2.0,T') for clock in (
        '23:59:58', '23:59:59', '23:59:58.5', '00:00:01', '23:59:59.5', '00:00:02', '20:00:00'))
    stamps, _, counts = read(tmp_path, text, date='2026-02-28')
    at = [(stamp - NOON) / S + 12 * 3600 for stamp in stamps]
    assert at == [-2, -1, -1.5, 1, -0.5, 2, 20 * 3600] and counts == {}


def test_a_time_of_day_takes_the_date_that_the_stream_tells(tmp_path):
    text = ('23:59:59.9 ' + sentence('HEHDT,1.0,T')
            + '00:00:00.3 ' + sentence('GPZDA,000000.17,01,03,2026,,')
            + '00:00:00.9 ' + sentence('HEHDT,2.0,T'))
    stamps, _, counts = read(tmp_path, text)
    assert [stamp - NOON + 43_200 * S for stamp in stamps] == [-S // 10, 9 * S // 10]
    assert counts == {'not_heading': 1}
    text = text.replace(sentence('GPZDA,000000.17,01,03,2026,,'),
                        sentence('GPRMC,000000.17,A,1,N,2,E,3,4,010326,,'))
    assert read(tmp_path, text)[0] == stamps


def test_a_gap_of_most_of_a_day_is_no_step_back(tmp_path):
    text = '08:00:00 ' + sentence('HEHDT,1.0,T') + '22:00:00 ' + sentence('HEHDT,2.0,T')
    stamps, _, _ = read(tmp_path, text, date='2026-03-01')
    assert stamps == [NOON - 4 * 3600 * S, NOON + 10 * 3600 * S]


def test_stamps_that_step_back_are_kept_as_they_are(tmp_path):
    text = ''.join(f'{NOON // S + k} ' + sentence('HEHDT,1.0,T') for k in (0, 5, 3, 4))
    assert read(tmp_path, text)[0] == [NOON + k * S for k in (0, 5, 3, 4)]
