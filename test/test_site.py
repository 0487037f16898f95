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

"""The tutorials run as printed, and the picture of the house shows the existing rooms."""

from __future__ import annotations

import doctest
from importlib.util import find_spec
from pathlib import Path
import re
import runpy
import shlex
import shutil

import pytest

from heading_intercompare.cli import main

ROOT = Path(__file__).resolve().parent.parent
DOCS = ROOT / 'docs'
TUTORIALS = sorted((DOCS / 'tutorials').glob('*.md'))
_CONSOLE = re.compile(r'^```console\n(.*?)^```', re.MULTILINE | re.DOTALL)
_FILE = re.compile(r'^```yaml\n# (\w+\.yaml)\n(.*?)^```', re.MULTILINE | re.DOTALL)
_PALMER = ('nbp1406/NBP1406_gyr1-2014-08-01', 'nbp1406/NBP1406_s330-2014-08-01')


def read_sessions(page):
    """Return the command lines of a page, each with the output that it prints there."""
    sessions = []
    for block in _CONSOLE.findall(page.read_text('utf-8')):
        for part in re.split(r'^\$ ', block, flags=re.MULTILINE)[1:]:
            command, _, shown = part.partition('\n')
            sessions.append((command, shown))
    return sessions


def fits(shown, printed):
    """Tell whether output matches the shown text, in which `...` stands for anything."""
    pattern = re.escape(shown.rstrip()).replace(re.escape('...'), '.*')
    return re.fullmatch(pattern, printed.rstrip(), re.DOTALL) is not None


@pytest.mark.slow
@pytest.mark.parametrize('name, least', [('first_verdict', 6), ('ship_logs', 5),
                                         ('fleet', 7)])
def test_the_commands_of_a_tutorial_print_what_it_shows(name, least, tmp_path, monkeypatch,
                                                        capsys, request):
    if name == 'ship_logs':
        data = request.getfixturevalue('shared_data')
        for log in _PALMER:
            shutil.copy(data / log, tmp_path)
    monkeypatch.chdir(tmp_path)
    page = DOCS / 'tutorials' / f'{name}.md'
    for file, text in _FILE.findall(page.read_text('utf-8')):
        Path(file).write_text(text, 'utf-8')
    sessions = read_sessions(page)
    assert len(sessions) >= least
    for command, shown in sessions:
        if '.pdf' in command and find_spec('weasyprint') is None:
            continue
        program, *arguments = shlex.split(command)
        assert program == 'heading-intercompare'
        assert main(arguments) == 0, command
        printed = capsys.readouterr().out
        assert fits(shown, printed), f'{command}\n{printed}'


def test_output_fits_only_what_is_shown():
    assert fits('a\n...\nd', 'a\nb\nc\nd\n') and fits('a...', 'abc')
    assert not fits('a\n...\nd', 'a\nb\nc\n') and not fits('a', 'ab') and not fits('', 'a')


@pytest.mark.slow
def test_the_python_tutorial_runs():
    failed, tried = doctest.testfile(str(DOCS / 'tutorials' / 'python.md'), module_relative=False)
    assert tried > 15 and not failed


def test_every_tutorial_is_run_or_needs_a_graph():
    assert {page.stem for page in TUTORIALS} == {'index', 'first_verdict', 'ship_logs', 'python',
                                                 'live_graph', 'bridge', 'fleet'}


def test_the_picture_of_the_house_is_that_of_the_tree():
    pytest.importorskip('matplotlib')
    house = runpy.run_path(str(DOCS / 'house.py'))
    picture = (DOCS / 'house.svg').read_text('utf-8')
    drawn = [name for storey in house['STOREYS'] for name, _ in storey]
    folders = [p.parent.name for p in house['PACKAGE'].glob('*/__init__.py')]
    assert sorted(drawn) == sorted(folders)
    for name in drawn:
        folder = house['PACKAGE'] / name
        for room in (folder, *house['list_rooms'](folder)):
            assert f'>{room.name}</text>' in picture, f'{room}: run make docs'
            assert f'>{house["count_modules"](room)} modules</text>' in picture


def test_the_marks_of_the_picture_are_the_ten_lines():
    pytest.importorskip('matplotlib')
    marks = runpy.run_path(str(DOCS / 'house.py'))['read_marks']()
    assert sorted({number for found in marks.values() for number in found}) == list(range(1, 11))
    assert marks['core/pairing'] == [5] and marks['messages'] == [3, 4]
