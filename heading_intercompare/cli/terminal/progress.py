# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Progress on stderr when it is a terminal, silence otherwise."""

from __future__ import annotations

import os
import sys
import time

__all__ = ['Progress']

_USUAL = 80


class Progress:
    """
    One line on stderr that is written over; nothing when stderr is not a terminal.

    Parameters
    ----------
    label : str
        What is going on.
    quiet : bool
        Never write.

    """

    def __init__(self, label: str, quiet: bool = False) -> None:
        self._label = label
        self._on = not quiet and sys.stderr.isatty()
        self._next = 0.0
        self._width = 0

    def __enter__(self) -> 'Progress':
        return self

    def __exit__(self, *exc) -> None:
        self.clear()

    def show(self, text: str) -> None:
        """Write the state, at most ten times a second; who writes next, writes over it."""
        if not self._on or time.monotonic() < self._next:
            return
        self._next = time.monotonic() + 0.1
        room = _columns() - 1
        line = f'{self._label}: {text}'[:room]
        sys.stderr.write(line.ljust(self._width)[:room] + '\r')
        sys.stderr.flush()
        self._width = len(line)

    def clear(self) -> None:
        """Take the line off the screen."""
        if self._width:
            sys.stderr.write('\r' + ' ' * self._width + '\r')
            sys.stderr.flush()
            self._width = 0


def _columns() -> int:
    """Return the width of the terminal; of one that does not tell, the usual."""
    try:
        return os.get_terminal_size(sys.stderr.fileno()).columns or _USUAL
    except OSError:
        return _USUAL
