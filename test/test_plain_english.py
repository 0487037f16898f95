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

"""The commonest slips from plain English, see docs/STYLE.md."""

from __future__ import annotations

import ast
import io
from pathlib import Path
import re
import tokenize
from typing import Iterator

import pytest

ROOT = Path(__file__).resolve().parent.parent
PACKAGE = ROOT / 'heading_intercompare'
ROOMS = sorted(p.name for p in PACKAGE.iterdir() if p.is_dir() and p.name != '__pycache__')
# Git ignores the pages that are generated.
GENERATED = [ROOT / line.rstrip('/') for line in (ROOT / '.gitignore').read_text('utf-8').split()
             if line.startswith('docs/')]
PAGES = [ROOT / name for name in ('README.md', 'CONTRIBUTING.md', 'RELEASING.md')] + [
    page for page in sorted((ROOT / 'docs').rglob('*.md'))
    if not {page, *page.parents} & {*GENERATED}]

SLIPS = {
    r'\bso (many|much|long)\b(?! (as|that)\b)': 'name the count, the amount or the time',
    r'\b(for|of|to|from|by|towards|serves|refuse|reaches) who\b|[;,] who (writes|takes|reads)':
        'say the caller, the reader, the worker',
    r'\bwho(ever| has not)\b': 'say which program or person',
    r'(?<!falls )(?<!lags )(?<!fall )(?<!lag )\bbehind\b': 'after',
    r'\banew\b': 'again',
    r'\bshall\b': 'must or should',
    r'\b(borne|till|whereof|thereof|lest)\b': 'an everyday word',
    r'\bfor want of\b': 'without, or because there is no ...',
    r'\bwhat (came|comes|has become|became) of\b': 'the result of',
    r'\b(makes?|made|know) of (it|them|what)\b': 'a verb that says the action',
    r'\bheld against\b': 'compared with',
    r'\b(is|are) taken for\b': 'mistaken for, or treated as',
    r'\bone an? (run|line|message|input|bag|chunk|file|topic|reading|row|sensor|minute|look)\b':
        'one per ...',
    r'[,;] else\b(?! (if|None)\b)': 'otherwise',
    r'\bas (large|many|much|long) as need be\b': 'as ... as needed',
    r'\bof no\b(?! (more|longer|less|fewer)\b)': 'without',
    r'\bin the place of\b': 'instead of',
    r'\b(if|unless) it is not so\b': 'otherwise',
}


def _texts(path: Path) -> Iterator[tuple[int, str]]:
    """Yield the docstrings, messages and comments of a module with their lines."""
    source = path.read_text('utf-8')
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            yield node.lineno, ' '.join(node.value.split())
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type == tokenize.COMMENT:
            yield token.start[0], token.string


def _slips(text: str) -> Iterator[str]:
    for pattern, instead in SLIPS.items():
        for match in re.finditer(pattern, text, re.IGNORECASE):
            yield f'{text[max(0, match.start() - 30):match.end() + 15]!r}: {instead}'


@pytest.mark.parametrize('room', [*ROOMS, ''])
def test_modules_are_in_plain_english(room):
    """Docstrings, messages and comments have none of the slips."""
    folder = PACKAGE / room
    paths = sorted(folder.rglob('*.py') if room else folder.glob('*.py'))
    found = [f'{path.relative_to(ROOT)}:{line}: {slip}' for path in paths
             for line, text in _texts(path) for slip in _slips(text)]
    assert not found, '\n'.join(found)


@pytest.mark.parametrize('page', PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_pages_are_in_plain_english(page):
    """Pages have none of the slips, except the section that lists them and the licence itself."""
    text = re.sub(r'^~~~$.*?^~~~$', '', page.read_text('utf-8'), flags=re.DOTALL | re.MULTILINE)
    if page.name == 'STYLE.md':
        text = re.sub(r'## Plain English.*?(?=^## )', '', text, flags=re.DOTALL | re.MULTILINE)
    assert not (found := list(_slips(' '.join(text.split())))), '\n'.join(found)
