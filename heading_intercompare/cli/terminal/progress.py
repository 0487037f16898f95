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

"""Progress on stderr if that is a terminal, silence otherwise."""

from __future__ import annotations

import re
import sys
import time
from typing import Any, Sequence

from .console import find_width, open_console

_USUAL = 80
#: Columns of the bar, and of what stands beside it and the words.
_LEAST_BAR, _BAR, _BESIDE = 8, 24, 20
#: Beginnings of a text that say how much of the work is done.
_NUMBER, _PERCENT = re.compile(r'\d[\d.,]*'), re.compile(r'(\d+)%')
_OF = re.compile(r'(?:replaying at )?([\d,]+(?:\.\d+)?)(?: s)? of ([\d,]+(?:\.\d+)?)\b')


class Progress:
    """
    One line on stderr that is overwritten each time; nothing if stderr is not a terminal.

    With rich it has a spinner and the elapsed time. If the text begins with a percentage, with
    "n of m" or with "replaying at n s of m s", it also has a bar and the time left. It uses no
    thread, because the bag reader does not fork decoders from a process with a second thread.

    Parameters
    ----------
    label
        The name of the work.
    quiet
        Never write.

    """

    def __init__(self, label: str, quiet: bool = False) -> None:
        self._label = label
        self._on = not quiet and sys.stderr.isatty()
        console = open_console(sys.stderr) if self._on else None
        self._display = None if console is None else _make_display(console)
        self._columns: Sequence[Any] = self._display.columns if self._display else ()
        self._bar: Any = None if self._display is None else self._display.columns[-2]
        self._next = 0.0
        self._words = ''
        self._width = 0

    def __enter__(self) -> 'Progress':
        return self

    def __exit__(self, *exc: object) -> None:
        self.clear()

    def show(self, text: str) -> None:
        """Write the state, at most ten times a second, or at once if the words change."""
        if not self._on:
            return
        words, now = _NUMBER.sub('', text), time.monotonic()
        if now < self._next and words == self._words:
            return
        self._next, self._words = now + 0.1, words
        room, line = (find_width(sys.stderr) or _USUAL) - 1, f'{self._label}: {text}'
        if self._display is not None:
            self._draw(self._display, _printable(line), _find_share(text), room)
            return
        sys.stderr.write(line[:room].ljust(self._width)[:room] + '\r')
        self._width = len(line[:room])
        sys.stderr.flush()

    def _draw(self, display: Any, line: str, share: float | None, room: int) -> None:
        """Draw the line with rich, as wide as the terminal."""
        task = display.tasks[0]
        if share is None or share < task.completed:
            # Other work, or a pause: the pace so far says nothing of the time left.
            task.total = task.finished_time = None
        display.update(task.id, description=line, completed=share or 0.0,
                       total=None if share is None else 1.0)
        display.console.width = room
        # Without a bar the words have its room; with one the words go first.
        display.columns = self._columns[:None if share is not None and room > 2 * _BAR else -2]
        self._bar.bar_width = min(_BAR, max(_LEAST_BAR, room - len(line) - _BESIDE))
        if display.live.is_started:
            display.refresh()
        else:
            display.start()
            # However the process ends, no terminal is left without one.
            display.console.show_cursor(True)

    def tell(self, text: str) -> None:
        """Write a line that stays, above the one that is overwritten."""
        self.clear()
        sys.stderr.write(_printable(text) + '\n')
        sys.stderr.flush()

    def clear(self) -> None:
        """Remove the line from the screen."""
        if self._display is not None:
            self._display.stop()
        elif self._width:
            sys.stderr.write('\r' + ' ' * self._width + '\r')
            sys.stderr.flush()
            self._width = 0


def _make_display(console: Any) -> Any:
    """Return a display of one task, with rich."""
    from rich.progress import (
        BarColumn,
        Progress as Display,
        SpinnerColumn,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )
    from rich.table import Column

    letters = (console.encoding or '').lower().startswith('utf')
    # Names from others are plain text, without markup. In a narrow terminal the words give way.
    words = TextColumn('{task.description}', markup=False,
                       table_column=Column(ratio=1, no_wrap=True, overflow='ellipsis'))
    display = Display(
        SpinnerColumn('dots' if letters else 'line'), words, TimeElapsedColumn(),
        BarColumn(_BAR), TimeRemainingColumn(compact=True), console=console, auto_refresh=False,
        expand=True, transient=True, redirect_stdout=False, redirect_stderr=False,
        get_time=time.monotonic)
    display.add_task('', total=None)
    return display


def _find_share(text: str) -> float | None:
    """
    Return the share of the work that is done, if the text begins with it.

    Examples
    --------
    >>> _find_share('12% copied'), _find_share('1,200 of 4,800 s'), _find_share('17 pairs')
    (0.12, 0.25, None)
    >>> _find_share('replaying at 6.250 s of 25.000 s'), _find_share('paused at 1.0 s of 25.0 s')
    (0.25, None)

    """
    if match := _PERCENT.match(text):
        return min(int(match[1]) / 100.0, 1.0)
    if match := _OF.match(text):
        part, whole = (float(number.replace(',', '') or '0') for number in match.groups())
        return min(part / whole, 1.0) if whole else None
    return None


def _printable(text: str) -> str:
    return ''.join(letter if letter.isprintable() else '\ufffd' for letter in text)
