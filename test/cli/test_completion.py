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

"""Completions for the Tab key, requested as bash requests them."""

from __future__ import annotations

import os
from pathlib import Path
import subprocess
import sys

import pytest

from heading_intercompare.app.scenarios import list_scenarios
from heading_intercompare.cli.completion import complete_setting
from heading_intercompare.cli.program import COMMANDS
from heading_intercompare.core.decision.coverage import SENSOR_CLASSES
from heading_intercompare.core.decision.norm_presets import PRESETS
from heading_intercompare.core.declared_settings import list_settings
from heading_intercompare.core.settings import Settings

pytest.importorskip('argcomplete')
pytestmark = pytest.mark.process

ASK = 'import sys; from heading_intercompare.cli import main; sys.exit(main())'


def ask(line, folder, code=ASK):
    """Return the completions of a line; the answer comes on descriptor 8."""
    asking = {**os.environ, 'PYTHONPATH': os.pathsep.join(sys.path), '_ARGCOMPLETE': '1',
              '_ARGCOMPLETE_IFS': '\n', '_ARGCOMPLETE_SHELL': 'bash', 'COMP_LINE': line,
              'COMP_POINT': str(len(line)), 'COMP_TYPE': '9',
              '_ARGCOMPLETE_COMP_WORDBREAKS': ' \t\n"\'><=;|&(:'}
    done = subprocess.run(['sh', '-c', 'exec 8>.answer 9>/dev/null; exec "$0" "$@"',
                           sys.executable, '-c', code], cwd=folder, env=asking, timeout=120,
                          stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                          stderr=subprocess.PIPE, text=True)
    assert (done.stdout, done.stderr) == ('', '')
    return (folder / '.answer').read_text().split()


@pytest.fixture
def folder(tmp_path):
    """Return a folder with a bag and files of several kinds."""
    (tmp_path / 'trial_bag').mkdir()
    for name in ('trial.mcap', 'trial.csv', 'trial.json', 'trial.yaml', 'trial.txt',
                 'trial.journal'):
        (tmp_path / name).touch()
    return tmp_path


@pytest.mark.parametrize('line, expected', [
    ('', {*COMMANDS, 'report', 'import-nmea', '--help', '--version'}),
    ('re', {'record', 'recover', 'rejudge', 'replay', 'report'}), ('analyze --se', {'--set'}),
    ('replay --lo', {'--loop'}), ('norms --', {'--help', '--quiet'}),
    ('analyze tri', {'trial_bag/', 'trial.mcap', 'trial.csv', 'trial.json', 'trial.journal'}),
    ('info tri', {'trial_bag/', 'trial.mcap'}), ('recover tri', {'trial_bag/', 'trial.mcap'}),
    ('rejudge x tri', {'trial_bag/', 'trial.mcap'}),
    ('analyze x --config tri', {'trial_bag/', 'trial.yaml'}),
    ('analyze x --runs tri', {'trial_bag/', 'trial.csv'}),
    ('analyze x --runs-csv tri', {'trial_bag/', 'trial.csv'}),
    ('report x --runs-c', {'--runs-csv'}),
    ('simulate --scenario tri', {'trial_bag/', 'trial.yaml'}),
    ('simulate --scenario sea_', {name for name in list_scenarios() if name.startswith('sea_')}),
    ('analyze x --set norms.sigma_m', {'norms.sigma_max_deg='}),
    ('analyze x --set norms.preset=imo_', {n for n in PRESETS if n.startswith('imo_')})])
def test_the_tab_key_offers_what_may_stand_there(folder, line, expected):
    assert len(expected) > 0
    assert {*ask(f'heading-intercompare {line}', folder)} - {'-h'} == expected


def test_commands_are_offered_without_loading_numbers(folder):
    code = (f'import os, sys\nsys.stdout = sys.stderr = open({str(folder / "log")!r}, "w")\n'
            'leave = os._exit\n'
            'def _exit(code):\n'
            '    print(*sys.modules, file=sys.stdout, flush=True)\n'
            '    leave(code)\n'
            f'os._exit = _exit\n{ASK}')
    assert ask('heading-intercompare rej', folder, code) == ['rejudge']
    loaded = {*(folder / 'log').read_text().split()}
    assert 'argcomplete' in loaded and not {'numpy', 'scipy', 'yaml', 'rclpy', 'rich'} & loaded


def test_every_setting_is_offered_and_every_value_that_has_a_name():
    rules = list_settings(Settings)
    assert complete_setting('') == [f'{rule.name}=' for rule in rules]
    for rule in rules:
        offered = complete_setting(f'{rule.name}=')
        assert offered or not rule.choices
        for text in offered:
            assert text.startswith(f'{rule.name}=')
    assert complete_setting('risk.sensor_class=') == [
        f'risk.sensor_class={name}' for name in SENSOR_CLASSES]
    assert complete_setting('norms.k_rule=t') == ['norms.k_rule=three']
    assert complete_setting('no.such=') == complete_setting('zzz') == []


def test_argcomplete_finds_its_mark_in_what_the_entry_point_names():
    import heading_intercompare.cli as cli

    for path in (Path(cli.__file__), Path(cli.__file__).parents[1] / '__main__.py'):
        assert 'PYTHON_ARGCOMPLETE_OK' in path.read_text('utf-8')[:1024]
