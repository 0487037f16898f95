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


"""Sentences in bags of every kind give the same headings, the same notes and the same verdict."""

from __future__ import annotations

from checksums import with_checksum
from command_line import analyze_json, NORMS, refusal
import numpy as np
import pytest

from heading_intercompare.cli import main
from heading_intercompare.messages.sentence_messages import SENTENCE

pytest.importorskip('rosbags', reason='rosbags is not installed')

from driver_bags import read, S, STORAGES, T0, write

N = 6000
SHIP = 90.0 + 20.0 * np.sin(np.arange(N) / 900.0)
NOISE = 0.1 * np.random.default_rng(3).standard_normal(N)
#: What a driver may put into a message.
FORMS = ['{}', '{}\r\n', '{}\n', ' {}', '{}\0']


def hdt(talker, heading_deg):
    """Return a sentence."""
    return with_checksum(f'{talker}HDT,{heading_deg:.3f},T')


def tell(at):
    """Return the text of a message: of a gyro, of a GNSS receiver, and of others in turn."""
    gyro, gnss = hdt('HE', SHIP[at] + NOISE[at]), hdt('GP', SHIP[at])
    course = with_checksum('GPVTG,1.0,T,,M,2.0,N,3.7,K')
    others = ['$HEHDT,9.0,T*00', '', 'no sentence', with_checksum('HEROT,1.0,A')]
    return {'sentence': [FORMS[at // 3 % len(FORMS)].format(gyro), f'{gnss}\r\n{course}',
                         others[at // 3 % len(others)]][at % 3]}


@pytest.fixture(scope='module')
def bags(tmp_path_factory):
    """Return a bag of each kind with the same messages."""
    folder = tmp_path_factory.mktemp('sentences')
    return {storage: write(folder / f'{storage}.bag', storage, {'/nmea': (SENTENCE, tell)}, N)
            for storage in STORAGES}


@pytest.mark.parametrize('storage', STORAGES)
@pytest.mark.parametrize('asked, phase, expected', [
    ('nmea.HEHDT', 0, SHIP + NOISE), ('nmea.GPHDT', 1, SHIP), ('/nmea.HDT', 0, SHIP + NOISE),
    ('nmea', 0, SHIP + NOISE)])
def test_the_sentences_of_a_topic_are_headings(bags, storage, asked, phase, expected):
    headings, oddities = read(bags[storage], asked)
    assert headings.stamp_ns.tolist() == [T0 + at * (S // 10) for at in range(phase, N, 3)]
    assert np.abs(headings.heading_deg - expected[phase::3]).max() < 5.1e-4
    talker, other = ('GP', 'HE') if phase else ('HE', 'GP')
    assert oddities[0].startswith(f'{asked}: headings of {talker}HDT; not taken: ')
    for count in ('500 bad_checksum', f'2000 other_talker.{other}'):
        assert count in oddities[0]


def test_each_kind_of_bag_has_one_verdict_and_one_list_of_what_was_not_taken(bags, capsys):
    verdicts, notes = [], []
    for storage in STORAGES:
        verdict, lines = analyze_json(capsys, bags[storage], '--ts', 'nmea.HEHDT', '--rs',
                                      'nmea.GPHDT')
        run, = verdict['runs']
        run.pop('source')
        verdicts.append(run)
        notes.append([line.partition('.bag: ')[2] for line in lines])
    assert verdicts[0] == verdicts[1] == verdicts[2] and notes[0] == notes[1] == notes[2]
    assert verdicts[0]['n'] > 1900 and 0.09 < verdicts[0]['std_deg'] < 0.12


@pytest.mark.parametrize('storage', STORAGES)
def test_info_shows_a_topic_of_sentences(bags, capsys, storage):
    assert main(['info', str(bags[storage])]) == 0
    row = next(line for line in capsys.readouterr().out.splitlines() if '/nmea' in line)
    assert SENTENCE in row and str(N) in row


@pytest.mark.parametrize('storage', STORAGES)
@pytest.mark.parametrize('asked, wrong', [
    ('nmea.HEROT', 'topic /nmea: HEROT: is no sentence with a heading; must be THS, HDT'),
    ('nmea.hehdt', 'topic /nmea: hehdt: is no sentence with a heading'),
    ('nmea.sentence', 'topic /nmea: sentence: is no sentence with a heading')])
def test_a_sentence_without_a_heading_is_one_line(bags, capsys, storage, asked, wrong):
    assert wrong in refusal(capsys, 'analyze', bags[storage], '--ts', asked, '--rs', 'nmea.GPHDT',
                            *NORMS)


@pytest.mark.parametrize('storage', STORAGES)
def test_the_log_time_may_replace_the_stamps_of_sentences(tmp_path, storage):
    bag = write(tmp_path / 'a.bag', storage, {'/nmea': (SENTENCE, lambda at: {
        'sentence': hdt('HE', SHIP[at]), 'header.stamp.sec': 0, 'header.stamp.nanosec': 0})}, 60)
    headings, oddities = read(bag, 'nmea.HDT@log_time')
    assert headings.stamp_ns.tolist() == [T0 + at * (S // 10) + 7 for at in range(60)]
    assert oddities[0].endswith('not taken: nothing; the stamps are the times at which the '
                                'messages were recorded, later than the headings')


@pytest.mark.parametrize('storage', STORAGES)
@pytest.mark.parametrize('kind, path', [
    ('std_msgs/msg/String', 'data'), ('maker_msgs/msg/Line', 'line.text')])
def test_sentences_in_a_text_of_any_message_are_headings(tmp_path, capsys, storage, kind, path):
    """A plain text has no header: its stamps are the log times."""
    bag = write(tmp_path / 'a.bag', storage, {
        '/nmea': (kind, lambda at: {path: tell(at)['sentence']})}, 600)
    late_ns = 7 * (kind == 'std_msgs/msg/String')
    for asked, phase, expected in ((f'nmea.{path}.HEHDT', 0, SHIP + NOISE),
                                   (f'nmea.{path}.GPHDT', 1, SHIP)):
        headings, oddities = read(bag, asked)
        assert headings.stamp_ns.tolist() == [
            T0 + at * (S // 10) + late_ns for at in range(phase, 600, 3)]
        assert np.abs(headings.heading_deg - expected[phase:600:3]).max() < 5.1e-4
        assert ('were recorded' in oddities[0]) == bool(late_ns)
    said = refusal(capsys, 'analyze', bag, '--ts', f'nmea.{path}.HEROT', '--rs', asked, *NORMS)
    assert 'topic /nmea: HEROT: is no sentence with a heading' in said
