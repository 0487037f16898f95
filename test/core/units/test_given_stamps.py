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

"""Stamps as numpy and pandas have them become nanoseconds, and another unit is refused."""

from __future__ import annotations

from datetime import datetime, timedelta, timezone

import numpy as np
import pytest

from heading_intercompare.core.records import Headings
from heading_intercompare.core.units.given_stamps import EARLIEST_NS, utc_stamps

NOON_NS = int(np.datetime64('2014-08-01T12:00:00', 'ns').astype(np.int64))
NOON = np.datetime64('2014-08-01T12:00:00', 's')
UNITS = ('s', 'ms', 'us', 'ns')


class ZonedColumn:
    """
    The part of a column of pandas with a time zone that `Headings.of` uses.

    As in pandas, it gives a plain array of objects, and datetime64 in UTC if asked for that.
    """

    class dtype:
        tz = 'Europe/Oslo'

    def __array__(self, dtype=None, copy=None):
        if dtype is None:
            return np.array([object(), object()])
        return (NOON + np.arange(2)).astype(dtype)


@pytest.mark.parametrize('unit', [*UNITS, 'm', 'h', 'D'])
def test_datetime64_of_any_unit_is_the_same_instant(unit):
    found = Headings.of(np.array(['2014-08-01'], f'M8[{unit}]'), [1.0])
    assert found.stamp_ns.tolist() == [NOON_NS - 12 * 3600 * 10 ** 9]


@pytest.mark.parametrize('unit, step', [('us', 10 ** 3), ('ms', 10 ** 6), ('ns', 1)])
def test_no_digit_of_a_datetime64_is_lost(unit, step):
    stamps = NOON.astype(f'M8[{unit}]') + np.arange(1000)
    assert Headings.of(stamps, np.zeros(1000)).stamp_ns.tolist() == [
        NOON_NS + k * step for k in range(1000)]


def test_a_column_with_a_time_zone_is_converted_to_utc():
    assert Headings.of(ZonedColumn(), [1.0, 2.0]).stamp_ns.tolist() == [NOON_NS, NOON_NS + 10 ** 9]


def test_columns_of_pandas_are_taken_as_they_are():
    pandas = pytest.importorskip('pandas')
    for unit in UNITS:
        for zone in (None, 'UTC', 'Europe/Oslo'):
            index = pandas.DatetimeIndex([NOON, NOON + 1]).as_unit(unit)
            if zone:
                index = index.tz_localize('UTC').tz_convert(zone)
            for column in (index, pandas.Series(index), pandas.Series(index).to_numpy()):
                if zone and isinstance(column, np.ndarray):
                    continue
                assert Headings.of(column, [1.0, 2.0]).stamp_ns.tolist() == [
                    NOON_NS, NOON_NS + 10 ** 9]
    assert Headings.of(pandas.Series([NOON, None]), [1.0, 2.0]).stamp_ns.tolist() == [NOON_NS, 0]


@pytest.mark.parametrize('words, factor', [
    ('microseconds', 10 ** 3), ('milliseconds', 10 ** 6), ('seconds', 10 ** 9)])
def test_integers_of_another_unit_are_refused_by_its_name(words, factor):
    """`.asi8` of pandas 3 is microseconds: 60 s of them were judged as 60 ms in 1970."""
    numbers = (NOON_NS + np.arange(600) * 10 ** 8) // factor
    with pytest.raises(ValueError) as refused:
        Headings.of(numbers, np.zeros(600))
    text = str(refused.value)
    assert text.startswith('stamp_ns: 600 of 600 stamps are before 1990-01-01: ')
    assert f'look like {words},' in text and f'multiply by {factor},' in text
    assert '\n' not in text


def test_stamps_of_no_known_unit_are_refused_with_the_way_out():
    with pytest.raises(ValueError, match=r'^stamp_ns: 2 of 3 .* no UTC nan.*Headings\.as_sent'):
        Headings.of([10, 20, NOON_NS], np.zeros(3))
    assert Headings.as_sent([10, 20], [1.0, 2.0]).stamp_ns.tolist() == [10, 20]


@pytest.mark.parametrize('early', ['1985-01-01', '1970-01-01', '1969-12-31', '1500-01-01'])
def test_times_before_1990_are_refused(early):
    with pytest.raises(ValueError, match=r'^stamp_ns: 1 of 2 stamps are before 1990-01-01: check'):
        Headings.of(np.array([early, '2014-08-01'], 'M8[us]'), [1.0, 2.0])
    assert len(Headings.of([EARLIEST_NS], [1.0])) == 1


def test_times_that_nanoseconds_cannot_hold_are_refused():
    with pytest.raises(ValueError, match='stamp 2300-01-01T00:00:00 is after 2262'):
        Headings.of(np.array(['2300-01-01', 'NaT'], 'M8[s]'), [1.0, 2.0])


def test_a_reading_without_a_stamp_stays_for_the_ledger():
    assert Headings.of([0, -1, NOON_NS], np.zeros(3)).stamp_ns.tolist() == [0, -1, NOON_NS]
    assert Headings.of(np.array(['NaT', NOON], 'M8[us]'), np.zeros(2)).stamp_ns.tolist() == [
        0, NOON_NS]


def test_neither_floats_nor_text_are_stamps():
    for wrong in ([NOON_NS / 1e9], ['2014-08-01']):
        with pytest.raises(ValueError, match='stamps are integer nanoseconds, or in Headings.of'):
            Headings.of(wrong, [1.0])


def test_datetime_objects_are_utc_or_have_a_zone():
    """A list of them was refused as "dtype object"."""
    oslo = timezone(timedelta(hours=2))
    moments = [datetime(2014, 8, 1, 12, 0, 0, 250_000), datetime(2014, 8, 1, 14, tzinfo=oslo)]
    expected = [NOON_NS + 250_000_000, NOON_NS]
    assert utc_stamps(moments).tolist() == expected
    assert utc_stamps(np.array(moments, object)).tolist() == expected


class Timestamp(datetime):
    """Counts nanoseconds, as that of pandas does."""

    def to_datetime64(self):
        """Return the time with the nanoseconds that a datetime has no room for."""
        return np.datetime64(self, 'ns') + np.timedelta64(7, 'ns')


def test_objects_that_count_nanoseconds_keep_them():
    assert utc_stamps([Timestamp(2014, 8, 1, 12)]).tolist() == [NOON_NS + 7]


@pytest.mark.parametrize('moments', [['2014-08-01'], [None], [datetime(2014, 8, 1), 7]])
def test_other_objects_are_refused(moments):
    with pytest.raises(ValueError, match='stamps are integer nanoseconds'):
        utc_stamps(moments)
