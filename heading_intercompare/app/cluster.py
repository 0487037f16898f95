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

"""The workers of a Dask cluster as an executor of the standard library."""

from __future__ import annotations

import asyncio
from concurrent.futures import BrokenExecutor, CancelledError, Executor, Future
from contextlib import contextmanager
from functools import partial
import json
import logging
from pathlib import Path
from pkgutil import resolve_name
import struct
from threading import Event, Lock, Thread
from time import monotonic
from typing import Any, Callable, Iterator, Mapping, NamedTuple
import warnings

from distributed import (
    __version__ as DISTRIBUTED,
    Client,
    KilledWorker,
    rpc,
    Security,
    TimeoutError as DaskTimeoutError,
)
from distributed.versions import VersionMismatchWarning

from heading_intercompare.core.version import VERSION

#: How long scheduler and workers may take to answer.
_CONNECT_S = 15.0
#: How often to check that there is a worker, and how long to wait without any: the nanny of a
#: worker that died starts a new one.
_LOOK_S, _DESERTED_S = 2.0, 60.0

#: Errors of the library when another program answers, and when there is no valid address.
_BABBLE = (TypeError, LookupError, MemoryError, OverflowError, struct.error)
_NO_SCHEDULER = (OSError, DaskTimeoutError, ValueError, ImportError, RuntimeError, *_BABBLE)

_DIED = 'the workers that judged it died (out of memory?)'
_LOST = 'the scheduler or its last worker was lost'


@contextmanager
def open_cluster(scheduler: str) -> Iterator[Executor]:
    """
    Yield the workers of a Dask scheduler as an executor; after the context no task starts.

    Parameters
    ----------
    scheduler
        Address of the scheduler, ``tcp://HOST:8786``; or its ``.json`` file, which holds the
        address.

    Yields
    ------
    concurrent.futures.Executor
        A future ends with a `BrokenExecutor` that says why if its workers died, or if the
        scheduler or all workers are gone.

    Raises
    ------
    OSError, ValueError
        If the file cannot be read or is not that of a scheduler; if the scheduler cannot be
        reached or has no worker; if the scheduler or a worker has another version of Dask or of
        this package.

    """
    place = _Place(scheduler, _address_in(scheduler) if scheduler.endswith('.json') else scheduler)
    with _silence(), _connect(place) as client:
        _check(client, place)
        pool = _Workers(client)
        try:
            yield pool
        finally:
            pool.shutdown(wait=False)


class _Place(NamedTuple):
    """A scheduler as the user named it, and its address."""

    name: str
    address: str

    def error(self, why: str) -> ValueError:
        """Return an error that names the scheduler."""
        return ValueError(f'--dask {self.name}: {why}')

    def check_version(self, package: str, expected: str, answers: Mapping[str, object]) -> None:
        """Reject a scheduler or worker whose version of a package differs from ours."""
        for who, answer in answers.items():
            if answer != expected:
                has = (f'cannot load it: {answer}' if isinstance(answer, BaseException)
                       else f'has {answer}')
                raise self.error(f'{package} is {expected} here, but {who} {has}')


class _Workers(Executor):
    """The Dask executor; a future that no worker is left for ends with the reason."""

    def __init__(self, client: Client) -> None:
        self._client = client
        self._pool = client.get_executor(pure=False)
        self._lock = Lock()
        self._waiting: dict[Future[Any], Future[Any]] = {}
        self._closed = Event()
        self._watch = Thread(target=self._look, daemon=True)
        self._watch.start()

    def submit(self, function: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Let a worker call a function."""
        promise: Future[Any] = Future()
        theirs = self._pool.submit(function, *args, **kwargs)
        with self._lock:
            self._waiting[promise] = theirs
        promise.add_done_callback(self._take_off)
        theirs.add_done_callback(partial(self._settle, promise))
        return promise

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Accept no more tasks; unless told to wait, cancel unfinished ones on the cluster."""
        self._pool.shutdown(wait=wait and not cancel_futures)
        self._closed.set()
        self._watch.join(_LOOK_S)

    def _take_off(self, promise: Future[Any]) -> None:
        """Cancel a task on the cluster if its future is cancelled."""
        with self._lock:
            theirs = self._waiting.get(promise)
        if promise.cancelled() and theirs is not None:
            theirs.cancel()

    def _settle(self, promise: Future[Any], theirs: Future[Any]) -> None:
        """Pass on the result or the error of a call."""
        error = None if theirs.cancelled() else theirs.exception()
        if theirs.cancelled() or isinstance(error, CancelledError):
            self._end(promise, BrokenExecutor(_LOST))
        elif isinstance(error, KilledWorker):
            self._end(promise, BrokenExecutor(_DIED))
        else:
            self._end(promise, error, None if error else theirs.result())

    def _end(self, promise: Future[Any], error: BaseException | None, result: Any = None) -> None:
        with self._lock:
            if self._waiting.pop(promise, None) is None:
                return
        if not promise.set_running_or_notify_cancel():
            return
        if error is not None:
            promise.set_exception(error)
        else:
            promise.set_result(result)

    def _look(self) -> None:
        """End the waiting futures if there has been no worker for too long."""
        seen_s = monotonic()
        while not self._closed.wait(_LOOK_S):
            if not self._waiting or self._has_worker():
                seen_s = monotonic()
            elif monotonic() - seen_s > _DESERTED_S:
                with self._lock:
                    lost = [*self._waiting]
                for promise in lost:
                    self._end(promise, BrokenExecutor(_LOST))

    def _has_worker(self) -> bool:
        """Tell whether there is a worker."""
        try:
            return bool(self._client.nthreads())
        except (CancelledError, *_NO_SCHEDULER):
            return False


@contextmanager
def _connect(place: _Place) -> Iterator[Client]:
    # Ask for the version first: a client is slow to notice a scheduler of another version.
    try:
        version = asyncio.run(_version_of(place.address))
    except _NO_SCHEDULER as error:
        why = ('another program does' if isinstance(error, _BABBLE) else
               str(error) or f'not within {_CONNECT_S:g} s')
        raise place.error(f'no Dask scheduler answers there: {why}') from error
    place.check_version('distributed', DISTRIBUTED, {'the scheduler': version})
    try:
        with warnings.catch_warnings():
            # The client warns of many libraries that do not matter here; `job` checks
            # the others.
            warnings.simplefilter('ignore', VersionMismatchWarning)
            client = Client(place.address, timeout=_CONNECT_S, set_as_default=False)
    except _NO_SCHEDULER as error:
        raise place.error(f'the scheduler no longer answers: {error}') from error
    with client:
        yield client


def _check(client: Client, place: _Place) -> None:
    """Reject a cluster that would judge differently, or not at all."""
    try:
        client.wait_for_workers(1, timeout=_CONNECT_S)
    except DaskTimeoutError as error:
        raise place.error('the scheduler has no workers') from error
    for name, expected in (('distributed:__version__', DISTRIBUTED),
                           ('heading_intercompare.core.version:VERSION', VERSION),
                           ('heading_intercompare.app.job:VERSION', VERSION)):
        # Send a function of the standard library: ours may not be installed on the worker.
        answers = client.run(resolve_name, name, on_error='return')
        answers = {f'worker {worker}': answer for worker, answer in answers.items()}
        try:
            answers['the scheduler'] = client.run_on_scheduler(resolve_name, name)
        except (ImportError, AttributeError) as error:
            answers['the scheduler'] = error
        place.check_version(name.partition('.')[0].partition(':')[0], expected, answers)


def _address_in(path: str) -> str:
    """Return the address in the file of a scheduler."""
    try:
        document: Any = json.loads(Path(path).read_text('utf-8'))
    except ValueError as error:
        raise ValueError(f'--dask {path}: must be JSON: {error}') from error
    address = document.get('address') if isinstance(document, dict) else None
    if not isinstance(address, str):
        raise ValueError(f'--dask {path}: is not the file of a Dask scheduler: it has no address')
    return address


async def _version_of(address: str) -> str:
    """Return the Dask version of a scheduler."""
    async def ask() -> str:
        secrets = Security().get_connection_args('client')
        async with rpc(address, connection_args=secrets, timeout=_CONNECT_S) as scheduler:
            kind = (await scheduler.identity())['type']
            if kind != 'Scheduler':
                raise ValueError(f'a {kind} does')
            version: str = (await scheduler.versions())['packages']['distributed']
            return version
    return await asyncio.wait_for(ask(), _CONNECT_S)


@contextmanager
def _silence() -> Iterator[None]:
    """Keep the log of the library off the terminal: errors are reported in one line."""
    loggers = [logging.getLogger(name) for name in ('distributed', 'distributed.client')]
    levels = [logger.level for logger in loggers]
    for logger in loggers:
        logger.setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        for logger, level in zip(loggers, levels):
            logger.setLevel(level)
