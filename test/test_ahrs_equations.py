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

"""The table of equations in docs/ahrs.md, the docstrings and the tests name each other."""

from __future__ import annotations

import ast
import importlib
from pathlib import Path
import re

import pytest

from heading_intercompare.ahrs.settings import Scenario
from heading_intercompare.core.declared_settings import list_settings

ROOT = Path(__file__).resolve().parent.parent
TEXT = (ROOT / 'docs' / 'ahrs.md').read_text(encoding='utf-8')
ROWS = re.findall(r'^\| \((\d+)\) \| ([PRC]) \| (.+) \| `([\w.]+)` \| (`.+`) \|$', TEXT,
                  re.MULTILINE)
NUMBER = re.compile(r'\((\d+)\)(?:-\((\d+)\))?')


def named_in(docstring):
    """Return the numbers that a docstring names as S (1), (2) or S (3)-(5)."""
    numbers = set()
    for match in re.finditer(r'\bS (\(\d+\)(?:(?:, |-)(?:S )?\(\d+\))*)', docstring):
        for first, last in NUMBER.findall(match.group(1).replace('S ', '')):
            numbers |= set(range(int(first), int(last or first) + 1))
    return numbers


def test_names_are_read_as_written():
    assert named_in('S (1), S (2), see S (5)-(7), then (9) and GK (11)') == {1, 2, 5, 6, 7}


def test_every_equation_has_one_row():
    assert [int(row[0]) for row in ROWS] == list(range(1, 23))


def module_of(name):
    """Return a module of the simulator, in whichever room it is."""
    (path,) = (ROOT / 'heading_intercompare' / 'ahrs').rglob(f'{name}.py')
    return importlib.import_module('.'.join(path.relative_to(ROOT).with_suffix('').parts))


@pytest.mark.parametrize('number, origin, form, function, tests', ROWS,
                         ids=[row[0] for row in ROWS])
def test_function_of_the_row_names_the_equation(number, origin, form, function, tests):
    module, *names = function.split('.')
    found = module_of(module)
    for name in names:
        found = getattr(found, name)
    assert int(number) in named_in(found.__doc__), f'{function} does not name S ({number})'
    assert form


@pytest.mark.parametrize('number, origin, form, function, tests', ROWS,
                         ids=[row[0] for row in ROWS])
def test_tests_of_the_row_exist_and_are_of_the_simulator(number, origin, form, function, tests):
    assert re.fullmatch('`[^`]+`(, `[^`]+`)*', tests), tests
    for test in re.findall('`([^`]+)`', tests):
        path, _, name = test.partition('::')
        tree = ast.parse((ROOT / path).read_text(encoding='utf-8'))
        assert name.startswith('test_')
        assert name in {n.name for n in tree.body if isinstance(n, ast.FunctionDef)}, test
        imported = {n.module for n in ast.walk(tree) if isinstance(n, ast.ImportFrom) and n.module}
        assert any(m.startswith('heading_intercompare.ahrs.') for m in imported), test


@pytest.mark.parametrize('function', sorted(
    set(re.findall(r'`(\w+\.\w+(?:\.\w+)?)`', TEXT))
    - {rule.name for rule in list_settings(Scenario)}))
def test_whatever_the_page_names_exists(function):
    module, *names = function.split('.')
    found = module_of(module)
    for name in names:
        found = getattr(found, name)


def test_no_docstring_names_an_equation_that_is_not_there():
    for path in sorted((ROOT / 'heading_intercompare' / 'ahrs').rglob('*.py')):
        for node in ast.walk(ast.parse(path.read_text(encoding='utf-8'))):
            if isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef)):
                named = named_in(ast.get_docstring(node) or '')
                assert named <= set(range(1, 23)), f'{path.name}: {named}'
