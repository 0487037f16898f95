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
The order in which to read the pieces of a bag whose chunks are not in the order of time.

Files that were joined, swapped or renamed have early chunks after late ones. Read as they lie,
half of their readings would look late. The index tells where that is so. Then two orders are
tried: that of the files, and that of the log times. The one in which more stamps rise is taken,
because the clock of a recorder may have gone back while those of the sensors went on.
"""

from __future__ import annotations

from heapq import heappop, heappush
from typing import Callable, Collection, Iterable, Iterator, NamedTuple, Sequence, TypeVar

import numpy as np

from heading_intercompare.bags.mcap.mcap_file import ChunkRow, Part, Stretch
from heading_intercompare.core.records import Integers

from .decoding import count_falls, Decoded, Decoder, Found

#: Recorders take their topics by turns, so that chunks overlap by this much.
_SLACK_NS = 1_000_000_000
#: Bytes of records in a piece, at least, unless the log times go back earlier.
_PIECE_BYTES = 12 * 2**20
#: Readings that wait for earlier ones, at most.
_MOST_WAITING = 2**20
#: One reading in eight shows which order is right.
_SAMPLED = 8
_NEVER_NS = 2**63 - 1

_Item = TypeVar('_Item')


class Piece(NamedTuple):
    """Whole chunks of a file whose log times do not go back, and the first of these times."""

    number: int
    stretch: Stretch
    first_ns: int


def is_in_order(parts: Sequence[Part], topics: Collection[str]) -> bool:
    """
    Tell whether the chunks with some topics are in the order of time, by their index.

    Parameters
    ----------
    parts
        The files of a bag, in their order.
    topics
        The topics; each is looked at on its own.

    """
    rows = [[row for row in part.chunk_rows() if row.last_ns] for part in parts]
    first = np.array([row.first_ns for part in rows for row in part], np.uint64).astype(float)
    last = np.array([row.last_ns for part in rows for row in part], np.uint64).astype(float)
    if (first[1:] >= np.maximum.accumulate(last)[:-1] - _SLACK_NS).all():
        return True
    newest_ns = dict.fromkeys(topics, -_SLACK_NS)
    for part, mine in zip(parts, rows):
        named: dict[tuple[bytes, bytes], list[str]] = {}
        for row in mine:
            if row.channels not in named:
                named[row.channels] = _topics_in(part, row, topics)
            for topic in named[row.channels]:
                if row.first_ns < newest_ns[topic] - _SLACK_NS:
                    return False
                newest_ns[topic] = max(newest_ns[topic], row.last_ns)
    return True


def _topics_in(part: Part, row: ChunkRow, topics: Collection[str]) -> list[str]:
    """Return which of some topics a chunk has; all of the file if its index does not say."""
    low, high = row.channels
    numbers = ({a + 256 * b for a, b in zip(low, high)} or {*part.channels}) & {*part.channels}
    return [topic for topic in {part.channels[number].topic for number in numbers}
            if topic in topics]


def cut_pieces(parts: Sequence[Part]) -> list[Piece]:
    """Cut files where their log times go back, and where a piece is large; in file order."""
    pieces: list[Piece] = []
    for number, part in enumerate(parts):
        whole = part.stretches()
        begin, first_ns, newest_ns, size = whole[0].begin, 0, 0, 0
        for row in part.chunk_rows():
            if not begin <= row.begin < part.end:
                continue
            if size and (row.first_ns < newest_ns or size >= _PIECE_BYTES):
                pieces.append(Piece(number, Stretch(begin, row.begin, size), first_ns))
                begin, size = row.begin, 0
            if not size:
                first_ns = row.first_ns
            newest_ns, size = row.first_ns, size + max(row.size, 1)
        pieces.append(Piece(number, Stretch(begin, part.end, size), first_ns))
    return pieces


def rises_by_time(decoder: Decoder, pieces: Iterable[Piece]) -> bool:
    """
    Tell whether more stamps rise in the order of the log times than in that of the files.

    It reads all pieces.

    Raises
    ------
    OSError, BagError
        If a piece cannot be read.

    """
    seen: dict[int, list[tuple[Integers, Integers]]] = {}
    for piece in pieces:
        for readings in (readings for block in _read(decoder, piece) for readings in block.found):
            for place in np.unique(readings.place).tolist():
                mine = np.flatnonzero(readings.place == place)[::_SAMPLED]
                seen.setdefault(place, []).append((readings.log_time_ns[mine],
                                                   readings.headings.stamp_ns[mine]))
    files = by_time = 0
    for samples in seen.values():
        log_time_ns, stamp_ns = (np.concatenate(column) for column in zip(*samples))
        files += count_falls(stamp_ns)
        by_time += count_falls(stamp_ns[np.argsort(log_time_ns, kind='stable')])
    return by_time < files


def _read(decoder: Decoder, piece: Piece) -> Iterator[Decoded]:
    return decoder.blocks(piece.number, piece.stretch.begin, piece.stretch.end)


def _sort(pieces: Iterable[Piece]) -> Iterator[tuple[Piece, int]]:
    """Yield pieces by their first log time, each with that of the next one."""
    ordered = sorted(pieces, key=lambda piece: (piece.first_ns, piece.number, piece.stretch.begin))
    later_ns = [min(piece.first_ns, _NEVER_NS) for piece in ordered[1:]] + [_NEVER_NS]
    return zip(ordered, later_ns)


def merge_by_time(pieces: Iterable[Piece],
                  read: Callable[[Piece], Iterable[tuple[int, _Item]]]) -> Iterator[_Item]:
    """Yield what is read of pieces, each item with a log time, as `read_by_time` does."""
    waiting: list[tuple[int, int, _Item]] = []
    count = 0
    for piece, limit_ns in _sort(pieces):
        for time_ns, item in read(piece):
            count += 1
            heappush(waiting, (time_ns, count, item))
            if len(waiting) > _MOST_WAITING:
                yield heappop(waiting)[2]
        while waiting and (waiting[0][0] < limit_ns or limit_ns == _NEVER_NS):
            yield heappop(waiting)[2]


def read_by_time(decoder: Decoder, pieces: Iterable[Piece],
                 counts: dict[int, int]) -> Iterator[Decoded]:
    """
    Yield the readings of pieces in the order of their log times.

    Readings wait until no later piece can hold an earlier reading. If a million wait, the earlier
    half is yielded all the same, so memory stays bounded.

    Parameters
    ----------
    decoder
        Turns the messages of a piece into readings.
    pieces
        Parts of the files, in any order.
    counts
        Gets the number of messages read, by file.

    Raises
    ------
    OSError, BagError
        If a piece cannot be read.

    """
    waiting: list[list[Found]] = []
    held = fresh = 0
    for piece, limit_ns in _sort(pieces):
        for block in _read(decoder, piece):
            counts[piece.number] = counts.get(piece.number, 0) + block.messages
            waiting.append(block.found)
            fresh += _count_rows(block.found)
            if held + fresh > _MOST_WAITING:
                middle = np.concatenate([
                    readings.log_time_ns for by_kind in waiting for readings in by_kind])
                released, waiting = _release(waiting, int(np.median(middle)) + 1)
                held, fresh = sum(map(_count_rows, waiting)), 0
                yield Decoded(0, released)
        # Not for a few readings: where many wait, looking at all of them takes time.
        if 4 * fresh >= held or limit_ns == _NEVER_NS:
            released, waiting = _release(waiting, limit_ns)
            held, fresh = sum(map(_count_rows, waiting)), 0
            yield Decoded(0, released)


def _count_rows(by_kind: Iterable[Found]) -> int:
    return sum(len(readings.place) for readings in by_kind)


def _release(waiting: Sequence[Sequence[Found]],
             limit_ns: int) -> tuple[list[Found], list[list[Found]]]:
    """Return the readings before a log time, in order, and the later readings."""
    released, pending = [], []
    for blocks in zip(*waiting):
        readings = Found.concatenate(blocks)
        early = readings.log_time_ns < limit_ns
        rows = np.flatnonzero(early)
        released.append(readings.take(rows[np.argsort(readings.log_time_ns[rows], kind='stable')]))
        pending.append(readings.take(np.flatnonzero(~early))._replace(unreadable=(0, ''),
                                                                         claims=()))
    return released, [pending] if any(len(readings.place) for readings in pending) else []
