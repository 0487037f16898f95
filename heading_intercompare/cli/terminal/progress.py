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

import os
import re
import sys
import time
from typing import Any

from .console import open_console

__all__ = ['Progress']

_USUAL = 80
_BAR = 24
#: Beginnings of a text that say how much of the work is done.
_NUMBER, _PERCENT = re.compile(r'\d[\d.,]*'), re.compile(r'(\d+)%')
_OF = re.compile(r'(?:replaying at )?([\d,]+(?:\.\d+)?)(?: s)? of ([\d,]+(?:\.\d+)?)\b')


class Progress:
    """
    One line on stderr that is overwritten each time; nothing if stderr is not a terminal.

    With rich it has a spinner and the elapsed time. If the text begins with a percentage, with
    "n of m" or with "replaying at n s of m s", it also has a bar and the time left. It uses
    no thread, because the bag reader does not fork decoders from a process with a second thread.

    Parameters
    ----------
    label : str
        The name of the work.
    quiet : bool
        Never write.

    """

    def __init__(self, label: str, quiet: bool = False) -> None:
        self._label = label
        self._on = not quiet and sys.stderr.isatty()
        self._console = open_console(sys.stderr) if self._on else None
        self._spinner: Any = None
        self._start = time.monotonic() if self._on else 0.0
        # When the work began or went on after a pause, and its share then.
        self._begun: tuple[float, float] | None = (self._start, 0.0)
        self._share = 0.0
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
        room = _columns() - 1
        if self._console is not None:
            self._draw(self._console, text, room)
        else:
            line = f'{self._label}: {text}'[:room]
            sys.stderr.write(line.ljust(self._width)[:room] + '\r')
            self._width = len(line)
        sys.stderr.flush()

    def _draw(self, console: Any, text: str, room: int) -> None:
        """Draw the line with rich, as wide as the terminal."""
        from rich.progress_bar import ProgressBar
        from rich.segment import Segments
        from rich.spinner import Spinner
        from rich.table import Table
        from rich.text import Text

        now = time.monotonic()
        if self._spinner is None:
            letters = (console.encoding or '').lower().startswith('utf')
            self._spinner = Spinner('dots' if letters else 'line', style='cyan')
        # Names from others are plain text, without markup or control characters.
        words = Text(_printable(f'{self._label}: {text}'), overflow='ellipsis')
        cells = [self._spinner.render(now), words, Text(_clock(now - self._start), style='dim')]
        share = _find_share(text)
        left_s = self._find_left_s(now, share)
        if share is not None and room > 2 * _BAR:
            cells += [ProgressBar(total=1.0, completed=share, width=_BAR),
                      Text('' if left_s is None else f'{_clock(left_s)} left')]
        line = Table.grid(*('' for _ in cells), padding=(0, 1))
        for column in line.columns:
            column.no_wrap = True
        # In a narrow terminal the words give way, and a blank stands between two cells.
        others = sum(1 + getattr(cell, 'cell_len', _BAR) for cell in cells if cell is not words)
        words.truncate(max(1, room - others), overflow='ellipsis')
        line.add_row(*cells)
        options = console.options.update(width=room, no_wrap=True)
        (drawn, *_) = console.render_lines(line, options)
        with console.capture() as written:
            console.print(Segments(drawn), end='')
        sys.stderr.write(written.get() + '\r')
        self._width = room

    def _find_left_s(self, now: float, share: float | None) -> float | None:
        """Return the time left at the pace since the work went on; None if it is not known."""
        if share is None:
            self._begun = None
            return None
        if self._begun is None or share < self._share:
            self._begun = (now, share)
        self._share = share
        begun_s, begun_share = self._begun
        done = share - begun_share
        return (now - begun_s) * (1.0 - share) / done if done > 0.0 else None

    def tell(self, text: str) -> None:
        """Write a line that stays, above the one that is overwritten."""
        self.clear()
        sys.stderr.write(_printable(text) + '\n')
        sys.stderr.flush()

    def clear(self) -> None:
        """Remove the line from the screen."""
        if self._width:
            sys.stderr.write('\r' + ' ' * self._width + '\r')
            sys.stderr.flush()
            self._width = 0


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


def _clock(seconds: float) -> str:
    """
    Return a time span in the format of a clock.

    Examples
    --------
    >>> _clock(7.9), _clock(75.0), _clock(7384.0)
    ('0:07', '1:15', '2:03:04')

    """
    minutes, rest = divmod(int(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f'{hours}:{minutes:02d}:{rest:02d}' if hours else f'{minutes}:{rest:02d}'


def _columns() -> int:
    """Return the width of the terminal; 80 if it is unknown."""
    try:
        return os.get_terminal_size(sys.stderr.fileno()).columns or _USUAL
    except OSError:
        return _USUAL
