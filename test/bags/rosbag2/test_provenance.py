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

"""What a bag says about its origin, and the operator's notes in it."""

from __future__ import annotations

import pytest

from heading_intercompare.bags.recording.bag_writer import BagWriter
from heading_intercompare.bags.recovery.recover_bag import recover
from heading_intercompare.bags.rosbag2.bag_reader import BagReader
from heading_intercompare.bags.rosbag2.provenance import (
    describe_origin,
    is_note,
    Note,
    Notes,
    read_notes,
    read_texts,
)
from heading_intercompare.core.version import VERSION
from heading_intercompare.messages.cdr import encode
from heading_intercompare.messages.status_messages import TEXT_TYPE

S = 1_000_000_000
NOW = 1_700_000_000 * S


def noted(*given):
    """Return the notes in texts, and the records they are written as."""
    records = {}
    notes = Notes(records.__setitem__)
    return [note for text in given for note in notes.add(text, NOW)], records


def test_the_origin_names_version_settings_and_sources():
    assert describe_origin({'model': 'NN', 'norms.preset': None},
                           {'ts': {'path': 'gyro.log', 'talker': None, 'fixed': '',
                                   'bytes': 0}}) == {
                 'version': VERSION, 'settings.model': 'NN', 'settings.norms.preset': 'none',
                 'source.ts.path': 'gyro.log', 'source.ts.bytes': 0}


def test_each_line_is_a_note():
    notes, records = noted('calm sea\n\n  wind\t5 m/s  \r\n', 'two\nthree')
    assert notes == [Note(NOW, text) for text in ('calm sea', 'wind 5 m/s', 'two', 'three')]
    assert list(records) == ['note.1', 'note.2', 'note.3', 'note.4']
    assert records['note.1'] == {'time': '2023-11-14T22:13:20.000000000Z', 'text': 'calm sea'}


@pytest.mark.parametrize('given, stamp_ns', [
    ('2014-08-01T00:05:00Z turn', 1406851500 * S), ('2014-08-01T00:05Z turn', 1406851500 * S),
    ('2014-08-01T00:05:00.25Z   turn', 1406851500 * S + S // 4),
    ('2014-08-01T00:05:00.000000001Z turn', 1406851500 * S + 1)])
def test_a_note_may_begin_with_its_time(given, stamp_ns):
    assert noted(given)[0] == [Note(stamp_ns, 'turn')]


@pytest.mark.parametrize('given', [
    '2014-13-01T00:05:00Z turn', '2014-08-01T00:05:00Z', '2014-08-01 the first day',
    '2014-08-01T00:05:00 local time', '1969-12-31T23:59:59Z turn', '0001-01-01T00:00:00Z turn'])
def test_what_is_not_quite_a_time_stays_in_the_note(given):
    assert noted(given)[0] == [Note(NOW, given)]


def test_a_note_cannot_command_a_terminal():
    assert noted('red \x1b[31malert\x00')[0] == [Note(NOW, 'red [31malert')]


def test_very_many_notes_end_with_a_word_of_it():
    notes, records = noted(*(f'note {i}' for i in range(1500)))
    assert len(notes) == len(records) == 1000
    assert notes[998].text == 'note 998'
    assert notes[999].text == (
        'too many notes: later ones are only in operator/note and operator/action')


def test_notes_are_read_back_in_the_order_of_their_times_whatever_happens_to_the_bag(tmp_path):
    with BagWriter(tmp_path / 'bag') as bag:
        notes = Notes(bag.metadata)
        notes.add('later', NOW)
        bag.split()
        notes.add('2014-08-01T00:05:00Z earlier\n2014-13-01T00:00:00Z no time', NOW + 7)
        bag.metadata('note.x', {'text': 'of somebody else'})
        bag.metadata('note.9', {'text': 'of somebody else', 'time': 'noon'})
    expected = [Note(1406851500 * S, 'earlier'), Note(NOW, 'later'),
                Note(NOW + 7, '2014-13-01T00:00:00Z no time')]
    assert read_notes(BagReader(tmp_path / 'bag')) == expected
    recover(tmp_path / 'bag', tmp_path / 'recovered')
    assert read_notes(BagReader(tmp_path / 'recovered')) == expected
    (tmp_path / 'bag' / 'bag_0.mcap').unlink()
    assert read_notes(BagReader(tmp_path / 'bag')) == expected


def test_a_recorder_that_is_killed_leaves_the_notes_it_had(tmp_path):
    bag = BagWriter(tmp_path / 'bag')
    Notes(bag.metadata).add('calm sea', NOW)
    assert BagReader(tmp_path / 'bag').incomplete
    assert read_notes(BagReader(tmp_path / 'bag')) == [Note(NOW, 'calm sea')]
    bag.close()


def test_notes_that_another_program_recorded_are_read_from_their_messages(tmp_path):
    with BagWriter(tmp_path / 'bag') as bag:
        bag.add_topic('/operator/note', TEXT_TYPE)
        for i, text in enumerate(['calm sea', '2014-08-01T00:05:00Z turn']):
            bag.write('/operator/note', encode(TEXT_TYPE, {'data': text}), NOW + i)
    reader = BagReader(tmp_path / 'bag')
    assert read_notes(reader) == [Note(1406851500 * S, 'turn'), Note(NOW, 'calm sea')]
    assert read_texts(reader, 'operator/note') == [(NOW, 'calm sea'),
                                                   (NOW + 1, '2014-08-01T00:05:00Z turn')]
    assert read_texts(reader, 'compliance/report') == []


@pytest.mark.parametrize('name, good', [
    ('note.1', True), ('note.12', True), ('note.', False), ('note.a', False), ('notes', False)])
def test_records_of_notes_are_known_by_their_names(name, good):
    assert is_note(name) is good
