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

"""Write the reference pages of the site: one per room, the names at the top, the commands."""

from __future__ import annotations

import ast
from contextlib import redirect_stdout, suppress
import io
import os
from pathlib import Path
from typing import Iterator
from unittest.mock import patch

import heading_intercompare
from heading_intercompare.cli import program

PACKAGE = Path(heading_intercompare.__file__).resolve().parent
FOLDERS = ('core', 'drivers', 'ahrs', 'messages', 'bags', 'journal', 'report', 'logbook', 'app',
           'nodes', 'cli')
"""The folders of the package, in the order in which they build on each other."""
#: Width of the terminal for which the help of the commands is laid out.
_COLUMNS = '96'


def _summarize(path: Path) -> str:
    """Return the first paragraph of a module's docstring on one line."""
    text = ast.get_docstring(ast.parse(path.read_text('utf-8'))) or ''
    return ' '.join(text.partition('\n\n')[0].split())


def _describe_room(room: Path) -> str:
    """Return the page of a room: its purpose, then each of its modules."""
    title = '.'.join(room.relative_to(PACKAGE).parts)
    lines = [title, '=' * len(title), '', _summarize(room / '__init__.py'), '']
    for module in sorted(room.glob('*.py')):
        if module.stem != '__init__':
            lines += [module.stem, '-' * len(module.stem), '',
                      f'.. automodule:: heading_intercompare.{title}.{module.stem}',
                      '   :members:', '']
    return '\n'.join(lines)


def _describe_rooms() -> Iterator[tuple[str, str]]:
    """Yield the names and pages of all rooms, and of their index."""
    names = []
    for folder in FOLDERS:
        for init in sorted((PACKAGE / folder).rglob('__init__.py')):
            names.append('.'.join(init.parent.relative_to(PACKAGE).parts))
            yield f'api/{names[-1]}.rst', _describe_room(init.parent)
    listed = '\n'.join(f'   {name}' for name in names)
    yield 'api/index.rst', (
        'Every module\n============\n\nThe rooms of the package, in the order in which they '
        f'build on each other.\n\n.. toctree::\n   :maxdepth: 1\n\n{listed}\n')


def _describe_door() -> str:
    """Return entries for the names that the package offers at its top."""
    lines = []
    for name in sorted(set(heading_intercompare.__all__) - {'__version__'}, key=str.lower):
        offered = getattr(heading_intercompare, name)
        kind = 'autoclass' if isinstance(offered, type) else 'autofunction'
        lines += [f'.. {kind}:: {offered.__module__}.{offered.__qualname__}', '   :no-index:']
        lines += ['   :members:', ''] if kind == 'autoclass' else ['']
    return '\n'.join(lines)


def _describe_commands() -> str:
    """Return the page of the command line: the help of every command."""
    text = ['# Commands', '', 'The output of `heading-intercompare COMMAND --help`. Exit codes: '
            '0 done, 2 a mistake in the input or the options, 70 a fault of the program;',
            'with `--check` see [use verdicts in scripts](../howto/use_verdicts.md).', '',
            '| command | does |', '|---|---|',
            *(f'| [`{name}`](#{name}) | {summary} |'
              for name, (_, summary, _) in program.COMMANDS.items()), '']
    for name in program.COMMANDS:
        shown = io.StringIO()
        with (patch.dict(os.environ, COLUMNS=_COLUMNS, NO_COLOR='1'), redirect_stdout(shown),
              suppress(SystemExit)):
            program.main([name, '--help'])
        text += [f'## {name}', '', '```text', shown.getvalue().rstrip(), '```', '']
    return '\n'.join(text)


def write_pages(into: Path) -> list[Path]:
    """
    Write the pages; an unchanged page keeps its modification time.

    Parameters
    ----------
    into
        The folder ``reference`` of the site. Pages of removed rooms are deleted.

    Returns
    -------
    list of Path
        All pages.

    """
    pages = {into / name: text for name, text in (
        *_describe_rooms(), ('api/door.inc', _describe_door()),
        ('commands.md', _describe_commands()))}
    (into / 'api').mkdir(parents=True, exist_ok=True)
    for path in (into / 'api').iterdir():
        if path not in pages:
            path.unlink()
    for path, text in pages.items():
        if not path.is_file() or path.read_text('utf-8') != text:
            path.write_text(text, 'utf-8')
    return list(pages)
