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

"""Every form of line, as ships write it, gives its stamp; what is not one form is not guessed."""

from __future__ import annotations

from pathlib import Path

from checksums import with_checksum
import numpy as np
import pytest

from heading_intercompare.drivers.log_lines.line_formats import FORMATS
from heading_intercompare.drivers.logs import read_log
from heading_intercompare.drivers.settings import DriverSettings, STAMP_FORMATS

PAGE = Path(__file__).resolve().parents[3] / 'docs' / 'howto' / 'import_logs.md'
EVENING = '2024-05-28T20:00:00.063'


def ns_of(utc: str) -> int:
    """Return nanoseconds of a time."""
    return int(np.datetime64(utc, 'ns').astype(np.int64))


def hdt(heading_deg: float = 218.53, talker: str = 'HE') -> str:
    """Return a sentence with its checksum."""
    text = f'{talker}HDT,{heading_deg:.2f},T'
    return with_checksum(text)


@pytest.fixture
def read(tmp_path):
    """Return a function that reads a log of some lines."""
    def read(lines, name='gyro.log', end='\r\n', **settings):
        path = tmp_path / name
        path.write_bytes(''.join(line + end for line in lines).encode('latin-1'))
        return read_log(path, DriverSettings(**settings))
    return read


@pytest.mark.parametrize('form', FORMATS, ids=lambda form: form.name)
def test_the_example_of_a_form_gives_its_stamp(form, read):
    date = form.stamp[:10] if form.kind == 'clock' else None
    for named in (form.name, 'auto') if form.automatic else (form.name,):
        headings, counts = read([form.example.decode()], stamp_format=named, date=date)
        assert (headings.stamp_ns.tolist(), counts) == ([ns_of(form.stamp)], {}), named
        assert headings.heading_deg.tolist() == [218.53]
    other = 'iso' if form.name == 'epoch' else 'epoch'
    assert read([form.example.decode()], stamp_format=other)[1] == {'no_stamp': 1}


def test_the_setting_and_the_page_name_every_form():
    assert set(STAMP_FORMATS) == {'auto', 'tag', 'none', *(form.name for form in FORMATS)}
    text = PAGE.read_text('utf-8')
    for form in FORMATS:
        assert f'| `{form.name}` | {form.words} | `{form.example.decode()}` |' in text


@pytest.mark.parametrize('line', [
    '2024-05-28T20:00:00.063000Z GYRO {}', '2024-05-28 20:00:00.063 {}',
    'NAV 2024/05/28 20:00:00.063 GYRO {}', 'NAV\t2024/05/28\t20:00:00.063\tGYRO\t{}',
    '2024-05-28;20:00:00,063;GYRO;{}', '[2024-05-28 20:00:00.063] {}',
    '2024-05-28 20:00:00.063 192.168.1.5:4001 > {}',
    '192.168.1.5:4001 2024-05-28T20:00:00.063Z: {}',
    'INFO 2024-05-28 20:00:00,063 logger[17]: {}', '"2024-05-28 20:00:00.063","GYRO","{}"',
    '<2024-05-28T20:00:00.063Z> {}', '2024-05-28T22:00:00.063+02:00 GYRO {}',
    '2024-05-28 22:00:00.063 +0200 {}', '2024-05-28 20:00:00.063 UTC {}',
    '2024-05-28 08:00:00.063 PM {}', '2024.05.28 20:00:00.063 {}', '2024-5-28 20:00:00.063 {}',
    '2024-149T20:00:00.063Z {}', '2024+149:20:00:00.063 {}', '24+149:20:00:00.063 GYRO {}',
    '2024.149.20:00:00.063 {}', '20240528T200000.063Z GYRO {}', '20240528 200000.063 {}',
    '20240528-200000.063 {}', '28 May 2024 20:00:00.063 {}', '28-May-2024 20:00:00.063 GYRO {}',
    '05/28/2024,20:00:00.063,{}', '05/28/2024 08:00:00.063 PM {}', '28/05/2024 20:00:00.063 {}',
    '28.05.2024 20:00:00,063 {}', '28-05-2024 20:00:00.063 {}', '1716926400.063 {}',
    '1716926400063 {}', '1716926400063000 GYRO {}', '1716926400063000000,{}',
    't=1716926400.063 {}', '2024-05-28 20:00:00:063 {}', '2024+149:20:00:00:063 {}',
    '20240528_200000_063 {}', '20240528200000063 {}', '20240528 200000063000 GYRO {}',
    '28.05.2024 20:00:00:063 GYRO {}', '2024-05-28 20:00:00,063,1,{}',
    '"28.05.2024";"20:00:00,063";"{}"', '2024-05-28|20:00:00.063|GYRO|{}',
    '2024-05-28-20:00:00.063 {}', '2024-05-28 - 20:00:00.063 - {}',
    'May 28, 2024 20:00:00.063 {}', 'Tue May 28 20:00:00.063 2024 {}',
    'Tue May 28 20:00:00.063 UTC 2024 {}', '{} Tue May 28 20:00:00.063 2024',
    '2024,05,28,20,00,00.063,{}', '2024 5 28 20 0 0.063 {}', '2024_05_28_20_00_00.063 {}',
    '2024-05-28T20-00-00.063Z {}', '2024-05-28 20.00.00.063 {}', '2024;5;28;20;0;0,063;{}',
    '{},1716926400.063', '{};1716926400063', '{} 2024-05-28T20:00:00.063Z',
    '{},GYRO,1716926400.063',
    'GYRO {} # 2024-05-28 20:00:00.063', '{},2024,05,28,20,00,00.063',
    '{}\t05/28/2024 20:00:00.063'])
@pytest.mark.parametrize('end', ['\r\n', '\n'])
def test_a_line_as_ships_write_it_gives_its_stamp(line, end, read):
    headings, counts = read([line.format(hdt())], end=end)
    assert (headings.stamp_ns.tolist(), counts) == ([ns_of(EVENING)], {})


@pytest.mark.parametrize('line, reason', [
    ('05/06/2024 20:00:00 {}', 'ambiguous_date'), ('20:00:00.063 {}', 'no_date'),
    ('2024-05-28 20:00:00 CEST {}', 'bad_stamp'), ('2024-13-28 20:00:00 {}', 'bad_stamp'),
    ('28/28/2024 20:00:00 {}', 'bad_stamp'), ('05/28/2024 13:00:00 PM {}', 'bad_stamp'),
    ('2024-05-28 20:61:00 {}', 'bad_stamp'), ('GYRO {}', 'no_stamp'), ('{}', 'no_stamp'),
    ('00:11:22:33:44:55 {}', 'no_stamp'), ('192.168.1.5:4001 {}', 'no_stamp'),
    ('#1234567 {}', 'no_stamp'), ('200000.063 {}', 'no_stamp')])
def test_what_is_not_certain_is_not_guessed(line, reason, read):
    headings, counts = read([line.format(hdt())])
    assert len(headings) == 0 and counts == {reason: 1}


@pytest.mark.parametrize('line', [
    '2024-05-28 20:00:00,1,{}', '2024-05-28,20:00:00,17,GYRO,{}', '2024-05-28 20:00:00,218.53,{}',
    '2024-05-28 20:00:00 063 {}', '2024-05-28 20:00:00:06 {}', '2024-05-28 20:00:00_0637 {}'])
def test_a_field_after_the_clock_is_no_decimals(line, read):
    headings, counts = read([line.format(hdt())])
    assert (headings.stamp_ns.tolist(), counts) == ([ns_of('2024-05-28T20:00:00')], {})


def test_a_month_name_without_a_year_takes_it_from_the_date(read):
    line = f'May 28 20:00:00 ship nmead[123]: {hdt()}'
    headings, counts = read([line], date='2024-05-28')
    assert headings.stamp_ns.tolist() == [ns_of('2024-05-28T20:00:00')]
    assert read([line])[1] == {'no_date': 1}


@pytest.mark.parametrize('stamp_format, utc', [('mdy', '2024-05-06T20:00:00'),
                                               ('dmy', '2024-06-05T20:00:00')])
def test_a_setting_says_whether_day_or_month_comes_first(stamp_format, utc, read):
    headings, _ = read([f'05/06/2024 20:00:00 {hdt()}'], stamp_format=stamp_format)
    assert headings.stamp_ns.tolist() == [ns_of(utc)]


@pytest.mark.parametrize('later, utc', [('05/13/2024', '2024-05-12T20:00:00'),
                                        ('13/05/2024', '2024-12-05T20:00:00')])
def test_one_date_of_a_log_says_for_all_whether_the_day_comes_first(later, utc, read):
    lines = [f'05/12/2024 20:00:00 {hdt()}'] * 3 + [f'{later} 01:00:00 {hdt()}']
    headings, counts = read(lines)
    assert counts == {} and headings.stamp_ns[0] == ns_of(utc)


@pytest.mark.parametrize('zone, utc', [
    ('+02:00', '2024-05-28T18:00:00'), ('-03:30', '2024-05-28T23:30:00'),
    ('Europe/Oslo', '2024-05-28T18:00:00'), ('UTC', '2024-05-28T20:00:00')])
def test_a_local_clock_is_turned_into_utc(zone, utc, read):
    for stamp in ('2024-05-28 20:00:00', '2024-05-28 20:00:00 CEST', '05/28/2024,20:00:00'):
        headings, counts = read([f'{stamp} {hdt()}'], stamp_zone=zone)
        assert (headings.stamp_ns.tolist(), counts) == ([ns_of(utc)], {})
    headings, _ = read([f'2024-05-28T20:00:00Z {hdt()}'], stamp_zone=zone)
    assert headings.stamp_ns.tolist() == [ns_of('2024-05-28T20:00:00')]


def test_an_hour_that_the_clocks_repeat_is_not_guessed(read):
    """27 October 2024: 02:30 came twice in Oslo; 31 March 2024: it never came."""
    lines = [f'{stamp} {hdt()}' for stamp in ('2024-10-27 02:30:00', '2024-03-31 02:30:00',
                                              '2024-10-27 03:30:00')]
    headings, counts = read(lines, stamp_zone='Europe/Oslo')
    assert headings.stamp_ns.tolist() == [ns_of('2024-10-27T02:30:00')]
    assert counts == {'bad_stamp': 2}


@pytest.mark.parametrize('pattern, line, utc', [
    (r'(?P<day>\d\d)(?P<month>\d\d)(?P<year>\d\d)_(?P<hour>\d\d)(?P<minute>\d\d)(?P<second>\d\d)',
     '280524_200000 {}', '2024-05-28T20:00:00'),
    (r'@(?P<epoch>\d+)\.(?P<fraction>\d+)', '@1716926400.063@ {}', EVENING),
    (r'(?P<year>\d{4})d(?P<yday>\d+) (?P<hour>\d+)h(?P<minute>\d+)m(?P<second>\d+)',
     '{} 2024d149 20h0m0', '2024-05-28T20:00:00'),
    (r'(?P<month>[A-Z][a-z]+) (?P<day>\d+) (?P<hour>\d+):(?P<minute>\d+):(?P<second>\d+) '
     r'(?P<year>\d+)', 'Tue May 28 20:00:00 2024 {}', '2024-05-28T20:00:00')])
def test_a_pattern_of_ones_own_reads_what_no_form_does(pattern, line, utc, read):
    headings, counts = read([line.format(hdt())], stamp_pattern=pattern)
    assert (headings.stamp_ns.tolist(), counts) == ([ns_of(utc)], {})


@pytest.mark.parametrize('pattern', [
    r'(?P<hour>\d\d)(?P<minute>\d\d)?(?P<second>x)?', r'(?P<epoch>@)',
    r'(?P<hour>.)(?P<minute>.)(?P<second>.)(?P<zone>.)',
    r'(?P<year>2024)?(?P<yday>x)?.(?P<hour>\d\d)(?P<minute>\d\d)(?P<second>\d\d)'])
def test_a_pattern_that_finds_no_instant_gives_no_stamp(pattern, read):
    headings, counts = read([f'@2024 {hdt()}'], stamp_pattern=pattern)
    assert len(headings) == 0 and sum(counts.values()) == 1


def test_a_stamp_may_follow_a_sentence_without_a_checksum(read):
    lines = ['$PUHAW,UVH,-4.87,-6.04,219.2,1716926400.063',
             '$PUHAW,UVH,-4.87,-6.04,219.3 2024-05-28T20:00:01.063Z']
    headings, counts = read(lines)
    assert headings.stamp_ns.tolist() == [ns_of(EVENING), ns_of('2024-05-28T20:00:01.063')]
    assert headings.heading_deg.tolist() == [219.2, 219.3] and counts == {}


def test_the_form_of_the_first_line_goes_before_others(read):
    """A counter of ten digits between the stamp and the sentence is no Unix time."""
    lines = [f'2024-05-28T20:00:0{k}Z {hdt()}' if k == 0 else
             f'2024-05-28T20:00:0{k}Z 1716926400 {hdt()}' for k in range(3)]
    headings, _ = read(lines)
    assert np.diff(headings.stamp_ns).tolist() == [10**9, 10**9]


@pytest.mark.parametrize('damaged', ['20:00:01.063Z GYRO {}', '28T20:00:01 1234567890 GYRO {}',
                                     'T20:00:01Z {}', '#-28 20:00:01 {}'])
def test_the_rest_of_a_damaged_stamp_is_no_stamp(damaged, read):
    """The name of the file states a date, and the log may have gone on for days."""
    lines = [f'2024-05-30T20:00:00Z GYRO {hdt()}', damaged.format(hdt(2.0))]
    headings, counts = read(lines, name='gyro_20240528.log')
    assert headings.heading_deg.tolist() == [218.53]
    assert counts in ({'no_stamp': 1}, {'burst': 1})
