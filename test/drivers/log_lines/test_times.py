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

"""Times in sentences, exact to the nanosecond."""

from __future__ import annotations

from datetime import datetime, timedelta, timezone

from hypothesis import given, strategies as st
import pytest

from heading_intercompare.drivers.log_lines.times import (
    DAY_NS,
    day_time_ns,
    gga_ns,
    nearest_day_ns,
    rmc_ns,
    zda_ns,
)

stamps = st.integers(0, 9_000_000_000 * 10**9)


def when(stamp_ns: int) -> tuple[datetime, int]:
    """Return date and time to the second, and the rest in nanoseconds."""
    seconds, rest_ns = divmod(stamp_ns, 10**9)
    return datetime(1970, 1, 1, tzinfo=timezone.utc) + timedelta(seconds=seconds), rest_ns


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


@given(st.integers(0, 3_100_000_000 * 10**2))
def test_rmc_is_exact(stamp_cs):
    at, rest_ns = when(stamp_cs * 10**7)
    text = (at.strftime('GPRMC,%H%M%S') + f'.{rest_ns:09d}'[:3]
            + at.strftime(',A,1,N,2,E,3,4,%d%m%y,,'))
    assert rmc_ns(text.encode().split(b',')) == stamp_cs * 10**7


@pytest.mark.parametrize('text', [
    b'GPRMC', b'GPRMC,000000,V,1,N,2,E,3,4,010814', b'GPRMC,000000,A,1,N,2,E,3,4,',
    b'GPRMC,,A,1,N,2,E,3,4,010814', b'GPRMC,000000,A,1,N,2,E,3,4,321314'])
def test_an_rmc_without_a_full_time_or_with_a_warning_is_an_error(text):
    with pytest.raises(ValueError):
        rmc_ns(text.split(b','))


def test_a_gga_tells_the_time_of_day_if_it_has_a_fix():
    assert gga_ns(b'GPGGA,010203.5,1,N,2,E,2,8'.split(b',')) == 3_723_500_000_000
    for text in (b'GPGGA,010203.5,1,N,2,E,0,8', b'GPGGA,010203.5,,,,,,', b'GPGGA,,1,N,2,E,1,8'):
        with pytest.raises(ValueError):
            gga_ns(text.split(b','))
