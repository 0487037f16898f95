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
Messages that rosbag2 compressed one by one (``--compression-mode message``).

Each is a frame of zstd. No message in CDR begins like one, so the bytes tell, also where
metadata.yaml is lost. rosbag2 compresses all messages of a bag or none: the first one tells.
"""

from __future__ import annotations

import numpy as np
import zstandard

from heading_intercompare.core.records import Integers
from heading_intercompare.messages.byte_columns import BytesLike

__all__ = ['is_packed', 'MOST_BYTES', 'unpack_payload', 'unpack_payloads']

_MAGIC = b'\x28\xb5\x2f\xfd'

MOST_BYTES = 2**27
"""A message that claims to be larger when unpacked is left as it is."""

#: No heading, and no message of the ship's motion, is larger.
_MOST_SMALL = 2**16


def is_packed(data: BytesLike, start: Integers) -> bool:
    """Tell whether the messages at these offsets of some data are compressed one by one."""
    return bool(len(start)) and bytes(data[start[0]:start[0] + len(_MAGIC)]) == _MAGIC


def unpack_payload(data: bytes, most: int = MOST_BYTES) -> bytes | None:
    """Return a message decompressed; None if it is not a frame of zstd, or too large."""
    try:
        size = zstandard.frame_content_size(data)
        if size > most:
            return None
        return zstandard.ZstdDecompressor().decompress(data, max_output_size=most if size < 0
                                                       else size)
    except (zstandard.ZstdError, MemoryError):
        return None


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
