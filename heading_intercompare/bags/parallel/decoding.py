# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Decoding of the headings in stretches of the files of a bag."""

from __future__ import annotations

from contextlib import ExitStack
from typing import Iterator, Mapping, NamedTuple, Sequence

import numpy as np

from heading_intercompare.bags.errors import BagError
from heading_intercompare.bags.mcap.mcap_file import Part, Stretch
from heading_intercompare.bags.mcap.message_blocks import Block
from heading_intercompare.bags.mcap.record_stream import RecordStream
from heading_intercompare.core.records import Headings
from heading_intercompare.messages.errors import MessageError
from heading_intercompare.messages.heading_messages import decode_headings

__all__ = ['Decoded', 'Decoder', 'Found', 'Kind']

#: At most this many bytes of records, and this many messages, are decoded at once.
_MOST_BYTES = 2**26
_MOST_MESSAGES = 2**20


class Kind(NamedTuple):
    """Topics decoded alike: their type and convention, and the index of each by name."""

    type_name: str
    convention: str
    places: Mapping[str, int]


class Found(NamedTuple):
    """Headings of a kind in file order: log time in ns, index of the topic, number, reading."""

    log_time_ns: np.ndarray
    place: np.ndarray
    sequence: np.ndarray
    headings: Headings


class Decoded(NamedTuple):
    """A block: the number of its messages, of all topics, and its headings by kind."""

    count: int
    found: list[Found]


def _find_headings(block: Block, kind: Kind, place_of: np.ndarray) -> Found:
    """Return the headings in a block; `place_of` gives the topic index of a channel, or -1."""
    place = place_of[block.heads['channel']]
    which = slice(None)
    if place.size and place.min() < 0:
        which = np.flatnonzero(place >= 0)
        place = place[which]
    headings = decode_headings(kind.type_name, kind.convention, block.data, block.start[which],
                               block.stop[which])
    heads = block.heads[which]
    return Found(heads['log_time'].copy(), place, heads['sequence'].copy(), headings)


class Decoder:
    """
    Reads headings from files, one file open at a time.

    Parameters
    ----------
    parts : sequence of Part
        The files; a file is identified by its index.
    kinds : sequence of Kind
        The topics to read.

    """

    def __init__(self, parts: Sequence[Part], kinds: Sequence[Kind]) -> None:
        self.parts = parts
        self._kinds = kinds
        self._number = -1
        self._file = ExitStack()

    def __enter__(self) -> 'Decoder':
        return self

    def __exit__(self, *exc) -> None:
        self._number = -1
        self._file.close()

    def _open(self, number: int) -> RecordStream:
        if number != self._number:
            self.__exit__()
            part = self.parts[number]
            self._stream = self._file.enter_context(part.open())
            self._places = [np.full(2**16, -1, np.int16) for _ in self._kinds]
            for channel in part.channels:
                for kind, place_of in zip(self._kinds, self._places):
                    place_of[channel] = kind.places.get(part.channels[channel].topic, -1)
            self._number = number
        return self._stream

    def blocks(self, number: int, begin: int, end: int | None = None) -> Iterator[Decoded]:
        """
        Yield the blocks between two bytes of a file, or up to its end.

        Raises
        ------
        OSError, BagError
            If a block cannot be read; the blocks before it have been yielded.

        """
        part = self.parts[number]
        for block in part.blocks_of(self._open(number), begin, end):
            try:
                found = [_find_headings(block, *each) for each in zip(self._kinds, self._places)]
            except MessageError as error:
                raise BagError(error.problem, part.path, block.offset) from None
            yield Decoded(len(block.start), found)

    def stretch(self, number: int, stretch: Stretch) -> list[Decoded] | None:
        """Return the blocks of a stretch; None if it is damaged or too large to hold in memory."""
        if stretch.size > _MOST_BYTES:
            return None
        decoded, count = [], 0
        try:
            for block in self.blocks(number, stretch.begin, stretch.end):
                decoded.append(block)
                count += block.count
                if count > _MOST_MESSAGES:
                    return None
        except (BagError, OSError):
            return None
        return decoded
