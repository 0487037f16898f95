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

"""The stamps of the rows of a table: the forms of logs, numbers, and columns of any name."""

from __future__ import annotations

from datetime import datetime, timedelta

import numpy as np
import pytest

from heading_intercompare.drivers.settings import DriverSettings
from heading_intercompare.readers.stamp_columns import find_time_columns
from heading_intercompare.readers.stream_recording import ReaderError, StreamOptions
from heading_intercompare.readers.tables import is_table, read_table

START = datetime(2024, 5, 28, 20)
START_NS = 1716926400 * 10 ** 9
N = 40


def seconds(moment):
    return (moment - datetime(1970, 1, 1)).total_seconds()


def write(form, names='time', separator=','):
    """Return a csv with a reading every half second, its stamps as a form of strftime or so."""
    rows = [separator.join((names, 'hdg'))]
    for k in range(N):
        moment = START + timedelta(seconds=k / 2)
        cells = form(moment) if callable(form) else moment.strftime(form)
        rows.append(separator.join((cells, '1.5' if separator == ',' else '1,5')))
    return '\n'.join(rows) + '\n'


def read(tmp_path, text, name='a.csv', **settings):
    path, options = tmp_path / name, StreamOptions(DriverSettings(**settings))
    path.write_text(text)
    assert is_table(text.encode(), options)
    return read_table(str(path), options)


def stamps_of(collected):
    assert not collected.not_taken
    return collected.streams()['hdg'].stamp_ns


@pytest.mark.parametrize('form, separator, settings', [
    ('%Y/%m/%d %H:%M:%S.%f', ',', {}), ('%m/%d/%Y %H:%M:%S.%f', ',', {}),
    ('%d/%m/%Y %H:%M:%S.%f', ';', {}), ('%d-%m-%Y %H:%M:%S.%f', ',', {}),
    ('%d.%m.%Y %H:%M:%S,%f', ';', {}), ('%d.%m.%Y %H:%M:%S,%f', '\t', {}),
    ('%Y-%m-%dT%H:%M:%S.%fZ', ',', {}), ('%Y-%m-%d %H:%M:%S.%f+00:00', ',', {}),
    ('%Y-%m-%d %H:%M:%S.%f', ',', {'stamp_zone': '+00:00'}),
    ('%m/%d/%Y %I:%M:%S.%f %p', ',', {}), ('%d-%b-%Y %H:%M:%S.%f', ',', {}),
    ('%a %b %d %H:%M:%S.%f %Y', ',', {}), ('%a, %d %b %Y %H:%M:%S.%f +0000', ';', {}),
    ('[%Y-%m-%d %H:%M:%S.%f]', ',', {}), ('%Y:%j:%H:%M:%S.%f', ',', {}),
    ('%Y%m%dT%H%M%S.%f', ',', {}), ('%Y%m%d%H%M%S.%f', ',', {}),
    ('%H:%M:%S.%f', ',', {'date': '2024-05-28'}),
    ('%H%M%S.%f', ',', {'date': '2024-05-28', 'stamp_format': 'hhmmss'}),
    ("%M:%S,%f at %H o'clock", ';', {
        'stamp_pattern': '(?P<minute>..):(?P<second>..),(?P<fraction>\\d+) at (?P<hour>..)'
                         " o'clock", 'date': '2024-05-28'}),
    (lambda moment: f'{seconds(moment):.3f}', ',', {}),
    (lambda moment: f'{seconds(moment):.3f}'.replace('.', ','), ';', {}),
    (lambda moment: f'{seconds(moment):.18e}', ',', {}),
    (lambda moment: f'{seconds(moment) * 1e3:.0f}', ',', {'stamp_format': 'epoch'}),
    (lambda moment: f'{seconds(moment) * 1e3:.1f}', ',', {}),
    (lambda moment: f'{seconds(moment) * 1e6:.0f}', ',', {}),
    (lambda moment: f'{int(seconds(moment) * 10) * 10 ** 8}', ',', {})])
def test_cells_have_the_forms_of_stamps_of_logs(tmp_path, form, separator, settings):
    stamps = stamps_of(read(tmp_path, write(form, separator=separator), **settings))
    assert stamps.tolist() == [START_NS + k * 5 * 10 ** 8 for k in range(N)]


@pytest.mark.parametrize('decimals, mark, separator', [(10, '.', ','), (9, ',', ';')])
def test_days_of_a_spreadsheet_are_read(tmp_path, decimals, mark, separator):
    text = write(lambda moment: f'{seconds(moment) / 86400 + 25569:.{decimals}f}'.replace(
        '.', mark), separator=separator)
    stamps = stamps_of(read(tmp_path, text))
    assert np.abs(stamps - START_NS - np.arange(N) * 5 * 10 ** 8).max() <= (
        86400 * 10 ** (9 - decimals) / 2 + 1000)


@pytest.mark.parametrize('names, form, settings', [
    ('Date,Time', '%m/%d/%Y,%H:%M:%S.%f', {}), ('date,time', '%Y-%m-%d,%H:%M:%S.%fZ', {}),
    ('UTC Date,UTC Time', '%Y%m%d,%H%M%S.%f', {}), ('Date,Time', '%d.%m.%Y,%H:%M:%S.%f', {}),
    ('Date,Time', '%m/%d/%Y,%I:%M:%S.%f %p', {}),
    ('Date,Time', '%Y-%m-%d 00:00:00,%H:%M:%S.%f', {}),
    ('Date,Time', '%d/%m/%y,%Y-%m-%dT%H:%M:%S.%fZ', {}),
    ('tag,uhr', '%d.%m.%Y,%H:%M:%S.%f', {'time_column': 'tag, uhr'}),
    ('year,doy,hms', '%Y,%j,%H:%M:%S.%f', {'time_column': 'year,doy,hms'}),
    ('y,mo,d,h,mi,s', '%Y,%m,%d,%H,%M,%S.%f', {'time_column': 'y,mo,d,h,mi,s'}),
    ('t,sent', 'x,%Y-%m-%d %H:%M:%S.%f', {'time_column': 'sent'}),
    ('Timestamp (UTC)', '%Y-%m-%d %H:%M:%S.%f', {}), ('Date', '%Y-%m-%d %H:%M:%S.%f', {})])
def test_a_stamp_may_stand_in_several_columns_of_any_name(tmp_path, names, form, settings):
    stamps = stamps_of(read(tmp_path, write(form, names), **settings))
    assert stamps.tolist() == [START_NS + k * 5 * 10 ** 8 for k in range(N)]


def test_rows_of_noaa_end_with_a_comma(tmp_path):
    text = 'Date,Time,LAT,GYRO-HEADING,\n05/28/2024,20:00:00.000,-18.4,219.05,\n'
    streams = read(tmp_path, text).streams()
    assert streams['GYRO-HEADING'].stamp_ns.tolist() == [START_NS]


@pytest.mark.parametrize('names, columns', [
    (('Date', 'Time', 'hdg'), ['Date', 'Time']), (('Time', 'gps_time', 'hdg'), ['Time']),
    (('gps_time', 'log_time', 'hdg'), []), (('DateTime', 'hdg'), ['DateTime']),
    (('timeout', 'hdg'), []), (('HeadingTime', 'hdg'), [])])
def test_columns_of_times_are_found_by_the_words_in_their_names(names, columns):
    assert find_time_columns(names) == columns


@pytest.mark.parametrize('name, unit_ns', [('time_s', 10 ** 9), ('Time [ms]', 10 ** 6),
                                           ('TimeUs', 10 ** 3), ('t_ns', 1)])
def test_the_unit_in_a_name_holds_for_numbers_of_any_size(tmp_path, name, unit_ns):
    text = f'{name},hdg\n' + ''.join(f'{10 ** 9 // unit_ns * k},1\n' for k in range(1, N))
    assert stamps_of(read(tmp_path, text)).tolist() == [k * 10 ** 9 for k in range(1, N)]


@pytest.mark.parametrize('first_s, unit', [(999_999_980, 1), (999_999_980, 1000)])
def test_one_unit_holds_where_the_number_of_digits_changes(tmp_path, first_s, unit):
    text = 'time,hdg\n' + ''.join(f'{(first_s + k) * unit},1\n' for k in range(N))
    assert stamps_of(read(tmp_path, text)).tolist() == [
        (first_s + k) * 10 ** 9 for k in range(N)]


def test_numbers_before_the_clock_was_set_are_counted(tmp_path):
    text = 'time,hdg\n0,1\n12.5,1\n' + ''.join(f'{1716926400 + k},1\n' for k in range(N))
    collected = read(tmp_path, text)
    assert dict(collected.not_taken) == {'bad_stamp': 2}
    assert len(collected.streams()['hdg']) == N
    assert "line 2: column time: '0' is no stamp" in collected.oddities[0]


@pytest.mark.parametrize('form, settings, problem', [
    ('05/06/2024 %H:%M:%S', {}, r"line 2: column time: '05/06/2024 20:00:00' .*--stamp-format to"),
    ('%m/%d/%Y %H:%M:%S', {'stamp_format': 'dmy'}, "'05/28/2024 20:00:00' is no stamp"),
    ('%H:%M:%S', {}, "'20:00:00' is no stamp .*--date"),
    ('%Y-%m-%d %H:%M', {}, 'it has no seconds'),
    ('%m/%d/%y %H:%M:%S', {'date': '2024-05-28'}, 'the year with four digits'),
    ('soon', {}, "'soon' .* --time-column"), ('%Y-%m-%d %H:%M:%S x', {}, 'x. is no stamp'),
    ('%Y-%m-%d %H:%M:%S CEST', {}, '--stamp-zone'), ('12.5', {}, 'time_ms'),
    ('1.71693e+09', {}, 'write every digit'), ('9999999999', {}, "'9999999999' is no stamp"),
    (lambda moment: f'{seconds(moment) / 86400 + 25569:.5f}', {}, 'rounded it')])
def test_a_table_without_a_stamp_is_refused_with_its_first_cell(tmp_path, form, settings, problem):
    with pytest.raises(ReaderError, match=problem):
        read(tmp_path, write(form), **settings)


@pytest.mark.parametrize('names, settings, problem', [
    ('stamp_ns', {}, 'milliseconds since 1970, which its name contradicts'),
    ('time', {'time_column': 'clock'}, r'no column of times \(clock\); it has time, hdg')])
def test_a_wrong_name_of_a_column_is_refused(tmp_path, names, settings, problem):
    path = tmp_path / 'a.csv'
    path.write_text(write(lambda moment: f'{seconds(moment) * 1e3:.0f}', names))
    with pytest.raises(ReaderError, match=problem):
        read_table(str(path), StreamOptions(DriverSettings(**settings)))


def test_the_name_of_a_file_tells_the_date_of_times_of_day(tmp_path):
    collected = read(tmp_path, write('%H:%M:%S.%f'), 'gyro_2024-05-28.csv')
    assert stamps_of(collected)[0] == START_NS
    assert 'date by the name of the file' in collected.oddities[0]


@pytest.mark.parametrize('name, date, undone', [
    ('a.csv', '2044-01-12', True), ('ins_2044-01-12.csv', None, True),
    ('a.csv', '2063-08-29', True), ('a.csv', '2044-01-10', False), ('a.csv', None, False)])
@pytest.mark.parametrize('form', ['%Y-%m-%d %H:%M:%S.%f', seconds])
def test_a_date_1024_weeks_later_undoes_a_rollover_of_gps(form, name, date, undone, tmp_path):
    """7168 days after 2024-05-28 it is 2044-01-12, and as long after that 2063-08-29."""
    text = write(form if form != seconds else lambda moment: f'{seconds(moment):.3f}')
    collected = read(tmp_path, text, name, date=date)
    weeks = {'2063-08-29': 2048}.get(str(date), 1024) * undone
    assert stamps_of(collected)[0] == START_NS + weeks * 7 * 86400 * 10 ** 9
    assert np.all(np.diff(stamps_of(collected)) == 5 * 10 ** 8)
    assert [f'{weeks} weeks early' in words for words in collected.oddities] == [True] * undone
