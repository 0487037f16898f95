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

"""Mistakes of a user give one clear line and exit code 2; and the exit codes of --check."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys

from command_line import NORMS, refusal
import numpy as np
import pytest
from trials import write_headings

from heading_intercompare import Headings
from heading_intercompare.cli import main
from heading_intercompare.core.version import VERSION
from heading_intercompare.messages.cdr import encode

S = 1_000_000_000
T0 = 1_400_000_000 * S


@pytest.fixture(scope='module')
def bag(tmp_path_factory):
    """Return a bag of 5 minutes at 10 Hz: TS 0.1° sd, RS exact, marks around the middle."""
    path = tmp_path_factory.mktemp('bag') / 'trial'
    rng = np.random.default_rng(1)
    stamps = T0 + np.arange(3000) * (S // 10)
    heading = 100.0 + 0.01 * np.arange(3000)
    streams = {topic: Headings.of(stamps, heading + error * rng.standard_normal(3000))
               for topic, error in (('ts/heading', 0.1), ('rs/heading', 0.0))}

    def remark(writer):
        writer.add_topic('remark', 'std_msgs/msg/String')
        writer.write('remark', encode('std_msgs/msg/String', {'data': 'x'}), T0)
    write_headings(path, streams, write_more=remark)
    return path


def test_a_missing_file_is_named(capsys):
    assert 'nowhere.mcap: No such file' in refusal(capsys, 'analyze', 'nowhere.mcap', *NORMS)
    assert 'nowhere.log: No such file' in refusal(
        capsys, 'import-nmea', '--ts', 'nowhere.log', '--rs', 'x', '-o', 'y')
    assert 'nowhere.yaml: No such file' in refusal(
        capsys, 'analyze', 'x', '--config', 'nowhere.yaml')


@pytest.mark.parametrize('name, content, words', [
    ('empty.mcap', b'', 'empty'), ('text.mcap', b'no bag at all', 'not'),
    ('empty.csv', b'', 'header'), ('no_columns.csv', b'a,b\n1,2\n', 'ts_deg'),
    ('bad_stamp.csv', b'stamp_ns,ts_deg,rs_deg\nnoon,1,2\n', 'line 2')])
def test_a_file_that_is_no_input_is_named_with_its_fault(name, content, words, capsys, tmp_path):
    (tmp_path / name).write_bytes(content)
    error = refusal(capsys, 'analyze', tmp_path / name, *NORMS)
    assert name in error and words in error


def test_a_bag_without_the_topic_lists_those_it_has(bag, capsys):
    error = refusal(capsys, 'analyze', bag, '--ts', 'gyro', *NORMS)
    assert "'gyro'" in error and '/rs/heading (sensor_msgs/msg/Imu)' in error


def test_a_topic_of_another_type_says_which_types_would_do(bag, capsys):
    error = refusal(capsys, 'analyze', bag, '--ts', 'remark', *NORMS)
    assert 'std_msgs/msg/String' in error and 'geometry_msgs/msg/QuaternionStamped' in error


@pytest.mark.parametrize('assignment, words', [
    ('pairing.tolerence_s=1', "did you mean 'pairing.tolerance_s'"),
    ('norms.sigma_max_deg=-1', 'norms.sigma_max_deg = -1'),
    ('norms.sigma_max_deg=0', 'greater than 0'),
    ('pairing.method=fast', "'interpolate_ts' or 'nearest'"),
    ('norms.sigma_max_deg', 'must be name=value')])
def test_a_wrong_setting_says_what_is_allowed(assignment, words, bag, capsys):
    name = assignment.partition('=')[0]
    norms = NORMS[2:] if NORMS[1].startswith(f'{name}=') else NORMS
    assert words in refusal(capsys, 'analyze', bag, *norms, '--set', assignment)


def test_a_missing_norm_is_named_before_anything_is_read(capsys):
    assert 'norms.sigma_max_deg is missing' in refusal(capsys, 'analyze', 'nowhere.mcap')


@pytest.mark.parametrize('text, words', [
    ('[1, 2', 'not YAML'), ('3', 'ROS parameter file'), ('a: 1', "section 'a'"),
    ('/**:\n  ros__parameters:\n    window_s: 3\n    window_s: 4', "line 4: 'window_s' is given"),
    ('/**:\n  ros__parameters:\n    norms.m_low: 0\n    norms: {m_low: 1}',
     "section '/**': norms.m_low is given twice"),
    ('/**: &all\n  ros__parameters: {}', 'line 1: anchors'),
    ('/**:\n  ros__parameters:\n    windows_s: 3', "did you mean 'window_s'")])
def test_a_wrong_parameter_file_is_named_with_its_fault(text, words, bag, capsys, tmp_path):
    file = tmp_path / 'config.yaml'
    file.write_text(text)
    error = refusal(capsys, 'analyze', bag, '--config', file)
    assert 'config.yaml' in error and words in error


@pytest.mark.parametrize('arguments', [
    ['analyse'], ['analyze'], ['analyze', 'x', '--colour'], ['import-nmea', '--ts', 'x']])
def test_a_wrong_command_line_points_to_the_help(arguments, capsys):
    assert '--help' in refusal(capsys, *arguments)


def test_norms_come_from_the_parameter_file_and_set_overrides_them(bag, capsys, tmp_path):
    file = tmp_path / 'config.yaml'
    file.write_text('/**:\n  ros__parameters:\n    norms:\n      sigma_max_deg: 0.3\n'
                    '      sigma_ref_max_deg: 0.1\n')
    assert main(['analyze', str(bag), '--config', str(file), '--json', '-']) == 0
    assert json.loads(capsys.readouterr().out)['settings']['norms.sigma_max_deg'] == 0.3
    assert main(['analyze', str(bag), '--config', str(file), '--json', '-', '--set',
                 'norms.sigma_max_deg=1']) == 0
    assert json.loads(capsys.readouterr().out)['settings']['norms.sigma_max_deg'] == 1.0


@pytest.mark.parametrize('sigma, code', [(0.3, 0), (0.05, 1), (0.1, 3)])
def test_check_turns_the_verdict_into_the_exit_code(sigma, code, bag, capsys):
    wanted = ['analyze', str(bag), '--set', f'norms.sigma_max_deg={sigma}', '--set',
              'norms.sigma_ref_max_deg=0.05', '--set', 'risk.min_duration_s=0']
    assert main(wanted) == 0
    assert main([*wanted, '--check']) == code
    capsys.readouterr()


def test_a_cut_bag_is_judged_on_what_is_there_and_said(bag, capsys, tmp_path):
    file = tmp_path / 'cut.mcap'
    shutil.copy(next(bag.glob('*.mcap')), file)
    with file.open('r+b') as cut:
        cut.truncate(file.stat().st_size // 2)
    assert main(['analyze', str(file), *NORMS]) == 0
    out, err = capsys.readouterr()
    assert 'VERDICT' in out and 'note: ' in err and 'cut.mcap' in err


@pytest.mark.parametrize('command', [['analyze', *NORMS], ['info'], ['info', '--check']])
def test_damaged_metadata_of_a_bag_are_named_with_line_and_remedy(command, bag, capsys, tmp_path):
    damaged = shutil.copytree(bag, tmp_path / 'bag')
    with (damaged / 'metadata.yaml').open('a') as file:
        file.write('rosbag2_bagfile_information: {}\n')
    line = (damaged / 'metadata.yaml').read_text().count('\n')
    said = refusal(capsys, command[0], damaged, *command[1:])
    assert f"metadata.yaml: line {line}: 'rosbag2_bagfile_information' is given twice; " in said
    assert '`recover` reads the bag without this file' in said
    assert main(['recover', str(damaged), '-o', str(tmp_path / 'new')]) == 0
    out, err = capsys.readouterr()
    assert 'kept: 6001 messages' in out and 'note: metadata.yaml: line ' in err
    assert main(['analyze', str(tmp_path / 'new'), *NORMS]) == 0


def test_the_run_table_says_where_the_runs_are(bag, capsys, tmp_path):
    table = tmp_path / 'runs.csv'
    table.write_text(f'start,stop,source\n{T0},{T0 + 60 * S},\n'
                     '2014-05-13T16:55:20Z,2014-05-13T16:56:20.5Z,trial\n'
                     f'{T0},{T0 + 60 * S},elsewhere\n')
    assert main(['analyze', str(bag), *NORMS, '--runs', str(table), '--json', '-']) == 0
    runs = json.loads(capsys.readouterr().out)['runs']
    assert [run['n'] for run in runs] == [600, 605]
    table.write_text('start,stop\nnoon,1\n')
    assert "line 2: 'noon'" in refusal(capsys, 'analyze', bag, *NORMS, '--runs', table)
    table.write_text('start,stop\n2,2\n')
    assert 'line 2: stop 2 is not after start 2' in refusal(capsys, 'analyze', bag, *NORMS,
                                                            '--runs', table)
    table.write_bytes(b'start,stop,source\n1,2,caf\xe9\n')
    assert 'is not UTF-8' in refusal(capsys, 'analyze', bag, *NORMS, '--runs', table)
    table.write_text('begin,end\n')
    assert 'start,stop[,source]' in refusal(capsys, 'analyze', bag, *NORMS, '--runs', table)


def test_the_verdict_names_its_input_and_its_sum(bag, capsys):
    assert main(['analyze', str(bag), *NORMS, '--json', '-']) == 0
    (entry,) = json.loads(capsys.readouterr().out)['inputs']
    assert entry['path'] == str(bag) and len(entry['sha256']) == 64
    assert (entry['ts_topic'], entry['rs_topic']) == ('ts/heading', 'rs/heading')


def test_too_little_memory_is_one_line(capsys, monkeypatch):
    def run(arguments):
        raise MemoryError

    monkeypatch.setattr('heading_intercompare.cli.commands.norms.run', run)
    assert 'there is not enough memory for this' in refusal(capsys, 'norms')


def test_version_and_help_and_norms(capsys):
    with pytest.raises(SystemExit) as end:
        main(['--version'])
    assert end.value.code == 0 and VERSION in capsys.readouterr().out
    with pytest.raises(SystemExit):
        main(['analyze', '--help'])
    assert 'example: heading-intercompare analyze' in capsys.readouterr().out
    assert main(['norms']) == 0 and 'imo_msc116' in capsys.readouterr().out


def test_a_command_does_not_wait_for_what_another_needs():
    code = ('import sys; from heading_intercompare.cli import main; main(["norms"]); '
            'print([m for m in sys.modules if m.startswith("heading_intercompare.ahrs")])')
    done = subprocess.run([sys.executable, '-c', code], stdout=subprocess.PIPE, text=True,
                          check=True, timeout=120,
                          env={**os.environ, 'PYTHONPATH': os.pathsep.join(sys.path)})
    assert done.stdout.splitlines()[-1] == '[]'


def test_the_command_leaves_linear_algebra_in_one_thread(monkeypatch):
    """What the user has set stays."""
    monkeypatch.setattr(sys, 'argv', ['heading-intercompare', '--version'])
    monkeypatch.setattr(sys, 'excepthook', sys.excepthook)
    monkeypatch.setattr(os, 'environ', {'MKL_NUM_THREADS': '3'})
    with pytest.raises(SystemExit):
        main()
    assert (os.environ['OPENBLAS_NUM_THREADS'], os.environ['MKL_NUM_THREADS']) == ('1', '3')


#: What a number in YAML 1.1 or in ROS may be that is none here, and what the refusal says.
NO_NUMBERS = {
    'yes': 'must be a number', 'on': 'must be a number', 'off': 'must be a number',
    'true': 'must be a number', '1:30': 'must be a number', '1_000': 'must be a number',
    '010': 'may be octal', '-007': 'may be octal', '.nan': 'must be', '"0.3"': 'must be a number',
    '.inf': 'must be', '2026-01-01': 'must be a number', '[0.3]': 'must be',
    '&a 0.3': 'anchors', '!!float 0.3': 'tags', '[' * 100_000: 'nested deeper than 50 levels',
    '{a: ' * 20_000: 'nested deeper than 50 levels', '9' * 400: 'too many digits'}


def by_config(value, bag, folder):
    file = folder / 'my.yaml'
    file.write_text(f'/**:\n  ros__parameters:\n    norms:\n      sigma_max_deg: {value}\n'
                    '      sigma_ref_max_deg: 0.1\n')
    return ['analyze', bag, '--config', file]


def by_set(value, bag, folder):
    return ['analyze', bag, '--set', f'norms.sigma_max_deg={value}', *NORMS[2:]]


def by_scenario(value, bag, folder):
    file = folder / 'my.yaml'
    file.write_text(f'duration_s: {value}\n')
    return ['simulate', '--scenario', file, '-o', folder / 'new']


@pytest.mark.parametrize('value', NO_NUMBERS, ids=lambda value: value[:12])
@pytest.mark.parametrize('given', [by_config, by_set, by_scenario])
def test_what_other_parsers_take_for_a_number_is_refused_in_one_line(given, value, bag, capsys,
                                                                     tmp_path):
    said = refusal(capsys, *given(value, bag, tmp_path))
    assert NO_NUMBERS[value] in said
    assert '.yaml' in said or '--set' in said or 'sigma_max_deg' in said


@pytest.mark.parametrize('text', ['1e-1', '1E-1', '.1', '+0.1', '0.10'])
@pytest.mark.parametrize('given', [by_config, by_set])
def test_numbers_are_read_however_they_are_written(given, text, bag, capsys, tmp_path):
    assert main([*map(str, given(text, bag, tmp_path)), '--json', '-']) == 0
    assert json.loads(capsys.readouterr().out)['settings']['norms.sigma_max_deg'] == 0.1


@pytest.mark.parametrize('command, text, words', [
    (['analyze', 'BAG', '--config', 'FILE'],
     '/**:\n  ros__parameters:\n    norms:\n      sigma_max_deg: 0.1\n      sigma_max_deg: 0.2\n',
     "line 5: 'sigma_max_deg' is given twice"),
    (['analyze', 'BAG', '--config', 'FILE'],
     '/compliance:\n  ros__parameters: {}\ncompliance:\n  ros__parameters: {}\n',
     "section 'compliance' is given twice"),
    (['simulate', '--scenario', 'FILE', '-o', 'NEW'], 'duration_s: 60\nduration_s: 90\n',
     "line 2: 'duration_s' is given twice"),
    (['analyze', 'BAG', *NORMS, '--set', 'norms.sigma_max_deg=0.4'], '',
     'norms.sigma_max_deg is given twice, first as 0.3')])
def test_a_name_given_twice_is_refused_in_one_line(command, text, words, bag, capsys, tmp_path):
    (tmp_path / 'my.yaml').write_text(text)
    places = {'BAG': bag, 'FILE': tmp_path / 'my.yaml', 'NEW': tmp_path / 'new'}
    assert words in refusal(capsys, *(places.get(each, each) for each in command))


@pytest.mark.parametrize('command', ['analyze', 'info'])
@pytest.mark.parametrize('text, words', [
    ('  a: ' + '[' * 100_000, 'nested deeper than 50 levels'),
    ('  a: 1\n  a: 2\n', "'a' is given twice"),
    ('  relative_file_paths: [yes, 1:30]\n', None), ('  x: *a\n', 'the alias *a stands'),
    ('  relative_file_paths: [010]\n', 'must be a list of names')])
def test_traps_in_the_metadata_of_a_bag_are_refused_or_words(command, text, words, bag, capsys,
                                                             tmp_path):
    damaged = shutil.copytree(bag, tmp_path / 'bag')
    (damaged / 'metadata.yaml').write_text(f'rosbag2_bagfile_information:\n{text}')
    arguments = [command, damaged, *(NORMS if command == 'analyze' else [])]
    if words:
        assert words in refusal(capsys, *arguments)
        return
    main([*map(str, arguments)])
    assert 'yes is missing; 1:30 is missing' in ''.join(capsys.readouterr()).replace('\n', ' ')
