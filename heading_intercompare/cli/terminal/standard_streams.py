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

"""Standard output and error that may be closed, full, or no longer read."""

from __future__ import annotations

from contextlib import contextmanager, redirect_stderr, redirect_stdout
import os
import sys
from typing import Any, Callable, IO, Iterator


class _Stream:
    """
    A stream that discards everything once a write has failed.

    Parameters
    ----------
    stream
        Standard output or error; None if it is closed, so that the output is discarded.
    name
        Its name in errors.
    ignored
        Errors that are ignored; any other error is raised, once.

    """

    def __init__(self, stream: IO[str] | None, name: str, ignored: type[OSError]) -> None:
        self._stream, self._name, self._ignored = stream, name, ignored

    def __getattr__(self, attribute: str) -> Any:
        return getattr(self._stream, attribute)

    def write(self, text: str) -> int:
        # A file name may have undecodable bytes, and a terminal may lack characters.
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
            # Otherwise the text left in the buffer would fail again when the process ends.
            with open(os.devnull, 'wb') as nowhere:
                os.dup2(nowhere.fileno(), self._stream.fileno())
            if not isinstance(error, self._ignored):
                raise OSError(error.errno, error.strerror, self._name) from error


@contextmanager
def safe_stderr() -> Iterator[None]:
    """Ignore failed writes to stderr."""
    with redirect_stderr(_Stream(sys.stderr, 'standard error', OSError)):
        yield


@contextmanager
def safe_stdout() -> Iterator[None]:
    """
    Flush standard output at the end; ignore that its reader is gone.

    Raises
    ------
    OSError
        If the output cannot be written for another reason; it names the stream.

    """
    stream = _Stream(sys.stdout, 'standard output', BrokenPipeError)
    with redirect_stdout(stream):
        try:
            yield
        finally:
            stream.flush()
