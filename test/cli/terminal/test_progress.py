# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Progress is one line of the terminal, whatever its width."""

from __future__ import annotations

import fcntl
from itertools import count
import os
import pty
import struct
import sys
import termios
from types import SimpleNamespace

import pytest

from heading_intercompare.cli.terminal import progress


class Terminal:
    """A terminal to write to."""

    def __init__(self):
        self.side, program = pty.openpty()
        os.set_blocking(self.side, False)
        self.stderr = os.fdopen(program, 'w')

    def widen(self, columns):
        """Give it another width."""
        fcntl.ioctl(self.stderr, termios.TIOCSWINSZ, struct.pack('4H', 24, columns, 0, 0))

    def seen(self):
        """Return what has been written to it since the last call."""
        return os.read(self.side, 65536).decode()


@pytest.fixture
def terminal(monkeypatch):
    """Return a terminal, in a time that passes quickly."""
    made = Terminal()
    monkeypatch.setattr(progress, 'time', SimpleNamespace(monotonic=count().__next__))
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
