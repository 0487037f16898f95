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

"""Csv of headings, as decoders of NMEA 2000 write them."""

from __future__ import annotations

import math

import pytest

from heading_intercompare.core.records import Headings
from heading_intercompare.drivers.logs import is_log, LogReader, read_log
from heading_intercompare.drivers.motion.motion_log import read_log_motion
from heading_intercompare.drivers.playback import FileSource
from heading_intercompare.drivers.refused_lines import explain_no_heading
from heading_intercompare.drivers.settings import DriverError, DriverSettings

HEADER = 't_ns,src,heading_deg,deviation_deg,variation_deg,reference_0true_1mag'


@pytest.fixture
def csv(tmp_path):
    """Return a function that writes lines to a csv and returns its path."""
    def write(*lines: str):
        path = tmp_path / 'headings.csv'
        path.write_text('\n'.join(lines) + '\n', 'utf-8')
        return path
    return write


def test_two_columns_are_enough(csv):
    path = csv('t_ns,heading_deg', '1782972093006000001,1.5', '1782972093006000002, 360 ')
    headings, counts = read_log(path)
    assert headings == Headings.as_sent([1782972093006000001, 1782972093006000002], [1.5, 0.0])
    assert counts == {}


@pytest.mark.parametrize('row, heading_deg', [
    ('1,5,10.0,,7.0,0', 10.0), ('1,5,10.0,,,', 10.0), ('1,5,10.0,,7.0,1', 17.0),
    ('1,5,10.0,-1.0,7.0,1', 16.0), ('1,5,359.0,,7.0,1', 6.0), ('1,5,1.0,,-7.0,1', 354.0)])
def test_magnetic_headings_are_turned_by_deviation_and_variation(csv, row, heading_deg):
    assert read_log(csv(HEADER, row))[0] == Headings.as_sent([1], [heading_deg])


@pytest.mark.parametrize('row, reason', [
    ('1,5,,,,0', 'empty_heading'), ('1,5,x,,,0', 'bad_field'), ('1,5,nan,,,0', 'out_of_range'),
    ('1,5,361,,,0', 'out_of_range'), ('1,5,10.0,,,1', 'no_variation'),
    ('1,5,10.0,,nan,1', 'bad_field'), ('1,5,10.0,,7.0,2', 'bad_field'),
    (',5,10.0,,,0', 'no_stamp'), ('1.5,5,10.0,,,0', 'bad_stamp'), ('-1,5,10.0,,,0', 'bad_stamp'),
    ('9223372036854775808,5,10.0,,,0', 'bad_stamp'), ('1,5,10.0', 'too_few_fields'),
    ('1,5,10.0,,,0,0', 'bad_field'), ('1,6,10.0,,,0', 'other_talker.6')])
def test_a_row_without_a_heading_is_counted_by_reason(csv, row, reason):
    headings, counts = read_log(csv(HEADER, '0,5,20.0,,,0', row))
    assert headings == Headings.as_sent([0], [20.0]) and counts == {reason: 1}


def test_one_source_is_taken(csv):
    path = csv(HEADER, '1,52,10.0,,,0', '2,27,20.0,,,0', '3,52,30.0,,,0', '')
    assert read_log(path) == (Headings.as_sent([1, 3], [10.0, 30.0]), {'other_talker.27': 1})
    assert read_log(path, DriverSettings(talker='27')) == (
        Headings.as_sent([2], [20.0]), {'other_talker.52': 2})


@pytest.mark.parametrize('block_bytes', [1, 3, 50])
def test_the_size_of_the_blocks_changes_nothing(csv, block_bytes):
    path = csv(HEADER, '1,52,10.0,,,0', '2,27,20.0,,,0', '3,52,30.0,,,0')
    reader = LogReader(path, block_bytes=block_bytes)
    assert (Headings.concatenate(list(reader)), reader.counts) == read_log(path)


def test_a_missing_column_is_named(csv):
    with pytest.raises(DriverError, match=r'headings\.csv: column t_ns is missing'):
        read_log(csv('time,heading_deg', '1,2'))


def test_headings_of_nmea_2000_are_read(shared_data):
    path = shared_data / 'n2k_canboat' / 'triton-engine-setup.127250.csv'
    headings, counts = read_log(path)
    assert len(headings) == 261 and counts == {'other_talker.27': 521}
    assert (headings.stamp_ns[0], headings.heading_deg[0]) == (1782972093006000000, 298.700087)
    headings, counts = read_log(path, DriverSettings(talker='27'))
    assert len(headings) == 0 and counts == {'no_variation': 521, 'other_talker.52': 261}


def write_hours(folder):
    """Write a log of three files: names mislead, and one has its columns in another order."""
    folder.mkdir()
    (folder / 'hour_10.csv').write_text('t_ns,heading_deg\n3000,3.0\n4000,4.0')
    (folder / 'hour_9.csv').write_text('heading_deg,t_ns\n5.0,5000\n')
    (folder / 'hour_11.csv').write_text('t_ns,heading_deg\n1000,1.0\n2000,\n')
    (folder / 'notes.txt').write_text('calm sea\n')
    return folder


@pytest.mark.parametrize('block_bytes', [1, 7, 1000])
@pytest.mark.parametrize('name', ['gnss', 'gnss/hour_*.csv'])
def test_the_files_of_a_folder_are_one_log_in_order_of_time(tmp_path, name, block_bytes):
    write_hours(tmp_path / 'gnss')
    assert is_log(tmp_path / name)
    reader = LogReader(tmp_path / name, block_bytes=block_bytes)
    headings = Headings.concatenate(list(reader))
    assert headings == Headings.as_sent([1000, 3000, 4000, 5000], [1.0, 3.0, 4.0, 5.0])
    assert reader.counts == {'empty_heading': 1} and reader.remarks == ['3 files']


def test_one_source_is_taken_of_all_files(tmp_path):
    for name, src in (('a', '5'), ('b', '6')):
        (tmp_path / f'{name}.csv').write_text(f't_ns,src,heading_deg\n1,{src},10.0\n')
    assert read_log(tmp_path) == (Headings.as_sent([1], [10.0]), {'other_talker.6': 1})


def test_a_file_of_a_folder_that_lacks_a_column_is_named(tmp_path):
    (tmp_path / 'a.csv').write_text('t_ns,heading_deg\n1,1.0\n')
    (tmp_path / 'b.csv').write_text('time,heading_deg\n1,1.0\n')
    with pytest.raises(DriverError, match='b.csv: column t_ns is missing'):
        LogReader(tmp_path)


def test_sentences_in_a_folder_come_before_csv(tmp_path):
    (tmp_path / 'a.csv').write_text('t_ns,heading_deg\n1,1.0\n')
    (tmp_path / 'b.log').write_text('1772366400 $HEHDT,2.0,T*2D\n')
    assert read_log(tmp_path)[0].heading_deg.tolist() == [2.0]


def test_a_folder_of_csv_without_a_heading_is_explained_by_its_line(tmp_path):
    (tmp_path / 'a.csv').write_text('t_ns,heading_deg\n1,\n')
    (tmp_path / 'b.csv').write_text('t_ns,heading_deg\n2,400.0\n')
    _, counts = read_log(tmp_path)
    assert counts == {'empty_heading': 1, 'out_of_range': 1}
    assert '2,400.0' in explain_no_heading(str(tmp_path), DriverSettings(), {'out_of_range': 1})


def test_a_folder_of_csv_has_no_motion_and_cannot_be_played(tmp_path):
    folder = write_hours(tmp_path / 'gnss')
    assert len(read_log_motion(folder).rows) == 0
    with pytest.raises(DriverError, match='a csv cannot be played, only imported'):
        FileSource(DriverSettings(source=f'file:{folder}'))


@pytest.mark.parametrize('cut', [2, 3, 4, 5, 6])
def test_a_last_number_that_is_cut_is_no_other_heading(tmp_path, cut):
    """39.927 cut to 3 would be an outlier of 37 degrees."""
    path = tmp_path / 'headings.csv'
    text = 't_ns,heading_deg\n1,40.123\n2,39.927\n'
    path.write_text(text[:-cut])
    assert read_log(path) == (Headings.as_sent([1], [40.123]), {'cut_line': 1})


def test_a_last_line_without_end_that_is_whole_is_read(tmp_path):
    path = tmp_path / 'headings.csv'
    path.write_text('t_ns,heading_deg\n1,40.123\n2,39.927')
    assert read_log(path) == (Headings.as_sent([1, 2], [40.123, 39.927]), {})


def test_headings_that_count_from_minus_180_are_taken(csv):
    headings, counts = read_log(csv('t_ns,heading_deg', '1,-0.5', '2,179.5', '3,-180.0'))
    assert headings.heading_deg.tolist() == [359.5, 179.5, 180.0] and not counts


def test_a_negative_number_after_a_heading_beyond_180_is_none(csv):
    headings, counts = read_log(csv('t_ns,heading_deg', '1,-0.5', '2,180.5', '3,-1.0'))
    assert headings.heading_deg.tolist() == [359.5, 180.5] and counts == {'out_of_range': 1}


def test_radians_in_a_column_of_degrees_are_refused(csv):
    rows = [f'{k},{(6.0 + 0.01 * k) % (2.0 * math.pi):.4f}' for k in range(1, 400)]
    with pytest.raises(DriverError, match='look like radians, not degrees, as a column heading_d'):
        read_log(csv('t_ns,heading_deg', *rows))
