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

from collections import Counter
from contextlib import contextmanager
from dataclasses import dataclass, field
from itertools import groupby
import json
from pathlib import Path
import struct
from typing import Any, Iterable, Iterator, Mapping, NamedTuple, Protocol, Sequence

from heading_intercompare.bags.errors import BagError
from heading_intercompare.core.kept_state import KeptState
from heading_intercompare.core.pairing.incarnations import Incarnations
from heading_intercompare.core.pairing.ledger import Ledger, LedgerSegment
from heading_intercompare.core.pairing.pair_maker import PairMaker
from heading_intercompare.core.raw_streams.stamp_jumps import SetBack
from heading_intercompare.core.records import Motion, Pairs, Quality
from heading_intercompare.core.sensors.pair_names import list_names, Names, TWO
from heading_intercompare.core.utc_text import utc
from heading_intercompare.messages.ledger_messages import LedgerMessage
from heading_intercompare.messages.status_messages import MARKS

from .frozen_state import hash_code, thaw_makers
from .journal_file import decode_columns, JournalContents, Record, split_parts
from .reading_batches import choose_pairs, decode_batch, decode_numbers, LastHeard

ABOUT, STATE, PAIRS, MARK, LEDGER, HOLE = b'H', b'S', b'P', b'M', b'L', b'G'
MOTION, BATCH, MAKERS, QUALITY = b'V', b'B', b'K', b'Q'

#: Pairs judged at once when a journal is read.
_AT_ONCE = 65536
#: What wrong bytes raise.
_WRONG = (ValueError, KeyError, TypeError, AttributeError, IndexError, OverflowError, struct.error)

#: First number, newest number and missing numbers of the pairs of each synchronizer, and the
#: number of its first clock segment, by name.
Numbers = Mapping[str, tuple[int, int, int, int]]


@dataclass(slots=True)
class Kept:
    """
    What a journal says besides the pairs.

    Attributes
    ----------
    ledgers
        The last ledger of each synchronizer, by its start.
    marks : set of (kind, stamp_ns)
        Marks that took effect.
    numbers : mapping
        Of the pairs, by synchronizer.
    n_pairs
        Pairs of the runs that the journal holds.
    start_ns, newest_ns
        Stamps of the first and of the newest of these pairs.
    dropped
        Records that could not be written.
    motion_ns
        Newest stamps of the motion taken, as of `find_newest`.
    heard, now_s
        The numbers of the readings taken, and the clock by which they waited, where the journal
        holds readings.
    n_readings
        Readings of each sensor after the last of the pairs in the journal.
    restarts : list of (started_ns, stream)
        Starts of the process that pairs, UTC ns, after which a sensor had another publisher.

    """

    ledgers: dict[int, LedgerMessage] = field(default_factory=dict)
    marks: set[tuple[str, int]] = field(default_factory=set)
    numbers: Numbers = field(default_factory=dict)
    n_pairs: int = 0
    start_ns: int | None = None
    newest_ns: int | None = None
    dropped: int = 0
    motion_ns: Mapping[str, int] = field(default_factory=dict)
    heard: Mapping[str, LastHeard] = field(default_factory=dict)
    now_s: float = 0.0
    n_readings: Counter[str] = field(default_factory=Counter)
    restarts: list[tuple[int, str]] = field(default_factory=list)

    def book(self, message: LedgerMessage) -> None:
        """Take the newest ledger of a synchronizer."""
        self.ledgers[message.started_ns] = message

    def sum_ledgers(self) -> Incarnations:
        """Return the ledgers of all starts of the synchronizer, to be added up."""
        incarnations = Incarnations()
        for message in self.ledgers.values():
            *_, first_segment = self.numbers.get(str(message.started_ns), (None,))
            incarnations.take(*message, first_segment=first_segment)
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
    names
        The pairs of sensors in it.
    holds_readings
        The process that kept it paired the readings, and they are in it.

    """

    settings: Mapping[str, Any]
    software: str
    began_ns: int
    bag: str | None
    names: tuple[Names, ...]
    holds_readings: bool


class Judge(Protocol):
    """Takes what a journal holds, as a `Compliance` does."""

    def update(self, pairs: Pairs) -> None:
        """Take pairs in stamp order."""

    def take_motion(self, motion: Motion) -> None:
        """Take motion of the ship."""

    def take_quality(self, stream: str, quality: Quality) -> None:
        """Take what ``'ts'`` or ``'rs'`` says of its readings."""

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

    def take_quality(self, stream: str, quality: Quality) -> None:
        """Take what ``'ts'`` or ``'rs'`` says of its readings."""

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
        code, software = abouts[0].get('code'), str(abouts[0]['software'])
        if code is not None and code != hash_code():
            raise BagError(f'was written by other code of version {software}, and only that can '
                           'pair its readings: analyze it there, or analyze the recording', path)
        return JournalOrigin(settings, software, int(abouts[0]['began_ns']),
                             bag if isinstance(bag, str) else None,
                             tuple((first, second) for first, second in abouts[0]['pairs']),
                             code is not None)


class Survey(NamedTuple):
    """
    Which records of a journal a restart uses.

    Attributes
    ----------
    starts : tuple of int
        Where the newest judged runs of each two sensors are: what is before does not count for
        them. Without judged runs they begin with the first record.
    paired
        Where the newest state of the pairing is: readings before it are not used.
    live_bytes
        Bytes of the records that are used, about.

    """

    starts: tuple[int, ...]
    paired: int
    live_bytes: int

    def uses(self, at: int, kind: bytes, pair: int | None) -> bool:
        """Tell whether a record is used, given its place, its kind and its two sensors."""
        if kind in (BATCH, MAKERS):
            return at >= self.paired
        return at >= (min(self.starts) if pair is None else self.starts[pair])


def find_pair(record: Record) -> int | None:
    """Return the number of the two sensors that a record is of; None if it is of all."""
    if record.kind not in (STATE, PAIRS, MOTION, QUALITY):
        return None
    pair: int | None = split_parts(record.data)[0]['pair']
    return pair


def survey_records(records: Iterable[Record], n_pairs: int) -> Survey:
    """
    Return which records are used, given of how many pairs of sensors they are.

    Raises
    ------
    ValueError, KeyError, TypeError, IndexError, struct.error
        If another version wrote them.

    """
    starts, paired = [0] * n_pairs, 0
    n_of_pair, n_common, n_batches = [0] * n_pairs, 0, 0
    # Bytes that are common to all, up to the start of each pair.
    n_before = [0] * n_pairs
    for at, record in enumerate(records):
        pair, n = find_pair(record), len(record.data)
        if record.kind == STATE and pair is not None:
            starts[pair], n_of_pair[pair], n_before[pair] = at, 0, n_common
        elif record.kind == MAKERS:
            paired, n_batches = at, 0
        if record.kind in (BATCH, MAKERS):
            n_batches += n
        elif pair is not None:
            n_of_pair[pair] += n
        elif record.kind not in (ABOUT, LEDGER):
            # Those two are written again.
            n_common += n
    return Survey(tuple(starts), paired,
                  n_batches + sum(n_of_pair) + n_common - min(n_before))


def check_states(records: Sequence[Record], n_pairs: int) -> None:
    """
    Raise an error if judged runs of any pair of sensors, or the pairing's state, are unreadable.

    Raises
    ------
    BagError, ValueError, KeyError, TypeError, AttributeError
        If another version wrote them.

    """
    survey = survey_records(records, n_pairs)
    for at in survey.starts:
        if records[at].kind == STATE:
            KeptState.from_text(split_parts(records[at].data)[0]['state'])
    if records[survey.paired].kind == MAKERS:
        thaw_makers(split_parts(records[survey.paired].data)[1])


def compare_settings(settings: Mapping[str, Any] | None, reference: Mapping[str, Any]) -> str:
    """Return the names of the settings that differ, the first three by name; '' if none do."""
    settings = settings or {}
    names = [name for name in {**reference, **settings}
             if settings.get(name) != reference.get(name)]
    more = f' and {len(names) - 3} more' if len(names) > 3 else ''
    return f'{", ".join(names[:3])}{more}'


class JournalReader:
    """
    Gives the contents of a journal to judges, one for each pair of sensors.

    Parameters
    ----------
    path
        Name of the journal, for errors.
    names : sequence of (str, str)
        The pairs of sensors in the journal, by their names.
    summary
        Takes what the journal says besides the pairs.
    makers
        Make the pairs of each two, as after construction, and go on after the readings in the
        journal. Without them readings are only counted.

    Attributes
    ----------
    kept : Kept
    paired_again : list of list of Pairs
        For each batch of readings that the journal has no pairs of, the pairs of each two.
    rows
        Segments of the last ledger of each synchronizer as they are written, by its start.

    """

    def __init__(self, path: Path, names: Sequence[Names] = (TWO,), summary: Kept | None = None,
                 makers: Sequence[PairMaker] | None = None) -> None:
        self._path, self._names, self._makers = path, names, makers
        self._sensors = list_names(names)
        self.kept = Kept() if summary is None else summary
        self.rows: dict[int, list[Any]] = {}
        self.paired_again: list[list[Pairs]] = []
        self._waiting: list[list[Pairs]] = [[] for _ in names]
        self._n_waiting = 0

    def read(self, contents: JournalContents, judges: Sequence[Judge]) -> int:
        """
        Give judges the judged runs, pairs and marks in their order.

        Returns
        -------
        int
            How many runs were judged.

        Raises
        ------
        BagError
            If this version cannot read a record.

        """
        with _decoding(self._path):
            survey = survey_records(contents.records, len(judges))
        n_judged = 0
        for at, record in enumerate(contents.records):
            pair = find_pair(record)
            if record.kind not in (ABOUT, HOLE, LEDGER) and not survey.uses(
                    at, record.kind, pair):
                continue
            takers = {number: judge for number, judge in enumerate(judges)
                      if pair in (None, number) and at >= survey.starts[number]}
            kind, data = record
            if kind == STATE and pair is not None:
                n_judged += self._begin(pair, data, judges[pair])
            elif kind in (PAIRS, BATCH):
                for number, pairs in [(pair or 0, self._take_pairs(data))] if kind == PAIRS else (
                        enumerate(self._pair(data))):
                    self._waiting[number].append(pairs)
                    self._n_waiting += len(pairs)
                if self._n_waiting > _AT_ONCE:
                    self._judge(judges)
            elif kind == MOTION:
                motion = self._take_motion(data)
                for judge in takers.values():
                    judge.take_motion(motion)
            elif kind == QUALITY:
                self._hand_out_quality(data, takers)
            elif kind == MARK:
                self._judge(judges)
                self._mark(data, [*takers.values()])
            else:
                with _decoding(self._path):
                    self._take_account(kind, data)
        self._judge(judges)
        return n_judged

    def _begin(self, pair: int, data: bytes, judge: Judge) -> int:
        """Let a judge go on from judged runs; return how many there are."""
        with _decoding(self._path):
            plain = split_parts(data)[0]
            state = KeptState.from_text(plain['state'])
            self.kept.marks |= {(word, stamp_ns) for word, stamp_ns in plain['marks']}
        self._waiting[pair].clear()
        judge.go_on(state, self._take_pairs(data))
        return state.n_judged

    def _mark(self, data: bytes, takers: Sequence[Judge]) -> None:
        with _decoding(self._path):
            word, stamp_ns = json.loads(data)
            if word not in MARKS:
                raise ValueError(f'a mark must be one of {", ".join(MARKS)}')
            self.kept.marks.add((word, stamp_ns))
        for judge in takers:
            judge.mark(word, stamp_ns)
        for maker in self._makers or ():
            maker.pairer.ledger.cut_run(stamp_ns + 1)

    def finish(self, judges: Sequence[Judge]) -> list[Ledger | None]:
        """End the pairing of readings, give the judges the last pairs; return whole ledgers."""
        if self._makers is None:
            return [self.kept.sum_ledgers().total]
        for maker, judge in zip(self._makers, judges):
            pairs = maker.choose(maker.pairer.flush(), end=True)
            self._note_span(pairs)
            judge.update(pairs)
        return [maker.pairer.ledger for maker in self._makers]

    def _judge(self, judges: Sequence[Judge]) -> None:
        for judge, waiting in zip(judges, self._waiting):
            judge.update(Pairs.concatenate(waiting))
            waiting.clear()
        self._n_waiting = 0

    def _take_account(self, kind: bytes, data: bytes) -> None:
        """Take what is neither pairs nor marks."""
        if kind == ABOUT:
            self.kept.restarts = [(started_ns, stream) for started_ns, stream
                                  in json.loads(data).get('restarts', ())]
        elif kind == LEDGER:
            self._take_ledger(json.loads(data))
        elif kind == HOLE:
            self.kept.dropped += json.loads(data)
        elif kind == MAKERS:
            self._go_on_pairing(data)

    def _go_on_pairing(self, data: bytes) -> None:
        """Take the state of the pairing after the pairs in the journal."""
        plain, frozen = split_parts(data)
        self.kept.now_s = plain['now_s']
        self.kept.heard = {stream: LastHeard(decode_numbers(numbers), sent_ns)
                           for stream, (numbers, sent_ns) in plain['heard'].items()}
        if self._makers is not None:
            for maker, before in zip(self._makers, thaw_makers(frozen)):
                maker.go_on_from(before)

    def _pair(self, data: bytes) -> list[Pairs]:
        """Return the pairs that a batch of readings completes, to be judged."""
        summary = self.kept
        with _decoding(self._path):
            batch = decode_batch(data, summary.heard, self._sensors)
        summary.heard, summary.now_s = batch.heard, batch.now_s
        summary.n_readings += {name: len(rows) for name, rows in batch.headings.items()}
        if self._makers is None:
            return []
        made = [choose_pairs(maker, batch, names)
                for maker, names in zip(self._makers, self._names)]
        self.paired_again.append(made)
        for pairs in made:
            self._note_span(pairs)
        return made

    def _take_pairs(self, data: bytes) -> Pairs:
        summary = self.kept
        with _decoding(self._path):
            plain, columns = split_parts(data)
            summary.numbers = {name: (first, last, missing, first_segment) for name, (
                first, last, missing, first_segment) in plain['numbers'].items()}
            pairs = decode_columns(columns, Pairs)
        self._note_span(pairs)
        return pairs

    def _note_span(self, pairs: Pairs) -> None:
        """Note how many pairs the runs of the journal have, and from when to when."""
        summary = self.kept
        if len(pairs):
            summary.n_pairs += len(pairs)
            first_ns, last_ns = int(pairs.stamp_ns[0]), int(pairs.stamp_ns[-1])
            summary.newest_ns = max(summary.newest_ns or last_ns, last_ns)
            summary.start_ns = min(summary.start_ns or first_ns, first_ns)

    def _take_motion(self, data: bytes) -> Motion:
        with _decoding(self._path):
            plain, columns = split_parts(data)
            self.kept.motion_ns = {what: int(newest_ns) for what, newest_ns
                                   in plain['newest_ns'].items()}
            return decode_columns(columns, Motion)

    def _hand_out_quality(self, data: bytes, takers: Mapping[int, Judge]) -> None:
        """Give what a sensor says of its readings to the judges of its pairs."""
        with _decoding(self._path):
            plain, columns = split_parts(data)
            sensor, quality = plain['sensor'], decode_columns(columns, Quality)
        for number, judge in takers.items():
            for stream, name in zip(TWO, self._names[number]):
                if name == sensor:
                    judge.take_quality(stream, quality)

    def _take_ledger(self, plain: Mapping[str, Any]) -> None:
        started_ns = plain['started_ns']
        rows = self.rows.get(started_ns, [])[:plain['at']] + plain['segments']
        self.rows[started_ns] = rows
        ledger = Ledger.from_segments(
            [LedgerSegment(start_ns, counts, clock_segment=clock_segment)
             for start_ns, counts, clock_segment in rows], plain['newest_ns'],
            [SetBack(*set_back) for set_back in plain['set_backs']])
        numbers = {stream: decode_numbers(fields) for stream, fields in plain['numbers'].items()}
        self.kept.book(LedgerMessage(ledger, plain['final'], started_ns, numbers))


def describe_restarts(summary: Kept, names: Names = TWO) -> Iterator[str]:
    """Yield, in plain sentences, which restarts left readings of two sensors uncounted."""
    for started_ns, several in groupby(summary.restarts, key=lambda restart: restart[0]):
        streams = [name.upper() if name in TWO else name for _, name in several if name in names]
        if streams:
            yield (f'the process that pairs was restarted at {utc(started_ns)} UTC, and so was '
                   f'the publisher of {" and ".join(streams)}: readings that came in between are '
                   'not counted')


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
    before = sum(max(0, (first or 1) - 1) for first, *_ in numbers)
    if before:
        yield f'{before} pairs were published before the node that kept it started'
    if missing := sum(n_missing for _, _, n_missing, _ in numbers):
        yield f'{missing} pairs never came to that node: lost on the way, or while it was down'
    if summary.dropped:
        yield f'{summary.dropped} records could not be written into it'
    yield from describe_restarts(summary)
    if not summary.heard:
        yield from _describe_ledgers(summary)
    if summary.newest_ns is not None:
        yield (f'it ends with the pair of {utc(summary.newest_ns)} UTC: what came later is not '
               'in it')


def _describe_ledgers(summary: Kept) -> Iterator[str]:
    """Yield what the ledgers that came with the pairs do not count."""
    ledgers = summary.sum_ledgers()
    yield from ledgers.problems()
    last = [*summary.numbers.values()][-1][1] if summary.numbers else 0
    if not len(ledgers):
        yield 'it holds no ledger: its pairs count as all readings received'
    elif ledgers.paired < last:
        yield f'its last ledger counts {ledgers.paired} of the {last} pairs published so far'
    elif ledgers.paired > last:
        yield f'{ledgers.paired - last} pairs that its last ledger counts are not in it'
