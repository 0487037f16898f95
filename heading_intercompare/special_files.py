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

"""Pipes, devices and sockets in place of files: they never end, or can be read only once."""

from __future__ import annotations

import errno
from io import BufferedReader, FileIO
import os
import select
import stat

#: How long the first writer of a pipe may take, seconds.
_WRITER_S = 5.0
_KINDS = ((stat.S_ISFIFO, 'a pipe'), (stat.S_ISCHR, 'a device'), (stat.S_ISBLK, 'a device'),
          (stat.S_ISSOCK, 'a socket'))


def refuse_special(path: str | os.PathLike[str]) -> None:
    """
    Raise OSError unless a path can be read as a file, or is a folder, or is not there.

    Raises
    ------
    OSError
        If it is a pipe, a device or a socket, which cannot be read twice, or never ends.

    """
    try:
        mode = os.stat(path).st_mode
    except FileNotFoundError:
        return
    for is_kind, name in _KINDS:
        if is_kind(mode):
            raise _make_error(path, f'is {name}, not a file: write what comes out of it to a '
                              'file, and give that')


def open_once(path: str | os.PathLike[str]) -> BufferedReader:
    """
    Open a file that is read once from its beginning to its end, which may be a pipe.

    Raises
    ------
    OSError
        If it cannot be opened, or nobody writes into the pipe.

    """
    if not stat.S_ISFIFO(os.stat(path).st_mode):
        return BufferedReader(FileIO(os.fspath(path)))
    descriptor = os.open(path, os.O_RDONLY | os.O_NONBLOCK)
    poll = select.poll()
    poll.register(descriptor, select.POLLIN)
    if not (poll.poll(1000 * _WRITER_S) or _has_writer(descriptor)):
        os.close(descriptor)
        raise _make_error(path, 'is a pipe into which nobody writes: give a file')
    os.set_blocking(descriptor, True)
    return BufferedReader(FileIO(descriptor))


def read_once(path: str | os.PathLike[str]) -> bytes:
    """Return the bytes of a file, or of a pipe; OSError as `open_once`."""
    with open_once(path) as file:
        return file.read()


def _has_writer(descriptor: int) -> bool:
    """Tell whether a pipe without data has a writer, which may write later."""
    try:
        os.read(descriptor, 1)
    except BlockingIOError:
        return True
    return False


def _make_error(path: str | os.PathLike[str], problem: str) -> OSError:
    return OSError(errno.EINVAL, problem, os.fspath(path))
