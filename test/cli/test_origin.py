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

"""The origin that commands write into a bag: version, norms, sources, seed, notes."""

from __future__ import annotations

import hashlib
import time

from checksums import with_checksum
from command_line import NORMS
import pytest

from heading_intercompare.bags.rosbag2.bag_reader import BagReader
from heading_intercompare.bags.rosbag2.provenance import read_notes
from heading_intercompare.cli import main
from heading_intercompare.core.version import VERSION

S = 1_000_000_000
NOTES = ['--note', 'MV Example', '--note', '2014-08-01T00:00:02Z course change',
         '--operator', 'J. Smith']


def assert_noted(bag, before_ns):
    """Both notes are there: one with its own time, one with the time the bag was made."""
    event, ship = read_notes(BagReader(bag))
    assert event == (1406851202 * S, 'course change [by J. Smith]')
    assert ship.text == 'MV Example [by J. Smith]' and before_ns <= ship.stamp_ns <= time.time_ns()


@pytest.fixture
def logs(tmp_path):
    """Return two logs of five sentences, one of them without a heading."""
    paths = []
    for name, talker in (('ts.log', 'HE'), ('rs.log', 'IN')):
        lines = []
        for i in range(5):
            body = f'{talker}HDT,{100 + i}.0,T' if i != 3 else f'{talker}HDT,,T'
            lines.append(f'2014-08-01T00:00:0{i}.000000Z {with_checksum(body)}\n')
        paths.append(tmp_path / name)
        paths[-1].write_text(''.join(lines))
    return paths


def test_an_import_names_its_logs_with_their_sha256_and_what_was_not_taken(logs, tmp_path, capsys):
    before_ns = time.time_ns()
    assert main(['import-nmea', '--ts', str(logs[0]), '--rs', str(logs[1]), '-o',
                 str(tmp_path / 'bag'), *NORMS, *NOTES]) == 0
    said = BagReader(tmp_path / 'bag').metadata()['heading_intercompare']
    assert said['version'] == VERSION and said['settings.norms.sigma_max_deg'] == '0.3'
    for role, log, sentence in zip(('ts', 'rs'), logs, ('HEHDT', 'INHDT')):
        mine = {key: said[f'source.{role}.{key}'] for key in (
            'path', 'sha256', 'bytes', 'sentence', 'time', 'stamp_format', 'headings')}
        assert mine == {
            'path': str(log), 'sha256': hashlib.sha256(log.read_bytes()).hexdigest(),
            'bytes': str(log.stat().st_size), 'sentence': sentence, 'time': 'receipt',
            'stamp_format': 'auto', 'headings': '4'}
    assert [key for key in said if key.startswith('source.ts.not_taken.')] != []
    assert_noted(tmp_path / 'bag', before_ns)
    capsys.readouterr()
    assert main(['info', str(tmp_path / 'bag')]) == 0
    text = capsys.readouterr().out
    assert '  ts.sentence: HEHDT\n' in text and 'UTC  course change [by J. Smith]\n' in text


def test_a_simulation_names_scenario_and_seed_and_holds_the_truth(tmp_path, capsys):
    (tmp_path / 'trial.yaml').write_text('duration_s: 20\nseed: 4\nlegs: 0 350 12; 9 20 12\n')
    before_ns = time.time_ns()
    assert main(['simulate', '--scenario', str(tmp_path / 'trial.yaml'), '-o',
                 str(tmp_path / 'bag'), '--seed', '5', *NORMS, *NOTES]) == 0
    reader = BagReader(tmp_path / 'bag')
    said = reader.metadata()
    assert said['heading_intercompare']['version'] == VERSION
    assert said['heading_intercompare']['settings.norms.sigma_ref_max_deg'] == '0.1'
    assert (said['scenario']['file'], said['scenario']['seed']) == ('trial.yaml', '5')
    assert reader.attachments()[0].name == 'trial.yaml'
    assert reader.topics['/truth/heading'].count == reader.topics['/ts/heading'].count > 0
    assert_noted(tmp_path / 'bag', before_ns)
    capsys.readouterr()


@pytest.mark.parametrize('command', [
    ['import-nmea', '--ts', 'x', '--rs', 'y', '-o', 'z'], ['record'],
    ['simulate', '--scenario', 'demo', '-o', 'z'], ['note']])
@pytest.mark.parametrize('note, why', [
    (' ', 'must not be empty'), ('\t\x01', 'must not be empty'), ('a\udcff', 'must be UTF-8')])
def test_a_note_that_says_nothing_is_refused_before_anything_is_done(
        command, note, why, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    option = 'TEXT' if command == ['note'] else '--note'
    assert main([*command, *([] if command == ['note'] else ['--note']), note]) == 2
    err = capsys.readouterr().err
    assert option in err and why in err and err.count('\n') == 1
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize('command', [['record'], ['simulate', '--scenario', 'demo']])
def test_a_bag_whose_name_is_not_utf_8_is_refused(command, tmp_path, capsys):
    assert main([*command, '-o', str(tmp_path / 'b\udcff')]) == 2
    err = capsys.readouterr().err
    assert "b\\udcff' must be UTF-8" in err and err.count('\n') == 1
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize('login, author', [('mate', 'mate'), (None, 'unknown operator')])
def test_a_note_without_a_name_is_that_of_the_login(login, author, tmp_path, monkeypatch, capsys):
    def find_login():
        if login is None:
            raise KeyError('getpwuid(): uid not found')
        return login
    monkeypatch.setattr('getpass.getuser', find_login)
    (tmp_path / 'trial.yaml').write_text('duration_s: 20\nlegs: 0 350 12; 9 20 12\n')
    assert main(['simulate', '--scenario', str(tmp_path / 'trial.yaml'), '-o',
                 str(tmp_path / 'bag'), *NORMS, '--note', 'one\ntwo']) == 0
    assert [note.text for note in read_notes(BagReader(tmp_path / 'bag'))] == [
        f'one [by {author}]', f'two [by {author}]']
    capsys.readouterr()


def test_a_name_that_is_no_text_is_refused(tmp_path, capsys):
    assert main(['note', 'rough sea', '--operator', 'a\udcff']) == 2
    assert 'error: --operator' in capsys.readouterr().err
