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
Messages and files that rosbag2 compressed, one by one or whole.

Each is one frame of zstd, or several, of which readers skip some. No message in CDR begins like
one, so the bytes tell, also where metadata.yaml is lost. rosbag2 compresses all messages of a bag
or none: the first one tells.
"""

from __future__ import annotations

from io import FileIO
from pathlib import Path
import re
import resource
import shutil
from tempfile import gettempdir, TemporaryFile
import weakref

import numpy as np
import zstandard

from heading_intercompare.core.records import Integers
from heading_intercompare.messages.byte_columns import BytesLike
from heading_intercompare.special_files import refuse_special

from .errors import BagError

#: How a frame of zstd begins, and one that readers skip.
_PLAIN = b'\x28\xb5\x2f\xfd'
_FRAME = re.compile(re.escape(_PLAIN) + rb'|[\x50-\x5f]\x2a\x4d\x18')
_FRAME_BYTES = 4
#: Compressed bytes at once of a message in several frames: they unpack to some megabytes at most.
_PACKED_BYTES = 2**8

MOST_MESSAGE_BYTES = 2**27
"""A message that claims to be larger when unpacked is left as it is."""

#: No heading, and no message of the ship's motion, is larger.
_MOST_SMALL = 2**16


def is_packed(data: BytesLike, start: Integers) -> bool:
    """Tell whether the messages at these offsets of some data are compressed one by one."""
    return bool(len(start)) and _FRAME.match(
        bytes(data[start[0]:start[0] + _FRAME_BYTES])) is not None


def unpack_payload(data: bytes, most: int = MOST_MESSAGE_BYTES) -> bytes | None:
    """Return a message decompressed; None if it is not of frames of zstd, or too large."""
    try:
        # Such bytes within a frame are rare, and lead to the same message.
        if _FRAME.search(data, 1) or not data.startswith(_PLAIN):
            return _unpack_frames(data, most)
        size = zstandard.frame_content_size(data)
        if size > most:
            return None
        return zstandard.ZstdDecompressor().decompress(data, max_output_size=most if size < 0
                                                       else size)
    except (zstandard.ZstdError, MemoryError):
        return None


def _unpack_frames(data: bytes, most: int) -> bytes | None:
    """Return the content of frames of zstd; None if there is none, one is cut, or too large."""
    content, rest = bytearray(), data
    if not _FRAME.match(data):
        return None
    while _FRAME.match(rest):
        frame = zstandard.ZstdDecompressor().decompressobj()
        for at in range(0, len(rest), _PACKED_BYTES):
            content += frame.decompress(rest[at:at + _PACKED_BYTES])
            if len(content) > most:
                return None
            if frame.eof:
                break
        else:
            return None
        rest = frame.unused_data + rest[at + _PACKED_BYTES:]
    return bytes(content)


def unpack_payloads(data: BytesLike, start: Integers,
                    stop: Integers) -> tuple[bytes, Integers, Integers]:
    """
    Return small messages decompressed.

    Parameters
    ----------
    data : bytes-like
        The bytes that hold them.
    start, stop : ndarray of int64, shape (n,)
        First byte of each message, and the byte after its last.

    Returns
    -------
    data : bytes
        The messages, one after the other. One that cannot be unpacked, or that has more than 64
        KiB, is empty.
    start, stop : ndarray of int64, shape (n,)
        As before, in these bytes.

    """
    payloads = [unpack_payload(bytes(data[lo:hi]), _MOST_SMALL) or b''
                for lo, hi in zip(start.tolist(), stop.tolist())]
    ends = np.cumsum([0, *map(len, payloads)], dtype=np.int64)
    return b''.join(payloads), ends[:-1], ends[1:]


PACKED = '.zstd'
"""What rosbag2 appends to the name of a file that it compressed."""

_PIECE_BYTES = 2**20
#: A file may unpack to this many bytes, or to this many times its own size if that is more.
_MOST_FILE_BYTES, _MOST_TIMES = 2**30, 200
#: This much of the disk is left free.
_FREE_BYTES = 2**28
#: The open files of this process, each by its number.
_DESCRIPTORS = Path('/proc/self/fd')


def plain_name(name: str) -> str:
    """Return the name of a file when it is unpacked."""
    return name.removesuffix(PACKED)


class PlainFile:
    """
    A file of a bag as it is read: the file itself, or what rosbag2 compressed whole, unpacked.

    What is unpacked has no name on the disk. So nothing of it is left however the program ends.

    Parameters
    ----------
    path
        The file.

    Attributes
    ----------
    source
        The file on the disk.
    path
        The same without the ending of the compression, for messages about what is in it.
    place
        Where to read it, in this process and those that it forks, as long as this object lasts.
    problem : str or None
        Why only the beginning could be unpacked; None if all was.

    Raises
    ------
    OSError
        If it is no file or cannot be read, or the temporary folder cannot be written.
    BagError
        If it unpacks to more than 200 times its size and more than 1 GiB, or to more than the
        disk can hold.

    """

    def __init__(self, path: Path) -> None:
        refuse_special(path)
        self.source = self.path = self.place = path
        self.problem: str | None = None
        if path.name.endswith(PACKED):
            self.path = path.with_name(plain_name(path.name))
            file = _make_nameless()
            weakref.finalize(self, file.close)
            self.place = _DESCRIPTORS / str(file.fileno())
            self.problem = _unpack(path, file)


def _make_nameless() -> FileIO:
    """Return a new file without a name; a bag may have more files than a process may open."""
    file: FileIO = TemporaryFile(buffering=0)
    may_open, most = resource.getrlimit(resource.RLIMIT_NOFILE)
    if file.fileno() > may_open // 2:
        resource.setrlimit(resource.RLIMIT_NOFILE, (most, most))
    return file


def _unpack(path: Path, file: FileIO) -> str | None:
    """Unpack a file piece by piece; return why only the beginning could be, None if all was."""
    most = max(_MOST_FILE_BYTES, _MOST_TIMES * path.stat().st_size)
    size = 0
    with path.open('rb') as packed:
        reader = zstandard.ZstdDecompressor().stream_reader(packed, read_across_frames=True)
        while True:
            try:
                piece = reader.read(_PIECE_BYTES)
            except zstandard.ZstdError as error:
                return f'is damaged: {error}; the data before that is read'
            if not piece:
                return None if size else 'is empty or cut: nothing of it can be unpacked'
            size += len(piece)
            if size > most:
                raise BagError(f'unpacks to more than {most} bytes; no recording does', path)
            folder = gettempdir()
            if shutil.disk_usage(folder).free < _FREE_BYTES + len(piece):
                raise BagError(f'does not fit into {folder} when it is unpacked; set TMPDIR to a '
                               'folder on a larger disk', path)
            # A file without a buffer may take less than it is given.
            view = memoryview(piece)
            while view:
                view = view[file.write(view):]
