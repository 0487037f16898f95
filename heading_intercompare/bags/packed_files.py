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

"""Files that rosbag2 compressed whole (``--compression-mode file``): ``bag_0.mcap.zstd``."""

from __future__ import annotations

from pathlib import Path
import shutil

import zstandard

from .errors import BagError

__all__ = ['PACKED', 'plain_name', 'unpack_file']

PACKED = '.zstd'
"""What rosbag2 appends to the name of a file that it compressed."""

_PIECE_BYTES = 2**20
#: A file may unpack to this many bytes, or to this many times its own size if that is more.
_MOST_BYTES, _MOST_TIMES = 2**30, 200
#: This much of the disk is left free.
_FREE_BYTES = 2**28


def plain_name(name: str) -> str:
    """Return the name of a file when it is unpacked."""
    return name.removesuffix(PACKED)


def unpack_file(path: Path, folder: Path) -> tuple[Path, str | None]:
    """
    Unpack a file into a folder, piece by piece; memory stays that of a piece.

    Returns
    -------
    place : Path
        The unpacked file.
    problem : str or None
        Why only the beginning could be unpacked; None if all was.

    Raises
    ------
    OSError
        If the file cannot be read, or the folder cannot be written.
    BagError
        If it unpacks to more than 200 times its size and more than 1 GiB, or to more than the
        disk can hold.

    """
    place = folder / plain_name(path.name)
    most = max(_MOST_BYTES, _MOST_TIMES * path.stat().st_size)
    size = 0
    with path.open('rb') as packed, place.open('wb') as file:
        reader = zstandard.ZstdDecompressor().stream_reader(packed, read_across_frames=True)
        while True:
            try:
                piece = reader.read(_PIECE_BYTES)
            except zstandard.ZstdError as error:
                return place, f'{path.name} is damaged: {error}; the data before that is read'
            if not piece:
                return place, None if size else (f'{path.name} is empty or cut: nothing of it can '
                                                 'be unpacked')
            size += len(piece)
            if size > most:
                raise BagError(f'unpacks to more than {most} bytes; no recording does', path)
            if shutil.disk_usage(folder).free < _FREE_BYTES + len(piece):
                raise BagError(f'does not fit into {folder} when it is unpacked; set TMPDIR to a '
                               'folder on a larger disk', path)
            file.write(piece)
