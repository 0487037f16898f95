# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Inputs judged by the workers of a Dask cluster."""

from __future__ import annotations

import asyncio
from concurrent.futures import CancelledError, Executor, FIRST_COMPLETED, Future, wait
from contextlib import contextmanager
from functools import partial
from importlib.metadata import version
import json
import logging
import os
from pathlib import Path
from pkgutil import resolve_name
from socket import gethostname
import struct
from threading import Lock
from time import monotonic
from typing import Any, Callable, Iterable, Iterator, Mapping
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
from threadpoolctl import threadpool_limits

from heading_intercompare.core.version import VERSION

from .job import Job, Judged

__all__ = ['Cluster']

#: How long scheduler and workers may take to answer.
_CONNECT_S = 15.0
#: How often it is looked whether there still is a worker, and how long none is borne with: a
#: worker that died is started anew by its nanny.
_LOOK_S, _DESERTED_S = 2.0, 60.0

#: What the library makes of the words of another program, and of an address that is none.
_BABBLE = (TypeError, LookupError, MemoryError, OverflowError, struct.error)
_NO_SCHEDULER = (OSError, DaskTimeoutError, ValueError, ImportError, RuntimeError, *_BABBLE)

_DIED = 'the workers that judged it died (out of memory?)'
_LOST = 'the scheduler or its last worker was lost'


class Cluster:
    """
    The workers of a Dask scheduler, as `campaign.Workers`.

    Parameters
    ----------
    address : str
        Of the scheduler, ``tcp://HOST:8786``; or the ``.json`` file in which it says so.

    Raises
    ------
    OSError, ValueError
        If the file cannot be read, or is not that of a scheduler.

    Notes
    -----
    Scheduler and workers need the version of this package that is here. What comes back of an
    input are the figures of its runs, never its pairs.

    """

    def __init__(self, address: str) -> None:
        self._given = address
        self._address = _address_in(address) if address.endswith('.json') else address
        self._client: Client | None = None

    @contextmanager
    def open(self) -> Iterator[Executor]:
        """
        Connect; at the end of the context nothing is begun any more.

        Raises
        ------
        ValueError
            If the scheduler cannot be reached, has no worker, or it or a worker has another
            version of Dask or of this package.

        """
        with _silence(), self._connected() as self._client:
            self._check()
            pool = self._client.get_executor(pure=False)
            try:
                yield pool
            finally:
                pool.shutdown(wait=False)

    def task(self, job: Job, path: str) -> Callable[[], Judged]:
        """Return what a worker has to do: its working directory is another."""
        return partial(_judge, job, path, os.path.abspath(path), _libraries())

    def completed(self, futures: Iterable[Future]) -> Iterator[Future]:
        """Yield what is done; what nobody is there to do any more, too."""
        waiting, seen_s = set(futures), monotonic()
        while waiting:
            done, waiting = wait(waiting, _LOOK_S, FIRST_COMPLETED)
            yield from done
            if done or self._anybody():
                seen_s = monotonic()
            elif monotonic() - seen_s > _DESERTED_S:
                for future in waiting:
                    future.cancel()
                yield from waiting
                return

    def result(self, job: Job, path: str, future: Future) -> Judged:
        """Return what a worker said; or that there is none who could."""
        try:
            return future.result()
        except KilledWorker:
            return job.unread(path, _DIED)
        except CancelledError:
            return job.unread(path, _LOST)

    @contextmanager
    def _connected(self) -> Iterator[Client]:
        # A client stumbles over a scheduler of another version, and is slow to get up.
        try:
            found = asyncio.run(_version_of(self._address))
        except _NO_SCHEDULER as error:
            why = ('what does is another program' if isinstance(error, _BABBLE) else
                   str(error) or f'not within {_CONNECT_S:g} s')
            raise self._refused(f'no Dask scheduler answers there: {why}') from error
        self._same('distributed', DISTRIBUTED, {'the scheduler': found})
        try:
            with warnings.catch_warnings():
                # A table of libraries, most of which are none of our concern; see `_judge`.
                warnings.simplefilter('ignore', VersionMismatchWarning)
                client = Client(self._address, timeout=_CONNECT_S, set_as_default=False)
        except _NO_SCHEDULER as error:
            raise self._refused(f'the scheduler no longer answers: {error}') from error
        with client:
            yield client

    def _anybody(self) -> bool:
        """Tell whether there is a worker."""
        try:
            return bool(self._client.nthreads())
        except (OSError, DaskTimeoutError):
            return False

    def _check(self) -> None:
        """Refuse a cluster that would judge otherwise, or not at all."""
        try:
            self._client.wait_for_workers(1, timeout=_CONNECT_S)
        except DaskTimeoutError as error:
            raise self._refused('the scheduler has no workers') from error
        for name, expected in (('distributed:__version__', DISTRIBUTED),
                               ('heading_intercompare.core.version:VERSION', VERSION),
                               (f'{__name__}:VERSION', VERSION)):
            # A function of the standard library: ours cannot be sent where it is not installed.
            found = self._client.run(resolve_name, name, on_error='return')
            found = {f'worker {worker}': answer for worker, answer in found.items()}
            try:
                found['the scheduler'] = self._client.run_on_scheduler(resolve_name, name)
            except (ImportError, AttributeError) as error:
                found['the scheduler'] = error
            self._same(name.partition('.')[0].partition(':')[0], expected, found)

    def _same(self, package: str, expected: str, found: Mapping[str, object]) -> None:
        """Refuse who has not the version of a package that is here."""
        for who, answer in found.items():
            if answer != expected:
                has = (f'cannot load it: {answer}' if isinstance(answer, BaseException)
                       else f'has {answer}')
                raise self._refused(f'{package} is {expected} here, {who} {has}')

    def _refused(self, why: str) -> ValueError:
        return ValueError(f'--dask {self._given}: {why}')


def _address_in(path: str) -> str:
    """Return the address that a scheduler has written into its file."""
    try:
        found: Any = json.loads(Path(path).read_text('utf-8'))
    except ValueError as error:
        raise ValueError(f'--dask {path}: is not JSON: {error}') from error
    address = found.get('address') if isinstance(found, dict) else None
    if not isinstance(address, str):
        raise ValueError(f'--dask {path}: is not the file of a Dask scheduler: no address in it')
    return address


async def _version_of(address: str) -> str:
    """Return the version of Dask that a scheduler has."""
    async def ask() -> str:
        secrets = Security().get_connection_args('client')
        async with rpc(address, connection_args=secrets, timeout=_CONNECT_S) as scheduler:
            kind = (await scheduler.identity())['type']
            if kind != 'Scheduler':
                raise ValueError(f'what does is a {kind}')
            return (await scheduler.versions())['packages']['distributed']
    return await asyncio.wait_for(ask(), _CONNECT_S)


@contextmanager
def _silence() -> Iterator[None]:
    """Keep what the library logs off the terminal: what goes wrong is said in one line."""
    loggers = [logging.getLogger(name) for name in ('distributed', 'distributed.client')]
    levels = [logger.level for logger in loggers]
    for logger in loggers:
        logger.setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        for logger, level in zip(loggers, levels):
            logger.setLevel(level)


class _OneThread:
    """
    Linear algebra with one thread while any task of this process is under way.

    As in the processes of `campaign`; a worker may have several tasks at once, and started without
    a nanny it computes with as many threads as it has cores.
    """

    def __init__(self) -> None:
        self._lock = Lock()
        self._tasks = 0
        self._limits: threadpool_limits | None = None

    def __enter__(self) -> None:
        with self._lock:
            if not self._tasks:
                self._limits = threadpool_limits(1)
            self._tasks += 1

    def __exit__(self, *exc: object) -> None:
        with self._lock:
            self._tasks -= 1
            if not self._tasks:
                self._limits.restore_original_limits()


_ONE_THREAD = _OneThread()


def _judge(job: Job, path: str, place: str, libraries: str) -> Judged:
    """Judge an input, on a worker, and say where if that mattered."""
    with _ONE_THREAD:
        judged = job.survive(path, place)
    if judged.error is not None:
        return job.unread(path, f'{judged.error} (on {gethostname()})')
    if libraries != _libraries():
        judged.notes.append(f'{path}: judged with {_libraries()} on {gethostname()}, here are '
                            f'{libraries}: last digits may differ')
    return judged


def _libraries() -> str:
    """Return the versions on which the last bits of figures depend."""
    return ' and '.join(f'{name} {version(name)}' for name in ('numpy', 'scipy'))
