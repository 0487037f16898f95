# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Standard output and error that may be closed, full, or read by nobody any more."""

from __future__ import annotations

from contextlib import contextmanager, redirect_stderr, redirect_stdout
import os
import sys
from typing import Any, Callable, IO, Iterator

__all__ = ['safe_stderr', 'safe_stdout']


class _Stream:
    """
    A stream that goes nowhere once writing failed.

    Parameters
    ----------
    stream : file or None
        Standard output or error; None if it is closed, and what is written goes nowhere.
    name : str
        What an error calls it.
    borne : type
        The errors of which nothing is said; all others are raised, once.

    """

    def __init__(self, stream: IO[str] | None, name: str, borne: type[OSError]) -> None:
        self._stream, self._name, self._borne = stream, name, borne

    def __getattr__(self, attribute: str) -> Any:
        return getattr(self._stream, attribute)

    def write(self, text: str) -> int:
        # The name of a file may have bytes that are no letters, and a terminal lacks letters.
        encoding = getattr(self._stream, 'encoding', None) or 'utf-8'
        shown = text.encode(encoding, 'backslashreplace').decode(encoding)
        self._try(lambda stream: stream.write(shown))
        return len(text)

    def flush(self) -> None:
        self._try(lambda stream: stream.flush())

    def isatty(self) -> bool:
        return self._stream is not None and self._stream.isatty()

    def _try(self, act: Callable[[IO[str]], object]) -> None:
        if self._stream is None:
            return
        try:
            act(self._stream)
        except OSError as error:
            # What waits in the buffer would fail once more when the process ends.
            with open(os.devnull, 'wb') as nowhere:
                os.dup2(nowhere.fileno(), self._stream.fileno())
            if not isinstance(error, self._borne):
                raise OSError(error.errno, error.strerror, self._name) from error


@contextmanager
def safe_stderr() -> Iterator[None]:
    """Say nothing on stderr where that cannot be."""
    with redirect_stderr(_Stream(sys.stderr, 'standard error', OSError)):
        yield


@contextmanager
def safe_stdout() -> Iterator[None]:
    """
    Write what is printed before the end, which comes even if nobody reads it any more.

    Raises
    ------
    OSError
        If it cannot be written for another reason; with the name of the stream.

    """
    stream = _Stream(sys.stdout, 'standard output', BrokenPipeError)
    with redirect_stdout(stream):
        try:
            yield
        finally:
            stream.flush()
