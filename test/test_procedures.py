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

"""The pages on field procedures: their commands run, and print what the pages show."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path
import re
import shlex

import pytest

from heading_intercompare.cli import main

FOLDER = Path(__file__).resolve().parent.parent / 'docs' / 'howto' / 'procedures'
PAGES = sorted(path for path in FOLDER.glob('*.md') if path.stem != 'index')
_BLOCK = re.compile(r'^```(text|console)\n(.*?)^```', re.MULTILINE | re.DOTALL)
_TABLE = re.compile(r'`(\w+\.csv)`')


def test_each_procedure_has_a_page_in_the_index_and_says_what_it_cannot_decide():
    index = (FOLDER / 'index.md').read_text('utf-8')
    for page in PAGES:
        assert f'\n{page.stem}\n' in index and f']({page.name})' in index
        assert '| can decide | cannot decide |' in page.read_text('utf-8')
    assert len(PAGES) >= 4


@pytest.mark.slow
@pytest.mark.parametrize('page', PAGES, ids=lambda page: page.stem)
def test_the_commands_of_a_page_print_what_it_shows(page, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    text = page.read_text('utf-8')
    if '--sun' in text and find_spec('ephem') is None:
        pytest.skip('ephem is not installed')
    printed, ran = '', 0
    for block in _BLOCK.finditer(text):
        if block[1] == 'text':
            name = _TABLE.findall(text[:block.start()])[-1]
            Path(name).write_text(block[2], 'utf-8')
            continue
        for line in block[2].splitlines():
            if line.startswith('$ '):
                assert main(shlex.split(line)[2:]) == 0, capsys.readouterr().err
                printed = capsys.readouterr().out
                ran += 1
            else:
                assert line in printed.splitlines(), f'{line!r} is not in\n{printed}'
    assert ran
