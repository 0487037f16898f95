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

"""A terminal highlights the outcome; elsewhere text stays plain, and no markup is obeyed."""

from __future__ import annotations

from contextlib import redirect_stdout, suppress
import io
import os
import pty
import re
import subprocess
import sys

import pytest

from heading_intercompare.cli import main
from heading_intercompare.cli.terminal.console import open_console, say, VERDICT_MARKS

ESCAPE = re.compile('\x1b\\[([0-9;]*)m')
TEXT = ('VERDICT: NON-COMPLIANT, DOUBTFUL: why\nGK as printed: COMPLIANT\n\n'
        'outcome  INDETERMINATE\n  warning: low')


class Terminal(io.StringIO):
    """A stream that says it is a terminal."""

    encoding = 'utf-8'

    def isatty(self):
        return True


@pytest.fixture
def terminal(monkeypatch):
    """Return a terminal, in an environment that allows colours."""
    for name in ('NO_COLOR', 'FORCE_COLOR', 'COLORTERM'):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv('TERM', 'xterm')
    return Terminal()


def said(terminal, *given):
    """Return the text that a terminal gets."""
    with redirect_stdout(terminal):
        say(*given)
    return terminal.getvalue()


def spans(text):
    """Return the words that stand out, each with its codes."""
    return [(codes, words) for codes, words in re.findall('\x1b\\[([0-9;]+)m(.*?)\x1b\\[0m', text,
                                                          re.DOTALL)]


def test_the_outcome_has_its_colour_and_the_text_is_the_same(terminal):
    pytest.importorskip('rich')
    shown = said(terminal, TEXT, VERDICT_MARKS)
    assert ESCAPE.sub('', shown) == f'{TEXT}\n'
    found = {words: codes for codes, words in spans(shown)}
    assert found['NON-COMPLIANT'] == '1;31' and found['COMPLIANT'] == '32'
    assert found['INDETERMINATE'] == '33' and found['DOUBTFUL'] == '1;33'
    assert found['VERDICT: '] == '1' and found['  warning:'] == '33'


@pytest.mark.parametrize('name, value', [('NO_COLOR', '1'), ('TERM', 'dumb')])
def test_a_user_who_wants_no_colour_gets_plain_text(terminal, monkeypatch, name, value):
    monkeypatch.setenv(name, value)
    assert said(terminal, TEXT, VERDICT_MARKS) == f'{TEXT}\n'


def test_an_empty_no_color_asks_for_nothing(terminal, monkeypatch):
    pytest.importorskip('rich')
    monkeypatch.setenv('NO_COLOR', '')
    assert '\x1b' in said(terminal, TEXT, VERDICT_MARKS)


def test_a_pipe_gets_plain_text_even_if_colours_are_forced(terminal, monkeypatch):
    monkeypatch.setenv('FORCE_COLOR', '1')
    assert said(io.StringIO(), f'{TEXT} \x1b[1m', VERDICT_MARKS) == f'{TEXT} \\u001b[1m\n'


def test_without_rich_a_terminal_gets_plain_text(terminal, monkeypatch):
    monkeypatch.setitem(sys.modules, 'rich.console', None)
    assert open_console(terminal) is None
    assert said(terminal, TEXT, VERDICT_MARKS) == f'{TEXT}\n'


@pytest.mark.parametrize('name', ['[bold red]x[/]', '[link=http://x]y[/link]', ':smile:', '[/]',
                                  '\\[', 'x' * 300, 'https://x.y/z 12 0x3f "quoted"'])
def test_foreign_words_are_no_markup_and_no_line_is_broken(terminal, name):
    pytest.importorskip('rich')
    assert said(terminal, f'topic {name}\nend') == f'topic {name}\nend\n'


def test_foreign_words_do_not_move_the_cursor(terminal):
    pytest.importorskip('rich')
    assert said(terminal, 'a\x1b[2Jb\x07\rc\x9bd') == 'a\\u001b[2Jb\\u0007\\u000dc\\u009bd\n'


def on_terminal(*arguments, **variables):
    """Return what a command prints on a terminal, and what it prints into a pipe."""
    command = [sys.executable, '-m', 'heading_intercompare', *arguments]
    environment = {name: value for name, value in os.environ.items()
                   if name not in ('NO_COLOR', 'FORCE_COLOR', 'COLORTERM')}
    environment |= {'TERM': 'xterm', 'PYTHONPATH': os.pathsep.join(sys.path), **variables}
    side, program = pty.openpty()
    with subprocess.Popen(command, env=environment, stdin=subprocess.DEVNULL, stdout=program,
                          stderr=subprocess.PIPE) as process:
        os.close(program)
        shown = b''
        with suppress(OSError):  # The end of a terminal is an error.
            while piece := os.read(side, 65536):
                shown += piece
        process.wait(120)
    os.close(side)
    piped = subprocess.run(command, env=environment, stdin=subprocess.DEVNULL, text=True,
                           stdout=subprocess.PIPE, timeout=120, check=True).stdout
    return shown.decode().replace('\r\n', '\n'), piped


@pytest.fixture
def inputs(tmp_path):
    """Return a csv of pairs, a verdict in JSON and a bag."""
    rows = [f'{1_400_000_000 + i},{100.0 + 0.1 * (i % 3)},100.0' for i in range(400)]
    (tmp_path / 'p.csv').write_text('\n'.join(['stamp_s,ts_deg,rs_deg', *rows]) + '\n')
    (tmp_path / 's.yaml').write_text('duration_s: 20.0\n')
    norms = ['--set', 'norms.sigma_max_deg=0.3', '--set', 'norms.sigma_ref_max_deg=0.1']
    assert main(['analyze', str(tmp_path / 'p.csv'), *norms, '--json',
                 str(tmp_path / 'v.json')]) == 0
    assert main(['simulate', '--scenario', str(tmp_path / 's.yaml'), '-o', str(tmp_path / 'bag'),
                 *norms]) == 0
    return {'csv': [str(tmp_path / 'p.csv'), *norms], 'bag': str(tmp_path / 'bag'),
            'json': [str(tmp_path / 'v.json'), '-o', str(tmp_path / 'again.json')]}


@pytest.mark.process
def test_commands_show_on_a_terminal_the_text_that_a_pipe_gets(inputs):
    pytest.importorskip('rich')
    for arguments, marked in (
            (['norms'], '[unverified]'), (['analyze', *inputs['csv'], '--quiet'], 'VERDICT: '),
            (['report', *inputs['json']], 'VERDICT: '), (['info', inputs['bag']], 'bag: '),
            (['rejudge', inputs['bag'], '--quiet'], 'INDETERMINATE')):
        shown, piped = on_terminal(*arguments)
        assert ESCAPE.sub('', shown) == piped, arguments
        assert marked in [words for _, words in spans(shown)], arguments
        assert '\x1b' not in piped
    shown, piped = on_terminal('norms', NO_COLOR='1')
    assert shown == piped
