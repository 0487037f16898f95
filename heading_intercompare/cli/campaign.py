# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Many inputs judged at once, one process a core; a bad one does not stop the others."""

from __future__ import annotations

from argparse import ArgumentTypeError
from concurrent.futures import as_completed, Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from multiprocessing import get_context
import os
from pathlib import Path
import signal
from typing import Any, Callable, Iterable, Iterator, Mapping, Sequence

from heading_intercompare.bags.errors import BagError
from heading_intercompare.cli.inputs import analyze_input, describe, RunTable
from heading_intercompare.cli.progress import Progress
from heading_intercompare.core.judge import RunResult
from heading_intercompare.core.outcome import Outcome, worst
from heading_intercompare.core.records import Pairs
from heading_intercompare.core.settings import Settings
from heading_intercompare.report import SeriesSketch

__all__ = ['capped', 'cores', 'judge_inputs', 'Judged', 'positive']

#: Together smaller inputs are judged here: to start processes would take longer.
_WORTH_BYTES = 100_000_000
#: Sums of a linear algebra library with several threads depend on their number in the last bits;
#: and where all cores are busy its threads only wait for each other.
_ONE_THREAD = ('OPENBLAS_NUM_THREADS', 'OMP_NUM_THREADS', 'MKL_NUM_THREADS')

_DIED = 'the process that judged it died (out of memory?)'


@dataclass(frozen=True, slots=True)
class Judged:
    """
    What came of one input.

    Attributes
    ----------
    path : str
        As it was given.
    results : list of RunResult
        Its runs.
    notes : list of str
        What the user should know of it.
    description : dict
        Its entry in the verdict; with `error` if it could not be read.
    sketch : SeriesSketch or None
        For the graphs of a report, if asked for.

    """

    path: str
    results: list[RunResult]
    notes: list[str]
    description: dict[str, Any]
    sketch: SeriesSketch | None

    @property
    def error(self) -> str | None:
        """Why it could not be read."""
        return self.description.get('error')


@dataclass(frozen=True, slots=True)
class _Job:
    """What is the same for all inputs; goes to the other processes."""

    settings: Settings
    table: RunTable | None
    sketched: bool

    def judge(self, path: str, takers: Iterable[Callable[[Pairs], None]] = (),
              progress: Callable[[str], None] = lambda text: None) -> Judged:
        """Judge one input; OSError and BagError if it cannot be read."""
        takers = list(takers)
        sketch = SeriesSketch(path) if self.sketched else None
        if sketch is not None:
            takers.append(partial(sketch.update, settings=self.settings))
        results, notes = analyze_input(path, self.settings, self.table, takers, progress)
        return Judged(path, results, notes, describe(path, self.settings), sketch)

    def survive(self, path: str) -> Judged:
        """Judge one input among others; one that cannot be read says why."""
        try:
            return self.judge(path)
        except OSError as error:
            return self.unread(path, error.strerror or str(error))
        except BagError as error:
            return self.unread(path, str(error).removeprefix(f'{path}: '))

    def unread(self, path: str, why: str) -> Judged:
        """Return what there is to say of an input that could not be read."""
        why = ' '.join(why.split())
        bag = Path(path).suffix != '.csv'
        return Judged(path, [], [f'{path}: not judged: {why}'],
                      {'path': path, 'sha256': None,
                       'ts_topic': self.settings.ts_topic if bag else None,
                       'rs_topic': self.settings.rs_topic if bag else None, 'error': why}, None)


def positive(text: str) -> int:
    """Return a number of processes from the command line."""
    if not text.isascii() or not text.isdigit() or not int(text):
        raise ArgumentTypeError(f'{text!r} is not a whole number above 0')
    return int(text)


def cores() -> int:
    """Return how many processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, 'sched_getaffinity') else (
        os.cpu_count() or 1)


def judge_inputs(paths: Sequence[str], settings: Settings, table: RunTable | None, *,
                 takers: Iterable[Callable[[Pairs], None]] = (), sketched: bool = False,
                 jobs: int | None = None, quiet: bool = False) -> list[Judged]:
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
        Each is given the pairs, chunk by chunk; for one input only.
    sketched : bool
        Collect what the graphs of a report need.
    jobs : int, optional
        Processes; one for each core by default. Where the inputs are small none is started.
    quiet : bool
        Show no progress.

    Returns
    -------
    list of Judged
        In the order of the paths, the same whatever `jobs` is.

    Raises
    ------
    OSError, BagError
        If there is one input, and it cannot be read.
    ValueError
        If none of several can be read.

    """
    job = _Job(settings, table, sketched)
    if len(paths) == 1:
        with Progress(paths[0], quiet) as progress:
            return [job.judge(paths[0], takers, progress.show)]
    worth = sum(map(_size, paths)) >= _WORTH_BYTES
    with Progress(f'{len(paths)} inputs', quiet) as progress:
        judged = _parallel(job, paths, min(len(paths), jobs or cores()), progress) if worth else (
            _serial(job, paths, progress))
    if all(each.error for each in judged):
        raise ValueError(f'none of the {len(paths)} inputs can be read: '
                         f'{judged[0].path}: {judged[0].error}')
    return judged


def _serial(job: _Job, paths: Sequence[str], progress: Progress) -> list[Judged]:
    judged = []
    for done, path in enumerate(paths):
        progress.show(f'{done} done, {path}')
        judged.append(job.survive(path))
    return judged


@contextmanager
def _pool(jobs: int) -> Iterator[ProcessPoolExecutor]:
    """Give processes with one thread each for linear algebra."""
    unset = [name for name in _ONE_THREAD if name not in os.environ]
    os.environ.update(dict.fromkeys(unset, '1'))
    try:
        # Spawned, not forked: threads of this process would be lost in the copy. Ctrl-C ends them.
        with ProcessPoolExecutor(jobs, get_context('spawn'), signal.signal,
                                 (signal.SIGINT, signal.SIG_DFL)) as pool:
            yield pool
    finally:
        for name in unset:
            del os.environ[name]


def _parallel(job: _Job, paths: Sequence[str], jobs: int, progress: Progress) -> list[Judged]:
    """Judge in other processes, the largest inputs first, so that none is left to the end."""
    order = sorted(range(len(paths)), key=lambda at: -_size(paths[at]))
    with _pool(jobs) as pool:
        futures = {pool.submit(job.survive, paths[at]): at for at in order}
        for done, future in enumerate(as_completed(futures), 1):
            progress.show(f'{done} done, {paths[futures[future]]}')
    found = {at: _result(job, paths[at], future) for future, at in futures.items()}
    return [found[at] for at in range(len(paths))]


def _result(job: _Job, path: str, future: Future) -> Judged:
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


def capped(verdict: Mapping[str, Any], judged: Sequence[Judged]) -> dict[str, Any]:
    """
    Return a verdict that does not claim compliance for inputs that could not be read.

    Parameters
    ----------
    verdict : mapping
        `Verdict.to_dict()` of those that could.
    judged : sequence of Judged
        All of them.

    """
    if not any(each.error for each in judged):
        return dict(verdict)
    least = {key: worst([Outcome(verdict[key]), Outcome.INDETERMINATE]).value
             for key in ('outcome', 'paper_outcome')}
    return {**verdict, **least}
