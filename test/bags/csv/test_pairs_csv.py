# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Csv of pairs: exact stamps, exact headings, mistakes named by line."""

from __future__ import annotations

import numpy as np
import pytest

from heading_intercompare.bags.csv.pairs_csv import (
    COLUMNS,
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
    assert [len(c) for c in chunks] == [65536, count - 65536]
    assert Pairs.concatenate(chunks) == Pairs.of(
        pairs.stamp_ns, ts_deg, rs_deg, None, pairs.rs_variance_factor, pairs.ts_variance_factor)


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
    (b'\x89MCAP0\r\n\0\0', 'line 1 is'),
    ('stamp_ns,ts_deg,rs_deg\n1,"' + 'x' * 200_000, 'line 2: field larger')])
def test_a_mistake_is_named_with_its_line(csv, tmp_path, text, problem):
    with pytest.raises(BagError, match=problem) as caught:
        csv(text)
    assert str(caught.value).startswith(str(tmp_path / 'pairs.csv'))
    assert '\n' not in str(caught.value) and len(str(caught.value)) < 500


def test_a_file_that_is_not_there_is_an_os_error(tmp_path):
    with pytest.raises(FileNotFoundError):
        next(read_pairs_csv(tmp_path / 'pairs.csv'))
    with pytest.raises(FileNotFoundError):
        PairsCsvWriter(tmp_path / 'absent' / 'pairs.csv')
