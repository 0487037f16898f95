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
Decoding of stretches of a bag in several processes.

Threads would not help: the numpy calls are short, and between them only one thread runs. A helper
is a forked copy of this process. It starts at once and returns headings through shared memory. If
a helper fails, this process does its work. Without helpers a thread decodes ahead (`run_ahead`).
"""

from __future__ import annotations

from collections import deque
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, suppress
from mmap import mmap
from multiprocessing import get_context, parent_process
from multiprocessing.connection import Connection, wait
import signal
import sys
from threading import active_count
from typing import Any, Container, Generator, Iterator, NamedTuple, Sequence, TypeVar
from warnings import catch_warnings, simplefilter

import numpy as np

from heading_intercompare.bags.mcap.mcap_file import Stretch
from heading_intercompare.core.records import Headings, Quality

from .decoding import Decoded, Decoder, Found

#: Items that are ready or in preparation while the caller uses one.
_ITEMS_AHEAD = 2
_Item = TypeVar('_Item')
#: Stretches that a helper holds, waiting, in work or done, and the memory for each.
_SLOTS = 4
_SLOT_BYTES = 26 * 2**20
#: Stretches per helper that this process decodes ahead of their turn instead of waiting.
_STRETCHES_AHEAD = 3
#: With fewer stretches, forking takes longer than the work.
_FEWEST = 12
#: All processes together decode at most this many bytes of records at once.
_MOST_BYTES = 2**27

_Claims = tuple[tuple[int, Quality], ...]
_COLUMNS = ('<i8', '<i2', '<u4', '<i8', '<f8')
#: For each block, the number of messages, the number of headings of each kind, and of each kind
#: what is unreadable and what is claimed.
_Layout = list[tuple[int, list[int], list[tuple[tuple[int, str], _Claims]]]]


class Task(NamedTuple):
    """A stretch of a file, and the index of the file."""

    number: int
    stretch: Stretch


def _places(layout: _Layout) -> Iterator[list[tuple[str, int, int]]]:
    """Yield, for each block and kind, the dtype, length and first byte of its columns."""
    at = 0
    for _, lengths, _ in layout:
        for length in lengths:
            columns = []
            for column in _COLUMNS:
                columns.append((column, length, at))
                at += -(-length * int(column[-1]) // 8) * 8
            yield columns


def _size(layout: _Layout) -> int:
    return sum(-(-length * int(column[-1]) // 8) * 8
               for _, lengths, _ in layout for length in lengths for column in _COLUMNS)


def _put(blocks: Sequence[Decoded], memory: memoryview) -> _Layout | None:
    """Write decoded blocks into memory and return their layout; None if they do not fit."""
    layout = [(block.messages, [len(readings.place) for readings in block.found],
               [(readings.unreadable, readings.claims) for readings in block.found])
              for block in blocks]
    if _size(layout) > len(memory):
        return None
    all_readings = [readings for block in blocks for readings in block.found]
    for readings, columns in zip(all_readings, _places(layout)):
        values = (readings.log_time_ns, readings.place, readings.sequence,
                  readings.headings.stamp_ns, readings.headings.heading_deg)
        for value, (kind, length, at) in zip(values, columns):
            np.frombuffer(memory, kind, length, at)[:] = value
    return layout


def _take(layout: _Layout, memory: bytes) -> list[Decoded]:
    """Read decoded blocks back from memory."""
    columns = _places(layout)
    blocks = []
    for count, _, beside in layout:
        by_kind = []
        for unreadable, claims in beside:
            log_time_ns, place, sequence, stamp_ns, heading_deg = (
                np.frombuffer(memory, *column) for column in next(columns))
            by_kind.append(Found(log_time_ns, place, sequence, Headings(stamp_ns, heading_deg),
                                 unreadable, claims))
        blocks.append(Decoded(count, by_kind))
    return blocks


def _work(decoder: Decoder, memory: mmap, connection: Connection,
          inherited: Sequence[Connection]) -> None:
    """Decode the stretches the parent asks for, until it closes the connection."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    # An inherited SIGTERM handler could keep a helper alive that must end.
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
    # While copies of these connections are open here, nobody notices that their other end has
    # closed.
    for copy in inherited:
        copy.close()
    slots = memoryview(memory)
    with decoder:
        while True:
            try:
                slot, task = connection.recv()
                blocks = decoder.stretch(*task)
                begin = slot * _SLOT_BYTES
                connection.send((slot, blocks and _put(blocks,
                                                       slots[begin:begin + _SLOT_BYTES])))
            except (EOFError, OSError, MemoryError):
                return


class _Helper:
    """A process that decodes in parallel with this one."""

    def __init__(self, decoder: Decoder, inherited: Sequence[Connection]) -> None:
        context = get_context('fork')
        self.connection, theirs = context.Pipe()
        self._memory = mmap(-1, _SLOTS * _SLOT_BYTES)
        self._free = list(range(_SLOTS))
        self._asked: dict[int, int] = {}
        self._process = context.Process(
            target=_work, daemon=True,
            args=(decoder, self._memory, theirs, [*inherited, self.connection]))
        with catch_warnings():
            # Python warns of threads of linear algebra; a helper does not use them.
            simplefilter('ignore', DeprecationWarning)
            # Ctrl-C during the fork would be lost here and raise an error in the helper.
            blocked = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
            try:
                self._process.start()
            finally:
                signal.pthread_sigmask(signal.SIG_SETMASK, blocked)
        theirs.close()

    @property
    def free(self) -> bool:
        """Whether it can take another task."""
        return bool(self._free)

    def ask(self, turn: int, task: Task) -> None:
        """Send a task to the process; OSError if the process is gone."""
        slot = self._free.pop()
        self.connection.send((slot, task))
        self._asked[slot] = turn

    def take(self) -> tuple[int, list[Decoded] | None]:
        """Return the turn and result of a finished task; EOFError, OSError if it is gone."""
        slot, layout = self.connection.recv()
        blocks = layout
        if layout:
            begin = slot * _SLOT_BYTES
            blocks = _take(layout, self._memory[begin:begin + _size(layout)])
        self._free.append(slot)
        return self._asked.pop(slot), blocks

    @property
    def asked(self) -> list[int]:
        """Return the turns of the tasks it has not handed back yet."""
        return list(self._asked.values())

    def close(self) -> None:
        """End the process."""
        self.connection.close()
        self._process.kill()
        self._process.join()
        # Where SIGCHLD is ignored, Python cannot tell that the process has ended.
        with suppress(ValueError):
            self._process.close()
        self._memory.close()


class _Crew:
    """The helpers that are alive, and their results."""

    def __init__(self, decoder: Decoder, count: int, stack: ExitStack) -> None:
        self._helpers: list[_Helper] = []
        for _ in range(count):
            try:
                helper = _Helper(decoder, [helper.connection for helper in self._helpers])
            except OSError:
                # No more processes or memory: continue with the helpers there are.
                break
            stack.callback(helper.close)
            self._helpers.append(helper)
        self.done: dict[int, list[Decoded] | None] = {}
        #: The turns that helpers are working on.
        self.asked: set[int] = set()

    def __len__(self) -> int:
        return len(self._helpers)

    def _lose(self, helper: _Helper) -> None:
        self._helpers.remove(helper)
        self.asked.difference_update(helper.asked)

    def ask(self, turn: int, task: Task) -> bool:
        """Give a task to a helper; False if none is free."""
        for helper in [helper for helper in self._helpers if helper.free]:
            try:
                helper.ask(turn, task)
            except OSError:
                self._lose(helper)
                continue
            self.asked.add(turn)
            return True
        return False

    def collect(self, timeout_s: float | None) -> None:
        """Collect finished tasks; wait up to `timeout_s` for one, None for as long as it takes."""
        ready = wait([helper.connection for helper in self._helpers], timeout_s)
        for helper in [helper for helper in self._helpers if helper.connection in ready]:
            try:
                turn, blocks = helper.take()
            except (EOFError, OSError):
                self._lose(helper)
                continue
            self.asked.discard(turn)
            # This process decodes the stretches that a helper could not.
            if blocks is not None:
                self.done[turn] = blocks


def can_fork() -> bool:
    """Tell whether this process may fork: on Linux, with no other thread, and not in a pool."""
    return sys.platform == 'linux' and active_count() == 1 and parent_process() is None


def decode_stretches(decoder: Decoder, tasks: Sequence[Task], helpers: int = 0,
                     unwanted: Container[int] = ()
                     ) -> Generator[list[Decoded] | None, None, None]:
    """
    Yield the decoded stretches in order, each as `Decoder.stretch` returns it.

    Parameters
    ----------
    decoder
        Reads in this process; it must not have a file open yet. Helpers get copies of it.
    tasks
        The stretches.
    helpers
        Most processes to decode in parallel with this one; 0 unless `can_fork`. Fewer are
        started if there is little work, or if stretches are too large to hold at once. They end
        with the iteration.
    unwanted : container of int
        Indexes of files to skip: None is yielded for their stretches. It may grow during the
        iteration.

    """
    with ExitStack() as stack:
        largest = max((task.stretch.size for task in tasks), default=0)
        helpers = min(helpers, _MOST_BYTES // max(largest, 1) - 1) if len(tasks) >= _FEWEST else 0
        crew = _Crew(decoder, helpers, stack)
        coming = 0
        for turn in range(len(tasks)):
            if tasks[turn].number in unwanted:
                yield None
                continue
            coming = max(coming, turn)
            while True:
                while coming < len(tasks) and crew.ask(coming, tasks[coming]):
                    coming += 1
                if crew:
                    crew.collect(0.0)
                if turn in crew.done or turn not in crew.asked:
                    break
                if coming < min(len(tasks), turn + (_SLOTS + _STRETCHES_AHEAD) * len(crew)):
                    crew.done[coming] = decoder.stretch(*tasks[coming])
                    coming += 1
                else:
                    crew.collect(None)
            coming = max(coming, turn + 1)
            yield crew.done.pop(turn) if turn in crew.done else decoder.stretch(*tasks[turn])


def run_ahead(items: Iterator[_Item]) -> Iterator[_Item]:
    """
    Yield the items of an iterator that runs in a second thread.

    If the iterator raises, the error follows the items it yielded before.
    """
    # Any, because `is not` tells it from the items.
    end: Any = object()
    with ThreadPoolExecutor(1) as worker:
        coming = deque(worker.submit(next, items, end) for _ in range(_ITEMS_AHEAD))
        while (item := coming.popleft().result()) is not end:
            coming.append(worker.submit(next, items, end))
            yield item
