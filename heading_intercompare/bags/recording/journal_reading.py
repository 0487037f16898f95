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

"""What the journal of a run holds, given to a judgement: after a crash, or to analyze it."""

from __future__ import annotations

from contextlib import contextmanager
from dataclasses import dataclass, field
import json
from pathlib import Path
import struct
from typing import Any, Iterator, Mapping, Protocol, Sequence

from heading_intercompare.bags.errors import BagError
from heading_intercompare.core.kept_state import KeptState
from heading_intercompare.core.pairing.incarnations import Incarnations, StreamNumbers
from heading_intercompare.core.pairing.ledger import Ledger, LedgerSegment
from heading_intercompare.core.pairing.names import Span
from heading_intercompare.core.raw_streams.stamp_jumps import SetBack
from heading_intercompare.core.records import Motion, Pairs
from heading_intercompare.core.utc_text import utc
from heading_intercompare.messages.ledger_messages import LedgerMessage
from heading_intercompare.messages.status_messages import MARKS

from .journal import decode_columns, JournalContents, Record

ABOUT, STATE, RUN, PAIRS, MARK, LEDGER, HOLE = b'H', b'S', b'R', b'P', b'M', b'L', b'G'
MOTION = b'V'
LENGTH = struct.Struct('<I')

#: Pairs judged at once when a journal is read.
_AT_ONCE = 65536
#: What wrong bytes raise.
_WRONG = (ValueError, KeyError, TypeError, AttributeError, IndexError, OverflowError, struct.error)

#: First number, newest number and missing numbers of the pairs of each synchronizer, by name.
Numbers = Mapping[str, tuple[int, int, int]]


@dataclass(slots=True)
class Kept:
    """
    What a journal says besides the pairs.

    Attributes
    ----------
    ledgers
        The last ledger of each synchronizer, by its start.
    before
        The ledger that the newest one replaced.
    marks : set of (kind, stamp_ns)
        Marks that took effect.
    numbers : mapping
        First number, newest number and missing numbers of the pairs, by synchronizer.
    n_pairs
        Pairs of the runs that the journal holds.
    start_ns, newest_ns
        Stamps of the first and of the newest of these pairs.
    dropped
        Records that could not be written.
    motion_ns
        Newest stamps of the motion taken, as of `find_newest`.

    """

    ledgers: dict[int, LedgerMessage] = field(default_factory=dict)
    before: LedgerMessage | None = None
    marks: set[tuple[str, int]] = field(default_factory=set)
    numbers: Numbers = field(default_factory=dict)
    n_pairs: int = 0
    start_ns: int | None = None
    newest_ns: int | None = None
    dropped: int = 0
    motion_ns: Mapping[str, int] = field(default_factory=dict)

    def book(self, message: LedgerMessage) -> None:
        """Take the newest ledger of a synchronizer."""
        self.before = self.ledgers.get(message.started_ns)
        self.ledgers[message.started_ns] = message

    @property
    def newest(self) -> LedgerMessage | None:
        """Return the last ledger of the last start; None before the first."""
        return max(self.ledgers.values(), key=lambda message: message.started_ns, default=None)

    def sum_ledgers(self) -> Incarnations:
        """Return the ledgers of all starts of the synchronizer, to be added up."""
        incarnations = Incarnations()
        for message in self.ledgers.values():
            incarnations.take(*message)
        return incarnations


@dataclass(frozen=True, slots=True)
class JournalOrigin:
    """
    The trial of a journal.

    Attributes
    ----------
    settings
        Settings of the analysis, by dotted name.
    software
        Version that began the journal.
    began_ns
        Time at which it was begun, UTC ns.
    bag
        Newest recording of the trial, as the node named it.

    """

    settings: Mapping[str, Any]
    software: str
    began_ns: int
    bag: str | None


class Judge(Protocol):
    """Takes what a journal holds, as a `Compliance` does."""

    def update(self, pairs: Pairs) -> None:
        """Take pairs in stamp order."""

    def take_motion(self, motion: Motion) -> None:
        """Take motion of the ship."""

    def mark(self, kind: str, stamp_ns: int) -> None:
        """Take a mark."""

    def go_on(self, state: KeptState, pairs: Pairs) -> None:
        """Go on from judged runs, and the pairs that the run after them had."""


class Unjudged:
    """A `Judge` for those who want to know only what a journal holds."""

    def update(self, pairs: Pairs) -> None:
        """Take pairs in stamp order."""

    def take_motion(self, motion: Motion) -> None:
        """Take motion of the ship."""

    def mark(self, kind: str, stamp_ns: int) -> None:
        """Take a mark."""

    def go_on(self, state: KeptState, pairs: Pairs) -> None:
        """Take judged runs, and the pairs that the run after them had."""


@contextmanager
def _decoding(path: Path) -> Iterator[None]:
    """Raise BagError for bytes that another version wrote, or that nobody wrote."""
    try:
        yield
    except _WRONG as error:
        raise BagError(f'this version cannot read it: {" ".join(str(error).split())[:200]}',
                       path) from error


def read_origin(contents: JournalContents, path: Path) -> JournalOrigin:
    """
    Return which trial a journal belongs to.

    Raises
    ------
    BagError
        If it does not say so: its first record was cut, or this version cannot read it.

    """
    if not contents.records:
        raise BagError('its first record was cut, so it holds neither settings nor pairs: there '
                       'is nothing to judge', path)
    with _decoding(path):
        abouts = [json.loads(data) for kind, data in contents.records if kind == ABOUT]
        settings, bag = abouts[0]['settings'], abouts[-1].get('bag')
        if not isinstance(settings, dict):
            raise ValueError('its settings must be a mapping')
        return JournalOrigin(settings, str(abouts[0]['software']), int(abouts[0]['began_ns']),
                             bag if isinstance(bag, str) else None)


def read_state(records: Sequence[Record]) -> tuple[KeptState | None, set[tuple[str, int]]]:
    """
    Return the judged runs in a journal, None if there are none, and the marks up to then.

    Raises
    ------
    ValueError, KeyError, TypeError, AttributeError
        If another version wrote them.

    """
    state, marks = None, set()
    for kind, data in records:
        if kind == STATE:
            plain = json.loads(data)
            state = KeptState.from_text(plain['state'])
            marks = {(word, stamp_ns) for word, stamp_ns in plain['marks']}
    return state, marks


def compare_settings(settings: Mapping[str, Any] | None, reference: Mapping[str, Any]) -> str:
    """Return the names of the settings that differ, the first three by name; '' if none do."""
    settings = settings or {}
    names = [name for name in {**reference, **settings}
             if settings.get(name) != reference.get(name)]
    more = f' and {len(names) - 3} more' if len(names) > 3 else ''
    return f'{", ".join(names[:3])}{more}'


class JournalReader:
    """
    Gives the contents of a journal to a judge.

    Parameters
    ----------
    path
        Name of the journal, for errors.
    summary
        Takes what the journal says besides the pairs.

    Attributes
    ----------
    kept : Kept
    rows
        Segments of the last ledger of each synchronizer as they are written, by its start.

    """

    def __init__(self, path: Path, summary: Kept | None = None) -> None:
        self._path = path
        self.kept = Kept() if summary is None else summary
        self.rows: dict[int, list[Any]] = {}
        self._waiting: list[Pairs] = []
        self._n_waiting = 0

    def read(self, contents: JournalContents, judge: Judge) -> KeptState | None:
        """
        Give a judge the judged runs, pairs and marks in their order; return the judged runs.

        Raises
        ------
        BagError
            If this version cannot read a record.

        """
        with _decoding(self._path):
            state, self.kept.marks = read_state(contents.records)
        for kind, data in contents.records:
            if kind == RUN and state is not None:
                judge.go_on(state, self._take_pairs(data))
            elif kind == PAIRS:
                pairs = self._take_pairs(data)
                self._waiting.append(pairs)
                self._n_waiting += len(pairs)
                if self._n_waiting > _AT_ONCE:
                    self._judge(judge)
            elif kind == MOTION:
                judge.take_motion(self._take_motion(data))
            elif kind == MARK:
                self._judge(judge)
                with _decoding(self._path):
                    word, stamp_ns = json.loads(data)
                    if word not in MARKS:
                        raise ValueError(f'a mark must be one of {", ".join(MARKS)}')
                    self.kept.marks.add((word, stamp_ns))
                judge.mark(word, stamp_ns)
            else:
                with _decoding(self._path):
                    self._take_account(kind, data)
        self._judge(judge)
        return state

    def _judge(self, judge: Judge) -> None:
        judge.update(Pairs.concatenate(self._waiting))
        self._waiting.clear()
        self._n_waiting = 0

    def _take_account(self, kind: bytes, data: bytes) -> None:
        """Take what is neither pairs nor marks."""
        if kind == LEDGER:
            self._take_ledger(json.loads(data))
        elif kind == HOLE:
            self.kept.dropped += json.loads(data)

    def _take_pairs(self, data: bytes) -> Pairs:
        summary = self.kept
        with _decoding(self._path):
            size, = LENGTH.unpack_from(data)
            at = LENGTH.size + size
            summary.numbers = {name: (first, last, missing) for name, (first, last, missing)
                               in json.loads(data[LENGTH.size:at]).items()}
            pairs = decode_columns(data[at:], Pairs)
        if len(pairs):
            summary.n_pairs += len(pairs)
            summary.newest_ns = int(pairs.stamp_ns[-1])
            if summary.start_ns is None:
                summary.start_ns = int(pairs.stamp_ns[0])
        return pairs

    def _take_motion(self, data: bytes) -> Motion:
        with _decoding(self._path):
            size, = LENGTH.unpack_from(data)
            at = LENGTH.size + size
            self.kept.motion_ns = {what: int(newest_ns) for what, newest_ns
                                   in json.loads(data[LENGTH.size:at]).items()}
            return decode_columns(data[at:], Motion)

    def _take_ledger(self, plain: Mapping[str, Any]) -> None:
        started_ns = plain['started_ns']
        rows = self.rows.get(started_ns, [])[:plain['at']] + plain['segments']
        self.rows[started_ns] = rows
        ledger = Ledger.from_segments(
            [LedgerSegment(start_ns, counts, clock_segment=clock_segment)
             for start_ns, counts, clock_segment in rows], plain['newest_ns'],
            [SetBack(*set_back) for set_back in plain['set_backs']])
        numbers = {stream: StreamNumbers(*fields)._replace(spans=tuple(Span(*s) for s in spans))
                   for stream, (*fields, spans) in plain['numbers'].items()}
        self.kept.book(LedgerMessage(ledger, plain['final'], started_ns, numbers))


def describe_gaps(summary: Kept, torn: int) -> Iterator[str]:
    """
    Yield, in plain sentences, what is missing from a journal.

    Parameters
    ----------
    summary
        Of the journal.
    torn
        Its last bytes, of a record that was cut.

    """
    if torn:
        yield (f'its last {torn} bytes are of a record that was cut, or is being written: its '
               'pairs, mark or ledger are missing')
    numbers = [*summary.numbers.values()]
    before = sum(max(0, (first or 1) - 1) for first, _, _ in numbers)
    if before:
        yield f'{before} pairs were published before the node that kept it started'
    if missing := sum(n_missing for _, _, n_missing in numbers):
        yield f'{missing} pairs never came to that node: lost on the way, or while it was down'
    if summary.dropped:
        yield f'{summary.dropped} records could not be written into it'
    ledgers = summary.sum_ledgers()
    yield from ledgers.problems()
    last = numbers[-1][1] if numbers else 0
    if not len(ledgers):
        yield 'it holds no ledger: its pairs count as all readings received'
    elif ledgers.paired < last:
        yield f'its last ledger counts {ledgers.paired} of the {last} pairs published so far'
    elif ledgers.paired > last:
        yield f'{ledgers.paired - last} pairs that its last ledger counts are not in it'
    if summary.newest_ns is not None:
        yield (f'it ends with the pair of {utc(summary.newest_ns)} UTC: what came later is not '
               'in it')
