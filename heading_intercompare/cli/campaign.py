# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Many inputs judged at once, here or on a cluster; a bad one does not stop the others."""

from __future__ import annotations

from argparse import ArgumentTypeError
from concurrent.futures import as_completed, Executor, Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from multiprocessing import get_context
from multiprocessing.connection import Connection, wait
import os
from pathlib import Path
import signal
from threading import Thread
from typing import Callable, ContextManager, Iterable, Iterator, Protocol, Sequence

from heading_intercompare.app.job import Job, Judged
from heading_intercompare.app.run_table import RunTable
from heading_intercompare.cli.terminal.progress import Progress
from heading_intercompare.core.records import Pairs
from heading_intercompare.core.settings import Settings

__all__ = ['count_cores', 'judge_inputs', 'MOST_READERS', 'positive']

#: Together smaller inputs are judged here: to start processes would take longer.
_WORTH_BYTES = 100_000_000
#: More processes would wait for the one that judges what they read.
MOST_READERS = 4
#: Sums of a linear algebra library with several threads depend on their number in the last bits;
#: and where all cores are busy its threads only wait for each other.
_ONE_THREAD = ('OPENBLAS_NUM_THREADS', 'OMP_NUM_THREADS', 'MKL_NUM_THREADS')

_DIED = 'the process that judged it died (out of memory?)'


class _Workers(Protocol):
    """Who judges several inputs at once: processes of this machine, or a cluster."""

    def open(self) -> ContextManager[Executor]:
        """Have them ready; at the end of the context nobody works any more."""

    def task(self, job: Job, path: str) -> Callable[[], Judged]:
        """Return what one of them has to do with an input."""

    def completed(self, futures: Iterable[Future]) -> Iterator[Future]:
        """Yield what has been submitted, each when it is done."""

    def result(self, job: Job, path: str, future: Future) -> Judged:
        """Return what came of an input, after the context; also if the worker died of it."""


@dataclass(frozen=True, slots=True)
class _Processes:
    """So many processes of this machine."""

    jobs: int

    def open(self) -> ContextManager[Executor]:
        return _pool(self.jobs)

    def task(self, job: Job, path: str) -> Callable[[], Judged]:
        return partial(job.survive, path)

    def completed(self, futures: Iterable[Future]) -> Iterator[Future]:
        return as_completed(futures)

    def result(self, job: Job, path: str, future: Future) -> Judged:
        return _result(job, path, future)


def positive(text: str) -> int:
    """Return a number of processes from the command line."""
    if not text.isascii() or not text.isdigit() or not int(text):
        raise ArgumentTypeError(f'{text!r} is not a whole number above 0')
    return int(text)


def count_cores() -> int:
    """Return how many processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, 'sched_getaffinity') else (
        os.cpu_count() or 1)


def judge_inputs(paths: Sequence[str], settings: Settings, table: RunTable | None, *,
                 takers: Iterable[Callable[[Pairs], None]] = (), sketched: bool = False,
                 jobs: int | None = None, dask: str | None = None,
                 quiet: bool = False) -> list[Judged]:
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
        Each is given the pairs, chunk by chunk; for one input only, and not on a cluster.
    sketched : bool
        Collect what the graphs of a report need.
    jobs : int, optional
        Processes; by default one for each core, or none where the inputs are small. A large bag
        alone is decoded by several, but judged by one.
    dask : str, optional
        Judge on the workers of this Dask scheduler: its address, or its file. It takes the inputs
        by their absolute paths, however small or few they are.
    quiet : bool
        Show no progress.

    Returns
    -------
    list of Judged
        In the order of the paths, the same whatever `jobs` and `dask` are. What has the data of an
        earlier one is not judged again: its description says in `same_as` which that is.

    Raises
    ------
    OSError, BagError
        If there is one input, and it cannot be read.
    ValueError
        If none of several can be read, or the cluster cannot be used.

    """
    job = Job(settings, table, sketched)
    if len(paths) == 1 and dask is None:
        with Progress(paths[0], quiet) as progress:
            helpers = min(jobs or count_cores(), MOST_READERS) - 1
            return [job.judge(paths[0], takers, progress.show, helpers=helpers)]
    with Progress(f'{len(paths)} inputs', quiet) as progress:
        if dask is not None:
            judged = _parallel(job, paths, _cluster(dask), progress)
        elif (jobs or 0) > 1 or jobs is None and sum(map(_size, paths)) >= _WORTH_BYTES:
            workers = _Processes(min(len(paths), jobs or count_cores()))
            judged = _parallel(job, paths, workers, progress)
        else:
            judged = _serial(job, paths, progress)
    if all(each.error for each in judged):
        several = f'none of the {len(paths)} inputs can be read: ' if len(paths) > 1 else ''
        raise ValueError(f'{several}{judged[0].path}: {judged[0].error}')
    return _once(judged)


def _once(judged: Sequence[Judged]) -> list[Judged]:
    """Return the same without the runs of inputs that have the data of an earlier one."""
    first: dict[str | None, Judged] = {}
    found = []
    for each in judged:
        digest = each.description['sha256']
        if digest is None or first.setdefault(digest, each) is each:
            found.append(each)
            continue
        same = first[digest].path
        found.append(Judged(
            each.path, [], [f'{each.path}: not judged again: it has the data of {same}'],
            {**each.description, 'same_as': same}, None))
    return found


def _cluster(address: str) -> _Workers:
    """Return the workers of a Dask cluster, whose library need not be installed."""
    try:
        from heading_intercompare.app.cluster import Cluster
    except ModuleNotFoundError as error:
        raise ValueError(f'--dask {address}: no module {error.name}: install '
                         'heading_intercompare[dask]') from error
    return Cluster(address)


def _serial(job: Job, paths: Sequence[str], progress: Progress) -> list[Judged]:
    judged = []
    for done, path in enumerate(paths):
        progress.show(f'{done} done, {path}')
        judged.append(job.survive(path))
    return judged


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


def _parallel(job: Job, paths: Sequence[str], workers: _Workers,
              progress: Progress) -> list[Judged]:
    """Judge in other processes, the largest inputs first, so that none is left to the end."""
    order = sorted(range(len(paths)), key=lambda at: -_size(paths[at]))
    progress.show('0 done')
    with workers.open() as pool:
        futures = {pool.submit(workers.task(job, paths[at])): at for at in order}
        for done, future in enumerate(workers.completed(futures), 1):
            progress.show(f'{done} done, {paths[futures[future]]}')
    found = {at: workers.result(job, paths[at], future) for future, at in futures.items()}
    return [found[at] for at in range(len(paths))]


def _result(job: Job, path: str, future: Future) -> Judged:
    """Return what a process said; if one died, which takes its fellows along, try this alone."""
    try:
        return future.result()
    except BrokenProcessPool:
        pass
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
