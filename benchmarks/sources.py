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

"""
Measure the sources: code lines, files, branches, names that say nothing, modules loaded.

    python benchmarks/sources.py
    python benchmarks/sources.py --root ../other_checkout

Code lines are those without blank lines, comments, imports and docstrings. A name says nothing if
it is one of `EMPTY_NAMES`; each place that binds it counts: a local, a parameter, an attribute.
"""

from __future__ import annotations

import argparse
import ast
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
import subprocess
import sys
from typing import Iterator

EMPTY_NAMES = frozenset((
    'found', 'one', 'some', 'own', 'told', 'given', 'said', 'known', 'made', 'each', 'taken',
    'kept', 'wanted', 'other', 'here', 'there'))
_BRANCHES = (ast.If, ast.For, ast.While, ast.IfExp, ast.ExceptHandler, ast.comprehension,
             ast.BoolOp, ast.Assert)
_DOCUMENTED = (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef, ast.Module)
_COMMANDS = ('analyze', 'info')


@dataclass(frozen=True, slots=True)
class Sources:
    """
    The figures of a package.

    Attributes
    ----------
    above_10, above_20
        Functions with more than 10 and 20 branches.
    names
        Places that bind a name that says nothing, by name.

    """

    files: int
    code_lines: int
    above_10: int
    above_20: int
    names: Counter[str]

    @property
    def names_per_1000(self) -> float:
        """Return the names that say nothing in 1000 code lines."""
        return 1000.0 * self.names.total() / self.code_lines


def measure(package: Path) -> Sources:
    """Measure all modules of a package."""
    files = code_lines = above_10 = above_20 = 0
    names: Counter[str] = Counter()
    for path in sorted(package.rglob('*.py')):
        text = path.read_text('utf-8')
        tree = ast.parse(text)
        files += 1
        code_lines += _count_code_lines(text, tree)
        branches = [_count_branches(node) for node in ast.walk(tree)
                    if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef))]
        above_10 += sum(count > 10 for count in branches)
        above_20 += sum(count > 20 for count in branches)
        names.update(_bind(tree))
    return Sources(files, code_lines, above_10, above_20, names)


def _count_code_lines(text: str, tree: ast.Module) -> int:
    left_out: set[int] = set()
    for node in ast.walk(tree):
        if isinstance(node, (ast.Import, ast.ImportFrom)):
            left_out |= {*range(node.lineno, (node.end_lineno or 0) + 1)}
        elif isinstance(node, _DOCUMENTED) and ast.get_docstring(node, clean=False) is not None:
            docstring = node.body[0]
            left_out |= {*range(docstring.lineno, (docstring.end_lineno or 0) + 1)}
    return sum(bool(line.strip()) and not line.strip().startswith('#')
               for number, line in enumerate(text.splitlines(), 1) if number not in left_out)


def _count_branches(function: ast.AST) -> int:
    branches = [node for node in ast.walk(function) if isinstance(node, _BRANCHES)]
    return 1 + len(branches) + sum(len(node.values) - 2 for node in branches
                                   if isinstance(node, ast.BoolOp))


def _bind(tree: ast.Module) -> Iterator[str]:
    """Yield each name that says nothing where it is bound."""
    for node in ast.walk(tree):
        name = (node.arg if isinstance(node, ast.arg) else
                node.id if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store) else
                node.attr if isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store)
                else '')
        if name.strip('_') in EMPTY_NAMES:
            yield name.strip('_')


def count_modules(root: Path, command: str) -> int:
    """Return the modules of the package that a command loads before it does anything."""
    code = ('import sys\n'
            'from heading_intercompare.cli.program import main\n'
            f'main([{command!r}, "no_such_input"])\n'
            'print(sum(name.startswith("heading_intercompare") for name in sys.modules))')
    done = subprocess.run([sys.executable, '-c', code], cwd=root, capture_output=True, text=True,
                          check=True)
    return int(done.stdout.split()[-1])


def main(arguments: list[str]) -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument('--root', type=Path, default=Path(__file__).resolve().parents[1],
                        help='checkout to measure (default: this one)')
    root = parser.parse_args(arguments).root
    sources = measure(root / 'heading_intercompare')
    rows = {'files': sources.files, 'code lines': sources.code_lines,
            'functions above 10 branches': sources.above_10,
            'functions above 20 branches': sources.above_20,
            'names that say nothing, in 1000 code lines': f'{sources.names_per_1000:.1f}',
            **{f'modules that `{name}` loads': count_modules(root, name) for name in _COMMANDS}}
    for words, figure in rows.items():
        print(f'| {words} | {figure} |')
    return 0


if __name__ == '__main__':
    sys.exit(main(sys.argv[1:]))
