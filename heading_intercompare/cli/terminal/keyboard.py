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

"""Keys from the terminal, read one by one without waiting."""

from __future__ import annotations

from contextlib import suppress
import os
import select
import sys
import termios
from typing import Any, IO

_MODES, _CHARACTERS = 3, 6


class Keyboard:
    """
    A context manager that reads the keys pressed in it; none if there is no terminal.

    Keys arrive at once and are not shown; Ctrl-C and Ctrl-Z work as usual. On exit, also after an
    error, the terminal is restored.

    Parameters
    ----------
    stream
        Source of the keys; standard input by default.

    Attributes
    ----------
    on : bool
        Whether there is a terminal.

    """

    def __init__(self, stream: IO[str] | None = None) -> None:
        stream = sys.stdin if stream is None else stream
        self.on = stream is not None and not stream.closed and stream.isatty()
        self._fd = stream.fileno() if self.on else -1
        self._before: list[Any] | None = None

    def __enter__(self) -> 'Keyboard':
        return self

    def __exit__(self, *_: object) -> None:
        if self._before is not None and self._ours():
            with suppress(termios.error):  # The terminal is gone.
                termios.tcsetattr(self._fd, termios.TCSANOW, self._before)

    def keys(self) -> str:
        """Return the keys pressed since the last call."""
        keys = b''
        if self.on and self._ours():
            try:
                self._set_modes()
                while select.select([self._fd], [], [], 0.0)[0]:
                    piece = os.read(self._fd, 64)
                    self.on = bool(piece)
                    if not piece:
                        break
                    keys += piece
            except (OSError, termios.error):
                self.on = False
        return keys.decode('ascii', 'ignore')

    def _ours(self) -> bool:
        """Tell whether we may use the terminal; it would stop a background process."""
        try:
            return os.tcgetpgrp(self._fd) == os.getpgrp()
        except OSError:  # Not the controlling terminal of this process.
            return True

    def _set_modes(self) -> None:
        """Make keys arrive at once; repeat it after a shell, on Ctrl-Z, has set its own modes."""
        modes = termios.tcgetattr(self._fd)
        if modes[_MODES] & termios.ICANON:
            self._before = self._before or termios.tcgetattr(self._fd)
            modes[_MODES] &= ~(termios.ICANON | termios.ECHO)
            modes[_CHARACTERS][termios.VMIN], modes[_CHARACTERS][termios.VTIME] = 1, 0
            termios.tcsetattr(self._fd, termios.TCSANOW, modes)
