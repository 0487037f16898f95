# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Files brought to the disk by a thread, so that a slow disk does not hold up who writes."""

from __future__ import annotations

from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from math import inf
import os
from pathlib import Path

__all__ = ['replace_file', 'Syncing']


def replace_file(target: Path, text: str) -> None:
    """Write a file anew, on the disk; nobody ever sees half of it, and a failure leaves none."""
    draft = target.with_name(f'{target.name}.part')
    try:
        with open(draft, 'w', encoding='utf-8') as file:
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
        os.replace(draft, target)
    except OSError as error:
        with suppress(OSError):
            draft.unlink()
        error.filename = error.filename or os.fspath(draft)
        raise
    folder = os.open(target.parent, os.O_RDONLY)
    try:
        os.fsync(folder)
    finally:
        os.close(folder)


def _sync(descriptor: int) -> None:
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


class Syncing:
    """
    One sync after the other, at most one an interval.

    Parameters
    ----------
    interval_s : float
        Time between the beginnings of two, seconds.

    """

    def __init__(self, interval_s: float) -> None:
        self._interval_s = interval_s
        self._worker = ThreadPoolExecutor(1)
        self._running: Future | None = None
        self._last_s = -inf

    def begin_if_due(self, descriptor: int, now_s: float) -> None:
        """
        Begin to bring a file to the disk if it is time and the last one is over.

        Parameters
        ----------
        descriptor : int
            Of the open file, which may be closed meanwhile.
        now_s : float
            The caller's steady clock, seconds.

        Raises
        ------
        OSError
            If the last one failed.

        """
        if self._running is not None:
            if not self._running.done():
                return
            done, self._running = self._running, None
            done.result()
        if now_s - self._last_s >= self._interval_s:
            self._last_s = now_s
            self._running = self._worker.submit(_sync, os.dup(descriptor))

    def close(self) -> None:
        """Wait for the last one."""
        self._worker.shutdown()
