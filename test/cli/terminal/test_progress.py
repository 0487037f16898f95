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

"""Progress is one line of the terminal, whatever its width."""

from __future__ import annotations

import fcntl
import os
import pty
import re
import select
import struct
import sys
import termios
import threading
import time
from types import SimpleNamespace

from deadlines import DEADLINE_S
import pytest

from heading_intercompare.cli.terminal import progress

#: A character that no progress writes.
_MARK = '\x1e'


class Terminal:
    """A terminal to write to."""

    def __init__(self):
        self.now_s = 0.0
        self.side, program = pty.openpty()
        os.set_blocking(self.side, False)
        self.stderr = os.fdopen(program, 'w')

    def widen(self, columns):
        """Change the width, a second later."""
        self.now_s += 1.0
        fcntl.ioctl(self.stderr, termios.TIOCSWINSZ, struct.pack('4H', 24, columns, 0, 0))

    def seen(self):
        """Return the text written since the last call; the system may hand it over later."""
        self.stderr.write(_MARK)
        self.stderr.flush()
        found, deadline_s = '', time.monotonic() + DEADLINE_S
        while not found.endswith(_MARK):
            assert time.monotonic() < deadline_s
            if select.select([self.side], [], [], 0.1)[0]:
                found += os.read(self.side, 65536).decode()
        return found.removesuffix(_MARK)


@pytest.fixture
def terminal(monkeypatch, request):
    """Return a terminal with a clock of its own, without rich unless the test asks for it."""
    if getattr(request, 'param', 'plain') == 'rich':
        pytest.importorskip('rich')
        for name in ('NO_COLOR', 'FORCE_COLOR', 'COLORTERM', 'COLUMNS'):
            monkeypatch.delenv(name, raising=False)
        monkeypatch.setenv('TERM', 'xterm-256color')
    else:
        monkeypatch.setitem(sys.modules, 'rich.console', None)
    made = Terminal()
    monkeypatch.setattr(progress, 'time', SimpleNamespace(monotonic=lambda: made.now_s))
    yield made
    made.stderr.close()
    os.close(made.side)


def test_the_line_does_not_wrap_when_the_width_changes(terminal, monkeypatch):
    monkeypatch.setattr(sys, 'stderr', terminal.stderr)
    with progress.Progress('trial') as line:
        for columns in (120, 40, 60):
            terminal.widen(columns)
            line.show('x' * 200)
            assert terminal.seen() == 'trial: '.ljust(columns - 1, 'x') + '\r'
            line.show('y')
            assert terminal.seen() == 'trial: y'.ljust(columns - 1) + '\r'
            line.show('x' * 200)
            terminal.seen()


def test_a_terminal_that_does_not_tell_its_width_has_the_usual(terminal, monkeypatch):
    monkeypatch.setattr(sys, 'stderr', terminal.stderr)
    terminal.widen(0)
    progress.Progress('trial').show('x' * 200)
    assert terminal.seen() == 'trial: '.ljust(79, 'x') + '\r'


rich_terminal = pytest.mark.parametrize('terminal', ['rich'], indirect=True)


def lines(text):
    """Return the successive lines, without colours and commands."""
    plain = re.sub('\x1b\\[[?0-9;]*[A-Za-z]', '', text)
    return [line for line in re.split('[\r\n]+', plain) if line]


def draw(terminal, line, text, seconds=1.0):
    """Return the line that a text gives some time after the one before."""
    terminal.now_s += seconds
    line.show(text)
    return lines(terminal.seen())[-1]


@rich_terminal
def test_with_rich_the_line_stays_one_and_fits_any_width(terminal, monkeypatch):
    monkeypatch.setattr(sys, 'stderr', terminal.stderr)
    with progress.Progress('trial') as line:
        for columns in (120, 40, 9, 60):
            terminal.widen(columns)
            for text in ('x' * 200, '43% copied', 'y'):
                line.show(text)
                written = terminal.seen()
                assert len(lines(written)[0]) == columns - 1 and '\n' not in written
    assert terminal.seen().endswith('\x1b[2K')


@rich_terminal
def test_with_rich_time_and_a_bar_are_shown_where_the_amount_is_known(terminal, monkeypatch):
    monkeypatch.setattr(sys, 'stderr', terminal.stderr)
    terminal.widen(100)
    with progress.Progress('trial') as line:
        assert draw(terminal, line, '17 pairs').endswith('0:00:01')
        assert draw(terminal, line, '25% looked at').count('\u2501') == 23
        shown = draw(terminal, line, '50% looked at')
        assert 'trial: 50% looked at' in shown and ' 0:00:03 ' in shown
        assert shown.endswith(' 00:02') and shown.index('\u257a') - shown.index('\u2501') == 12
        # A second part of the work begins again at zero.
        assert draw(terminal, line, '0% copied').endswith('-:--')
        draw(terminal, line, '10% copied')
        assert draw(terminal, line, '20% copied').endswith(' 00:08')


@rich_terminal
def test_with_rich_foreign_words_are_no_markup_and_draw_no_thread(terminal, monkeypatch):
    monkeypatch.setattr(sys, 'stderr', terminal.stderr)
    before = threading.active_count()
    with progress.Progress('[red]bag[/]\x1b[2J') as line:
        line.show('[/] \n done')
        assert '[red]bag[/]\ufffd[2J: [/] \ufffd done' in lines(terminal.seen())[0]
        assert threading.active_count() == before


@rich_terminal
def test_a_line_that_stays_stands_above_the_one_that_is_overwritten(terminal, monkeypatch):
    monkeypatch.setattr(sys, 'stderr', terminal.stderr)
    with progress.Progress('trial') as line:
        line.show('17 pairs')
        line.tell('compliance: alarm raised: jump\x1b[2J')
        terminal.now_s += 1.0
        line.show('18 pairs')
    shown = ''
    while '18 pairs' not in shown:   # A terminal hands over what it has so far.
        shown += terminal.seen().replace('\r\n', '\n')
    assert 'compliance: alarm raised: jump\ufffd[2J\n' in shown
    assert shown.rindex('18 pairs') > shown.index('alarm')


def test_the_quiet_and_the_redirected_show_nothing(terminal, monkeypatch, tmp_path):
    monkeypatch.setattr(sys, 'stderr', terminal.stderr)
    with progress.Progress('trial', quiet=True) as line:
        line.show('x')
    with open(tmp_path / 'log', 'w') as log:
        monkeypatch.setattr(sys, 'stderr', log)
        with progress.Progress('trial') as line:
            line.show('x')
    assert (tmp_path / 'log').read_text() == ''
    assert terminal.seen() == ''


@rich_terminal
def test_the_time_left_of_a_replay_counts_no_pause(terminal, monkeypatch):
    monkeypatch.setattr(sys, 'stderr', terminal.stderr)
    terminal.widen(120)
    with progress.Progress('bag') as line:
        for _ in range(20):
            shown = draw(terminal, line, 'paused at 2.000 s of 10.000 s; space: pause, resume')
        assert shown.endswith('0:00:20')
        for at_s in (2, 4, 6):
            shown = draw(terminal, line, f'replaying at {at_s}.000 s of 8.000 s', 2.0)
        assert shown.endswith(' 00:02')


@rich_terminal
def test_in_a_narrow_terminal_the_words_give_way_to_the_time_left(terminal, monkeypatch):
    monkeypatch.setattr(sys, 'stderr', terminal.stderr)
    terminal.widen(80)
    with progress.Progress('bag') as line:
        draw(terminal, line, f'10% of {"x" * 100}')
        shown = draw(terminal, line, f'20% of {"x" * 100}')
        assert len(shown) == 79 and shown.endswith(' 00:08') and '…' in shown


@rich_terminal
def test_with_rich_the_cursor_stays_visible(terminal, monkeypatch):
    """A process that is killed leaves no terminal without one."""
    monkeypatch.setattr(sys, 'stderr', terminal.stderr)
    with progress.Progress('bag') as line:
        line.show('1% copied')
        assert terminal.seen().rpartition('\x1b[?25')[2].startswith('h')


def test_new_words_are_drawn_at_once_and_new_numbers_after_a_while(terminal, monkeypatch):
    monkeypatch.setattr(sys, 'stderr', terminal.stderr)
    monkeypatch.setattr(progress, 'time', SimpleNamespace(monotonic=lambda: 5.0))
    with progress.Progress('bag') as line:
        line.show('1 of 9 headings')
        assert lines(terminal.seen()) == ['bag: 1 of 9 headings']
        line.show('8 of 9 headings')
        line.show('judging the runs')
        assert lines(terminal.seen()) == ['bag: judging the runs']
