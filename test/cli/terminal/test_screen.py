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

"""Lines at the foot of a terminal: drawn again in place, below what others print."""

from __future__ import annotations

import fcntl
import os
import pty
import re
import struct
import subprocess
import sys
import termios

import pytest

pytestmark = pytest.mark.process
pytest.importorskip('rich')

ROWS, COLUMNS = 24, 80
_PIECE = re.compile(r'\x1b\[([?\d;]*)([A-Za-z])|([\r\n])|([^\x1b\r\n]+)')


def emulate(text):
    """Return the lines that a terminal shows, also those that scrolled off."""
    lines, row, column = [''], 0, 0
    for number, command, move, letters in _PIECE.findall(text):
        if command == 'A':
            row = max(0, row - int(number or 1))
        elif command == 'K':
            lines[row] = lines[row][:column]
        elif command == 'J' and number != '2':
            lines[row] = lines[row][:column]
            del lines[row + 1:]
        elif move == '\r':
            column = 0
        elif move == '\n':
            row += 1
            lines += [''] * (row + 1 - len(lines))
        elif letters:
            line = lines[row].ljust(column)
            lines[row] = line[:column] + letters + line[column + len(letters):]
            column += len(letters)
        else:
            assert command in 'mhlJH', command
    return lines


def run(code, **environment):
    """Run code on a terminal; return what it wrote and whether the modes are as before."""
    ours, theirs = pty.openpty()
    fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack('HHHH', ROWS, COLUMNS, 0, 0))
    before = termios.tcgetattr(theirs)
    kept = {name: value for name, value in os.environ.items()
            if name not in ('NO_COLOR', 'FORCE_COLOR')}
    process = subprocess.Popen([sys.executable, '-c', code], stdin=theirs, stdout=theirs,
                               stderr=theirs,
                               env={**kept, 'TERM': 'xterm', **environment})
    written = b''
    while process.poll() is None:
        written += read(ours)
    written += read(ours)
    after = termios.tcgetattr(theirs)
    os.close(theirs)
    os.close(ours)
    return written.decode(), process.returncode, before == after


def read(terminal):
    """Return what is there."""
    os.set_blocking(terminal, False)
    try:
        return os.read(terminal, 65536)
    except BlockingIOError:
        return b''


VIEW = """
import os, sys
from heading_intercompare.cli.terminal.live_view import LiveView
from heading_intercompare.web.bridge.bridge_view import BridgeView
def show(view, n):
    for i in range(n):
        view.show(BridgeView(difference_deg=0.01 * i), 'starting' if i < 2 else '')
"""
LOG = "os.write(2, b'[{0}] [1700000000.5] [recorder]: {1}\\n')"


def test_a_view_is_drawn_in_place_and_warnings_stand_above_it():
    written, code, restored = run(f"""{VIEW}
print('before')
with LiveView('live: trial', 'Ctrl-C ends the trial') as view:
    show(view, 3)
    {LOG.format('WARN', 'disk is slow')}
    {LOG.format('INFO', 'goes on')}
    print('page: http://127.0.0.1:1/')
    view.tell('alarm raised')
    import time
    deadline = time.monotonic() + 120.0
    while len(view._screen._tap.lines) < 4 and time.monotonic() < deadline:
        pass
    show(view, 4)
    os.write(2, b'SHOWN')
    os._exit(7)
""")
    lines = emulate(written)
    assert code == 7 and lines[0] == 'before'
    assert sorted(lines[1:4]) == ['22:13:20 WARN recorder: disk is slow', 'alarm raised',
                                  'page: http://127.0.0.1:1/']
    # One view, whatever was drawn before.
    assert lines[4] == 'live: trial' and lines[-1].strip() == 'Ctrl-C ends the trial'
    assert sum('TS - RS' in line for line in lines) == 1 and '+0.03°' in '\n'.join(lines)
    assert 'goes on' not in written and 'starting' not in '\n'.join(lines)
    assert all(len(line) < COLUMNS for line in lines) and len(lines) - 4 < ROWS


@pytest.mark.parametrize('end', ['raise KeyboardInterrupt', 'raise SystemExit(3)',
                                 "raise ValueError('it broke')"])
def test_the_terminal_is_as_before_however_the_view_ends(end):
    written, _, restored = run(f"""{VIEW}
with LiveView('live: trial') as view:
    show(view, 3)
    {LOG.format('ERROR', 'last words')}
    {end}
""")
    lines = emulate(written)
    assert restored and lines[0] == '22:13:20 ERROR recorder: last words'
    assert 'live: trial' not in lines
    if 'broke' in end:
        assert 'ValueError: it broke' in lines[-2]


def test_no_colour_where_none_is_wanted_and_text_on_a_dumb_terminal():
    code = f"""{VIEW}
from heading_intercompare.web.bridge.bridge_records import Tone, ValidityView
with LiveView('live: trial') as view:
    view.show(BridgeView(validity=ValidityView('bad', Tone.BAD)))
"""
    coloured, _, _ = run(code)
    plain, _, _ = run(code, NO_COLOR='1')
    dumb, _, _ = run(code, TERM='dumb')
    assert '\x1b[31m' in coloured and 'live: trial' in coloured
    assert '\x1b[31m' not in plain and 'live: trial' in plain
    assert '\x1b' not in dumb and dumb.endswith('neither TS nor RS heard yet; bad\r\n')


def test_a_view_without_rich_is_text():
    written, _, _ = run(f"""import sys; sys.modules['rich'] = sys.modules['rich.console'] = None
{VIEW}
with LiveView('live: trial') as view:
    show(view, 9)
""")
    assert '\x1b' not in written
    first, = written.splitlines()
    assert first.endswith('starting; neither TS nor RS heard yet; not known: nothing is heard')
