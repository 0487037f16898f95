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

"""The files of a log: compressed by content, in Unicode forms, in folders and by patterns."""

from __future__ import annotations

import bz2
import gzip
import lzma

import pytest
import zstandard

from heading_intercompare.drivers.log_lines.log_files import is_several
from heading_intercompare.drivers.logs import is_log, LogReader, read_log
from heading_intercompare.drivers.settings import DriverError

TEXT = b''.join(b'17723664%02d $HEHDT,1.0,T*2E\r\n' % k for k in range(60))


@pytest.mark.parametrize('encode', [
    gzip.compress, bz2.compress, lzma.compress, zstandard.compress,
    lambda text: gzip.compress(text[:200]) + gzip.compress(text[200:]),
    lambda text: zstandard.compress(text[:200]) + zstandard.compress(text[200:]),
    lambda text: b'\xef\xbb\xbf' + text, lambda text: text.decode().encode('utf-16'),
    lambda text: b'\xfe\xff' + text.decode().encode('utf-16-be'),
    lambda text: text.decode().encode('utf-16-le'), lambda text: text.rstrip(),
    lambda text: gzip.compress(text.decode().encode('utf-16'))])
def test_a_log_is_read_by_its_content_whatever_its_name(encode, tmp_path):
    (tmp_path / 'plain.log').write_bytes(TEXT)
    (tmp_path / 'gyro.txt').write_bytes(encode(TEXT))
    assert is_log(tmp_path / 'gyro.txt')
    for block_bytes in (7, 1 << 20):
        reader = LogReader(tmp_path / 'gyro.txt', block_bytes=block_bytes)
        found = sum(len(chunk) for chunk in reader)
        assert (found, reader.counts, reader.position) == (60, {}, reader.size)
    assert read_log(tmp_path / 'gyro.txt') == read_log(tmp_path / 'plain.log')


@pytest.mark.parametrize('compress', [gzip.compress, bz2.compress, lzma.compress,
                                      zstandard.compress])
def test_compressed_data_that_end_early_give_what_they_hold_and_say_so(compress, tmp_path):
    text = b''.join(b'%d.%d $HEHDT,1.0,T*2E\n' % (1772366400 + k, k * 7919 % 1000)
                    for k in range(200_000))
    (tmp_path / 'a.gz').write_bytes(compress(text)[:-2000])
    reader = LogReader(tmp_path / 'a.gz')
    assert 1000 < sum(len(chunk) for chunk in reader) < 200_000
    assert reader.remarks == [f'{tmp_path / "a.gz"} ends too early']


def test_damaged_compressed_data_are_an_error_that_names_the_file(tmp_path):
    data = bytearray(zstandard.compress(TEXT * 100))
    data[20:40] = bytes(20)
    (tmp_path / 'a.zst').write_bytes(data)
    with pytest.raises(DriverError, match=r'a\.zst: the compressed data are damaged'):
        read_log(tmp_path / 'a.zst')


@pytest.fixture
def hours(tmp_path):
    """Return a folder with a log an hour: names in no order of letters, one of them empty."""
    folder = tmp_path / 'hours'
    (folder / 'day').mkdir(parents=True)
    for hour in (9, 10, 11):
        where = folder / 'day' if hour == 11 else folder
        (where / f'gyro_{hour}.log').write_bytes(
            f'2026-03-01T{hour:02d}:00:00Z $HEHDT,1.0,T*2E'.encode())
    (folder / 'gyro_12.log').touch()
    (folder / 'README').write_text('These are the logs.\n')
    (folder / '.hidden').write_bytes(TEXT)
    return folder


@pytest.mark.parametrize('pattern', ['', '/**/gyro_*', '/**'])
def test_the_files_of_a_folder_or_a_pattern_are_one_log_in_order_of_time(hours, pattern):
    path = str(hours) + pattern
    assert is_log(path)
    reader = LogReader(path)
    stamps = [ns for chunk in reader for ns in chunk.stamp_ns.tolist()]
    assert len(stamps) == 3 and stamps == sorted(stamps) and reader.counts == {}
    assert reader.remarks == ['3 files'] and reader.position == reader.size


def test_the_first_stamps_decide_before_the_names(tmp_path):
    """Day first in a name puts 1 February before 31 January."""
    for name, stamp in (('gyro_01-02.log', '2026-02-01'), ('gyro_31-01.log', '2026-01-31')):
        (tmp_path / name).write_text(f'{stamp} 12:00:00 $HEHDT,1.0,T*2E\n')
    stamps = read_log(tmp_path)[0].stamp_ns
    assert stamps[0] < stamps[1]


def test_the_names_say_the_dates_of_times_of_day(tmp_path):
    """A day is missing between the files."""
    for day in ('20260301', '20260303'):
        (tmp_path / f'gyro_{day}.log').write_text('12:00:00 $HEHDT,1.0,T*2E\n'
                                                  '00:00:01 $HEHDT,2.0,T*2D\n')
    reader = LogReader(tmp_path)
    stamps = [ns for chunk in reader for ns in chunk.stamp_ns.tolist()]
    assert [(ns // 10**9 - 1772366400) / 3600 for ns in stamps[::2]] == [0.0, 48.0]
    assert reader.remarks == ['2 files', 'date by the name of the file']


def test_no_burst_goes_on_in_another_file(tmp_path):
    (tmp_path / 'a_1.log').write_text('1772366400 $GPVTG,1*7A\n')
    (tmp_path / 'a_2.log').write_text('$HEHDT,1.0,T*2E\n1772366401 $HEHDT,2.0,T*2D\n')
    headings, counts = read_log(tmp_path)
    assert headings.heading_deg.tolist() == [2.0] and counts['no_stamp'] == 1


def test_a_pattern_is_what_names_no_file(tmp_path):
    (tmp_path / 'a[1].log').write_bytes(TEXT)
    assert not is_several(str(tmp_path / 'a[1].log')) and is_log(tmp_path / 'a[1].log')
    assert is_several(str(tmp_path / 'a*.log')) and not is_several(str(tmp_path / 'b.log'))
    with pytest.raises(DriverError, match='no file with anything in it'):
        LogReader(tmp_path / 'b*.log')
    assert not is_log(tmp_path / 'b*.log')


def test_a_bag_is_no_folder_of_logs(tmp_path):
    (tmp_path / 'metadata.yaml').write_text('x: 1\n')
    (tmp_path / 'a.log').write_bytes(TEXT)
    assert not is_log(tmp_path)


def test_a_link_in_a_folder_that_leads_nowhere_is_named(tmp_path):
    (tmp_path / 'a.log').write_bytes(TEXT)
    (tmp_path / 'b.log').symlink_to(tmp_path / 'b.log')
    reader = LogReader(tmp_path)
    assert sum(len(chunk) for chunk in reader) == 60
    assert reader.remarks == [f'{tmp_path / "b.log"} is a link that leads nowhere']
