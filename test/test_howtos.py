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

"""The how-to guides run: commands on stand-ins of their inputs, parameter files as printed."""

from __future__ import annotations

from glob import glob
from importlib.util import find_spec
from pathlib import Path
import re
import shutil
import subprocess

from checksums import with_checksum
import pytest
from test_documented_commands import read_commands
from test_logger_examples import seconds

from heading_intercompare.app.config import load_config, settings_for
from heading_intercompare.app.scenarios import read_scenario
from heading_intercompare.cli import main

FOLDER = Path(__file__).resolve().parent.parent / 'docs' / 'howto'
_YAML = re.compile(r'^```yaml\n(?:# (\w+\.yaml)\n)?(.*?)^```', re.MULTILINE | re.DOTALL)
NORMS = 'norms: {sigma_max_deg: 0.3, sigma_ref_max_deg: 0.1}\n'
#: The names under which pages have a recording of the demo.
BAGS = ('trial', 'trial_1', 'trial_2', 'monday', 'tuesday', 'wednesday')
#: The sentences of each second in the logs that pages name.
TS, RS = 'HEHDT,{ts:.2f},T', 'INHDT,{rs:.2f},T'
LOGS = {'gyro.log': [TS], 'compass.log': [RS], 'seapath.log': [RS], 'nav.log': [TS, RS],
        'gps.log': ['GPVTG,{rs:.2f},T,,M,9.0,N,,K']}
#: Commands that need a graph, messages of other types, sensors or runs that other tests make.
ELSEWHERE = re.compile(r'^(live|demo|note|import|simulate)|@|tf\.|OUTPUT|FILE|four|gyro=|bag_\*|'
                       '--rs-antennas|COMMAND|--certify')

#: A plan repeats its trial: one shows that the command runs, and 13 h of 12 sail legs twice.
ONE_TRIAL = ('--trials', '1')
LONGER = ('--hours', '13')


def read_parameter_files():
    """Yield the name if it has one, and the text, of each parameter file of the guides."""
    for page in sorted(FOLDER.glob('*.md')):
        for name, text in _YAML.findall(page.read_text('utf-8')):
            yield pytest.param(name, text, id=page.stem)


def read_guides():
    """Yield the pages with the commands that run here."""
    for page in sorted(FOLDER.glob('*.md')):
        commands = [words for words in read_commands(page.read_text('utf-8'))
                    if not ELSEWHERE.search(' '.join(words))]
        if commands and page.stem != 'index':
            yield pytest.param(page, commands, id=page.stem)


@pytest.mark.parametrize('name, text', [*read_parameter_files()])
def test_a_parameter_file_of_a_guide_is_taken(tmp_path, name, text):
    path = tmp_path / (name or 'my.yaml')
    path.write_text(text, 'utf-8')
    if text.startswith('title:'):
        (tmp_path / 'gyro.log').touch()
        assert read_scenario(str(path)).scenario.title
    else:
        config = load_config(str(path))
        assert config.shared or config.sections
        settings_for(config)


@pytest.fixture(scope='module')
def inputs(tmp_path_factory):
    """Return a folder with stand-ins of what the pages name."""
    folder = tmp_path_factory.mktemp('inputs')
    for name in ('my.yaml', 'heading_intercompare.yaml'):
        (folder / name).write_text(NORMS)
    assert main(['simulate', '--scenario', 'demo', '--config', str(folder / 'my.yaml'),
                 '-o', str(folder / BAGS[0]), '--quiet']) == 0
    for name in BAGS[1:]:
        shutil.copytree(folder / BAGS[0], folder / name)
    for name, bodies in LOGS.items():
        (folder / name).write_text(''.join(
            f'{t:%Y-%m-%dT%H:%M:%S}.000Z {with_checksum(body.format(ts=ts, rs=rs))}\n'
            for _, t, ts, rs in seconds() for body in bodies))
    (folder / 'pairs.csv').write_text('stamp_s,ts_deg,rs_deg\n' + ''.join(
        f'{t.timestamp():.0f},{ts},{rs}\n' for _, t, ts, rs in seconds()))
    # The home of who signs, and the list of signers.
    (folder / '.ssh').mkdir()
    subprocess.run(['ssh-keygen', '-q', '-t', 'ed25519', '-N', '', '-f',
                    folder / '.ssh' / 'id_ed25519'], check=True)
    (folder / 'allowed_signers').write_text(
        f'a.mate {(folder / ".ssh" / "id_ed25519.pub").read_text()}')
    for name in ('example', 'other'):
        assert main(['analyze', str(folder / 'trial'), '--config', str(folder / 'my.yaml'),
                     '--logbook', str(folder / f'{name}.sqlite'), '--ship', name]) == 0
    return folder


@pytest.mark.slow
@pytest.mark.parametrize('page, commands', [*read_guides()])
def test_the_commands_of_a_guide_run(page, commands, inputs, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(shutil.copytree(inputs, tmp_path / 'inputs'))
    monkeypatch.setenv('HOME', str(tmp_path / 'inputs'))
    for name, text in _YAML.findall(page.read_text('utf-8')):
        if name:
            Path(name).write_text(text, 'utf-8')
    for words in commands:
        if any(word.endswith('.pdf') for word in words) and find_spec('weasyprint') is None:
            continue
        # As the shell does.
        words = [name for word in words
                 for name in (sorted(glob(word)) if '*' in word else [word])]
        if words[0] == 'plan':
            words += [*ONE_TRIAL, *(LONGER if '--hours' in words else ())]
        code = main(words)
        # Verdicts have the codes 1, 3 and 4 with --check.
        assert code == 0 or '--check' in words and code in (1, 3, 4), capsys.readouterr().err
