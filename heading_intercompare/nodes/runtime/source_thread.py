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

"""A source, read in a thread of its own so that bytes are stamped on arrival, and its node."""

from __future__ import annotations

from concurrent.futures import Future, ThreadPoolExecutor
from queue import Empty, Full, Queue
import threading
from typing import Callable, Sequence

from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.timer import Timer

from heading_intercompare.drivers.framing import Received
from heading_intercompare.drivers.settings import DriverSettings
from heading_intercompare.drivers.sources import FileSource, open_source, Source
from heading_intercompare.nodes.ros.parameters import follow
from heading_intercompare.nodes.settings import Taking

from .publishing import Audience, await_acknowledgement

__all__ = ['Reading', 'ReadingNode']

_PIECE = 50
_READ_S = 0.2


class Reading:
    """
    Reads a source in its own thread.

    Parameters
    ----------
    settings : DriverSettings
        Names the source; it is opened here and closed by `stop`.
    max_rate_hz : float
        Most lines per second from a file that is played as fast as possible.
    notify : callable
        Called from the thread when lines have arrived or reading is over.

    Attributes
    ----------
    source : Source
        The source.
    from_file : bool
        It is a log, which can wait for `start`.

    Raises
    ------
    SettingsError, DriverError, OSError
        As in `open_source`.

    """

    def __init__(self, settings: DriverSettings, max_rate_hz: float,
                 notify: Callable[[], None]) -> None:
        self.from_file = settings.address.scheme == 'file'
        self._notify = notify
        self._stopped = threading.Event()
        # `stop` interrupts a pause between two lines of a log.
        self.source: Source = (FileSource(settings, wait=self._stopped.wait) if self.from_file
                               else open_source(settings))
        self._pause_s = _PIECE / max_rate_hz if self.from_file else 0.0
        self._queue: Queue[list[Received]] = Queue(maxsize=20)
        self._pool = ThreadPoolExecutor(1)
        self._work: Future[None] | None = None

    def start(self) -> None:
        """Begin to read."""
        self._work = self._pool.submit(self._run)
        self._work.add_done_callback(lambda _: self._notify())

    @property
    def started(self) -> bool:
        """Whether `start` was called."""
        return self._work is not None

    @property
    def over(self) -> bool:
        """Whether nothing more will come; raises the error that ended the reading, if any."""
        if self._work is None or not self._work.done():
            return False
        self._work.result()
        return self._queue.empty()

    def take(self) -> list[Received]:
        """Return the lines received since the last call."""
        lines: list[Received] = []
        try:
            while True:
                lines += self._queue.get_nowait()
        except Empty:
            return lines

    def stop(self) -> None:
        """Stop reading and close the source."""
        self._stopped.set()
        self._pool.shutdown()
        self.source.close()

    def _run(self) -> None:
        while not (self._stopped.is_set() or self.source.exhausted):
            lines = self.source.read(_READ_S)
            for at in range(0, len(lines), _PIECE):
                self._put(lines[at:at + _PIECE])

    def _put(self, lines: list[Received]) -> None:
        while not self._stopped.is_set():
            try:
                self._queue.put(lines, timeout=0.1)
            except Full:
                continue
            self._notify()
            self._stopped.wait(self._pause_s * len(lines) / _PIECE)
            return


class ReadingNode(Node):
    """A node that reads a source: a live one at once, a log once all who wait for it are there."""

    done: bool
    ended: bool
    _reading: Reading
    _audience: Audience
    _later: Timer
    _flushed: bool
    _ending: bool
    _allowed_s: tuple[float, float]

    def _allow_silence(self, taking: Taking) -> None:
        """Note how long the source may be silent; `stale_s` may change while the node runs."""
        def change(stale_s: float) -> None:
            self._allowed_s = taking.first_wait_s, stale_s
        change(taking.stale_s)
        follow(self, 'stale_s', change)

    @property
    def first_ns(self) -> int | None:
        """First stamp of a log; None for other sources."""
        return getattr(self._reading.source, 'first_ns', None)

    def play_from(self, origin_ns: int) -> None:
        """Let a log start at a log time, to play in step with others; call it before the start."""
        self._reading.source.origin_ns = origin_ns

    def _begin(self) -> None:
        if not self._reading.started and (
                not self._reading.from_file or self._audience.is_there()):
            self._reading.start()

    def _leave(self, publishers: Sequence[Publisher]) -> None:
        """Note that all is published, once the subscribers have it."""
        if self._ending:
            await_acknowledgement(publishers)
        elif not self._audience.has_heard(publishers):
            self._later.reset()
            return
        self.done, self.ended = self._flushed, self._ending

    def destroy_node(self) -> None:
        """Stop reading and destroy the node."""
        self._reading.stop()
        super().destroy_node()
