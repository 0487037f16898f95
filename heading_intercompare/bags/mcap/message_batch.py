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

"""Batches of messages to write at once."""

from __future__ import annotations

from dataclasses import dataclass

from mcap.opcode import Opcode
import numpy as np
from numpy.typing import ArrayLike

from heading_intercompare.core.records import Integers
from heading_intercompare.messages.byte_columns import BytesLike

from .message_blocks import HEAD, MESSAGE_HEADS

__all__ = ['Records', 'Rows']


@dataclass(frozen=True, slots=True, eq=False)
class Rows:
    """
    Many messages of one topic.

    Attributes
    ----------
    topic : str
        A topic that was added.
    data : ndarray of uint8, shape (n, size)
        One CDR message per row.
    log_time_ns : array_like of int, shape (n,)
        Nanoseconds; also the publish time, unless one is given.
    publish_time_ns : array_like of int, shape (n,), optional
        Nanoseconds.
    sequence : array_like of int, shape (n,) or scalar
        Sequence numbers.

    """

    topic: str
    data: np.ndarray
    log_time_ns: ArrayLike
    publish_time_ns: ArrayLike | None = None
    sequence: ArrayLike = 0

    def records(self, channel: int) -> list[bytes]:
        """Return the messages as MCAP records."""
        count, size = self.data.shape
        log = np.asarray(self.log_time_ns)
        head = np.empty(count, MESSAGE_HEADS)
        head['opcode'], head['channel'] = Opcode.MESSAGE, channel
        head['length'] = head.itemsize - HEAD.size + size
        head['sequence'], head['log_time'] = self.sequence, log
        head['publish_time'] = log if self.publish_time_ns is None else self.publish_time_ns
        records = np.empty((count, head.itemsize + size), np.uint8)
        records[:, :head.itemsize] = head.view(np.uint8).reshape(count, head.itemsize)
        records[:, head.itemsize:] = self.data
        return records.view(f'V{records.shape[1]}').ravel().tolist()


class Records:
    """
    Message records within some data, in the order to write them.

    Parameters
    ----------
    data : bytes-like
        The bytes that hold the records.
    start, stop : ndarray of int64, shape (n,)
        First byte of each record, and the byte after its last; rising, without overlap.
    channel, log_time_ns : ndarray of int, shape (n,)
        Channel and log time of each record, as they are in it.

    Attributes
    ----------
    ends : ndarray of int64, shape (n,)
        Where each record ends when they are written without gaps.

    """

    def __init__(self, data: BytesLike, start: Integers, stop: Integers, channel: Integers,
                 log_time_ns: Integers) -> None:
        self.channel, self.log_time_ns = channel, log_time_ns
        self.ends = np.cumsum(stop - start)
        self._data, self._start, self._stop = memoryview(data), start, stop
        self._breaks = np.flatnonzero(start[1:] != stop[:-1]) + 1

    def __len__(self) -> int:
        return len(self.ends)

    def piece(self, lo: int, hi: int) -> bytes:
        """Return the records `lo` to `hi`, `hi` excluded, without gaps."""
        first = np.searchsorted(self._breaks, lo, 'right')
        edges = [lo, *self._breaks[first:np.searchsorted(self._breaks, hi)].tolist(), hi]
        return b''.join([self._data[self._start[a]:self._stop[b - 1]]
                         for a, b in zip(edges[:-1], edges[1:])])
