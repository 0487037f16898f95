# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""One input judged by an executor: where it failed, and whether last digits may differ."""

from __future__ import annotations

from importlib.metadata import version
from socket import gethostname
from threading import Lock
from typing import Any

from heading_intercompare.core.version import VERSION

from .job import Job, Judged

try:
    from threadpoolctl import threadpool_limits
except ModuleNotFoundError:
    threadpool_limits = None

# VERSION is asked for by name where this must be there to be loaded.
__all__ = ['describe_libraries', 'judge_there', 'VERSION']


class _OneThread:
    """
    Linear algebra with one thread while any task of this process is under way.

    As in the processes of `campaign`; an executor may have several tasks at once in one process,
    and then computes with as many threads as there are cores. Without threadpoolctl it stays so.
    """

    def __init__(self) -> None:
        self._lock = Lock()
        self._tasks = 0
        self._limits: Any = None

    def __enter__(self) -> None:
        with self._lock:
            if not self._tasks and threadpool_limits is not None:
                self._limits = threadpool_limits(1)
            self._tasks += 1

    def __exit__(self, *exc: object) -> None:
        with self._lock:
            self._tasks -= 1
            if not self._tasks and self._limits is not None:
                self._limits.restore_original_limits()


_ONE_THREAD = _OneThread()


def judge_there(job: Job, path: str, place: str, libraries: str) -> Judged:
    """
    Judge an input wherever this is called.

    Parameters
    ----------
    job : Job
    path : str
        What the verdict calls it.
    place : str
        Its absolute path.
    libraries : str
        `describe_libraries` of who asks; a note says if they are others here.

    """
    with _ONE_THREAD:
        judged = job.survive(path, place)
    if judged.error is not None:
        return job.unread(path, f'{judged.error} (on {gethostname()})')
    here = describe_libraries()
    if libraries != here:
        judged.notes.append(f'{path}: judged with {here} on {gethostname()}, here are '
                            f'{libraries}: last digits may differ')
    return judged


def describe_libraries() -> str:
    """Return the versions on which the last bits of figures depend."""
    return ' and '.join(f'{name} {version(name)}' for name in ('numpy', 'scipy'))
