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

"""
A journal: records appended to a file that survive a process that is killed.

Each record has its length and a checksum, so a record that was cut is found. What is appended
reaches the system with the next `flush`, and the disk within a second more.
"""

from __future__ import annotations

from collections import deque
from contextlib import suppress
import fcntl
import hashlib
import io
from itertools import chain
import json
import os
from pathlib import Path
import re
import struct
from typing import Any, BinaryIO, Iterable, Iterator, NamedTuple, TypeVar
import zlib

import numpy as np

from heading_intercompare.bags.errors import BagError
from heading_intercompare.bags.recording.disk_sync import Syncing
from heading_intercompare.core.records import Headings, Motion, Pairs, Quality

_MAGIC = b'heading_intercompare journal 3\n'
_KIND = _MAGIC[:-3]
#: A journal, also one that was set aside.
_NAMED = re.compile(r'.+\.journal(\.[0-9]+)?')
_HEAD = struct.Struct('<IIc')
_LENGTH = struct.Struct('<I')
_SYNC_S = 1.0
#: Records that wait for a disk that is full; older ones are given up.
_MOST_WAITING = 16_000_000
_RETRY_S = 1.0

_Columns = TypeVar('_Columns', Pairs, Motion, Quality, Headings)
_TYPES = {'stamp_ns': '<i8', 'lag_ns': '<i8', 'flag': '<i8'}


class Record(NamedTuple):
    """A record: its kind, one letter, and its bytes."""

    kind: bytes
    data: bytes


class JournalContents(NamedTuple):
    """
    The records of a journal.

    Attributes
    ----------
    size
        Bytes up to the end of the last whole record.
    torn
        Bytes after it, of a record that was cut.
    sha256
        Hash of all bytes.

    """

    records: list[Record]
    size: int
    torn: int
    sha256: str


def encode_columns(rows: Pairs | Motion | Quality | Headings) -> bytes:
    """Return rows as bytes; a column of one value throughout takes the place of one."""
    flags, parts = 0, []
    for at, name in enumerate(type(rows).__slots__):
        column = np.ascontiguousarray(getattr(rows, name), _TYPES.get(name, '<f8'))
        bits = column.view('<i8')
        if len(bits) and (bits == bits[0]).all():
            flags, column = flags | 1 << at, column[:1]
        parts.append(column.tobytes())
    return b''.join([struct.pack('<IB', len(rows), flags), *parts])


def decode_columns(data: bytes, kind: type[_Columns]) -> _Columns:
    """
    Return the rows in bytes of `encode_columns`, to the bit.

    Raises
    ------
    BagError
        If the number of bytes is wrong.

    """
    columns, at = [], 5
    n, flags = struct.unpack_from('<IB', data) if len(data) >= at else (0, 0)
    counts = [1 if flags & 1 << number else n for number in range(len(kind.__slots__))]
    if len(data) != at + 8 * sum(counts):
        raise BagError(f'columns of {len(data)} bytes: must be {at + 8 * sum(counts)}')
    for name, count in zip(kind.__slots__, counts):
        number = np.dtype(_TYPES.get(name, '<f8'))
        column = np.frombuffer(data, number, count, at).astype(number.newbyteorder('='))
        columns.append(column if count == n else np.full(n, column[0]))
        at += 8 * count
    return kind(*columns)


def join_parts(plain: Any, data: bytes) -> bytes:
    """Return the bytes of a record: a value that JSON can hold, and what follows it."""
    text = json.dumps(plain, separators=(',', ':')).encode()
    return _LENGTH.pack(len(text)) + text + data


def split_parts(data: bytes) -> tuple[Any, bytes]:
    """Return the two parts of `join_parts`; ValueError or struct.error for other bytes."""
    size, = _LENGTH.unpack_from(data)
    at = _LENGTH.size + size
    return json.loads(data[_LENGTH.size:at]), data[at:]


def _pack(record: Record) -> bytes:
    checksum = zlib.crc32(record.kind + record.data)
    return _HEAD.pack(len(record.data), checksum, record.kind) + record.data


def _write_all(descriptor: int, data: bytes, at: int) -> None:
    """Write bytes at a position, however many the system takes at once."""
    view = memoryview(data)
    while view:
        n = os.pwrite(descriptor, view, at)
        at, view = at + n, view[n:]


def is_journal(path: str | os.PathLike[str]) -> bool:
    """Tell whether a file is to be read as a journal: it begins like one, or has its name."""
    place = Path(path)
    if place.is_dir():
        return False
    if _NAMED.fullmatch(place.name):
        return True
    try:
        if not place.is_file():
            return False
        with place.open('rb') as file:
            return file.read(len(_KIND)) == _KIND
    except OSError:
        return False


def read_journal(path: Path, most_bytes: int = -1) -> JournalContents:
    """
    Return the whole records of a journal. It takes no lock and changes nothing.

    Parameters
    ----------
    path
        The file; another process may be writing it.
    most_bytes
        Read the first bytes only; by default all.

    Raises
    ------
    OSError
        If the file cannot be read.
    BagError
        If it is no journal, or one of another version.

    """
    with path.open('rb') as file:
        data = file.read(most_bytes)
    if not data.startswith(_MAGIC):
        if data.startswith(_KIND):
            version = data[len(_KIND):].partition(b'\n')[0][:20].decode('ascii', 'replace').strip()
            raise BagError(f'is a journal of version {version}, must be 3', path)
        raise BagError('is not a journal', path)
    records = [*iterate_records(io.BytesIO(data))]
    at = len(_MAGIC) + sum(_HEAD.size + len(record.data) for record in records)
    return JournalContents(records, at, len(data) - at, hashlib.sha256(data).hexdigest())


def iterate_records(file: BinaryIO) -> Iterator[Record]:
    """Yield the whole records of a journal from its beginning, up to one that was cut."""
    file.seek(len(_MAGIC))
    while len(head := file.read(_HEAD.size)) == _HEAD.size:
        size, checksum, kind = _HEAD.unpack(head)
        body = file.read(size)
        if len(body) < size or zlib.crc32(kind + body) != checksum:
            return
        yield Record(kind, body)


class Journal:
    """
    The writer of a journal.

    Parameters
    ----------
    path
        The file. Its folder must exist.
    head
        The first record of a file that is begun.
    size
        Go on after this many bytes of the file, see `JournalContents`. Without it a file is
        begun at the first `flush`, and one that was there is lost.

    Attributes
    ----------
    fault : str
        Why the last write failed; '' if it did not.
    dropped : int
        Records given up because they could not be written for too long.

    Raises
    ------
    OSError
        If the file cannot be opened, or another process has it open (BlockingIOError).

    """

    def __init__(self, path: Path, head: Record, size: int | None = None) -> None:
        self.path = path
        self._file = -1 if size is None else self._open(path)
        self._size = size or 0
        self._waiting: deque[bytes] = deque()
        self._n_waiting = 0
        self._retry_s = 0.0
        self._syncing = Syncing(_SYNC_S)
        self.fault, self.dropped = '', 0
        if size is None:
            self._add(_MAGIC + _pack(head))
        else:
            os.ftruncate(self._file, size)

    @property
    def size(self) -> int:
        """Return the number of bytes that are written."""
        return self._size

    @staticmethod
    def _open(path: Path) -> int:
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o644)
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            os.close(descriptor)
            raise
        return descriptor

    @classmethod
    def probe(cls, path: Path) -> None:
        """Raise OSError unless the file is there and no other process has it open."""
        path.stat()
        os.close(cls._open(path))

    def _add(self, data: bytes) -> None:
        self._waiting.append(data)
        self._n_waiting += len(data)

    def append(self, kind: bytes, data: bytes) -> None:
        """Append a record; `flush` writes it."""
        self._add(_pack(Record(kind, data)))
        while self._n_waiting > _MOST_WAITING and len(self._waiting) > 1:
            # The first may be the head of the file.
            at = int(self._waiting[0].startswith(_MAGIC))
            self._n_waiting -= len(self._waiting[at])
            del self._waiting[at]
            self.dropped += 1

    def flush(self, now_s: float) -> None:
        """
        Write what was appended, unless the disk refuses it; then it waits for the next time.

        Parameters
        ----------
        now_s
            The caller's steady clock, seconds.

        """
        if now_s < self._retry_s:
            return
        try:
            if self._file < 0:
                self._file = self._open(self.path)
                os.ftruncate(self._file, 0)
            if self._waiting:
                self._write(b''.join(self._waiting))
                self._waiting.clear()
                self._n_waiting = 0
            self._syncing.begin_if_due(self._file, now_s)
        except OSError as error:
            self._fail(error, now_s)
        else:
            self.fault, self._retry_s = '', 0.0

    def _write(self, data: bytes) -> None:
        try:
            _write_all(self._file, data, self._size)
        except OSError:
            with suppress(OSError):
                os.ftruncate(self._file, self._size)
            raise
        self._size += len(data)

    def _fail(self, error: OSError, now_s: float) -> None:
        self.fault, self._retry_s = error.strerror or str(error), now_s + _RETRY_S

    def replace(self, records: Iterable[Record], now_s: float) -> None:
        """
        Replace all records in one step; if that fails, the former ones stay and these wait.

        Parameters
        ----------
        records
            What the journal holds from now on.
        now_s
            The caller's steady clock, seconds.

        """
        size = 0
        draft = self.path.with_name(f'{self.path.name}.part')
        descriptor = -1
        try:
            descriptor = self._open(draft)
            os.ftruncate(descriptor, 0)
            for data in chain([_MAGIC], map(_pack, records)):
                _write_all(descriptor, data, size)
                size += len(data)
            os.fsync(descriptor)
            os.replace(draft, self.path)
        except OSError as error:
            if descriptor >= 0:
                os.close(descriptor)
                with suppress(OSError):
                    draft.unlink()
            self._fail(error, now_s)
            return
        if self._file >= 0:
            os.close(self._file)
        self._file, self._size = descriptor, size
        self._waiting.clear()
        self._n_waiting = 0
        self.fault = ''

    def close(self, *, remove: bool = False) -> None:
        """Write what waits, or remove the file: its work is done."""
        if not remove:
            self._retry_s = 0.0
            self.flush(0.0)
        with suppress(OSError):
            self._syncing.close()
        if self._file < 0:
            return
        if remove:
            with suppress(OSError):
                self.path.unlink()
        os.close(self._file)


def name_journal(journal: str, sensor: str) -> str:
    """
    Return the journal of a sensor, or of a pair of them, given that of the graph.

    Examples
    --------
    >>> name_journal('trial.journal', 'gyro1'), name_journal('trial.journal', 'gyro1.ins')
    ('trial.gyro1.journal', 'trial.gyro1.ins.journal')

    """
    path = Path(journal)
    return os.fspath(path.with_name(f'{path.stem}.{sensor}{path.suffix}'))
