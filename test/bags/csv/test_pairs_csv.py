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

"""Csv of pairs: exact stamps, exact headings, mistakes named by line."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
import hashlib
import os

import numpy as np
import pytest

from heading_intercompare.bags.csv.pairs_csv import (
    COLUMNS,
    PairsCsv,
    PairsCsvWriter,
    read_pairs_csv,
    write_pairs_csv,
)
from heading_intercompare.bags.errors import BagError
from heading_intercompare.core.records import Pairs


@pytest.fixture
def csv(tmp_path):
    """Return a function that writes a text and reads it as pairs."""
    def reads(text: str | bytes) -> Pairs:
        path = tmp_path / 'pairs.csv'
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return Pairs.concatenate(list(read_pairs_csv(path)))
    return reads


@pytest.mark.parametrize('text, stamp_ns', [
    ('1406851200.183', 1406851200183000000), ('1406851200', 1406851200000000000),
    ('1406851200.123456789', 1406851200123456789), ('9007199.254740993', 9007199254740993),
    ('0.000000001', 1), ('1406851200.', 1406851200000000000), ('.5', 500000000),
    ('1.4068512001830000e+09', 1406851200183000000), ('-0.5', -500000000),
    ('1406851200.1234567894', 1406851200123456789), ('1406851200.1234567896',
                                                     1406851200123456790),
    (' 12 ', 12000000000)])
def test_decimal_seconds_are_read_exactly(csv, text, stamp_ns):
    assert csv(f'stamp_s,ts_deg,rs_deg\n{text},1,2\n').stamp_ns.tolist() == [stamp_ns]


def test_columns_are_found_by_name_and_others_ignored(csv):
    pairs = csv('\ufeffremark, rs_deg ,stamp_ns,ts_deg,difference_deg\r\n'
                '"a, b",2.5,9007199254740993,1.25,x\r\n\r\n,359.9,9007199254740994,0.1,\r\n')
    assert pairs == Pairs.of([9007199254740993, 9007199254740994], [1.25, 0.1], [2.5, 359.9])


def test_headings_that_are_not_finite_are_nan(csv):
    pairs = csv('stamp_ns,ts_deg,rs_deg\n1,nan,1\n2,inf,1\n3,,1\n4,1,-Infinity\n5,1,2\n')
    assert np.isnan(pairs.ts_deg).tolist() == [True, True, True, False, False]
    assert np.isnan(pairs.rs_deg).tolist() == [False, False, False, True, False]


@pytest.mark.slow
def test_what_is_written_is_read_back_to_the_bit(tmp_path, rng):
    count = 70_000
    ts_deg, rs_deg = rng.uniform(0.0, 360.0, (2, count))
    ts_deg[7] = np.nan
    pairs = Pairs.of(1_406_851_200_000_000_001 + np.arange(count) * 9_999_999, ts_deg, rs_deg,
                     rng.integers(-10**9, 10**9, count), *rng.uniform(0.5, 1.0, (2, count)))
    write_pairs_csv(tmp_path / 'a.csv', [pairs[:1], pairs[1:]])
    chunks = list(read_pairs_csv(tmp_path / 'a.csv'))
    assert max(map(len, chunks)) <= 65536 and sum(map(len, chunks)) == count
    assert Pairs.concatenate(chunks) == pairs


def test_a_file_without_variance_factors_has_factors_of_1(csv):
    pairs = csv('stamp_ns,ts_deg,rs_deg,difference_deg,lag_s,rs_variance_factor\n'
                '1,2,3,-1,0,0.625\n2,2,3,-1,0,\n')
    assert pairs.rs_variance_factor.tolist() == [0.625, 1.0]
    assert pairs.ts_variance_factor.tolist() == [1.0, 1.0]


def test_a_row_holds_difference_lag_and_factors(tmp_path):
    with PairsCsvWriter(tmp_path / 'a.csv') as file:
        file.write(Pairs.of([5], [359.75], [0.5], [-3_000_000], [0.625], [0.75]))
        file.write(Pairs.empty())
    assert (tmp_path / 'a.csv').read_text() == (
        ','.join(COLUMNS) + '\n5,359.75,0.5,-0.75,-0.003,0.625,0.75\n')


def test_differences_are_wrapped_about_the_centre(tmp_path):
    write_pairs_csv(tmp_path / 'a.csv', [Pairs.of([5], [359.75], [0.5])], wrap_center_deg=180.0)
    assert (tmp_path / 'a.csv').read_text().splitlines()[1].split(',')[3] == '359.25'


@pytest.mark.parametrize('text, lag_ns', [
    ('-0.003', -3_000_000), ('1e-09', 1), ('-1e-09', -1), ('0.0', 0), ('-0.0', 0), ('', 0),
    ('0.300000001', 300_000_001), ('86400.000000001', 86_400_000_000_001)])
def test_the_lag_is_read_to_the_nanosecond(csv, text, lag_ns):
    assert csv(f'stamp_ns,ts_deg,rs_deg,lag_s\n5,1,2,{text}\n').lag_ns.tolist() == [lag_ns]
    assert csv(f'stamp_ns,ts_deg,rs_deg,lag_ns\n5,1,2,{lag_ns}\n').lag_ns.tolist() == [lag_ns]


TEXT = ('stamp_s,ts_deg,rs_deg,lag_s,rs_variance_factor\n'
        '1406851200.183,359.5,0.25,-0.003,0.625\n1406851201.183,nan,0.5,,\n')
READ = Pairs.of([1406851200183000000, 1406851201183000000], [359.5, np.nan], [0.25, 0.5],
                [-3_000_000, 0], [0.625, 1.0])


@pytest.mark.parametrize('text', [
    TEXT, TEXT.replace(',', ';'), TEXT.replace(',', '\t'), TEXT.replace('\n', '\r\n'),
    TEXT.replace(',', ';').replace('.', ','), TEXT.replace(',', '\t').replace('.', ','),
    'sep=;\r\n' + TEXT.replace(',', ';').replace('.', ','),
    '# made by a program\n\n' + TEXT.replace('\n', '\n# between, the, rows\n', 1),
    TEXT.replace('1406851200.183,', '"1406851200,183",').replace('1406851201.183,',
                                                                 '"1406851201,183",')
    .replace('359.5', '"359,5"').replace('0.25', '"0,25"').replace('0.5', '"0,5"')
    .replace('-0.003', '"-0,003"').replace('0.625', '"0,625"'),
    TEXT.replace('\n', ',,\n') + ',,,,,,\n',
    TEXT.replace('1406851200.183', '2014-08-01T00:00:00.183Z').replace('stamp_s', 'stamp_utc')
    .replace('1406851201.183', '2014-08-01 02:00:01,183+02:00', 1).replace(
        '2014-08-01 02:00:01,183', '"2014-08-01 02:00:01,183').replace('+02:00', '+02:00"'),
    '\ufeff' + TEXT, TEXT.encode('utf-16'), TEXT.rstrip('\n')],
    ids=['commas', 'semicolons', 'tabs', 'crlf', 'decimal commas', 'tabs and decimal commas',
         'sep', 'comments', 'quoted decimal commas', 'padded', 'utc', 'bom', 'utf-16', 'no end'])
def test_a_file_is_read_as_spreadsheets_write_it(csv, text):
    assert csv(text) == READ


def test_day_numbers_of_a_spreadsheet_are_read_as_utc(csv):
    """2014-08-01 is day 41852 from 1899-12-30; 0.25 days are 6 hours."""
    assert csv('stamp_utc,ts_deg,rs_deg\n41852.25,1,2\n').stamp_ns.tolist() == [
        1406851200000000000 + 6 * 3600 * 10**9]


def test_columns_that_are_not_read_are_named(tmp_path):
    path = tmp_path / 'a.csv'
    path.write_text('stamp_s,ts_deg,rs_deg,rs_variance_factr,difference_deg\n1,2,3,0.5,-1\n')
    assert PairsCsv(path).ignored == ('rs_variance_factr',)


def test_the_fingerprint_of_pairs_is_that_of_their_values(tmp_path):
    one, two = (Pairs.of([5, 6], [359.75, nan], [0.5, -0.0], [-3, 4]) for nan in
                (np.nan, np.inf))
    found = []
    for name, chunks in (('a', [one]), ('b', [two[:1], two[1:]]), ('c', [one[:1]])):
        with PairsCsvWriter(tmp_path / name) as file:
            for pairs in chunks:
                file.write(pairs)
            found.append(file.fingerprint)
        assert found[-1].csv_sha256 == hashlib.sha256((tmp_path / name).read_bytes()).hexdigest()
    assert found[0].pairs_sha256 == found[1].pairs_sha256 != found[2].pairs_sha256


def test_a_header_alone_is_no_pairs(csv):
    assert csv('stamp_s,ts_deg,rs_deg\n') == Pairs.empty()


@pytest.mark.parametrize('text, problem', [
    ('', 'is empty'),
    ('1,2,3\n', "line 1 is '1,2,3': must be a header .*: stamp_s or stamp_ns, ts_deg, rs_deg"),
    ('stamp_s,ts_deg\n', 'missing: rs_deg'),
    ('stamp_s,ts_deg,rs_deg\n1,2,3\n1,2\n', 'line 3 has 2 columns'),
    ('stamp_s,ts_deg,rs_deg\n2014-08-01T00:00:00Z,1,2\n',
     "line 2: stamp_s = '2014-08-01T00:00:00Z' must be a decimal number of seconds"),
    ('stamp_ns,ts_deg,rs_deg\n1.5,1,2\n', "line 2: stamp_ns = '1.5' must be a whole number"),
    ('stamp_s,ts_deg,rs_deg\nnan,1,2\n', "line 2: stamp_s = 'nan'"),
    ('stamp_s,ts_deg,rs_deg\n,1,2\n', "line 2: stamp_s = ''"),
    ('stamp_s,ts_deg,rs_deg\n1e999999999,1,2\n', 'line 2: stamp_s'),
    ('stamp_ns,ts_deg,rs_deg\n9223372036854775808,1,2\n', 'line 2: stamp_ns'),
    ('stamp_ns,ts_deg,rs_deg\n\n1,north,2\n', "line 3: ts_deg = 'north', rs_deg = '2' must be"),
    ('stamp_ns,ts_deg,rs_deg,ts_variance_factor\n1,1,2,1.5\n',
     "line 2: rs_variance_factor = '', ts_variance_factor = '1.5' must be above 0 and at most 1"),
    ('stamp_ns,ts_deg,rs_deg,ts_deg\n1,2,3,4\n',
     "line 1: column 'ts_deg' stands twice, as column 2 and 4"),
    ('# x\nremark,stamp_ns, remark ,ts_deg,rs_deg\n', "line 2: column 'remark' stands twice"),
    ('stamp_s,ts_deg,rs_deg\n1406851200,5,1,5,2,5\n',
     r'line 2 has 6 columns, more than the header \(3\); if its numbers have decimal commas'),
    ('stamp_s;ts_deg;rs_deg\n1406851200,5;1,5;2,5\n1406851201,5;1.5;2,5\n',
     "line 3: ts_deg = '1.5', rs_deg = '2,5' must be numbers; its decimal mark is '.'"),
    ('stamp_s;ts_deg;rs_deg\n1.406.851.200,5;1,5;2,5\n',
     "line 2: stamp_s = '1.406.851.200,5' .* since 1970; write numbers without thousands"),
    ('stamp_s,ts_deg,rs_deg\n"1,406,851,200.5",1,2\n', 'without thousands separators'),
    ('stamp_s\tts_deg\trs_deg\n1 406 851 200\t1\t2\n', 'without thousands separators'),
    ('stamp_ns,ts_deg,rs_deg\n1.40685E+18,1,2\n', 'a spreadsheet has rounded it: give it as text'),
    ('stamp_s,ts_deg,rs_deg\n2014-08-01 00:00:00,1,2\n', 'name the column stamp_utc'),
    ('stamp_utc,ts_deg,rs_deg\n01.08.2014 00:00,1,2\n', 'a spreadsheet has rewritten it'),
    ('stamp_s,ts_deg,rs_deg\n00:00.2,1,2\n', 'a spreadsheet has rewritten it'),
    ('stamp_utc,ts_deg,rs_deg\n1406851200,1,2\n', 'name the column stamp_s or stamp_ns'),
    ('stamp_utc,ts_deg,rs_deg\n2014-13-01T00:00:00Z,1,2\n', 'line 2: stamp_utc = '),
    ('stamp_s,ts_deg,rs_deg\n' + ''.join(f'{41852 + i / 86400!r},1,2\n' for i in range(5)),
     'stamp_s = 41852.0 looks like a day number of a spreadsheet .2014-08-01 00:00:00.000 UTC'),
    *(('stamp_ns,ts_deg,rs_deg\n' + ''.join(f'{(1406851200 + i) * per_s},1,2\n'
                                             for i in range(5)),
       f'stamp_ns = {1406851200 * per_s} looks like {unit} since 1970 '
       '.2014-08-01 00:00:00.000 UTC., not nanoseconds: ')
      for unit, per_s in (('seconds', 1), ('milliseconds', 1000), ('microseconds', 10 ** 6))),
    ('stamp_ns,ts_deg,rs_deg,lag_s\n1,1,2,late\n', "line 2: lag_s = 'late' must be a decimal"),
    ('stamp_ns,ts_deg,rs_deg,lag_s\n1,1,2,nan\n', "line 2: lag_s = 'nan' must be a decimal"),
    ('# nothing\n,,,\n', 'is empty'),
    (b'\x89MCAP0\r\n\0\0', 'line 1 is'),
    ('stamp_ns,ts_deg,rs_deg\n1,"' + 'x' * 200_000, 'line 2: field larger')])
def test_a_mistake_is_named_with_its_line(csv, tmp_path, text, problem):
    with pytest.raises(BagError, match=problem) as caught:
        csv(text)
    assert str(caught.value).startswith(str(tmp_path / 'pairs.csv'))
    assert '\n' not in str(caught.value) and len(str(caught.value)) < 500


def test_nanoseconds_since_the_start_of_a_clock_are_no_other_unit(csv):
    """Seconds after its start, and days, a clock has numbers like seconds and microseconds."""
    for start_ns, step_ns in ((0, 10 ** 8), (2 * 10 ** 9, 10 ** 7), (216 * 10 ** 13, 10 ** 7)):
        text = ''.join(f'{start_ns + i * step_ns},1,2\n' for i in range(200))
        assert len(csv('stamp_ns,ts_deg,rs_deg\n' + text).stamp_ns) == 200


def test_a_file_that_is_not_there_is_an_os_error(tmp_path):
    with pytest.raises(FileNotFoundError):
        next(read_pairs_csv(tmp_path / 'pairs.csv'))
    with pytest.raises(FileNotFoundError):
        PairsCsvWriter(tmp_path / 'absent' / 'pairs.csv')


def test_a_pipe_is_opened_once(tmp_path):
    """It has no beginning to come back to: a second opening waited for ever."""
    pipe = tmp_path / 'p.csv'
    os.mkfifo(pipe)
    rows = 'stamp_ns,ts_deg,rs_deg\n1000000000000000000,1.0,2.0\n'
    with ThreadPoolExecutor(1) as beside:
        written = beside.submit(pipe.write_text, rows)
        pairs, = read_pairs_csv(pipe)
        assert written.result(30.0) == len(rows)
    assert pairs.ts_deg.tolist() == [1.0]


@pytest.mark.parametrize('cut', [3, 14, 22])
def test_a_last_line_that_is_cut_is_left_out_and_named(tmp_path, cut):
    path = tmp_path / 'pairs.csv'
    line = '1400000002000000000,10.25,11.5\n'
    path.write_text('stamp_ns,ts_deg,rs_deg\n1400000001000000000,10.0,11.0\n' + line[:cut])
    rows = PairsCsv(path)
    assert [len(pairs) for pairs in rows] == [1]
    assert rows.cut.startswith('line 3 was left out: the file ends within it')


def test_a_last_line_without_end_that_is_whole_is_read(tmp_path):
    path = tmp_path / 'pairs.csv'
    path.write_text('stamp_ns,ts_deg,rs_deg\n1400000001000000000,10.0,11.0')
    rows = PairsCsv(path)
    assert [len(pairs) for pairs in rows] == [1] and rows.cut == ''


@pytest.mark.parametrize('mark', '.,')
@pytest.mark.parametrize('cut', [1, 2, 3, 4])
def test_a_last_number_that_is_cut_is_not_read_as_another(tmp_path, cut, mark):
    """59.863 cut to 5 would be a difference of 55 degrees."""
    path = tmp_path / 'pairs.csv'
    row = '140000000{};60.047;59.863'.replace('.', mark)
    path.write_text('\n'.join(['stamp_s;ts_deg;rs_deg', row.format(1), row.format(2)])[:-cut])
    rows = PairsCsv(path)
    assert [len(pairs) for pairs in rows] == [1]
    assert rows.cut.startswith('line 3 was left out: the file ends within it, and its last number')
