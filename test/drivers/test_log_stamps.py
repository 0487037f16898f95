# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Stamps of logs and times of sentences, exact to the nanosecond."""

from __future__ import annotations

from datetime import datetime, timedelta, timezone

from hypothesis import given, strategies as st
import pytest

from heading_intercompare.drivers.log_stamps import (
    DAY_NS,
    day_time_ns,
    log_stamp_ns,
    nearest_day_ns,
    zda_ns,
)

stamps = st.integers(0, 9_000_000_000 * 10**9)


def when(stamp_ns: int) -> tuple[datetime, int]:
    """Return date and time to the second, and the rest in nanoseconds."""
    seconds, rest_ns = divmod(stamp_ns, 10**9)
    return datetime(1970, 1, 1, tzinfo=timezone.utc) + timedelta(seconds=seconds), rest_ns


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
    b'', b' ', b'12:34:56 ', b'99 bottles ', b'x2014-08-01T00:00:00Z', b'14068512001 ',
    b'2014-08-01T00:00:00Z and more ', b'140685120 '])
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


@given(stamps)
def test_zda_is_exact(stamp_ns):
    stamp_ns -= stamp_ns % 10**7
    at, rest_ns = when(stamp_ns)
    text = at.strftime('GPZDA,%H%M%S') + f'.{rest_ns:09d}'[:3] + at.strftime(',%d,%m,%Y,-01,00')
    assert zda_ns(text.encode().split(b',')) == stamp_ns


@pytest.mark.parametrize('text', [
    b'GPZDA', b'GPZDA,095559,,,,00,', b'GPZDA,,01,08,2014,,', b'GPZDA,000000.17,32,08,2014,,',
    b'GPZDA,240000,01,08,2014,,', b'GPZDA,000000,01,08,14,,', b'GPZDA,0000,01,08,2014,,',
    b'GPZDA,0x0000,01,08,2014,,'])
def test_a_zda_without_a_full_time_is_an_error(text):
    with pytest.raises(ValueError):
        zda_ns(text.split(b','))


@given(st.integers(10 * DAY_NS, 9_000 * DAY_NS), st.integers(0, DAY_NS - 1))
def test_the_nearest_day_is_less_than_half_a_day_away(near_ns, time_of_day_ns):
    stamp_ns = nearest_day_ns(time_of_day_ns, near_ns)
    assert stamp_ns % DAY_NS == time_of_day_ns
    assert abs(stamp_ns - near_ns) <= DAY_NS // 2


def test_the_time_of_day_by_hand():
    assert day_time_ns(b'010203.5') == 3_723_500_000_000
