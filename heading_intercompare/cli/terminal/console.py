# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The door to rich: whether a stream shows colours, and text in which what matters stands out."""

from __future__ import annotations

import os
import re
import sys
from typing import Any, IO, Sequence

__all__ = ['Mark', 'open_console', 'say', 'VERDICT_MARKS']

#: What a pattern finds, or its first group, and the style of rich that it is shown in.
Mark = tuple[str, str]

_WORDS = ((r'(?<![\w-])COMPLIANT\b', 'green'), (r'\bNON-COMPLIANT\b', 'red'),
          (r'\bINDETERMINATE\b', 'yellow'))

#: Of the table of a verdict, and of lines that say no more than its outcome.
VERDICT_MARKS: tuple[Mark, ...] = (
    *_WORDS, (r'(?m)^VERDICT: .*$', 'bold'), (r'\b(?:DOUBTFUL|VOID)\b', 'yellow'),
    (r'(?m)^ +(?:run \d+ *)+$', 'bold'), (r'(?m)^  warning:', 'yellow'))

#: What would move the cursor or colour the screen; lines and tabs stay.
_CONTROL = re.compile('[\x00-\x08\x0b-\x1f\x7f-\x9f]')


def open_console(stream: IO[str]) -> Any:
    """
    Return a console of rich that writes to a stream; None where text stays plain.

    It does where the stream is no terminal, or a dumb one, where ``NO_COLOR`` is set, and where
    rich is not installed.
    """
    if not stream.isatty() or os.environ.get('NO_COLOR') or os.environ.get('TERM') == 'dumb':
        return None
    try:
        from rich.console import Console
    except ImportError:
        return None
    # The text is that of others, too: what looks like markup or an emoji is none.
    return Console(file=stream, markup=False, emoji=False, highlight=False, soft_wrap=True)


def say(text: str, marks: Sequence[Mark] = ()) -> None:
    """
    Print text on standard output.

    Parameters
    ----------
    text : str
        Printed as it is; nothing in it is taken for markup.
    marks : sequence of Mark
        What stands out on a terminal; the later covers the earlier.

    """
    console = open_console(sys.stdout)
    if console is None:
        print(text)
        return
    from rich.text import Text

    shown = Text(_CONTROL.sub('\ufffd', text))
    for pattern, style in marks:
        for match in re.finditer(pattern, shown.plain):
            shown.stylize(style, *match.span(1 if match.re.groups else 0))
    console.print(shown)
