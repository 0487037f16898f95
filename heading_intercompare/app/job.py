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

"""The judging of one input of a campaign, in any process or by any executor."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from socket import gethostname
from threading import Lock
from typing import Any, Callable, Mapping, Sequence

from heading_intercompare.core.settings import Settings
from heading_intercompare.core.verdict.verdict_document import Input

# `cluster` asks workers for it by this name, to see that they can load this module.
from heading_intercompare.core.version import VERSION as VERSION
from heading_intercompare.drivers.settings import DEFAULT_DRIVER, DriverSettings

from .inputs import describe_recording, judge_input
from .run_table import RunTable
from .sources.input_comparison import PairTakers
from .sources.judged_input import JudgedInput


class _OneThread:
    """
    Limits linear algebra to one thread while any task runs in this process.

    This matches the processes of `campaign`. An executor may run several tasks in one process, and
    each would then use as many threads as there are cores. Without threadpoolctl none is set.
    """

    def __init__(self) -> None:
        self._lock = Lock()
        self._tasks = 0
        self._limits: Any = None

    def __enter__(self) -> None:
        with self._lock:
            if not self._tasks:
                self._limits = _limit_threads()
            self._tasks += 1

    def __exit__(self, *exc: object) -> None:
        with self._lock:
            self._tasks -= 1
            if not self._tasks and self._limits is not None:
                self._limits.restore_original_limits()


def _limit_threads() -> Any:
    """Limit linear algebra to one thread; return what restores it, None without threadpoolctl."""
    try:
        # Only workers need threadpoolctl, and it takes some time to load.
        from threadpoolctl import threadpool_limits
    except ModuleNotFoundError:
        return None
    return threadpool_limits(1)


_ONE_THREAD = _OneThread()


def judge_there(job: Job, path: str, place: str, libraries: str) -> JudgedInput:
    """
    Judge an input in the process that calls this, perhaps on another computer.

    Parameters
    ----------
    job
        What to do with the input.
    path
        Name of the input in the verdict.
    place
        Absolute path of the input.
    libraries
        `describe_libraries` of the process that asks; if they differ here, a note says so.

    """
    with _ONE_THREAD:
        judged = job.survive(path, place)
    if judged.error is not None:
        return job.unread(path, f'{judged.error} (on {gethostname()})')
    local_libraries = describe_libraries()
    if libraries != local_libraries:
        judged.notes.append(f'{path}: judged with {local_libraries} on {gethostname()}, but here '
                            f'are {libraries}: last digits may differ')
    return judged


def describe_libraries() -> str:
    """Return the versions of the libraries on which the last bits of figures depend."""
    # The module takes some time to load, and only tasks elsewhere ask for versions.
    from importlib.metadata import version
    return ' and '.join(f'{name} {version(name)}' for name in ('numpy', 'scipy'))


UNREADABLE = (OSError, ValueError, MemoryError)
"""The errors of an input that cannot be judged."""


def explain_unreadable(error: Exception, path: str) -> str:
    """Return why the input at `path` raised one of `UNREADABLE`, in one line without the path."""
    if isinstance(error, MemoryError):
        return 'there is not enough memory for it'
    why = str(error)
    if isinstance(error, OSError) and error.strerror:
        why = error.strerror
    return ' '.join(why.removeprefix(f'{path}: ').split())


@dataclass(frozen=True, slots=True)
class Job:
    """
    The part of the task that is the same for all inputs; it is sent to other processes.

    Attributes
    ----------
    table : sequence of (start_ns, stop_ns, source), optional
        Runs.
    sketched
        Collect the data for the graphs of a report.
    parts
        Absolute paths of the bags that go on with the trial of an input, by its path.
    driver
        Column and form of the stamps in a table.

    """

    settings: Settings
    table: RunTable | None
    sketched: bool
    parts: Mapping[str, Sequence[str]] = field(default_factory=dict)
    driver: DriverSettings = DEFAULT_DRIVER

    def judge(self, path: str, takers: PairTakers | None = None,
              progress: Callable[[str], None] = lambda text: None, *,
              place: str | None = None, helpers: int = 0) -> JudgedInput:
        """
        Judge one input; OSError and ValueError if it cannot be read.

        `place` is where to find it, if the path means something else here; `helpers` is the
        number of processes that decode in parallel with this one.
        """
        return judge_input(
            place or path, self.settings, self.table, takers, progress, name=path,
            helpers=helpers, parts=self.parts.get(path, ()), sketched=self.sketched,
            driver=self.driver)

    def survive(self, path: str, place: str | None = None) -> JudgedInput:
        """Judge one input among others; if that fails, return a result that says why."""
        try:
            return self.judge(path, place=place)
        except UNREADABLE as error:
            return self.unread(path, explain_unreadable(error, place or path))

    def unread(self, path: str, why: str) -> JudgedInput:
        """Return the result for an input that could not be judged."""
        why = ' '.join(why.split())
        entry = Input(path, error=why)
        note = f'not judged: {why}'
        if Path(path).suffix != '.csv':
            return describe_recording(path, entry, self.settings).without_runs(note)
        return JudgedInput(path=path, results={}, entries=[entry],
                           entries_of_tested={'ts': [entry]}).without_runs(note)
