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

"""A running graph on standard error: lines that are drawn again on a terminal, text elsewhere."""

from __future__ import annotations

from collections import deque
from contextlib import ExitStack, suppress
from datetime import datetime, timezone
import os
import re
import sys
import threading
import time
from typing import Sequence

from heading_intercompare.web.bridge.bridge_view import BridgeView

from .console import open_console
from .keyboard import Keyboard
from .status_lines import StatusLines
from .view_lines import LABEL, lay_out, Line, one_line

#: A line that rclpy logs: its level, time, logger and text.
_LOGGED = re.compile(r'\[(DEBUG|INFO|WARN|ERROR|FATAL)\] \[(\d+)[.\d]*\] \[(.*?)\]: (.*)')
_NUMBER = re.compile(r'\d[\d.,:]*')
_STYLES = {'WARN': 'yellow', 'ERROR': 'red', 'FATAL': 'red'}
_TONES = {'good': 'green', 'doubt': 'yellow', 'bad': 'red'}
#: Lines that wait to be printed; more would only scroll by.
_MOST = 500
_TO_THE_END, _BELOW = '\x1b[K', '\x1b[J'
# A terminal that knows this shows all of a drawing at once; others ignore it.
_BEGIN, _END = '\x1b[?2026h', '\x1b[?2026l'


class _Tap:
    """Takes what is printed on standard output and error, from any library, line by line."""

    def __init__(self, numbers: Sequence[int]) -> None:
        self.lines: deque[str] = deque(maxlen=_MOST)
        read, write = os.pipe()
        self._saved = [(number, os.dup(number)) for number in numbers]
        for number in numbers:
            os.dup2(write, number)
        os.close(write)
        # No print may wait for the next drawing.
        self._thread = threading.Thread(target=self._read, args=(read,), name='tap', daemon=True)
        self._thread.start()

    def _read(self, pipe: int) -> None:
        with open(pipe, encoding='utf-8', errors='replace') as lines:
            for line in lines:
                self.lines.append(line.rstrip('\r\n'))

    def close(self) -> None:
        """Let the streams go where they went before; all lines are there afterwards."""
        sys.stdout.flush()
        sys.stderr.flush()
        for number, saved in self._saved:
            os.dup2(saved, number)
            os.close(saved)
        self._thread.join(1.0)


class Screen:
    """
    A context manager that draws lines on the terminal of standard error.

    While it is entered, what this process prints there is shown above the lines: warnings and
    errors of the nodes, and other text as it is. Information that nodes log is left out.

    Notes
    -----
    The cursor stays visible below the lines, and no mode of the terminal is changed. So nothing
    is left to restore, however the process ends.

    """

    def __init__(self) -> None:
        self._tap: _Tap | None = None
        self._height = 0
        self._size = (0, 0)

    def __enter__(self) -> 'Screen':
        self._file = open(os.dup(sys.stderr.fileno()), 'w', encoding='utf-8', errors='replace')
        self._console = open_console(self._file, colourless=True)
        streams = [stream for stream in (sys.stdout, sys.stderr) if stream.isatty()]
        for stream in streams:
            stream.flush()
        self._tap = _Tap([stream.fileno() for stream in streams])
        return self

    def __exit__(self, *_: object) -> None:
        if self._tap is not None:
            self._tap.close()
        self._write(self._erase(), *self._printed(), _BELOW)
        self._file.close()

    def room(self) -> tuple[int, int]:
        """Return the columns and rows for lines."""
        try:
            size = os.get_terminal_size(self._file.fileno())
        except OSError:
            return 79, 23
        return max(20, size.columns - 1), max(5, size.lines - 1)

    def draw(self, lines: Sequence[Line]) -> None:
        """Replace the lines."""
        size = self.room()
        # A terminal wraps the lines again when its width changes: where they begin is not known.
        start = self._erase() if size == self._size or not self._height else '\x1b[H\x1b[2J'
        self._size = size
        shown = [f'{self._render(line, size[0])}{_TO_THE_END}' for line in lines[:size[1]]]
        self._write(_BEGIN, start, *self._printed(), '\r\n'.join(shown), _BELOW, _END)
        self._height = len(shown)

    def tell(self, text: str) -> None:
        """Print a line above, at the next drawing."""
        if self._tap is not None:
            self._tap.lines.append(text)

    def _erase(self) -> str:
        """Return what moves the cursor to the first line."""
        return '\r' if self._height < 2 else f'\r\x1b[{self._height - 1}A'

    def _printed(self) -> list[str]:
        """Return what others have printed, in lines that stay."""
        lines = []
        while self._tap is not None and self._tap.lines:
            text, style = self._tap.lines.popleft(), ''
            if (match := _LOGGED.match(text)) is not None:
                level, second, name, words = match.groups()
                if level not in _STYLES:
                    continue
                when = datetime.fromtimestamp(int(second), timezone.utc)
                text, style = f'{when:%H:%M:%S} {level} {name}: {words}', _STYLES[level]
            lines.append(f'{self._style(text, style)}{_TO_THE_END}\r\n')
        return lines

    def _render(self, line: Line, columns: int) -> str:
        """Return a line in its colours, cut to the width."""
        style = ' '.join(filter(None, ['bold' if line.bold else '', _TONES.get(line.tone, '')]))
        label = f'{line.label:<{LABEL}}' if line.label else ''
        room = max(1, columns - (LABEL if label or not line.bold else 0))
        if not label and not line.bold:
            label = ' ' * LABEL
        return self._style(label, 'dim') + self._style(line.text, style, room)

    def _style(self, text: str, style: str, columns: int | None = None) -> str:
        from rich.text import Text

        shown = Text(''.join(character if character.isprintable() else '\ufffd'
                             for character in text), style)
        if columns is not None:
            shown.truncate(columns, overflow='ellipsis')
        with self._console.capture() as written:
            self._console.print(shown, end='', soft_wrap=True)
        return str(written.get())

    def _write(self, *parts: str) -> None:
        left = ''.join(parts).encode('utf-8', 'replace')
        # If the terminal is gone, the trial goes on without it.
        with suppress(OSError):
            while left:
                left = left[os.write(self._file.fileno(), left):]


class LiveView:
    """
    A context manager that shows views of a graph until it is left.

    Parameters
    ----------
    title
        What runs.
    foot
        What can be done, such as how to end it.
    quiet
        Show nothing.

    Notes
    -----
    On a terminal with rich the view is drawn again each time. Elsewhere a line of text is written
    every 10 s, and when something changes: a verdict, what speaks against the comparison, an
    alarm, a node.

    """

    def __init__(self, title: str, foot: str = '', quiet: bool = False) -> None:
        self._title, self._foot, self._quiet = title, foot, quiet
        can_draw = not quiet and open_console(sys.stderr, colourless=True) is not None
        self._screen = Screen() if can_draw else None
        self._open = ExitStack()
        self._keyboard: Keyboard | None = None
        self._lines = StatusLines()

    def __enter__(self) -> 'LiveView':
        if self._screen is not None:
            self._open.enter_context(self._screen)
            # Typed letters would tear the view apart.
            self._keyboard = self._open.enter_context(Keyboard())
        return self

    def __exit__(self, *_: object) -> None:
        self._open.close()

    def show(self, view: BridgeView, phase: str = '') -> None:
        """
        Show a view.

        Parameters
        ----------
        view
            What the graph tells by now.
        phase
            What the graph does at the moment if it does not just run.

        """
        if self._screen is not None:
            if self._keyboard is not None:
                self._keyboard.keys()
            columns, rows = self._screen.room()
            self._screen.draw(lay_out(view, columns, rows, title=self._title, phase=phase,
                                      foot=self._foot))
        elif not self._quiet and self._lines.is_due(_state_of(view, phase)):
            self._lines.write(one_line(view, time.time_ns(), phase))

    def tell(self, text: str) -> None:
        """Write a line that stays."""
        if self._screen is not None:
            self._screen.tell(text)
        elif not self._quiet:
            self._lines.write(text)


def _state_of(view: BridgeView, phase: str) -> tuple[object, ...]:
    """Return what a person wants to know at once when it changes."""
    return (phase, view.lamp.word, view.lamp.given_ns, _NUMBER.sub('#', view.validity.words),
            tuple((alarm.name, alarm.state) for alarm in view.alarms),
            tuple((node.name, node.level, node.stale) for node in view.nodes),
            view.ts.stale, view.rs.stale, view.run.number,
            None if view.sensors is None else (
                _NUMBER.sub('#', view.sensors.vote),
                tuple((row.now.stale, row.lamp.word) for row in view.sensors.rows)))
