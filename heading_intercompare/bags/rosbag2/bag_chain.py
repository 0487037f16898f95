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

"""The hash chain through the first chunks of a bag at hand."""

from __future__ import annotations

from itertools import islice
import os
from pathlib import Path
from typing import Iterator

from heading_intercompare.bags.mcap.chunk_chain import ChunkChain, ChunkHash, hash_chunks
from heading_intercompare.bags.packed_files import PlainFile

from .bag_files import find_files


def read_chain(path: str | os.PathLike[str], most: int) -> ChunkChain:
    """
    Return the chain through the first `most` chunks of a bag, or through all if it has fewer.

    Parameters
    ----------
    path
        An MCAP file or a rosbag2 directory.
    most
        Number of chunks, over all files in order.

    Raises
    ------
    OSError
        If a file cannot be read.
    BagError
        If a directory holds no MCAP file, or its list of files is damaged.

    """
    chain = ChunkChain()
    for chunk in islice(_hash_bag(Path(path)), most):
        chain = chain.after(chunk)
    return chain


def _hash_bag(path: Path) -> Iterator[ChunkHash]:
    """Yield the SHA-256 of each chunk of all files."""
    for part in find_files(path).paths:
        file = PlainFile(part)
        yield from hash_chunks(file.place)
