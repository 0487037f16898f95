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

"""The words around a sentence name its instrument."""

from __future__ import annotations

from checksums import checksum_of, with_checksum
import pytest

from heading_intercompare.drivers.log_lines.line_words import words_of
from heading_intercompare.drivers.logs import read_log
from heading_intercompare.drivers.settings import DriverError, DriverSettings


def line(second: int, before: str, heading_deg: float) -> str:
    """Return a line with a stamp and words around its sentence."""
    text = f'HEHDT,{heading_deg:.1f},T'
    return f'{before.format(f"17723664{second:02d}")}{with_checksum(text)}\n'


def write(path, forms, n=20):
    """Write a log in which the forms of line alternate, each with a heading of its own."""
    path.write_text(''.join(line(k, form, 10.0 * (i + 1))
                            for k in range(n) for i, form in enumerate(forms)))
    return path


@pytest.mark.parametrize('forms, name', [
    (('{} GYRO1 ', '{} GYRO2 '), 'GYRO2'), (('NAV A {} ', 'NAV B {} '), 'b'),
    (('{} 10.0.0.5:4001 ', '{} 10.0.0.6:4001 '), '10.0.0.6:4001'),
    (('[gyro-1] {} ', '[gyro-2] {} '), 'gyro-2'), (('{} port=1 p1 ', '{} port=2 p2 '), 'p2')])
def test_two_instruments_of_one_talker_are_told_apart_or_refused(forms, name, tmp_path):
    log = write(tmp_path / 'both.log', forms)
    with pytest.raises(DriverError, match='HEHDT comes from several instruments'):
        read_log(log)
    headings, counts = read_log(log, DriverSettings(instrument=name))
    assert set(headings.heading_deg) == {20.0} and counts == {'other_instrument': 20}
    assert len(read_log(log, DriverSettings(instrument='any'))[0]) == 40


def test_one_instrument_with_changing_words_is_no_two(tmp_path):
    log = tmp_path / 'one.log'
    log.write_text(''.join(line(k, f'{{}} GYRO c{k} ', 10.0) for k in range(60)))
    assert len(read_log(log)[0]) == 60
    log.write_text(''.join(line(k, '{} GYRO ' if k != 30 else '{} GYR0 ', 10.0)
                           for k in range(60)))
    assert len(read_log(log)[0]) == 60


def test_a_bare_line_belongs_to_the_instrument_before_it(tmp_path):
    log = tmp_path / 'bursts.log'
    log.write_text(''.join(f'17723664{k:02d} {name}\n' + line(k, '', heading_deg)
                           for k in range(5) for name, heading_deg in (('G1', 1.0), ('G2', 2.0))))
    headings, counts = read_log(log, DriverSettings(instrument='G2'))
    assert headings.heading_deg.tolist() == [2.0] * 5
    assert counts == {'no_sentence': 10, 'other_instrument': 5}


def test_the_choice_of_the_sentence_is_that_of_the_instrument(tmp_path):
    """The other instrument sends THS, which is preferred."""
    log = tmp_path / 'both.log'
    log.write_text(''.join(f'17723664{k:02d} OTHER $HETHS,1.0,A*1B\n' + line(k, '{} MINE ', 2.0)
                           for k in range(5)))
    headings, _ = read_log(log, DriverSettings(instrument='MINE'))
    assert headings.heading_deg.tolist() == [2.0] * 5


def test_the_sources_of_tag_blocks_are_instruments(tmp_path):
    def tagged(source, second):
        text = f's:{source},c:17723664{second:02d}'
        return f'\\{text}*{checksum_of(text):02X}\\'
    log = tmp_path / 'tags.log'
    log.write_text(''.join(tagged(source, k) + line(k, '', heading_deg)
                           for k in range(20) for source, heading_deg in (('G1', 1.0),
                                                                          ('G2', 2.0))))
    with pytest.raises(DriverError, match='G1.*G2'):
        read_log(log)
    assert set(read_log(log, DriverSettings(instrument='G1'))[0].heading_deg) == {1.0}


def test_words_by_hand():
    assert words_of(b'2024-05-28T20:00:00Z GYRO *4A T 17 ') == (b'GYRO',)
