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

"""Pages of a long run, kept in a temporary file instead of in memory."""

from __future__ import annotations

from functools import partial
from io import FileIO
import os
import tempfile
from typing import Callable

import numpy as np

#: Usually on disk; the default folder of temporary files may itself be in memory.
_ON_DISK = '/var/tmp'


class Spool:
    """
    A temporary file for pages of numbers; it lives as long as the last page that is in use.

    Parameters
    ----------
    on_fault
        Called with the reason when a page cannot be written and stays in memory.
    folder
        Folder of the file; by default /var/tmp if that is writable.

    """

    def __init__(self, on_fault: Callable[[str], None] = lambda why: None,
                 folder: str | None = None) -> None:
        self._on_fault = on_fault
        self._folder = folder or (_ON_DISK if os.access(_ON_DISK, os.W_OK) else None)
        self._file: FileIO | None = None
        self._size = 0

    def keep(self, page: np.ndarray) -> Callable[[], np.ndarray]:
        """Store a page; return a function that reads it back. It stays in memory if that fails."""
        try:
            if self._file is None:
                self._file = tempfile.TemporaryFile(buffering=0, dir=self._folder)
            at, data = self._size, page.data.cast('B')
            while data:
                data = data[os.pwrite(self._file.fileno(), data, at + page.nbytes - len(data)):]
        except OSError as error:
            self._on_fault(error.strerror or str(error))
            return lambda: page
        self._size += page.nbytes
        return partial(self._read, at, page.dtype, len(page))

    def _read(self, at: int, dtype: np.dtype, count: int) -> np.ndarray:
        page = np.empty(count, dtype)
        assert self._file is not None
        if os.preadv(self._file.fileno(), [page.data], at) < page.nbytes:
            raise OSError(f'temporary file in {self._folder} ends early')
        return page
