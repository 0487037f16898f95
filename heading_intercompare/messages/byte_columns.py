# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Bytes to columns and back: values at any offsets, single messages to chunks."""

from __future__ import annotations

from typing import Sequence

import numpy as np
from numpy.typing import DTypeLike

from heading_intercompare.core.records import Integers

__all__ = ['gather', 'join_messages', 'split_rows']


def _plain(dtype: np.dtype) -> np.dtype:
    """Return the dtype as raw bytes: numpy copies these at once, but structures by field."""
    return np.dtype(f'V{dtype.itemsize}') if dtype.names or dtype.shape else dtype


def gather(data: bytes, kind: DTypeLike, at: Integers) -> np.ndarray:
    """
    Return the values at the given byte offsets of some data, aligned or not.

    Parameters
    ----------
    data : bytes
        The bytes that hold the values.
    kind : dtype
        Type of the values, with its byte order; several in a row if it has a shape.
    at : ndarray of int64, shape (n,)
        Offset of each value; it must lie within the data.

    """
    dtype = np.dtype(kind)
    plain = _plain(dtype)
    everywhere = np.ndarray(max(len(data) - dtype.itemsize + 1, 0), plain, data, 0, (1,))
    found: np.ndarray = everywhere[at].view(dtype.base)
    return found.reshape(-1, *dtype.shape)


def join_messages(messages: Sequence[bytes]) -> tuple[bytes, Integers, Integers]:
    """Return n >= 0 messages joined, the first byte of each, and the byte after its last."""
    ends = np.cumsum([0, *map(len, messages)], dtype=np.int64)
    return b''.join(messages), ends[:-1], ends[1:]


def split_rows(rows: np.ndarray) -> list[bytes]:
    """Return the rows of a uint8 array, shape (n, size), as n messages."""
    data, size = rows.tobytes(), rows.shape[1]
    return [data[at:at + size] for at in range(0, len(data), size)]
