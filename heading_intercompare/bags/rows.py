# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Many messages of one topic, to be written at once."""

from __future__ import annotations

from dataclasses import dataclass

from mcap.opcode import Opcode
import numpy as np
from numpy.typing import ArrayLike

from .blocks import HEAD, MESSAGE_HEADS

__all__ = ['Rows']


@dataclass(frozen=True, slots=True, eq=False)
class Rows:
    """
    Many messages of one topic.

    Attributes
    ----------
    topic : str
        A topic that was added.
    data : ndarray of uint8, shape (n, size)
        One CDR message a row.
    log_time_ns : array_like of int, shape (n,)
        Nanoseconds; also the publish time unless that is given.
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
        """Return the message records of MCAP."""
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
