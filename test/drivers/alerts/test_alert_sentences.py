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

"""The sentences of alerts have the form that the manuals of makers print."""

from __future__ import annotations

from checksums import with_checksum
from hypothesis import given, strategies
import pytest

from heading_intercompare.drivers.alerts.alert_sentences import (
    AlertCommand,
    AlertEntry,
    frame,
    read_command,
    tag,
    time_of_day,
    write_alc,
    write_alf,
    write_arc,
    write_hbt,
)
from heading_intercompare.drivers.sentences import Rejected

NS = 1_700_000_000_120_000_000


def entry(**given_values):
    """Return an alert that is active and not acknowledged."""
    return AlertEntry(**{'identifier': 10001, 'instance': 1, 'revision': 1, 'escalation': 0,
                         'priority': 'W', 'state': 'V', 'changed_ns': NS, 'title': 'JUMP',
                         **given_values})


def test_the_examples_of_the_norm_that_others_print_have_these_checksums():
    """Public decoders quote them with their checksums: 14, 2D and 0D."""
    assert frame('IIALF,1,1,0,124304.50,A,W,A,,192,1,1,0,LOST TARGET').endswith(b'*14\r\n')
    for body, checksum in (
            ('IIALF,2,1,1,081950.10,B,A,S,XYZ,0512,1,2,0,HEADING LOST', b'2D'),
            ('IIALF,2,2,1,,,,,XYZ,0512,1,2,0,NO SYSTEM HEADING AVAILABLE', b'0D')):
        assert frame(body) == b'$%s*%s\r\n' % (body.encode(), checksum)


def test_an_alert_is_its_title_and_then_its_description():
    assert write_alf('II', 'XYZ', 1, entry(revision=2, description='TS - RS jumped by 3 deg')) == (
        'IIALF,2,1,1,221320.12,B,W,V,XYZ,10001,1,2,0,JUMP',
        'IIALF,2,2,1,,,,,XYZ,10001,1,2,0,TS - RS jumped by 3 deg')
    assert write_alf('II', '', 0, entry(state='N')) == (
        'IIALF,1,1,0,221320.12,B,W,N,,10001,1,1,0,JUMP',)


def test_what_has_a_meaning_of_its_own_is_escaped_and_what_is_not_ascii_replaced():
    _, second = write_alf('II', '', 0, entry(description='a,b*c: 3.2° − ✓'))
    assert second.rpartition(',0,')[2] == 'a^2Cb^2Ac: 3.2 deg - ?'


@given(text=strategies.text(max_size=200), title=strategies.text(max_size=40),
       number=strategies.integers(1, 999999))
def test_no_sentence_is_longer_than_82_characters(text, title, number):
    sentences = [*write_alf('II', 'XYZ', 9, entry(
        identifier=9_999_999, instance=number, revision=99, title=title, description=text)),
        *write_alc('II', 'XYZ', 99, [entry(identifier=9_999_999, instance=number)] * 9)]
    for body in sentences:
        data = frame(body)
        assert len(data) <= 82 and data[:-2] == with_checksum(body).encode()
        # An escape is whole.
        assert all(len(part) >= 2 for part in body.split('^')[1:])


def test_a_list_divides_no_entry_between_two_sentences():
    entries = [entry(identifier=10001 + k, revision=99) for k in range(5)]
    assert write_alc('II', 'XYZ', 3, entries) == (
        'IIALC,02,01,03,3,XYZ,10001,1,99,XYZ,10002,1,99,XYZ,10003,1,99',
        'IIALC,02,02,03,2,XYZ,10004,1,99,XYZ,10005,1,99')
    assert write_alc('II', '', 0, []) == ('IIALC,01,01,00,0',)
    assert len(write_alc('II', 'XYZ', 0, entries * 100)) == 99


def test_a_refusal_and_a_heartbeat():
    assert write_arc('II', AlertCommand('XYZ', 10001, 2, 'O'), NS) == (
        'IIARC,221320.12,XYZ,10001,2,O',)
    assert write_arc('II', AlertCommand('', 10001, None, 'A'), NS) == (
        'IIARC,221320.12,,10001,,A',)
    assert write_hbt('II', 30.0, 7, is_well=True) == ('IIHBT,30.0,A,7',)
    assert write_hbt('II', 30.0, 7, is_well=False) == ('IIHBT,30.0,V,7',)


def test_a_command_is_read_and_other_sentences_are_not():
    assert read_command(b'BMACN,093015.00,XYZ,10001,1,A,C') == AlertCommand('XYZ', 10001, 1, 'A')
    assert read_command(b'BMACN,,,10001,,Q,C') == AlertCommand('', 10001, None, 'Q')
    assert read_command(b'HEHDT,1.0,T') is None and read_command(b'') is None


@pytest.mark.parametrize('text, reason', [
    (b'BMACN,093015.00,XYZ,10001,1,A,R', 'no_command'), (b'BMACN,093015.00,XYZ', 'no_command'),
    (b'BMACN,,,x,1,A,C', 'bad_command'), (b'BMACN,,,10001,-1,A,C', 'bad_command'),
    (b'BMACN,,,10001,1,,C', 'bad_command'), (b'BMACN,,,10001,1,AB,C', 'bad_command')])
def test_a_command_that_names_no_alert_or_no_command_is_rejected(text, reason):
    with pytest.raises(Rejected) as error:
        read_command(text)
    assert error.value.reason == reason


@given(data=strategies.binary(max_size=100))
def test_any_bytes_are_a_command_another_sentence_or_rejected(data):
    for text in (data, b'BMACN,' + data):
        try:
            read_command(text)
        except Rejected:
            pass


def test_a_time_of_day_begins_again_at_midnight():
    assert time_of_day(86_400 * 10 ** 9 - 1) == '235959.99'
    assert time_of_day(86_400 * 10 ** 9) == '000000.00'


def test_a_tag_block_has_a_checksum_of_its_own():
    """The documentation of gpsd prints this block with 4A."""
    parts = ['g:1-2-73874', 'n:157036', 's:r003669945', 'c:1241544035']
    assert tag(parts) == b'\\%s*4A\\' % ','.join(parts).encode()
