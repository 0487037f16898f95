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
The topic that a channel number means in each part of a file.

A definition may stand before or after its messages, and more than once. If definitions disagree,
the one in a chunk with a checksum counts from its place on: there a new epoch begins. Nothing
carries over from one file to another that was appended to it.
"""

from __future__ import annotations

from bisect import bisect_right

from mcap import records as mcap
from mcap.opcode import Opcode

from heading_intercompare.bags.errors import BagError
from heading_intercompare.bags.mcap.record_stream import parse_record

__all__ = ['Definitions']

_Definition = mcap.Schema | mcap.Channel


class _History:
    """Definitions of one kind by number, each valid from an epoch on."""

    def __init__(self) -> None:
        self._rows: dict[int, tuple[list[int], list[_Definition]]] = {}

    def add(self, epoch: int, definition: _Definition) -> None:
        """Take a definition; within an epoch the first one counts."""
        epochs, found = self._rows.setdefault(definition.id, ([], []))
        if not epochs or epochs[-1] < epoch:
            epochs.append(epoch)
            found.append(definition)

    def find(self, number: int, epoch: int, begin: int, end: int) -> _Definition | None:
        """Return the last definition up to `epoch`, or the next one, within [begin, end)."""
        epochs, found = self._rows.get(number, ([], []))
        place = bisect_right(epochs, epoch) - 1
        if place >= 0 and epochs[place] >= begin:
            return found[place]
        place += 1
        return found[place] if place < len(epochs) and epochs[place] < end else None


class Definitions:
    """
    The schemas and channels found in a file.

    Attributes
    ----------
    epoch : int
        The current epoch, counted from 0.

    """

    def __init__(self) -> None:
        self.epoch = 0
        self._files = [0]
        #: Definitions in chunks with a checksum, and others.
        self._schemas: tuple[_History, _History] = (_History(), _History())
        self._channels: tuple[_History, _History] = (_History(), _History())
        self._seen: set[tuple[int, bytes]] = set()
        #: By first byte of a chunk: the offsets in its records where epochs begin.
        self._within: dict[int, list[tuple[int, int]]] = {}

    def begin_file(self) -> None:
        """Begin a file that was appended: the definitions so far do not apply to it."""
        self.epoch += 1
        self._files.append(self.epoch)
        self._seen.clear()

    def take(self, opcode: int, content: bytes, checked: bool, place: tuple[int, int]) -> None:
        """
        Take a definition.

        Parameters
        ----------
        opcode, content
            Opcode and content of its record; a damaged one is ignored.
        checked : bool
            It is in a chunk with a correct checksum.
        place : tuple of int
            The first byte of the chunk, and the offset of the definition in its records.

        """
        if checked and (opcode, content) in self._seen:
            return
        kind = mcap.Schema if opcode == Opcode.SCHEMA else mcap.Channel
        histories = self._schemas if opcode == Opcode.SCHEMA else self._channels
        try:
            definition = parse_record(kind, content)
        except BagError:
            return
        if not checked:
            histories[1].add(self.epoch, definition)
            return
        known = histories[0].find(definition.id, self.epoch, self._files[-1], self.epoch + 1)
        if known is not None and known != definition:
            self.epoch += 1
            self._seen.clear()
            self._within.setdefault(place[0], []).append((place[1], self.epoch))
        self._seen.add((opcode, content))
        histories[0].add(self.epoch, definition)

    def find_epochs(self, start: int) -> list[tuple[int, int]]:
        """Return where in the records of a chunk epochs begin, and their numbers."""
        return self._within.get(start, [])

    def topic(self, epoch: int, number: int) -> tuple[mcap.Channel, mcap.Schema] | None:
        """Return channel and schema of a number in an epoch; None if lost or not of ROS 2."""
        channel = self._find(self._channels, epoch, number)
        if channel is None or channel.message_encoding != 'cdr':
            return None
        schema = self._find(self._schemas, epoch, channel.schema_id)
        return None if schema is None else (channel, schema)

    def _find(self, histories: tuple[_History, _History], epoch: int,
              number: int) -> _Definition | None:
        file = bisect_right(self._files, epoch)
        begin = self._files[file - 1]
        end = self._files[file] if file < len(self._files) else self.epoch + 1
        for history in histories:
            definition = history.find(number, epoch, begin, end)
            if definition is not None:
                return definition
        return None
