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

"""Colours on the terminal, with rich: whether a stream shows them, and text with highlights."""

from __future__ import annotations

import os
import re
import sys
from typing import Any, IO, Iterable, Sequence

from .printable import escape, escape_lines

# A pattern and the rich style of its matches, or of their first group.
_Mark = tuple[str, str]

_WORDS = ((r'(?<![\w-])COMPLIANT\b', 'green'), (r'\bNON-COMPLIANT\b', 'red'),
          (r'\bINDETERMINATE\b', 'yellow'))

#: Marks for the table of a verdict, and for lines with only its outcome.
VERDICT_MARKS: tuple[_Mark, ...] = (
    *_WORDS, (r'(?m)^VERDICT: .*$', 'bold'),
    (r'\b(?:DOUBTFUL|VOID|NOT JUDGED|NO RUN)\b', 'yellow'),
    (r'(?m)^ +(?:run \d+ *)+$', 'bold'), (r'(?m)^  warning:', 'yellow'))


def open_console(stream: IO[str], *, colourless: bool = False) -> Any:
    """
    Return a rich console that writes to a stream, or None if text must stay plain.

    Text stays plain if the stream is not a terminal, or is a dumb one, if ``NO_COLOR`` is set
    unless `colourless` asks for a console without colours, or if rich is not installed.
    """
    if not stream.isatty() or os.environ.get('TERM') == 'dumb':
        return None
    if os.environ.get('NO_COLOR') and not colourless:
        return None
    try:
        from rich.console import Console
    except ImportError:
        return None
    # The text may contain foreign names: nothing in it is markup or an emoji.
    return Console(file=stream, markup=False, emoji=False, highlight=False, soft_wrap=True)


def find_width(stream: IO[str]) -> int | None:
    """Return the width of the terminal that a stream writes to; None if it is no terminal."""
    if not stream.isatty():
        return None
    try:
        return os.get_terminal_size(stream.fileno()).columns or None
    except OSError:
        return None


def say_lines(lines: Iterable[str], marks: Sequence[_Mark] = ()) -> None:
    """Print lines on standard output; a line end within one is escaped, like in `say`."""
    say('\n'.join(map(escape, lines)), marks)


def tell(note: str) -> None:
    """Print a note on standard error, in one line; what does not print is escaped."""
    print(f'note: {escape(note)}', file=sys.stderr)


def say(text: str, marks: Sequence[_Mark] = ()) -> None:
    """
    Print text on standard output.

    Parameters
    ----------
    text
        Nothing in it is treated as markup. What does not print is escaped, except line ends and
        tabs: commands of a terminal, and characters that turn the direction of the text.
    marks : sequence of (str, str)
        Highlights on a terminal: a pattern, and the rich style of its matches or of their first
        group. Later marks override earlier ones.

    """
    text = escape_lines(text)
    console = open_console(sys.stdout)
    if console is None:
        print(text)
        return
    from rich.text import Text

    shown = Text(text)
    for pattern, style in marks:
        for match in re.finditer(pattern, shown.plain):
            shown.stylize(style, *match.span(1 if match.re.groups else 0))
    console.print(shown)
