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

"""Csv of ensembles: its columns, days and flags."""

from __future__ import annotations

from datetime import datetime, timezone

import pytest

from heading_intercompare.bags.csv.ensembles_csv import COLUMNS, EnsemblesCsvWriter
from heading_intercompare.core.records import Pairs

S = 1_000_000_000


def ns(*moment):
    """Return a stamp of UTC."""
    return int(datetime(*moment, tzinfo=timezone.utc).timestamp()) * S


@pytest.fixture
def written(tmp_path):
    """Return a function that writes chunks of pairs and returns the rows after the header."""
    def write(*chunks, span_s=120.0):
        path = tmp_path / 'ensembles.csv'
        with EnsemblesCsvWriter(path, span_s, gap_s=60.0, std_limit_deg=0.2) as file:
            for pairs in chunks:
                file.write(pairs)
        header, *rows = path.read_text('ascii').splitlines()
        assert header == 'dday,mean_hdg,last_hdg,mean_dh,std_dh,num,badflag' == ','.join(COLUMNS)
        return [row.split(',') for row in rows]
    return write


def test_a_row_by_hand(written):
    """0.1 and 0.3 have the mean 0.2 and the standard deviation 0.1 √2."""
    noon = ns(2014, 1, 1, 12)
    assert written(Pairs.of([noon - S, noon], [29.0, 31.0], [28.9, 30.7])) == [
        ['0.5000000', '30.0000', '31.0000', '0.2000', '0.1414', '2', '0']]


def test_days_go_on_over_the_new_year(written):
    """31 December 2016, 24:00, is day 366 of that leap year, in the count of a cruise."""
    rows = written(Pairs.of([ns(2016, 12, 31, 23, 59), ns(2017, 1, 1)], [1.0] * 2, [1.0] * 2,),
                   Pairs.of([ns(2017, 1, 1, 6)], [1.0], [1.0]))
    assert [row[0] for row in rows] == ['366.0000000', '366.2500000']


def test_a_heading_that_is_rounded_stays_below_360(written):
    (row,) = written(Pairs.of([S, 2 * S], [359.99999, 359.99999], [0.0, 0.0]))
    assert row[1:4] == ['0.0000', '0.0000', '-0.0000']


@pytest.mark.parametrize('ts_deg, flag', [
    ([0.0, 0.28], '0'), ([0.0, 0.29], '1'), ([0.0], '1'), ([float('nan')] * 2, '1'),
    ([0.0, 0.0, float('nan')], '0')])
def test_an_ensemble_is_bad_if_it_scatters_more_than_the_limit_or_has_no_two_pairs(
        written, ts_deg, flag):
    """The standard deviation of 0 and x is x / √2: 0.198 and 0.205; the limit is 0.2."""
    stamps = [S * (i + 1) for i in range(len(ts_deg))]
    (row,) = written(Pairs.of(stamps, ts_deg, [0.0] * len(ts_deg)))
    assert row[-1] == flag


def test_what_does_not_exist_is_nan(written):
    (row,) = written(Pairs.of([S], [float('nan')], [0.0]))
    assert row[1:] == ['nan', 'nan', 'nan', 'nan', '0', '1']


def test_without_pairs_there_is_a_header(written):
    assert written() == [] and written(Pairs.empty()) == []


def test_a_folder_that_is_not_there_and_a_wrong_length_leave_nothing(tmp_path):
    with pytest.raises(OSError):
        EnsemblesCsvWriter(tmp_path / 'no' / 'x.csv', 60.0, gap_s=60.0, std_limit_deg=1.0)
    with pytest.raises(ValueError, match='length of an ensemble'):
        EnsemblesCsvWriter(tmp_path / 'x.csv', 0.0, gap_s=60.0, std_limit_deg=1.0)
    assert not (tmp_path / 'x.csv').exists()


def test_to_close_twice_is_allowed(tmp_path):
    file = EnsemblesCsvWriter(tmp_path / 'x.csv', 60.0, gap_s=60.0, std_limit_deg=1.0)
    file.write(Pairs.of([S], [1.0], [1.0]))
    file.close()
    file.close()
    assert len((tmp_path / 'x.csv').read_text().splitlines()) == 2
