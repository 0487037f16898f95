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

"""The judging of many inputs at once, here or by any executor; a bad one stops no other."""

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
from functools import partial
from multiprocessing import get_context
from multiprocessing.connection import Connection, wait
import os
from pathlib import Path
import signal
from threading import Thread
from typing import Callable, Iterator, Mapping, Sequence, TypeVar

from heading_intercompare.bags.rosbag2.trial_parts import find_parts
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.verdict.verdict_document import Input
from heading_intercompare.drivers.settings import DEFAULT_DRIVER, DriverSettings

from .inputs import describe_recording, sha256
from .job import describe_libraries, Job, judge_there
from .run_table import RunTable
from .sources.input_comparison import PairTakers
from .sources.judged_input import JudgedInput

#: Inputs of a smaller total size are judged here: starting processes would take longer.
_WORTH_BYTES = 100_000_000
#: More processes than this would wait for the one that judges what they read.
MOST_READERS = 4
#: The last bits of sums in a linear algebra library depend on its number of threads; and when all
#: cores are busy, these threads only wait for each other.
_ONE_THREAD = ('OPENBLAS_NUM_THREADS', 'OMP_NUM_THREADS', 'MKL_NUM_THREADS')

_Result = TypeVar('_Result')

_DIED = 'the process that judged it died (out of memory?)'
_GIVEN_UP = 'the executor dropped it'


def count_cores() -> int:
    """Return the number of processors that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, 'sched_getaffinity') else (
        os.cpu_count() or 1)


def judge_inputs(paths: Sequence[str], settings: Settings, table: RunTable | None = None, *,
                 takers: PairTakers | None = None, sketched: bool = False,
                 jobs: int | None = None, executor: Executor | None = None,
                 driver: DriverSettings = DEFAULT_DRIVER,
                 progress: Callable[[str], None] = lambda text: None) -> list[JudgedInput]:
    """
    Judge inputs, several at once.

    Parameters
    ----------
    paths
        The inputs.
    settings
        By which each input is judged.
    table : sequence of (start_ns, stop_ns, source), optional
        Runs; those with a source apply only to the input of that name.
    takers : mapping of str to sequence of callable, optional
        Each is called with the pairs of a tested sensor (`ts` of two), chunk by chunk; for one
        input, and not with an executor.
    sketched
        Collect the data for the graphs of a report.
    jobs
        Processes; by default one per core, or none if the inputs are small. A single large bag is
        decoded by several processes but judged by one. Ignored with an executor.
    executor
        Judges instead, in threads, in processes or on other computers, which see the same paths.
        The executor gets the absolute paths of all inputs, however small or few they are.
    driver
        Column and form of the stamps in a table.
    progress
        Called with the progress in words.

    Returns
    -------
    list of JudgedInput
        In the order of the paths; the same whichever executor judges. An input with the same data
        as an earlier one is not judged again: `same_as` in its description names that one.

    Raises
    ------
    OSError, BagError
        If the only input cannot be read.
    ValueError
        If none of several inputs can be read, or the executor can read none; if there are takers
        with several inputs or an executor.

    Notes
    -----
    An input is reported like an unreadable one if its future is cancelled or ends with a
    `BrokenExecutor`; the words of the error are kept. An input lost with a broken pool of
    processes is tried once more, alone. Any other exception is passed on.

    """
    if takers and (executor is not None or len(paths) > 1):
        raise ValueError('takers: must be empty with several inputs or with an executor')
    trials = find_parts(paths)
    job = Job(settings, table, sketched, {
        first: [os.path.abspath(part) for part in parts] for first, parts in trials.items()},
        driver)
    all_paths, paths = paths, [path for path in paths
                               if not any(path in parts for parts in trials.values())]
    if executor is None and len(paths) == 1:
        helpers = min(jobs or count_cores(), MOST_READERS) - 1
        return _add_parts(all_paths, trials, [job.judge(paths[0], takers, progress,
                                                        helpers=helpers)], settings)
    if executor is not None:
        judged = _judge_elsewhere(job, paths, executor, progress)
    elif (jobs or 0) > 1 or jobs is None and sum(map(_size, paths)) >= _WORTH_BYTES:
        judged = _judge_in_processes(job, paths, min(len(paths), jobs or count_cores()), progress)
    else:
        judged = _judge_in_turn(job, paths, progress)
    if all(judged_input.error for judged_input in judged):
        several = f'none of the {len(paths)} inputs can be read: ' if len(paths) > 1 else ''
        raise ValueError(f'{several}{judged[0].path}: {judged[0].error}')
    return _add_parts(all_paths, trials, _drop_repeats(judged), settings)


def _add_parts(paths: Sequence[str], trials: Mapping[str, Sequence[str]],
               judged: Sequence[JudgedInput], settings: Settings) -> list[JudgedInput]:
    """Add an entry for each bag that was judged together with the one before it."""
    firsts = {part: first for first, parts in trials.items() for part in parts}
    others = iter(judged)
    return [next(others) if path not in firsts else describe_recording(
        path, Input(path, sha256(path), continues=firsts[path]), settings).without_runs(
            f'judged together with {firsts[path]}') for path in paths]


def _drop_repeats(judged: Sequence[JudgedInput]) -> list[JudgedInput]:
    """Drop the runs of inputs that have the same data as an earlier one."""
    firsts: dict[str, JudgedInput] = {}
    once = []
    for judged_input in judged:
        digest = judged_input.sha256
        first = judged_input if digest is None else firsts.setdefault(digest, judged_input)
        once.append(judged_input if first is judged_input else judged_input.without_runs(
            f'not judged again: it has the data of {first.path}', same_as=first.path))
    return once


def _judge_in_turn(job: Job, paths: Sequence[str],
                   progress: Callable[[str], None]) -> list[JudgedInput]:
    judged = []
    for done, path in enumerate(paths):
        progress(f'{done} of {len(paths)} done, {path}')
        judged.append(job.survive(path))
    return judged


def _judge_in_processes(job: Job, paths: Sequence[str], jobs: int,
                        progress: Callable[[str], None]) -> list[JudgedInput]:
    with open_pool(jobs) as pool:
        futures = complete_tasks(pool, [partial(job.survive, path) for path in paths], paths,
                                 progress)
    return [_result(job, path, future) for path, future in zip(paths, futures)]


def _judge_elsewhere(job: Job, paths: Sequence[str], executor: Executor,
                     progress: Callable[[str], None]) -> list[JudgedInput]:
    libraries = describe_libraries()
    # Another process may have another working directory.
    tasks = [partial(judge_there, job, path, os.path.abspath(path), libraries) for path in paths]
    futures = complete_tasks(executor, tasks, paths, progress)
    return [_result(job, path, future) for path, future in zip(paths, futures)]


@contextmanager
def open_pool(jobs: int) -> Iterator[ProcessPoolExecutor]:
    """Yield processes with one linear algebra thread each; none outlives the context."""
    unset = [name for name in _ONE_THREAD if name not in os.environ]
    os.environ.update(dict.fromkeys(unset, '1'))
    # Spawn, do not fork: a fork would lose the threads of this process.
    context = get_context('spawn')
    theirs, ours = context.Pipe(duplex=False)
    try:
        # Our end closes first: after Ctrl-C nobody waits for unfinished tasks.
        with theirs, ProcessPoolExecutor(jobs, context, _begin, (theirs,)) as pool, ours:
            yield pool
    finally:
        for name in unset:
            del os.environ[name]


def _begin(ended: Connection) -> None:
    """Make this process end at Ctrl-C, and when the other end of a pipe is closed or gone."""
    def watch() -> None:
        wait([ended])
        os._exit(1)

    signal.signal(signal.SIGINT, signal.SIG_DFL)
    Thread(target=watch, daemon=True).start()


def complete_tasks(executor: Executor, tasks: Sequence[Callable[[], _Result]],
                   names: Sequence[str], progress: Callable[[str], None],
                   ) -> list[Future[_Result]]:
    """Run tasks, those of the largest inputs first, so that no large one is left to the end."""
    futures: dict[Future[_Result], int] = {}
    progress(f'0 of {len(names)} done')
    try:
        for at in sorted(range(len(names)), key=lambda at: -_size(names[at])):
            futures[executor.submit(tasks[at])] = at
        for done, future in enumerate(as_completed(futures), 1):
            progress(f'{done} of {len(names)} done, {names[futures[future]]}')
    finally:
        for future in futures:
            future.cancel()
    return sorted(futures, key=futures.__getitem__)


def _result(job: Job, path: str, future: Future[JudgedInput]) -> JudgedInput:
    """Return the result for an input; if its pool broke, perhaps through another, try it alone."""
    try:
        return future.result()
    except BrokenProcessPool:
        pass
    except BrokenExecutor as error:
        return job.unread(path, str(error) or _GIVEN_UP)
    except CancelledError:
        return job.unread(path, _GIVEN_UP)
    try:
        with open_pool(1) as pool:
            return pool.submit(job.survive, path).result()
    except BrokenProcessPool:
        return job.unread(path, _DIED)


def _size(path: str) -> int:
    """Return the number of bytes to read; 0 if the input does not exist."""
    place = Path(path)
    try:
        files = place.iterdir() if place.is_dir() else [place]
        return sum(file.stat().st_size for file in files)
    except OSError:
        return 0
