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

"""A file on a disk that can no longer read all of it."""

from __future__ import annotations

from bisect import bisect_left, insort
import errno
from io import BufferedReader, RawIOBase
import os
from pathlib import Path

#: Unreadable data counts as lost in blocks of this many bytes.
HOLE_BYTES = 4096
_BUFFER_BYTES = 2**18


class _RoughFile(RawIOBase):
    """
    A file, open for reading; a read stops at the next hole.

    Parameters
    ----------
    path
        The file.
    holes
        The first byte of each hole, in order; newly found holes are added to it.

    """

    def __init__(self, path: Path, holes: list[int]) -> None:
        self._holes = holes
        self._descriptor = os.open(path, os.O_RDONLY)

    def readable(self) -> bool:
        return True

    def seekable(self) -> bool:
        return True

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        return os.lseek(self._descriptor, offset, whence)

    # BufferedReader hands in nothing else, and Python 3.10 has no name for every buffer.
    def readinto(self, buffer: memoryview) -> int:  # type: ignore[override]
        at = self.tell()
        size = len(buffer)
        if self._holes:
            place = bisect_left(self._holes, at - at % HOLE_BYTES)
            if place < len(self._holes):
                size = min(size, max(self._holes[place] - at, 0))
        while size:
            try:
                return os.readv(self._descriptor, [memoryview(buffer)[:size]])
            except OSError as error:
                if error.errno != errno.EIO:
                    raise
            rest = HOLE_BYTES - at % HOLE_BYTES
            if size <= rest:
                insort(self._holes, at - at % HOLE_BYTES)
                return 0
            size = max(size // 2, rest)
        return 0

    def close(self) -> None:
        if not self.closed:
            os.close(self._descriptor)
        super().close()


def open_with_holes(path: Path, holes: list[int]) -> BufferedReader:
    """
    Open a file for reading; blocks that the disk cannot read are holes.

    A read ends at a hole, as at the end of the file. It continues after a seek past the hole.

    Parameters
    ----------
    path
        The file.
    holes
        Offsets of the unreadable blocks of `HOLE_BYTES` known so far, in order; newly found ones
        are added.

    Raises
    ------
    OSError
        If the file cannot be opened, is a directory, or disappears.

    """
    if path.is_dir():
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
    return BufferedReader(_RoughFile(path, holes), _BUFFER_BYTES)
