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

"""The commands `info`, `recover` and `replay`."""

from __future__ import annotations

import fcntl
import json
import os
import pty
import re
import select
import subprocess
import sys
import termios
import time

from command_line import refusal
from deadlines import DEADLINE_S
from mcap.reader import make_reader
import numpy as np
import pytest

from heading_intercompare import analyze, Headings, Settings
from heading_intercompare.bags.mcap.chunk_writer import Rows
from heading_intercompare.bags.recording.bag_writer import BagWriter
from heading_intercompare.bags.rosbag2.bag_reader import BagReader
from heading_intercompare.bags.rosbag2.provenance import Notes
from heading_intercompare.bags.settings import BagSettings
from heading_intercompare.cli import main
from heading_intercompare.messages.cdr import encode
from heading_intercompare.messages.heading_messages import encode_imu

S = 1_000_000_000
T0 = 1_400_000_000 * S


@pytest.fixture
def bag(tmp_path, rng):
    """Return a bag of 2 minutes at 10 Hz, with settings, sources, verdict and table of runs."""
    path = tmp_path / 'trial'
    settings = Settings.from_mapping({'norms.sigma_max_deg': 0.3, 'norms.sigma_ref_max_deg': 0.1})
    stamps = T0 + np.arange(1200) * (S // 10)
    rs = Headings.of(stamps, np.full(1200, 90.0))
    ts = Headings.of(stamps, 90.0 + 0.1 * rng.standard_normal(1200))
    report = json.dumps(analyze(ts, rs, settings).to_dict())
    with BagWriter(path, BagSettings(chunk_bytes=20_000)) as writer:
        writer.metadata('heading_intercompare', {
            'version': '1.2.3', 'source.ts.path': 'gyro.log', 'operator_note': 'calm sea',
            **{f'settings.{k}': v for k, v in settings.to_mapping().items()}})
        for topic, readings in (('/ts/heading', ts), ('/rs/heading', rs)):
            writer.add_topic(topic, 'sensor_msgs/msg/Imu')
            writer.write_rows([Rows(topic, encode_imu(readings, 'x'), stamps)])
        writer.add_topic('/remark', 'std_msgs/msg/String')
        writer.write('/remark', encode('std_msgs/msg/String', {'data': 'x'}), T0)
        writer.attachment('report.json', 'application/json', report.encode())
        writer.attachment('runs.csv', 'text/csv', b'run,start,stop\n1,2,3\n')
    return path


def damage_first_chunk(file):
    """Change one bit in the middle of the messages of the first chunk."""
    content = bytearray(file.read_bytes())
    with file.open('rb') as stream:
        chunk = make_reader(stream).get_summary().chunk_indexes[0]
    content[chunk.chunk_start_offset + chunk.chunk_length // 2] ^= 0x10
    file.write_bytes(content)


def printed(capsys, *arguments) -> str:
    assert main([str(a) for a in arguments]) == 0
    out, _ = capsys.readouterr()
    return out


def test_info_says_what_a_bag_holds(bag, capsys):
    text = printed(capsys, 'info', bag)
    rows = [line.split() for line in text.splitlines()]
    assert ['complete:', 'yes'] in rows
    assert 'span: 2014-05-13 16:53:20.000 to 2014-05-13 16:55:19.900 UTC, 119.9 s' in text
    assert ['/ts/heading', 'sensor_msgs/msg/Imu', '1200', '10.00'] in rows
    assert ['/remark', 'std_msgs/msg/String', '1', '-'] in rows
    assert ['software:', 'heading_intercompare', '1.2.3'] in rows
    assert ['norms.sigma_max_deg:', '0.3'] in rows and ['model:', 'NN'] in rows
    assert ['ts.path:', 'gyro.log'] in rows and ['operator_note:', 'calm', 'sea'] in rows
    assert '\nVERDICT: ' in text and 'run 1' in text
    assert ['run,start,stop'] in rows and ['1,2,3'] in rows


def test_info_shows_notes_sources_and_losses(tmp_path, capsys):
    with BagWriter(tmp_path / 'bag') as writer:
        Notes(writer.metadata).add('calm sea\n2014-05-13T16:54:00Z course change', T0 + 7 * S)
        writer.metadata('recording', {
            'faults': 1, 'received./ts/heading': 12, 'lost_on_the_way./ts/heading': 3,
            'not_written./ts/heading': 0, 'received./rs/heading': 0})
        writer.metadata('scenario', {'seed': 7, 'legs': '0 45 12\n180 90 12\n', 'fixed': '',
                                     'errors': None})
    text = printed(capsys, 'info', tmp_path / 'bag')
    assert ("\noperator's notes:\n  2014-05-13 16:53:27.000 UTC  calm sea\n"
            '  2014-05-13 16:54:00.000 UTC  course change\n') in text
    assert ('\nscenario:\n  seed: 7\n  legs:\n    0 45 12\n    180 90 12\n') in text + '\n'
    rows = [line.split() for line in text.splitlines()]
    assert ['faults:', '1'] in rows and ['/ts/heading', '12', '3', '0'] in rows
    assert ['/rs/heading', '0', '-', '-'] in rows
    assert 'fixed' not in text and 'errors' not in text and 'note.1' not in text


def test_info_check_reads_all_of_it(bag, capsys):
    text = printed(capsys, 'info', '--check', bag)
    rows = [line.split() for line in text.splitlines()]
    assert ['topic', 'type', 'messages', 'rate', '[1/s]', 'missing'] in rows
    assert ['/ts/heading', 'sensor_msgs/msg/Imu', '1200', '10.00', '-'] in rows
    assert 'check: 2,401 messages in ' in text and text.endswith('  every checksum is correct\n')
    assert 'check:' not in printed(capsys, 'info', bag)


def test_info_check_shows_gaps_in_the_numbers(tmp_path, capsys):
    with BagWriter(tmp_path / 'bag') as writer:
        for topic, numbers in (('/a', [1, 2, 5]), ('/b', [4, 5, 1])):
            writer.add_topic(topic, 'std_msgs/msg/String')
            for number in numbers:
                writer.write(topic, encode('std_msgs/msg/String', {'data': 'x'}), T0 + number,
                             None, number)
    rows = [line.split('  ') for line in printed(
        capsys, 'info', '--check', tmp_path / 'bag').splitlines()]
    missing = {row[0]: row[-1] for row in rows}
    assert (missing['/a'], missing['/b']) == ('2', '0 (numbers begin at 4, again: 1)')


def test_info_check_of_a_damaged_bag_ends_with_2_and_says_where(bag, capsys):
    damage_first_chunk(bag / 'trial_0.mcap')
    assert main(['info', '--check', str(bag)]) == 2
    out, err = capsys.readouterr()
    assert '/ts/heading' in out and '  wrong: trial_0.mcap: chunk damaged: ' in out
    assert 'checksum is correct' not in out and '`recover` copies the intact' in out
    assert err.count('\n') == 1 and f'{bag}: trial_0.mcap: chunk damaged' in err
    printed(capsys, 'info', bag)


def test_info_check_of_a_cut_bag_ends_with_2(bag, capsys):
    file = bag / 'trial_0.mcap'
    file.write_bytes(file.read_bytes()[:-3000])
    assert main(['info', '--check', str(bag)]) == 2
    assert 'trial_0.mcap was not closed' in capsys.readouterr().err


def test_info_extracts_what_is_attached_and_overwrites_nothing(bag, tmp_path, capsys):
    folder = tmp_path / 'some' / 'where'
    text = printed(capsys, 'info', bag, '--extract', folder)
    assert f'written: {folder / "runs.csv"}\n' in text
    assert (folder / 'runs.csv').read_bytes() == b'run,start,stop\n1,2,3\n'
    assert json.loads((folder / 'report.json').read_text())['schema']
    assert main(['info', str(bag), '--extract', str(folder)]) == 2
    assert 'report.json: File exists' in capsys.readouterr().err


def test_what_is_attached_stays_in_the_folder_it_is_extracted_to(tmp_path, capsys):
    with BagWriter(tmp_path / 'bag') as writer:
        writer.attachment('../../up.txt', 'text/plain', b'up')
        writer.attachment('..', 'text/plain', b'dots')
        writer.attachment('/', 'text/plain', b'root')
    printed(capsys, 'info', tmp_path / 'bag', '--extract', tmp_path / 'to')
    assert {f.name: f.read_bytes() for f in (tmp_path / 'to').iterdir()} == {
        'up.txt': b'up', 'attachment_2': b'dots', 'attachment_3': b'root'}


def test_info_shows_the_last_report_where_none_came_to_be_attached(bag, tmp_path, capsys):
    report = next(a.data for a in BagReader(bag).attachments() if a.name == 'report.json')
    with BagWriter(tmp_path / 'killed') as writer:
        writer.add_topic('/compliance/report', 'std_msgs/msg/String')
        for i, text in enumerate(['{}', report.decode()]):
            writer.write('/compliance/report', encode('std_msgs/msg/String', {'data': text}),
                         T0 + i * S)
    text = printed(capsys, 'info', tmp_path / 'killed')
    assert 'last report on compliance/report, 2014-05-13 16:53:21.000 UTC\nVERDICT: ' in text


def test_info_of_an_unfinished_bag_says_so(bag, capsys):
    file = bag / 'trial_0.mcap'
    file.write_bytes(file.read_bytes()[:-3000])
    text = printed(capsys, 'info', bag)
    assert 'complete: no: trial_0.mcap was not closed' in text
    assert '/ts/heading' in text


def test_info_of_a_bag_whose_recorder_lost_messages_says_so(tmp_path, capsys):
    with BagWriter(tmp_path / 'bag') as writer:
        writer.metadata('recording', {
            'faults': 2, 'absent': 1, 'not_written./ts/heading': 7, 'not_written./rs/heading': 5,
            'lost_on_the_way./ts/heading': 3})
    text = printed(capsys, 'info', tmp_path / 'bag')
    assert ('\ncomplete: no: 12 messages received but not written, '
            '1 message in files that were removed or moved\n') in text


@pytest.mark.parametrize('record, entries, line', [
    ('recording', {'not_written./ts/heading': 4000, 'absent': 802},
     'missing: 4,802 of 7,203 messages (67%)'),
    ('recording', {'not_written./ts/heading': 2}, 'missing: 2 of 2,403 messages (under 1%)'),
    ('recovery', {'messages_lost': 2401, 'messages_lost_is': 'all'},
     'missing: 2,401 of 4,802 messages (50%)'),
    ('recovery', {'messages_lost': 2401, 'messages_lost_is': 'at least'},
     'missing: at least 2,401 of 4,802 messages (50%)'),
    ('recording', {'lost_on_the_way./ts/heading': 3}, None)])
def test_the_first_line_of_info_says_what_share_is_missing(bag, tmp_path, capsys, record,
                                                           entries, line):
    with BagWriter(tmp_path / 'copy') as writer:
        reader = BagReader(bag)
        for name, info in reader.topics.items():
            writer.add_topic(name, info.type_name)
        for message in reader.messages():
            writer.write(message.topic, message.data, message.log_time_ns)
        writer.metadata(record, entries)
    first = printed(capsys, 'info', tmp_path / 'copy').splitlines()[0]
    assert first == (line or f'bag: {tmp_path / "copy"}')


def test_the_first_line_of_info_says_what_an_index_counts_and_is_not_there(bag, capsys):
    file = bag / 'trial_0.mcap'
    data = bytearray(file.read_bytes())
    count = (2401).to_bytes(8, 'little')
    at = data.rindex(count)
    data[at:at + 8] = (4802).to_bytes(8, 'little')
    file.write_bytes(data)
    assert printed(capsys, 'info', bag).startswith('missing: 2,401 of 4,802 messages (50%)\nbag: ')


def test_info_of_a_bag_without_messages(tmp_path, capsys):
    with BagWriter(tmp_path / 'empty'):
        pass
    assert 'span: no message' in printed(capsys, 'info', tmp_path / 'empty')


@pytest.mark.parametrize('report', [b'[]', b'{}', b'nonsense', b'{"outcome": 3}', b'\xff'])
def test_info_survives_a_report_that_is_no_verdict(tmp_path, capsys, report):
    with BagWriter(tmp_path / 'bag') as writer:
        writer.attachment('report.json', 'application/json', report)
    assert 'not a verdict that this version can read' in printed(capsys, 'info', tmp_path / 'bag')


def test_recover_prints_what_was_kept_and_lost(bag, tmp_path, capsys):
    damage_first_chunk(bag / 'trial_0.mcap')
    assert main(['recover', str(bag), '-o', str(tmp_path / 'new')]) == 0
    out, err = capsys.readouterr()
    kept = sum(t.count for t in BagReader(tmp_path / 'new').topics.values())
    assert 2200 < kept < 2401
    assert f'kept: {kept} messages' in out
    assert f'lost: {2401 - kept} messages; 1 chunk damaged or cut' in out
    assert f'bag: {tmp_path / "new"}\n' in out
    assert err.startswith('note: trial_0.mcap: bytes ') and err.count('\n') == 1
    text = printed(capsys, 'info', tmp_path / 'new')
    assert 'complete: no: recovered from a damaged bag' in text


def test_recover_of_a_whole_bag_loses_nothing(bag, tmp_path, capsys):
    text = printed(capsys, 'recover', bag, '-o', tmp_path / 'new')
    assert 'lost: nothing\n' in text
    assert 'complete: yes' in printed(capsys, 'info', tmp_path / 'new')


@pytest.mark.parametrize('content', [b'', b'no bag', bytes(100)])
def test_recover_of_what_is_not_readable_is_one_line(tmp_path, capsys, content):
    (tmp_path / 'x.mcap').write_bytes(content)
    err = refusal(capsys, 'recover', tmp_path / 'x.mcap', '-o', tmp_path / 'new')
    assert 'nothing in it is readable' in err
    assert not (tmp_path / 'new').exists()


def test_recover_of_what_is_not_there_is_one_line(tmp_path, capsys):
    assert main(['recover', str(tmp_path / 'nowhere'), '-o', str(tmp_path / 'new')]) == 2
    assert 'nowhere: No such file' in capsys.readouterr().err


@pytest.mark.parametrize('rules, words', [
    (['ts/heading'], "'ts/heading' must be OLD:=NEW, two topic names"),
    (['ts/heading:='], "'ts/heading:=' must be OLD:=NEW"),
    ([':=gyro'], "':=gyro' must be OLD:=NEW"),
    (['ts/heading:=1st'], "'ts/heading:=1st' must be OLD:=NEW"),
    (['ts/heading:=a:=b'], "'ts/heading:=a:=b' must be OLD:=NEW"),
    (['ts heading:=gyro'], "'ts heading:=gyro' must be OLD:=NEW"),
    (['ts/heading:=gyro//x'], "'ts/heading:=gyro//x' must be OLD:=NEW"),
    (['ts/heading:=a__b'], "'ts/heading:=a__b' must be OLD:=NEW, two topic names without __"),
    (['ts/heading:=a', 'ts/heading:=b'], 'ts/heading is already remapped to a')])
def test_a_malformed_remapping_is_one_line(rules, words, capsys):
    assert words in refusal(capsys, 'replay', 'bag', '--remap', *rules)


def test_rules_in_front_of_the_bag_are_not_taken_for_it(capsys):
    assert main(['replay', '--remap', 'ts/heading:=gyro', 'trial']) == 2
    assert "'trial' must be OLD:=NEW" in capsys.readouterr().err


@pytest.mark.parametrize('options, words', [
    (['--remap', 'pairs:=x'], "remap 'pairs': is not replayed; must be one of ts/heading, "
     'rs/heading, compliance/marker'),
    (['-m', 'ts/heading:=x', '--remap', 'rs/heading:=x'], "topic 'rs/heading' would be published "
     "as /x, which is already the name of 'ts/heading'"),
    (['-m', '/ts/heading:=/x', 'ts/heading:=y'], "remap '/ts/heading': is given 2 times"),
    (['--start', '-1'], 'start_s = -1.0: must be a number of at least 0'),
    (['--start', '120'], 'start_s = 120.0: '), (['--start', 'nan'], 'start_s = nan: '),
    (['--duration', '-0.5'], 'duration_s = -0.5: must be a number of at least 0 or none'),
    (['--rate', '-2'], 'rate = -2.0: must be a number of at least 0')])
def test_a_replay_that_cannot_be_is_one_line(options, words, bag, capfd):
    pytest.importorskip('rclpy')
    assert words in refusal(capfd, 'replay', bag, *options)


@pytest.mark.parametrize('content, words', [
    (None, 'No such file'), ('stamp_ns,ts_deg,rs_deg', 'is not a ROS parameter file'),
    ('a: 1', "section 'a': must hold ros__parameters")])
@pytest.mark.parametrize('command', [['replay', 'bag'], ['record']])
def test_a_wrong_parameter_file_of_a_node_is_one_line(command, content, words, tmp_path, capfd):
    pytest.importorskip('rclpy')
    file = tmp_path / 'parameters.yaml'
    if content is not None:
        file.write_text(content)
    assert f'{file}: {words}' in refusal(capfd, *command, '--config', file)


@pytest.mark.slow
def test_a_replay_of_a_part_without_headings_says_so_and_ends(bag, capfd):
    pytest.importorskip('rclpy')
    assert main(['replay', str(bag), '--start', '7.01', '--duration', '0.05']) == 0
    out, err = capfd.readouterr()
    assert out == '' and err.count('nothing to replay') == 1
    assert f'nothing to replay: {bag} from 7.01 s to before 7.06 s has no heading' in err


class Person:
    """A person at a terminal in which a command runs."""

    def __init__(self, *arguments, **environment):
        self.side, program = pty.openpty()
        self.program = program
        self.before = termios.tcgetattr(program)
        self.seen = ''
        self.process = subprocess.Popen(
            [sys.executable, '-m', 'heading_intercompare', *arguments], stdin=program,
            stdout=program, stderr=program, start_new_session=True,
            env={**os.environ, **environment},
            preexec_fn=lambda: fcntl.ioctl(program, termios.TIOCSCTTY, 0))

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.process.poll() is None:
            self.process.kill()
            self.process.wait()
        os.close(self.side)
        os.close(self.program)

    def read(self):
        """Read what is on the screen."""
        if select.select([self.side], [], [], 0.05)[0]:
            self.seen += os.read(self.side, 65536).decode()

    def presses(self, keys):
        """Press keys, and forget what was seen before."""
        self.seen = ''
        os.write(self.side, keys)

    def sees(self, words):
        """Wait for a text that matches a pattern."""
        deadline_s = time.monotonic() + DEADLINE_S
        while not (found := re.search(words, self.seen)):
            assert time.monotonic() < deadline_s, self.seen
            self.read()
        return found

    def ends(self):
        """Wait for the end; return the exit code."""
        deadline_s = time.monotonic() + DEADLINE_S
        while self.process.poll() is None:
            assert time.monotonic() < deadline_s, self.seen
            self.read()
        while select.select([self.side], [], [], 0.0)[0]:
            self.read()
        return self.process.returncode


@pytest.fixture
def alone(tmp_path):
    """Return the options of a replay that does not wait for subscribers."""
    pytest.importorskip('rclpy')
    file = tmp_path / 'alone.yaml'
    file.write_text('replayer: {ros__parameters: {subscribers: 0}}\n')
    return ['--config', str(file)]


@pytest.mark.process
def test_the_space_bar_pauses_and_ctrl_c_leaves_the_terminal_as_it_was(bag, alone):
    with Person('replay', str(bag), *alone, '--start-paused') as person:
        person.sees(r'trial: paused at 0\.000 s of 119\.900 s; space: pause, resume')
        person.presses(b' ')
        person.sees(r'replaying at [0-9.]+ s of 119\.900 s')
        person.presses(b'x ')
        place = person.sees(r'paused at ([0-9.]+) s')[1]
        assert 0.0 < float(place) < 119.9
        person.presses(b'  ')
        person.sees(f'paused at {place} s')
        assert termios.tcgetattr(person.program) != person.before
        assert 'replaying' not in person.seen
        person.presses(b'\x03')
        assert person.ends() == 0
        assert 'Traceback' not in person.seen
        # At its end rich leaves the line, goes back up, and erases it.
        seen = re.sub(r'\r\n\x1b\[\?25h\r?\x1b\[1A\x1b\[2K', '', person.seen)
        assert '\n' not in seen.replace('^C', '')
        assert termios.tcgetattr(person.program) == person.before


@pytest.mark.process
def test_at_its_end_and_after_an_error_the_terminal_is_as_it_was(bag, alone):
    for options, code in ((['--rate', '0'], 0), (['--remap', 'x:=y'], 2)):
        with Person('replay', str(bag), *alone, *options) as person:
            assert person.ends() == code
            assert termios.tcgetattr(person.program) == person.before
