# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Pages of a long run in a temporary file instead of in memory."""

from __future__ import annotations

from functools import partial
import os
import tempfile
from typing import Callable

import numpy as np

__all__ = ['Spool']

#: Disk by custom; the usual place of temporary files may be memory itself.
_ON_DISK = '/var/tmp'


class Spool:
    """
    A temporary file for pages of numbers; it goes with the last page that anybody holds.

    Parameters
    ----------
    on_fault : callable
        Is told why a page stays in memory, when it cannot be written.
    folder : str, optional
        Where the file is; by default /var/tmp if that is there and can be written.

    """

    def __init__(self, on_fault: Callable[[str], None] = lambda why: None,
                 folder: str | None = None) -> None:
        self._on_fault = on_fault
        self._folder = folder or (_ON_DISK if os.access(_ON_DISK, os.W_OK) else None)
        self._file = None
        self._size = 0

    def keep(self, page: np.ndarray) -> Callable[[], np.ndarray]:
        """Put a page away; return what gives it again. A page that cannot be written stays."""
        try:
            if self._file is None:
                self._file = tempfile.TemporaryFile(buffering=0, dir=self._folder)
            at, data = self._size, memoryview(page).cast('B')
            while data:
                data = data[os.pwrite(self._file.fileno(), data, at + page.nbytes - len(data)):]
        except OSError as error:
            self._on_fault(error.strerror or str(error))
            return lambda: page
        self._size += page.nbytes
        return partial(self._read, at, page.dtype, len(page))

    def _read(self, at: int, dtype: np.dtype, count: int) -> np.ndarray:
        page = np.empty(count, dtype)
        if os.preadv(self._file.fileno(), [page], at) < page.nbytes:
            raise OSError(f'temporary file in {self._folder} ends early')
        return page
