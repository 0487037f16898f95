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
import time
from typing import Any, Callable

from rclpy.publisher import Publisher

from heading_intercompare.core.alarms.alarm import Priority
from heading_intercompare.drivers.framing import Received
from heading_intercompare.drivers.playback import FileSource
from heading_intercompare.drivers.settings import DriverSettings
from heading_intercompare.drivers.sources import open_source, Source
from heading_intercompare.messages.status_messages import OK, WARN
from heading_intercompare.nodes.interface.parameters import declare, follow
from heading_intercompare.nodes.presence.graph_node import GraphNode
from heading_intercompare.nodes.presence.health import Health
from heading_intercompare.nodes.presence.setting_changes import SettingChanges
from heading_intercompare.nodes.sending.driver_motion import DriverMotion
from heading_intercompare.nodes.sending.publishing import Audience, await_acknowledgement
from heading_intercompare.nodes.settings import DriverNode, PUBLISHED, Sending, Taking
from heading_intercompare.nodes.spinning.clocks import every

_PIECE = 50
_READ_S = 0.2
_FOLLOWED = ('stale_s',)


class Reading:
    """
    Reads a source in its own thread.

    Parameters
    ----------
    settings
        Names the source; it is opened here and closed by `stop`.
    max_rate_hz
        Most lines per second from a file that is played as fast as possible.
    notify
        Called from the thread when lines have arrived or reading is over.

    Attributes
    ----------
    source
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
    def first_ns(self) -> int | None:
        """First stamp of a log; None for other sources."""
        return self.source.first_ns if isinstance(self.source, FileSource) else None

    def play_from(self, origin_ns: int) -> None:
        """Let a log start at a log time."""
        if isinstance(self.source, FileSource):
            self.source.origin_ns = origin_ns

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


class ReadingNode(GraphNode):
    """
    A node that reads a source: a live one at once, a log once all who wait for it are there.

    The motion of the ship in the lines is published; a node of headings adds to it what else the
    lines tell, in `_take`, `_take_last` and `_publish_waiting`.

    Parameters
    ----------
    name
        Name of the node.
    record
        What the source tells, in a word.
    **kwargs
        As for `Node`.

    """

    _audience: Audience
    _allowed_s: tuple[float, float]

    def __init__(self, name: str, record: str, **kwargs: Any) -> None:
        super().__init__(name, **kwargs)
        self._record = record
        self._analysis, self._settings, self._sending, taking, self._own = declare(
            self, PUBLISHED, DriverSettings, Sending, Taking, DriverNode, followed=_FOLLOWED)
        self._allow_silence(taking)
        self._flushed = self._ending = False
        self.health = Health(
            self, priority=Priority.WARNING if record == 'heading' else Priority.CAUTION)
        SettingChanges(self, self.health, _FOLLOWED)
        self._newest_s = time.monotonic()

    def _open(self, *, alone: bool = False) -> None:
        """Open the source, once nothing else can be wrong; `alone` as for `DriverMotion`."""
        wake = self.create_guard_condition(self._pass_on)
        self._reading = Reading(self._settings, self._sending.max_rate_hz, wake.trigger)
        self._motion = DriverMotion(self, self.health, self._analysis, self._settings, self._own,
                                    alone=alone)

    def _watch(self) -> None:
        """Begin to read, at once or when all who wait are there; the end of `__init__`."""
        if self._reading.from_file and self._own.origin_ns is not None:
            self.play_from(self._own.origin_ns)
        self._later = every(self, 0.01, self._pass_on)
        self.health.add_refresher(self._note)
        self._start = every(self, 0.05, self._begin)
        self._begin()

    def _allow_silence(self, taking: Taking) -> None:
        """Note how long the source may be silent; `stale_s` may change while the node runs."""
        def change(stale_s: float) -> None:
            self._allowed_s = taking.first_wait_s, stale_s
        change(taking.stale_s)
        follow(self, 'stale_s', change)

    @property
    def n_published(self) -> int:
        """Return the number of messages published."""
        return self._motion.n_published

    @property
    def first_ns(self) -> int | None:
        """First stamp of a log; None for other sources."""
        return self._reading.first_ns

    def play_from(self, origin_ns: int) -> None:
        """Let a log start at a log time, to play in step with others; call it before the start."""
        self._reading.play_from(origin_ns)

    def _begin(self) -> None:
        if not self._reading.started and (
                not self._reading.from_file or self._audience.is_there()):
            self._reading.start()
        if self._reading.started:
            self._start.cancel()

    def _pass_on(self) -> None:
        """Publish what the bytes received tell."""
        if self.ended:
            return
        n_before = self.n_published
        for received in self._reading.take():
            self._take(received)
        if self._reading.over and not self._flushed:
            self._flushed = True
            self._take_last()
        has_more = self._publish_waiting()
        if self.n_published != n_before:
            self._newest_s = time.monotonic()
        if has_more:
            self._later.reset()
            return
        self._later.cancel()
        if (self._flushed and not self.done) or self._ending:
            self._leave()

    def _take(self, received: Received) -> None:
        """Take bytes."""
        self._motion.feed(received)

    def _take_last(self) -> None:
        """Take the end of the source."""
        self._motion.flush()

    def _publish_waiting(self) -> bool:
        """Publish what may be published now; tell whether more waits."""
        return self._motion.publish()

    def _list_publishers(self) -> list[Publisher]:
        return self._motion.publishers

    def _leave(self) -> None:
        """Note that all is published, once the subscribers have it."""
        publishers = self._list_publishers()
        if self._ending:
            await_acknowledgement(publishers)
        elif not self._audience.has_heard(publishers):
            self._later.reset()
            return
        self.done, self.ended = self._flushed, self._ending

    def _note(self) -> None:
        """Report the state of the source."""
        if self._reading.started and not self.done:
            self._pass_on()
        n, age_s = self.n_published, time.monotonic() - self._newest_s
        allowed_s = self._allowed_s[n > 0]
        silent = self._reading.started and not self._flushed and age_s > allowed_s
        words = f'no {self._record} for more than {allowed_s:g} s; ' if silent else ''
        self.health.note('source', WARN if silent else OK, words + self._reading.source.status,
                         figures=self._describe(n, age_s))

    def _describe(self, n_published: int, age_s: float) -> dict[str, object]:
        """Return what to show of the source."""
        return {'published': n_published, 'age_s': age_s, **self._reading.source.counts}

    def end(self) -> None:
        """Stop reading; `ended` becomes True once everything received is published."""
        self._reading.stop()
        self._ending = True
        self._pass_on()

    def destroy_node(self) -> None:
        """Stop reading and destroy the node."""
        self._reading.stop()
        super().destroy_node()
