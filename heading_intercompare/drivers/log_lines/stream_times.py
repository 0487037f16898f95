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

"""The times that sentences of a stream tell: ZDA, RMC, GGA."""

from __future__ import annotations

from itertools import chain
from typing import Callable, Iterable, Iterator, Sequence

from heading_intercompare.drivers.framing import Framer

from .days import Days
from .rollovers import Rollovers
from .times import gga_ns, nearest_day_ns, rmc_ns, zda_ns

#: Sentences that tell the time, the best first; only the best of those in a log is used.
TIME_SENTENCES = ('ZDA', 'RMC', 'GGA')

_RANKS = {f'{kind},'.encode(): rank for rank, kind in enumerate(TIME_SENTENCES)}
#: Bytes kept of a line that does not end; it has no sentence beyond them.
_MOST_TAIL = 1 << 16
_DATED: dict[int, Callable[[list[bytes]], int]] = {0: zda_ns, 1: rmc_ns}


def find_kind(blocks: Iterable[bytes], lenient: bool = False) -> str | None:
    """
    Return the sentence that tells the time in a log; None without one.

    It is the best of those that tell a valid time at least once; if none does, the best of all.

    Parameters
    ----------
    blocks
        The log, cut anywhere.
    lenient
        Sentences without a checksum count too.

    """
    best = present = len(TIME_SENTENCES)
    tail = b''
    for block in chain(blocks, (b'\n',)):
        text = tail + block
        end = max(text.rfind(b'\n'), text.rfind(b'\r')) + 1
        text, tail = text[:end], text[end:][-_MOST_TAIL:]
        if not any(token in text for token, rank in _RANKS.items() if rank < best):
            continue
        for rank, sentence in _time_sentences(text, lenient):
            present = min(present, rank)
            if rank < best and _tells_time(sentence, rank):
                best = rank
        if best == 0:
            break
    best = present if best == len(TIME_SENTENCES) else best
    return TIME_SENTENCES[best] if best < len(TIME_SENTENCES) else None


def _time_sentences(text: bytes, lenient: bool) -> Iterator[tuple[int, bytes]]:
    """Yield the sentences of whole lines that tell the time, each with the rank of its kind."""
    for _, _, sentence, checked, _ in Framer().feed(text, None):
        rank = _RANKS.get(sentence[2:6])
        if rank is not None and (checked or lenient):
            yield rank, sentence


def _tells_time(text: bytes, rank: int) -> bool:
    """Tell whether a sentence of this rank tells a valid time."""
    try:
        _DATED.get(rank, gga_ns)(text.split(b','))
    except ValueError:
        return False
    return True


def find_first_time(blocks: Iterable[bytes]) -> int | None:
    """Return the first time with a date that a log tells, nanoseconds UTC; None without one."""
    framer = Framer()
    for block in blocks:
        for frame in framer.feed(block, None):
            rank = _RANKS.get(frame[2][2:6])
            if rank in _DATED:
                try:
                    return _DATED[rank](frame[2].split(b','))
                except ValueError:
                    continue
    return None


class StreamTimes:
    """
    The time that a stream tells about its next sentences.

    Parameters
    ----------
    days
        The day of a GGA.
    kinds
        The sentences to use, of `TIME_SENTENCES`: the best that has told a valid time so far.

    Attributes
    ----------
    newest_ns
        The last time with its date, nanoseconds UTC.
    rollovers
        Undoes those of GPS that the receiver has missed.

    """

    def __init__(self, days: Days, kinds: Sequence[str] = TIME_SENTENCES) -> None:
        self._days = days
        self._ranks = {f'{kind},'.encode(): TIME_SENTENCES.index(kind) for kind in kinds}
        self._rank = len(TIME_SENTENCES)
        #: The addresses of sentences that have told a valid time.
        self._valid: set[bytes] = set()
        self.newest_ns: int | None = None
        self.rollovers = Rollovers(days)

    def tells(self, text: bytes) -> bool:
        """
        Tell whether a sentence is one whose time is used.

        Until one is valid, all are. Then those are not whose talker has never told a valid time.
        """
        rank = self._ranks.get(text[2:6])
        if rank is None or rank > self._rank:
            return False
        address = text[:5]
        if address not in self._valid and _tells_time(text, rank):
            self._valid.add(address)
            self._rank = rank
        return address in self._valid or not self._valid

    def read(self, text: bytes, received_ns: int | None) -> int:
        """
        Return the time that a sentence tells, nanoseconds UTC.

        Parameters
        ----------
        text
            A sentence of which `tells` is true.
        received_ns
            Its time of receipt, which says the day of a GGA and whether rollovers of GPS were
            missed; None: `Days` says it.

        Raises
        ------
        ValueError
            If the time is missing or impossible, or nothing says the day.

        """
        fields, rank = text.split(b','), self._ranks[text[2:6]]
        if rank in _DATED:
            ns = self.rollovers.undo(_DATED[rank](fields), received_ns)
            self.newest_ns = ns
            self._days.tell(ns)
            return ns
        return self.place(gga_ns(fields), received_ns)

    def place(self, time_of_day_ns: int, received_ns: int | None) -> int:
        """Return the instant of a time of day; ValueError if nothing says the day."""
        near_ns = self.newest_ns if self.newest_ns is not None else received_ns
        if near_ns is not None:
            return nearest_day_ns(time_of_day_ns, near_ns)
        ns = self._days.place(time_of_day_ns)
        if ns is None:
            raise ValueError('date')
        return ns
