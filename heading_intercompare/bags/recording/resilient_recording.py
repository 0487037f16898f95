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
The recording of a bag, whatever happens to the disk.

While the disk cannot be written, messages wait in memory. Afterwards they go to a new file of the
bag. Messages that do not fit into memory are lost and counted.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from math import inf
import os
from pathlib import Path
import shutil
from typing import Callable, Mapping

from heading_intercompare.bags.mcap.chunk_chain import ChunkChain
from heading_intercompare.bags.rosbag2.bag_yaml import Qos
from heading_intercompare.bags.settings import BagSettings

from .bag_writer import BagWriter

_MB = 1_000_000
#: Recording resumes when `free_space_mb` times this is free.
_AGAIN = 1.1
#: Time from one check of the disk to the next, seconds.
_LOOK_S = 0.5


def _words(error: OSError) -> str:
    where = '' if error.filename is None else f'{os.fspath(error.filename)}: '
    return f'{where}{error.strerror or error}'


@dataclass(slots=True)
class _Attached:
    """An attachment, and the file of the bag that holds it."""

    name: str
    media_type: str
    data: bytes
    file: Path | None = None


class Recording:
    """
    Records a bag; once it is open, no method raises OSError.

    Parameters
    ----------
    path
        The rosbag2 directory; it must not exist.
    settings : BagSettings
        Settings of the bag.
    free_bytes
        Returns the free bytes on the disk of a path; OSError if the path does not exist.

    Attributes
    ----------
    fault : str
        Why nothing can be written at the moment; empty if it can.
    remark : str
        A problem that loses no message: metadata.yaml or a new file cannot be written.
    written : int
        Messages handed to the bag.
    lost
        Messages by topic that could not be written and no longer wait.
    faults : int
        How often writing stopped.

    Raises
    ------
    BagError
        If the path exists.
    OSError
        If the bag cannot be opened.

    """

    def __init__(self, path: str | os.PathLike[str], settings: BagSettings | None = None, *,
                 free_bytes: Callable[[str | os.PathLike[str]], int] = lambda path:
                 shutil.disk_usage(path).free) -> None:
        self._settings = settings or BagSettings()
        self._free_bytes = free_bytes
        self._bag = BagWriter(path, self._settings)
        self.path = self._bag.path
        self.fault = ''
        self.remark = ''
        self.written = self.faults = 0
        self.lost: dict[str, int] = {}
        self._waiting: deque[tuple[str, bytes, int, int, int]] = deque()
        self._waiting_bytes = 0
        self._next_s = -inf
        self._owed: dict[str, Mapping[str, object]] = {}
        self._attached: list[_Attached] = []

    @property
    def free_bytes(self) -> int | None:
        """Free bytes on the disk of the bag; None if the disk cannot be asked."""
        try:
            return self._free_bytes(self.path)
        except OSError:
            return None

    @property
    def waiting(self) -> int:
        """Return the number of messages that wait in memory because they cannot be written."""
        return len(self._waiting)

    @property
    def absent(self) -> int:
        """Return the number of messages written to files that somebody removed or moved."""
        return self._bag.absent

    @property
    def chain(self) -> ChunkChain:
        """Return the hash chain through the chunks written."""
        return self._bag.chain

    def add_topic(self, topic: str, type_name: str, qos: Qos | None = None) -> None:
        """Add a topic; see `BagWriter.add_topic`."""
        self._bag.add_topic(topic, type_name, qos)

    def metadata(self, name: str, mapping: Mapping[str, object]) -> None:
        """Write a metadata record."""
        self._try_again()
        self._owed[name] = mapping
        self._pay()

    def attachment(self, name: str, media_type: str, data: bytes) -> None:
        """Write a file into the bag; write it again if the bag's file that holds it is removed."""
        self._try_again()
        self._attached.append(_Attached(name, media_type, data))
        self._pay()

    def _pay(self) -> None:
        """Write the records still to be written, and the attachments that no file holds."""
        for name, mapping in list(self._owed.items()):
            if self._attempt(self._bag.metadata, name, mapping):
                del self._owed[name]
        for attachment in self._attached:
            if (attachment.file is None or not attachment.file.exists()) and self._attempt(
                    self._bag.attachment, attachment.name, attachment.media_type, attachment.data):
                attachment.file = self._bag.file

    def write(self, topic: str, data: bytes, log_time_ns: int, publish_time_ns: int,
              sequence: int) -> None:
        """Take one message; see `BagWriter.write`."""
        if self.fault:
            self._wait((topic, data, log_time_ns, publish_time_ns, sequence))
            return
        self.written += 1
        self._attempt(self._bag.write, topic, data, log_time_ns, publish_time_ns, sequence)

    def _wait(self, message: tuple[str, bytes, int, int, int]) -> None:
        size = len(message[1])
        if self._waiting_bytes + size > self._settings.waiting_mb * _MB:
            self._lose(message[0])
            return
        self._waiting.append(message)
        self._waiting_bytes += size

    def _lose(self, topic: str) -> None:
        self.lost[topic] = self.lost.get(topic, 0) + 1

    def _attempt(self, action: Callable[..., object], *arguments: object) -> bool:
        """
        Do something to the bag; return whether it worked.

        An OSError stops the writing and becomes the fault.
        """
        try:
            action(*arguments)
        except OSError as error:
            self._stop(_words(error))
            return False
        return True

    def _stop(self, fault: str) -> None:
        self.faults += not self.fault
        self.fault = fault
        pending = self._bag.take_pending()
        self.written -= len(pending)
        for message in pending:
            self._wait(message)

    def tick(self, now_s: float) -> None:
        """
        Write messages that are due, check the disk, or try to write again.

        Call it often, at least twice per flush interval and four times per second.

        Parameters
        ----------
        now_s
            A steady clock, seconds.

        """
        if not self.fault:
            self._attempt(self._bag.flush_if_due, now_s)
        if now_s < self._next_s:
            return
        self._next_s = now_s + _LOOK_S
        self._try_again()
        if not self.fault:
            self._attempt(self._look)
        problem = self._bag.problem
        self.remark = '' if problem is None else _words(problem)

    def _look(self) -> None:
        """Stop if free space is low, while the end of the file still fits; raise if it is gone."""
        self._bag.check()
        if self._free_bytes(self.path) < self._settings.free_space_mb * _MB:
            self._stop(f'less than {self._settings.free_space_mb:g} MB free on the disk of '
                       f'{self.path}')

    def _try_again(self, *, last: bool = False) -> None:
        """
        If writing has stopped, write the waiting messages to a new file, or to the same one.

        The same file is used if no new one can be created. The last attempt ignores
        `free_space_mb`: that space was kept free for it.
        """
        if not self.fault:
            return
        try:
            if not (last or self._room()):
                return
            self._bag.split()
            self._owed.clear()
        except OSError as error:
            self.fault = _words(error)
            try:
                self._bag.check()
            except OSError:
                return
        fault, faults = self.fault, self.faults
        waiting, self._waiting, self._waiting_bytes = self._waiting, deque(), 0
        self.fault = ''
        for message in waiting:
            self.write(*message)
        self._attempt(self._bag.flush)
        self._pay()
        if self.fault:
            self.fault, self.faults = fault, faults

    def _room(self) -> bool:
        """Tell whether there is enough room again, at the nearest folder that exists."""
        place = self.path.absolute()
        while not place.exists():
            place = place.parent
        return self._free_bytes(place) >= self._settings.free_space_mb * _AGAIN * _MB

    def settle(self) -> None:
        """Write all messages in memory; those that cannot be written now are lost."""
        if not self.fault:
            self._attempt(self._bag.check)
        self._try_again(last=True)
        self._attempt(self._bag.flush)
        self._pay()
        for topic, *_ in self._waiting:
            self._lose(topic)
        self._waiting.clear()
        self._waiting_bytes = 0

    def close(self) -> None:
        """End the bag; messages that cannot be written now are lost."""
        self.settle()
        self._attempt(self._bag.close)
