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

"""A log without a heading shows its first refused line, what is in it, and what to set."""

from __future__ import annotations

from checksums import with_checksum
import pytest

from heading_intercompare.drivers.logs import read_log
from heading_intercompare.drivers.refused_lines import explain_no_heading
from heading_intercompare.drivers.settings import DriverSettings


def sentence(text: str = 'HEHDT,1.0,T') -> str:
    """Return a sentence with its checksum."""
    return with_checksum(text)


HDT, NOON = sentence(), '2026-03-01T12:00:00Z '


@pytest.mark.parametrize('lines, settings, words', [
    ([f'GYRO {HDT}'], {}, ('GYRO $HEHDT', 'no stamp, the sentence HEHDT', '`time`', 'pattern')),
    (['# x', f'05/06/2024 20:00:00 {HDT}'], {},
     ('05/06/2024', 'a date with day or month first', '`stamp_format` to dmy or mdy')),
    ([f'20:00:00 {HDT}'], {}, ("'20:00:00", 'a time of day without a date', 'set `date`')),
    ([f'2024-05-28 20:00:00 CEST {HDT}'], {}, ('CEST', 'unknown', '`stamp_zone`')),
    ([NOON + '$HEHDT,1.0,T'], {}, ('a stamp of the form iso', 'HEHDT', '`checksum` to if_pr')),
    ([NOON + '$HEHDT,1.0,T*00'], {}, ('bad_checksum', 'damaged')),
    ([NOON + HDT], {'stamp_format': 'doy'}, ('form iso', 'no_stamp')),
    ([NOON + HDT], {'sentence': 'THS'}, ('the sentence HEHDT', 'choose', '`sentence`')),
    ([NOON + HDT], {'talker': 'GP'}, ('other_talker.HE', '`talker`')),
    ([NOON + HDT], {'instrument': 'GYRO'}, ('other_instrument', '`instrument`')),
    ([HDT], {'time': 'validity'}, ('no_validity_time', '`time` to receipt')),
    ([sentence('GPGGA,120000,1,N,2,E,1,8'), HDT], {'time': 'validity'}, ('bad_time', '`date`')),
    ([NOON + sentence('HEHDT,,T')], {}, ('empty_heading', 'no valid heading')),
    ([NOON + sentence('HCHDM,1.0,M')], {}, ('no_variation', 'magnetic', '`variation_deg`')),
    ([NOON + sentence('HEROT,0.5,A')], {}, ('HEROT, which gives no heading', 'PUHAW,UVH')),
    (['hello', 'there'], {}, ("'hello'", 'no stamp, no sentence', 'begins with')),
    (['t_ns,heading_deg', '1,x'], {}, ("'1,x'", 'a row of a csv', 'correct the file'))])
def test_the_first_refused_line_is_shown_with_what_is_in_it(lines, settings, words, tmp_path):
    log = tmp_path / 'a.log'
    log.write_text('\r\n'.join(lines) + '\r\n')
    driver = DriverSettings(**settings)
    headings, counts = read_log(log, driver)
    found = explain_no_heading(str(log), driver, counts)
    assert len(headings) == 0 and '\n' not in found and found.startswith('first refused line: ')
    for each in words:
        assert each in found, found


def test_a_long_or_binary_line_is_shown_short_and_printable(tmp_path):
    log = tmp_path / 'a.log'
    log.write_bytes(b'\x1b[2J\xff' * 300 + HDT.encode() + b'\n')
    found = explain_no_heading(str(log), DriverSettings(), read_log(log)[1])
    assert len(found) < 600 and found.isprintable()
