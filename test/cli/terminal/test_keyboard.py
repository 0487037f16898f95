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

"""Keys of a terminal, and the terminal afterwards."""

from __future__ import annotations

import io
import os
import pty
import termios

import pytest

from heading_intercompare.cli.terminal.keyboard import Keyboard


@pytest.fixture
def terminal():
    """Return the side of a person and the side of the program, as file and as descriptor."""
    person, program = pty.openpty()
    with os.fdopen(program, 'r') as stream:
        yield person, stream, program
    os.close(person)


def pressed(keyboard, n):
    """Return n keys; they take a moment through the terminal."""
    keys = ''
    while len(keys) < n:
        keys += keyboard.keys()
    return keys


def test_keys_come_at_once_in_their_order_and_are_not_shown(terminal):
    person, stream, program = terminal
    with Keyboard(stream) as keyboard:
        assert keyboard.on and keyboard.keys() == ''
        assert not termios.tcgetattr(program)[3] & (termios.ECHO | termios.ICANON)
        os.write(person, b' x ')
        assert pressed(keyboard, 3) == ' x '
        assert keyboard.keys() == ''


def test_ctrl_c_stays_what_it_is(terminal):
    _, stream, program = terminal
    with Keyboard(stream) as keyboard:
        keyboard.keys()
        assert termios.tcgetattr(program)[3] & termios.ISIG


@pytest.mark.parametrize('error', [None, ValueError, KeyboardInterrupt, SystemExit])
def test_the_terminal_is_as_it_was_however_it_ends(terminal, error):
    _, stream, program = terminal
    before = termios.tcgetattr(program)
    try:
        with Keyboard(stream) as keyboard:
            keyboard.keys()
            assert termios.tcgetattr(program) != before
            if error is not None:
                raise error
    except (ValueError, KeyboardInterrupt, SystemExit) as raised:
        assert type(raised) is error
    assert termios.tcgetattr(program) == before


def test_after_a_shell_has_set_its_own_modes_keys_come_at_once_again(terminal):
    person, stream, program = terminal
    before = termios.tcgetattr(program)
    with Keyboard(stream) as keyboard:
        keyboard.keys()
        termios.tcsetattr(program, termios.TCSANOW, before)
        keyboard.keys()
        os.write(person, b' ')
        assert pressed(keyboard, 1) == ' '
    assert termios.tcgetattr(program) == before


def test_in_the_background_the_terminal_is_not_touched(terminal, monkeypatch):
    person, stream, program = terminal
    before = termios.tcgetattr(program)
    monkeypatch.setattr(os, 'tcgetpgrp', lambda fd: os.getpgrp() + 1)
    with Keyboard(stream) as keyboard:
        os.write(person, b' ')
        assert keyboard.keys() == ''
        assert termios.tcgetattr(program) == before


def test_a_terminal_that_goes_away_is_the_end_of_the_keys():
    person, program = pty.openpty()
    with os.fdopen(program, 'r') as stream, Keyboard(stream) as keyboard:
        keyboard.keys()
        os.close(person)
        assert keyboard.keys() == '' and not keyboard.on
        assert keyboard.keys() == ''


def test_what_is_no_terminal_gives_no_keys(monkeypatch, tmp_path):
    file = tmp_path / 'file'
    file.write_text('   ')
    with open(file) as stream, Keyboard(stream) as keyboard:
        assert (keyboard.on, keyboard.keys()) == (False, '')
    with Keyboard(stream) as keyboard:
        assert (keyboard.on, keyboard.keys()) == (False, '')
    for none in (None, io.StringIO('   ')):
        monkeypatch.setattr('sys.stdin', none)
        with Keyboard() as keyboard:
            assert (keyboard.on, keyboard.keys()) == (False, '')
