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

"""
What a process says to systemd: that it runs, that it still turns, that it ends.

systemd names a socket in the environment of a service of the type `notify` (sd_notify(3)). If it
watches the service, it names how often it wants to hear from it, too (sd_watchdog_enabled(3)).
Without them nothing is said.
"""

from __future__ import annotations

from contextlib import contextmanager
from functools import partial
import os
import socket
import time
from typing import Iterator, Mapping

from heading_intercompare.nodes.spinning.executors import StockExecutor


class SystemdLink:
    """
    Says to systemd how this process is.

    Parameters
    ----------
    environ
        The environment of the process.

    Attributes
    ----------
    period_s : float or None
        Time from one sign of life to the next, half of what systemd bears; None: it does not
        watch this process.

    """

    def __init__(self, environ: Mapping[str, str] = os.environ) -> None:
        self._place = environ.get('NOTIFY_SOCKET', '')
        watched, pid = environ.get('WATCHDOG_USEC', ''), environ.get('WATCHDOG_PID', '')
        # The nodes of a launch file inherit what is meant for the program that started them.
        is_watched = watched.isdecimal() and pid in ('', str(os.getpid()))
        self.period_s = int(watched) / 2e6 if self._place and is_watched else None
        self._due_s = 0.0
        self._still: set[StockExecutor] = set()
        self._watched: set[StockExecutor] = set()

    def tell(self, state: str) -> None:
        """Send a state such as `READY=1`; a systemd that is gone changes nothing."""
        if not self._place:
            return
        # A name that begins with @ is in the abstract namespace of Linux.
        place = f'\0{self._place[1:]}' if self._place.startswith('@') else self._place
        with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM | socket.SOCK_CLOEXEC) as out:
            try:
                out.sendto(state.encode(), place)
            except OSError:
                pass

    @contextmanager
    def watch(self, executor: StockExecutor) -> Iterator[None]:
        """
        Send signs of life while entered, as long as the executor turns.

        If several are watched, each of them must turn: one that hangs ends the signs of all.
        """
        if self.period_s is None:
            yield
            return
        self._watched.add(executor)
        executor.beat = partial(self._note_turn, executor)
        try:
            yield
        finally:
            executor.beat = None
            self._watched.discard(executor)

    def _note_turn(self, executor: StockExecutor) -> None:
        """Note that an executor turns; send a sign of life if all do and it is time to."""
        self._still.discard(executor)
        now_s = time.monotonic()
        if not self._still & self._watched and now_s >= self._due_s and self.period_s is not None:
            self._due_s = now_s + self.period_s
            self._still = {*self._watched}
            self.tell('WATCHDOG=1')
