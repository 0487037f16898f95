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

"""The sentences of the motion; those marked real are from logs of R/V Palmer and Gould."""

from __future__ import annotations

import math

import pytest

from heading_intercompare.core.records import KNOT_M_S
from heading_intercompare.drivers.motion.motion_sentences import MOTION
from heading_intercompare.drivers.sentences import Rejected

# Real: OpenRVDAS (MIT), NBP1406 and LMG1903.
VTG = b'INVTG,215.11,T,239.79,M,9.1,N,16.9,K,A'
RMC = b'INRMC,100555.17,A,5307.012403,S,06724.614243,W,12.5,135.31,260319,,,A'
GGA = b'INGGA,000000.16,2200.110899,S,01756.359432,W,1,12,0.7,-2.76,M,4.67,M,,'
GLL = b'GPGLL,2200.1117,S,01756.3597,W,000000.00,A'


def parse_motion(text):
    """Return the rows of a sentence."""
    return MOTION.parse(MOTION.identify(text), text)


def course_of(row):
    """Return course and speed, degrees and knots."""
    return (math.degrees(math.atan2(*row.values)) % 360.0, math.hypot(*row.values) / KNOT_M_S)


@pytest.mark.parametrize('text, course, speed', [
    (VTG, 215.11, 9.1), (b'GPVTG,90,T,,M,,N,18.52,K', 90.0, 10.0),
    (b'GPVTG, 0.0 ,T,,,5.0,N,,', 0.0, 5.0)])
def test_courses_of_vtg(text, course, speed):
    row, = parse_motion(text)
    assert row.what == 'velocity' and course_of(row) == pytest.approx((course, speed))


def test_rmc_tells_position_and_course():
    position, course = parse_motion(RMC)
    assert position.what == 'fix' and course.what == 'velocity'
    assert position.values == pytest.approx(
        (-53.0 - 7.012403 / 60.0, -67.0 - 24.614243 / 60.0))
    assert course_of(course) == pytest.approx((135.31, 12.5))


def test_rmc_of_a_ship_at_rest_tells_its_position_alone():
    rows = parse_motion(b'GPRMC,100555,A,5307.0,N,00724.6,E,0.0,,260319,,')
    assert [row.what for row in rows] == ['fix']


@pytest.mark.parametrize('text, latitude, longitude', [
    (GGA, -22.0 - 0.110899 / 60.0, -17.0 - 56.359432 / 60.0),
    (GLL, -22.0 - 0.1117 / 60.0, -17.0 - 56.3597 / 60.0),
    (b'GNGNS,014035.00,4332.69262,N,17235.48549,E,RR,13,0.9,25.63,11.24,,',
     43.0 + 32.69262 / 60.0, 172.0 + 35.48549 / 60.0)])
def test_positions(text, latitude, longitude):
    row, = parse_motion(text)
    assert row.what == 'fix'
    assert row.values == pytest.approx((latitude, longitude), abs=1e-12)


def test_the_rate_of_turn_is_in_degrees_a_minute_and_negative_to_port():
    row, = parse_motion(b'HEROT,-90.0,A')
    assert row == ('rate', (-1.5,))


@pytest.mark.parametrize('text, reason', [
    (b'INVTG,215.11,M,239.79,M,9.1,N', 'not_true'),
    (b'INVTG,,T,,M,,N,,K,N', 'invalid_mode'), (b'INVTG,215.11,T,,M,9.1,N,,K,E', 'invalid_mode'),
    (b'INVTG,,T,,M,9.1,N', 'empty'), (b'INVTG,361.0,T,,M,9.1,N', 'out_of_range'),
    (b'INVTG,36.0,T,,M,155.6,N', 'out_of_range'), (b'INVTG,36.0,T,,M,,N,288.1,K', 'out_of_range'),
    (b'HEROT,3601.0,A', 'out_of_range'),
    (b'INVTG,1x,T,,M,9.1,N', 'bad_field'), (b'INVTG,15.0,T', 'too_few_fields'),
    (b'INRMC,100555.17,V,,,,,,,260319,,', 'invalid_mode'),
    (b'GPGGA,000000,,,,,0,,,,,,,,', 'invalid_mode'),
    (b'GPGGA,000000,2200.1,S,01756.3,W,6,12', 'invalid_mode'),
    (b'GPGGA,000000,2260.1,S,01756.3,W,1,12', 'bad_field'),
    (b'GPGGA,000000,2200.1,X,01756.3,W,1,12', 'bad_field'),
    (b'GPGGA,000000,9100.1,S,01756.3,W,1,12', 'out_of_range'),
    (b'GPGLL,2200.1,S,01756.3,W,000000,V', 'invalid_mode'),
    (b'GNGNS,014035,4332.6,N,17235.4,E,NN,13', 'invalid_mode'),
    (b'HEROT,-90.0,V', 'invalid_mode'), (b'HEROT,,A', 'empty'), (b'HEROT,3.0', 'too_few_fields')])
def test_what_tells_nothing_is_rejected_with_its_reason(text, reason):
    with pytest.raises(Rejected) as error:
        parse_motion(text)
    assert error.value.reason == reason


@pytest.mark.parametrize('kind', MOTION.parsers)
def test_no_field_at_all_is_rejected(kind):
    for text in (f'GP{kind},', f'GP{kind},,,,,,,,,,,,,'):
        with pytest.raises(Rejected):
            parse_motion(text.encode())
