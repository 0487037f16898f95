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

"""The tables of docs/equations.md, the docstrings and the tests name each other."""

from __future__ import annotations

import ast
import importlib
from pathlib import Path
import re

import pytest

ROOT = Path(__file__).resolve().parent.parent
TEXT = (ROOT / 'docs' / 'equations.md').read_text(encoding='utf-8')
ROW = re.compile(r'^\| (GK \(\S+\)|[SKE]\.\d+) \| (.+?) \| (.+?) \| (.+?) \|$', re.MULTILINE)
ROWS = [(number.replace('\\', ''), *rest) for number, *rest in ROW.findall(TEXT)]
USED = [row for row in ROWS if row[2] != 'not used']
UNUSED = [row for row in ROWS if row[2] == 'not used']

PRINTED = ['1', '2', '2a', '2b', '2c', '2d', '3', '4', '5', "5'", "5''", '*', '**', '6', "6'",
           "6''", '7']
NUMBERS = [*(f'GK ({n})' for n in PRINTED), 'K.1', 'K.2', *(f'S.{n}' for n in range(1, 20)),
           *(f'E.{n}' for n in range(1, 30))]

ONE = r"\((?:\d+[a-z]?'*|\*+)\)"
CHAIN = re.compile(rf'\bGK ({ONE}(?:(?:, and |, | and | to |-)(?:GK )?{ONE})*)')
LINK = re.compile(rf'({ONE})(?:(?:-| to )(?:GK )?({ONE}))?')
OWN = re.compile(r'\b([SKE])\.(\d+)(?: to \1\.(\d+))?')


def named_in(text):
    """Return the numbers named as GK (5), (5'), GK (4)-(7), S.4 or S.8 to S.10."""
    text, found = ' '.join((text or '').split()), set()
    for chain in CHAIN.findall(text):
        for first, last in LINK.findall(chain):
            ends = [n[1:-1] for n in (first, last or first)]
            if set(ends) <= set(PRINTED):
                lo, hi = (PRINTED.index(n) for n in ends)
                ends = PRINTED[lo:hi + 1]
            found |= {f'GK ({n})' for n in ends}
    for letter, first, last in OWN.findall(text):
        found |= {f'{letter}.{n}' for n in range(int(first), int(last or first) + 1)}
    return found


def quoted(cell):
    """Return the names in backquotes in a cell, which must contain nothing else but commas."""
    assert re.fullmatch(r'`[^`]+`(, `[^`]+`)*', cell), cell
    return re.findall(r'`([^`]+)`', cell)


def parsed(path):
    return ast.parse(path.read_text(encoding='utf-8'))


def docstrings():
    """Yield the place and the text of every docstring of the package."""
    for path in sorted((ROOT / 'heading_intercompare').rglob('*.py')):
        for node in ast.walk(parsed(path)):
            if isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef)):
                where = f'{path.relative_to(ROOT)}: {getattr(node, "name", "module")}'
                yield where, ast.get_docstring(node) or ''


@pytest.mark.parametrize('text, numbers', [
    ("GK (5), GK (5'), (5''): a ratio", {'GK (5)', "GK (5')", "GK (5'')"}),
    ('of GK (*) and\n    (**). S (12), (6)', {'GK (*)', 'GK (**)'}),
    ('GK (2)-(2d) for', {'GK (2)', 'GK (2a)', 'GK (2b)', 'GK (2c)', 'GK (2d)'}),
    ('GK (6)-(7)', {'GK (6)', "GK (6')", "GK (6'')", 'GK (7)'}),
    ('GK (9)', {'GK (9)'}),
    ('S.8 to S.10 of a page; E.3, K.1.', {'S.8', 'S.9', 'S.10', 'E.3', 'K.1'}),
    ('GK, e.g. variant C. E.', set()),
    (None, set())])
def test_numbers_are_read_as_they_are_written(text, numbers):
    assert named_in(text) == numbers


def test_every_number_has_exactly_one_row():
    assert [row[0] for row in ROWS] == NUMBERS


def test_every_line_of_the_tables_is_a_row_that_was_read():
    lines = [line for line in TEXT.splitlines() if line.startswith('|')]
    heads = [line for line in lines if line.startswith(('| number |', '|---|'))]
    assert len(lines) - len(heads) == len(ROWS)


def module_of(name):
    """Return the full name of a module of core, in whichever room it is."""
    (path,) = (ROOT / 'heading_intercompare' / 'core').rglob(f'{name}.py')
    return '.'.join(path.relative_to(ROOT).with_suffix('').parts)


@pytest.mark.parametrize('number, formula, functions, tests', USED, ids=[row[0] for row in USED])
def test_the_functions_of_a_row_name_its_number(number, formula, functions, tests):
    for function in quoted(functions):
        module, *names = function.split('.')
        found = importlib.import_module(module_of(module))
        assert names
        for name in names:
            found = getattr(found, name)
        assert number in named_in(found.__doc__), f'{function} does not name {number}'


@pytest.mark.slow
@pytest.mark.parametrize('number, formula, functions, tests', USED, ids=[row[0] for row in USED])
def test_the_tests_of_a_row_exist_and_import_what_they_test(number, formula, functions, tests):
    modules = {module_of(f.partition('.')[0]) for f in quoted(functions)}
    for test in quoted(tests):
        path, _, name = test.partition('::')
        tree = parsed(ROOT / path)
        assert name.startswith('test_')
        assert name in {n.name for n in tree.body if isinstance(n, ast.FunctionDef)}, test
        imported = {n.module for n in ast.walk(tree) if isinstance(n, ast.ImportFrom)}
        assert imported & modules, f'{path} imports none of {sorted(modules)}'


@pytest.mark.slow
@pytest.mark.parametrize('number, formula, functions, why', UNUSED, ids=[r[0] for r in UNUSED])
def test_a_number_that_is_not_used_says_why_and_is_named_nowhere(number, formula, functions, why):
    assert '`' not in why and why.endswith('.')
    assert not [where for where, text in docstrings() if number in named_in(text)]


@pytest.mark.slow
def test_no_docstring_names_a_number_without_a_row():
    wrong = {where: named_in(text) - set(NUMBERS) for where, text in docstrings()}
    assert {where: numbers for where, numbers in wrong.items() if numbers} == {}


@pytest.mark.parametrize('page', sorted(p.name for p in (ROOT / 'docs').glob('*.md')))
def test_no_page_names_a_number_without_a_row(page):
    text = (ROOT / 'docs' / page).read_text(encoding='utf-8').replace('\\', '')
    assert named_in(text) <= set(NUMBERS)
