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

"""The files of one log, in order, and their bytes: plain or compressed, in any Unicode form."""

from __future__ import annotations

import bz2
import codecs
from functools import cached_property
import glob
import gzip
from itertools import chain
import lzma
import os
from typing import Any, BinaryIO, Callable, Generator, Iterator
import zlib

from heading_intercompare.drivers.settings import DriverError
from heading_intercompare.natural_order import natural_key
from heading_intercompare.special_files import refuse_special

_BLOCK = 1 << 20
_LONGEST_LINE = 1 << 16
_HEAD_BYTES = 1 << 16
_UTF16 = {b'\xff\xfe': 'utf-16-le', b'\xfe\xff': 'utf-16-be'}
_DAMAGED = (gzip.BadGzipFile, zlib.error, lzma.LZMAError)


def _is_pattern(path: str) -> bool:
    return not os.path.lexists(path) and glob.has_magic(path)


def is_several(path: str) -> bool:
    """Tell whether a path is a folder, or a pattern of file names, such as `gyro*.log`."""
    return os.path.isdir(path) or _is_pattern(path)


def list_files(path: str) -> list[str]:
    """Return the files of a folder or a pattern; none if one of them is part of a bag."""
    try:
        files = LogFiles(path).paths
    except DriverError:
        return []
    is_bag = any(file.endswith('.mcap') or os.path.basename(file) == 'metadata.yaml'
                 for file in files)
    return [] if is_bag else files


class LogFiles:
    """
    The files of one log: a file, the files in a folder, or those that a pattern matches.

    Parameters
    ----------
    path
        A file; a folder, with the files in its folders; or a pattern with `*`, `?`, `[...]`, and
        `**` for folders. Files whose names begin with a dot are none.

    Attributes
    ----------
    path
        The path as given.
    position : int
        Bytes on the disk read so far by `blocks`.
    cut
        Compressed files that end too early; what they hold until then was read.
    dangling
        Links that lead nowhere, or to themselves.

    Raises
    ------
    OSError
        If a file cannot be read; raised where its bytes are needed.
    DriverError
        If no file matches, or compressed data are damaged.

    """

    def __init__(self, path: str) -> None:
        self.path = path
        self.position = 0
        self.cut: list[str] = []
        self.dangling: list[str] = []

    @cached_property
    def paths(self) -> list[str]:
        """
        Return the files with bytes in them, by name, numbers in names by value.

        Raises
        ------
        OSError
            If the path does not exist.
        DriverError
            If no file matches.

        """
        if _is_pattern(self.path):
            paths = [path for path in glob.glob(self.path, recursive=True)
                     if os.path.isfile(path)]
        elif os.path.isdir(self.path):
            paths = [os.path.join(folder, name)
                     for folder, folders, names in os.walk(self.path)
                     for name in names
                     if not any(part.startswith('.') for part in os.path.relpath(
                         os.path.join(folder, name), self.path).split(os.sep))]
        else:
            os.stat(self.path)
            refuse_special(self.path)
            return [self.path]
        self.dangling = sorted((path for path in paths if not os.path.exists(path)),
                               key=natural_key)
        filled = sorted((path for path in paths if path not in self.dangling
                         and os.path.getsize(path)), key=natural_key)
        if not filled:
            raise DriverError(f'{self.path}: no file with anything in it')
        return filled

    @property
    def size(self) -> int:
        """Bytes on the disk of all files."""
        return sum(os.path.getsize(path) for path in self.paths)

    @property
    def share_read(self) -> str:
        """Return how much of the log `blocks` has read, as 12%."""
        return f'{self.position / max(1, self.size):.0%}'

    def keep(self, is_log: Callable[[str], bool], key: Callable[[str], int | None]) -> None:
        """
        Drop the files that are not logs, and put the logs in order of time.

        Parameters
        ----------
        is_log
            Tells of the path of a file whether it is a log.
        key
            Returns the first stamp of a file; if one has none, the order of names stays.

        """
        paths = [path for path in self.paths if is_log(path)]
        stamps = [key(path) for path in paths]
        first_stamps = [stamp for stamp in stamps if stamp is not None]
        if len(first_stamps) == len(paths):
            paths = [path for _, path in sorted(zip(first_stamps, paths),
                                                key=lambda entry: entry[0])]
        self.__dict__['paths'] = paths

    def blocks(self, size: int = _BLOCK) -> Iterator[tuple[str | None, bytes]]:
        """
        Yield the bytes of the files as UTF-8, without their byte order marks.

        Yields
        ------
        path : str or None
            The file that begins with this block; None for a later block of the same file.
        data : bytes
            A file that does not end with a line end gets one if another file follows it.

        """
        before = 0
        for path in self.paths:
            begins: str | None = path
            last = b''
            with open(path, 'rb') as file:
                try:
                    for data in _decode(_decompress(file, size)):
                        self.position = before + min(file.tell(), os.path.getsize(path))
                        yield begins, data
                        begins, last = None, data[-1:]
                except EOFError:
                    self.cut.append(path)
                except _DAMAGED as error:
                    raise DriverError(f'{path}: the compressed data are damaged ({error}); '
                                      'give the file decompressed') from None
            before += os.path.getsize(path)
            self.position = before
            if path != self.paths[-1] and last not in (b'', b'\n', b'\r'):
                yield None, b'\n'

    def bare_blocks(self) -> Iterator[bytes]:
        """Yield the bytes alone, without a note where a file begins; `position` stays."""
        position, cut = self.position, list(self.cut)
        for _, data in self.blocks():
            yield data
        self.position, self.cut = position, cut

    def lines(self) -> Generator[tuple[str | None, bytes], None, None]:
        """Yield the lines with their ends, each with the file that it begins or None."""
        rest, begins = b'', None
        for path, data in self.blocks():
            begins = path or begins
            lines = (rest + data).split(b'\n')
            rest = lines.pop()
            for line in lines:
                yield begins, line + b'\n'
                begins = None
            while len(rest) >= _LONGEST_LINE:
                yield begins, rest[:_LONGEST_LINE]
                rest, begins = rest[_LONGEST_LINE:], None
        if rest:
            yield begins, rest


def head_of(path: str) -> bytes:
    """Return the beginning of a file, decompressed, as UTF-8; empty if that cannot be read."""
    with open(path, 'rb') as file:
        try:
            return next(_decode(_decompress(file, _HEAD_BYTES)), b'')
        except (EOFError, *_DAMAGED):
            return b''


class _ZstdReader:
    """
    Reads a zstd file of any number of frames.

    EOFError if the last one is cut, zlib.error if the file is damaged.
    """

    def __init__(self, file: BinaryIO) -> None:
        try:
            # A driver of a line needs it not.
            import zstandard
        except ModuleNotFoundError as error:
            raise DriverError(f'{file.name}: reading zstd needs the module zstandard: python3 -m '
                              'pip install zstandard; or decompress it with zstd -d') from error
        self._file, self._unused, self._open = file, b'', False
        self._begin = zstandard.ZstdDecompressor().decompressobj
        self._frame, self._damaged = self._begin(), zstandard.ZstdError

    def read1(self, size: int) -> bytes:
        """Return some of the decompressed bytes; none at the end."""
        while data := self._unused or self._file.read(max(1, size // 8)):
            if self._frame.eof:
                self._frame = self._begin()
            try:
                text = self._frame.decompress(data)
            except self._damaged as error:
                raise zlib.error(str(error)) from error
            self._unused, self._open = self._frame.unused_data, not self._frame.eof
            if text:
                return text
        if self._open:
            raise EOFError
        return b''


_OPENERS: dict[bytes, Callable[[BinaryIO], Any]] = {
    b'\x1f\x8b': lambda file: gzip.GzipFile(fileobj=file),
    b'\x28\xb5\x2f\xfd': _ZstdReader,
    b'BZh': bz2.BZ2File,
    b'\xfd7zXZ\x00': lzma.LZMAFile,
}
"""First bytes of compressed files, and what reads them."""


def _decompress(file: BinaryIO, size: int) -> Iterator[bytes]:
    """Yield the decompressed bytes; EOFError after the last one if the data are cut."""
    head = file.read(6)
    file.seek(0)
    opener = next((opener for magic, opener in _OPENERS.items() if head.startswith(magic)), None)
    if opener is None:
        while data := file.read(size):
            yield data
        return
    reader, parts, cut = opener(file), [b''], False
    while parts:
        parts = []
        try:
            while sum(map(len, parts)) < size and (data := reader.read1(size)):
                parts.append(data)
        except EOFError:
            cut = True
        if parts:
            yield b''.join(parts)
        if cut:
            raise EOFError


def _decode(blocks: Iterator[bytes]) -> Iterator[bytes]:
    """Yield the bytes of a file as UTF-8; a log is ASCII, and other bytes pass unchanged."""
    data = next(blocks, b'')
    encoding = _UTF16.get(data[:2])
    if encoding is None and len(data) >= 4 and data[:4:2].isascii() and data[1:4:2] == b'\0\0':
        encoding = 'utf-16-le'
    if encoding is None:
        if data := data.removeprefix(codecs.BOM_UTF8):
            yield data
        yield from blocks
        return
    decoder = codecs.getincrementaldecoder(encoding)('replace')
    for block in chain((data,), blocks):
        yield decoder.decode(block).lstrip('\ufeff').encode()
