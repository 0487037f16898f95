# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Many inputs judged at once, here or by any executor; a bad one does not stop the others."""

from __future__ import annotations

from concurrent.futures import (
    as_completed,
    BrokenExecutor,
    CancelledError,
    Executor,
    Future,
    ProcessPoolExecutor,
)
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from multiprocessing import get_context
from multiprocessing.connection import Connection, wait
import os
from pathlib import Path
import signal
from threading import Thread
from typing import Callable, Iterable, Iterator, Sequence

from heading_intercompare.core.records import Pairs
from heading_intercompare.core.settings import Settings

from .job import Job, Judged
from .remote_task import describe_libraries, judge_there
from .run_table import RunTable

__all__ = ['count_cores', 'judge_inputs', 'MOST_READERS']

#: Together smaller inputs are judged here: to start processes would take longer.
_WORTH_BYTES = 100_000_000
#: More processes would wait for the one that judges what they read.
MOST_READERS = 4
#: Sums of a linear algebra library with several threads depend on their number in the last bits;
#: and where all cores are busy its threads only wait for each other.
_ONE_THREAD = ('OPENBLAS_NUM_THREADS', 'OMP_NUM_THREADS', 'MKL_NUM_THREADS')

_DIED = 'the process that judged it died (out of memory?)'
_GIVEN_UP = 'the executor gave it up'


def count_cores() -> int:
    """Return how many processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, 'sched_getaffinity') else (
        os.cpu_count() or 1)


def judge_inputs(paths: Sequence[str], settings: Settings, table: RunTable | None = None, *,
                 takers: Iterable[Callable[[Pairs], None]] = (), sketched: bool = False,
                 jobs: int | None = None, executor: Executor | None = None,
                 progress: Callable[[str], None] = lambda text: None) -> list[Judged]:
    """
    Judge inputs, several at once.

    Parameters
    ----------
    paths : sequence of str
        The inputs.
    settings : Settings
    table : sequence of (start_ns, stop_ns, source), optional
        Runs; those with a source are for the input of that name only.
    takers : iterable of callable
        Each is given the pairs, chunk by chunk; for one input only, and not with an executor.
    sketched : bool
        Collect what the graphs of a report need.
    jobs : int, optional
        Processes; by default one for each core, or none where the inputs are small. A large bag
        alone is decoded by several, but judged by one. Not used with an executor.
    executor : concurrent.futures.Executor, optional
        Who judges instead, in threads, in processes or on other computers, which see the same
        paths. It is given the inputs by their absolute paths, however small or few they are.
    progress : callable
        Told what has been done.

    Returns
    -------
    list of Judged
        In the order of the paths, the same whoever judges. What has the data of an earlier one is
        not judged again: its description says in `same_as` which that is.

    Raises
    ------
    OSError, BagError
        If there is one input, and it cannot be read.
    ValueError
        If none of several can be read, or none by the executor; if takers cannot be served.

    Notes
    -----
    An input that the executor could not have judged is named like one that cannot be read: if the
    future is cancelled or ends with a `BrokenExecutor`, whose words are taken. What a broken pool
    of processes takes along is tried once more, alone. Any other exception goes up.

    """
    takers = list(takers)
    if takers and (executor is not None or len(paths) > 1):
        raise ValueError('takers: pairs are given of one input alone, and by no executor')
    job = Job(settings, table, sketched)
    if executor is None and len(paths) == 1:
        helpers = min(jobs or count_cores(), MOST_READERS) - 1
        return [job.judge(paths[0], takers, progress, helpers=helpers)]
    if executor is not None:
        judged = _judge_elsewhere(job, paths, executor, progress)
    elif (jobs or 0) > 1 or jobs is None and sum(map(_size, paths)) >= _WORTH_BYTES:
        judged = _judge_in_processes(job, paths, min(len(paths), jobs or count_cores()), progress)
    else:
        judged = _judge_in_turn(job, paths, progress)
    if all(each.error for each in judged):
        several = f'none of the {len(paths)} inputs can be read: ' if len(paths) > 1 else ''
        raise ValueError(f'{several}{judged[0].path}: {judged[0].error}')
    return _once(judged)


def _once(judged: Sequence[Judged]) -> list[Judged]:
    """Return the same without the runs of inputs that have the data of an earlier one."""
    first: dict[str | None, Judged] = {}
    found = []
    for each in judged:
        digest = each.description.sha256
        if digest is None or first.setdefault(digest, each) is each:
            found.append(each)
            continue
        same = first[digest].path
        found.append(Judged(
            each.path, [], [f'{each.path}: not judged again: it has the data of {same}'],
            replace(each.description, same_as=same)))
    return found


def _judge_in_turn(job: Job, paths: Sequence[str],
                   progress: Callable[[str], None]) -> list[Judged]:
    judged = []
    for done, path in enumerate(paths):
        progress(f'{done} of {len(paths)} done, {path}')
        judged.append(job.survive(path))
    return judged


def _judge_in_processes(job: Job, paths: Sequence[str], jobs: int,
                        progress: Callable[[str], None]) -> list[Judged]:
    with _pool(jobs) as pool:
        futures = _complete(pool, [partial(job.survive, path) for path in paths], paths, progress)
    return [_result(job, path, future) for path, future in zip(paths, futures)]


def _judge_elsewhere(job: Job, paths: Sequence[str], executor: Executor,
                     progress: Callable[[str], None]) -> list[Judged]:
    here = describe_libraries()
    # The working directory of another process is another.
    tasks = [partial(judge_there, job, path, os.path.abspath(path), here) for path in paths]
    futures = _complete(executor, tasks, paths, progress)
    return [_result(job, path, future) for path, future in zip(paths, futures)]


@contextmanager
def _pool(jobs: int) -> Iterator[ProcessPoolExecutor]:
    """Give processes with one thread each for linear algebra; none outlives the context."""
    unset = [name for name in _ONE_THREAD if name not in os.environ]
    os.environ.update(dict.fromkeys(unset, '1'))
    # Spawned, not forked: threads of this process would be lost in the copy.
    context = get_context('spawn')
    theirs, ours = context.Pipe(duplex=False)
    try:
        # Our end is closed first: what is not done then, after Ctrl-C, is not waited for.
        with theirs, ProcessPoolExecutor(jobs, context, _begin, (theirs,)) as pool, ours:
            yield pool
    finally:
        for name in unset:
            del os.environ[name]


def _begin(ended: Connection) -> None:
    """Have this process end at Ctrl-C, and when the other end of a pipe is closed or gone."""
    def watch() -> None:
        wait([ended])
        os._exit(1)

    signal.signal(signal.SIGINT, signal.SIG_DFL)
    Thread(target=watch, daemon=True).start()


def _complete(executor: Executor, tasks: Sequence[Callable[[], Judged]], paths: Sequence[str],
              progress: Callable[[str], None]) -> list[Future[Judged]]:
    """Have tasks done, those of the largest inputs first, so that none is left to the end."""
    futures: dict[Future[Judged], int] = {}
    progress(f'0 of {len(paths)} done')
    try:
        for at in sorted(range(len(paths)), key=lambda at: -_size(paths[at])):
            futures[executor.submit(tasks[at])] = at
        for done, future in enumerate(as_completed(futures), 1):
            progress(f'{done} of {len(paths)} done, {paths[futures[future]]}')
    finally:
        for future in futures:
            future.cancel()
    return sorted(futures, key=futures.__getitem__)


def _result(job: Job, path: str, future: Future[Judged]) -> Judged:
    """Return what came of an input; if a process died, which takes others along, try it alone."""
    try:
        return future.result()
    except BrokenProcessPool:
        pass
    except BrokenExecutor as error:
        return job.unread(path, str(error) or _GIVEN_UP)
    except CancelledError:
        return job.unread(path, _GIVEN_UP)
    try:
        with _pool(1) as pool:
            return pool.submit(job.survive, path).result()
    except BrokenProcessPool:
        return job.unread(path, _DIED)


def _size(path: str) -> int:
    """Return how much there is to read; nothing if it is not there."""
    place = Path(path)
    try:
        files = place.iterdir() if place.is_dir() else [place]
        return sum(file.stat().st_size for file in files)
    except OSError:
        return 0
