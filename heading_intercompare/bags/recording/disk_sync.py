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

"""A thread that syncs files to the disk, so that a slow disk does not hold up the writer."""

from __future__ import annotations

from collections import deque
from concurrent.futures import Future, ThreadPoolExecutor
from math import inf
import os
from pathlib import Path

from heading_intercompare.replaced_file import replace_file


def _sync(descriptor: int) -> None:
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


class Syncing:
    """
    Syncs files to the disk in a thread, one after the other.

    Parameters
    ----------
    interval_s
        Least time from the start of one sync by `begin_if_due` to the next, seconds.

    Attributes
    ----------
    problem
        Why the last text could not be written; None if it could.

    """

    def __init__(self, interval_s: float) -> None:
        self._interval_s = interval_s
        self._worker = ThreadPoolExecutor(1)
        self._running: deque[Future[None]] = deque()
        self._last_s = -inf
        self._texts: dict[Path, str] = {}
        self.problem: OSError | None = None

    def begin_if_due(self, descriptor: int, now_s: float) -> None:
        """
        Start to sync a file if the interval has passed and earlier syncs have finished.

        Parameters
        ----------
        descriptor
            Descriptor of the open file, which may be closed meanwhile.
        now_s
            The caller's steady clock, seconds.

        Raises
        ------
        OSError
            If an earlier sync failed.

        """
        while self._running and self._running[0].done():
            self._running.popleft().result()
        if not self._running and now_s - self._last_s >= self._interval_s:
            self._last_s = now_s
            self.begin(descriptor)

    def begin(self, descriptor: int) -> None:
        """Start to sync a file; it may be closed meanwhile."""
        self._running.append(self._worker.submit(_sync, os.dup(descriptor)))

    def replace(self, target: Path, text: str) -> None:
        """Start to replace a file; if a later text arrives before its turn, only that is used."""
        self._texts[target] = text
        self._worker.submit(self._replace, target)

    def _replace(self, target: Path) -> None:
        text = self._texts.pop(target, None)
        if text is None:
            return
        try:
            replace_file(target, text)
            self.problem = None
        except OSError as error:
            self.problem = error

    def close(self) -> None:
        """Wait until everything has finished."""
        self._worker.shutdown()
