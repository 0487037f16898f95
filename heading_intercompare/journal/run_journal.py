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
The run in progress on disk, from which a node that was killed goes on.

The journal holds what came in, in its order: readings with what was lost of them, or pairs and
ledgers where another process pairs; motion, quality and marks. Whatever is computed from them is
computed again, by the same code, so the verdict is the same to the bit. Of readings it gets the
pairs and the state of the pairing now and then, so that only the last ones are paired again. When
a run of two sensors ends, it gets their judged runs, with the pairs, the motion and the quality of
their next run. What came before is then left out, so it never holds more than one run of each two
sensors.
"""

from __future__ import annotations

from itertools import chain
import json
from pathlib import Path
import shlex
from typing import Any, Iterator, Mapping, Sequence

from heading_intercompare.bags.errors import BagError
from heading_intercompare.core.declared_settings import settings_sha256
from heading_intercompare.core.motion.motion_record import find_newest
from heading_intercompare.core.pairing.pair_maker import PairMaker
from heading_intercompare.core.pipeline import Compliance
from heading_intercompare.core.records import Motion, Pairs, Quality
from heading_intercompare.core.sensors.pair_names import list_names, Names, TWO
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.utc_text import utc
from heading_intercompare.core.version import VERSION
from heading_intercompare.messages.ledger_messages import LedgerMessage

from .frozen_state import freeze, hash_code
from .journal_file import (
    encode_columns,
    iterate_records,
    join_parts,
    Journal,
    read_journal,
    Record,
)
from .journal_reading import (
    ABOUT,
    BATCH,
    check_states,
    compare_settings,
    find_pair,
    HOLE,
    JournalReader,
    Kept,
    LEDGER,
    MAKERS,
    MARK,
    MOTION,
    Numbers,
    PAIRS,
    QUALITY,
    STATE,
    survey_records,
)
from .reading_batches import Batch, encode_batch

#: Pairs wait at most this long for the system to take them.
_PERIOD_S = 0.25
#: Batches that are paired again after a crash, at most: a second or two.
_MOST_BATCHES = 2000


class RunJournal:
    """
    Keeps what the judges of a trial are given, and gives it again after a crash.

    Parameters
    ----------
    path
        The journal.
    settings
        Of the trial.
    judges : mapping of (str, str) to Compliance
        Judges of the pairs of each two sensors, by their names; as they are after construction.
        They go on from the journal.
    within_s
        A journal that was not written for longer than this is another trial.
    now_ns
        Time of day, UTC ns.
    bag
        The recording of this trial.
    makers
        Make the pairs of each two sensors, as they are after construction; they go on from the
        journal, too. Without them the journal holds pairs, not readings.

    Attributes
    ----------
    began_ns : int
        When the trial began, UTC ns.
    kept : Kept
        What the journal says besides the pairs.
    resumed : str
        In words, what this trial goes on with; '' if it begins.
    set_aside : str
        In words, which journal was set aside and why; '' if none was.
    fault
        Why the journal cannot be written now; '' if it can.

    Raises
    ------
    OSError
        If the journal cannot be opened, or another process uses it (BlockingIOError).

    """

    def __init__(self, path: Path, settings: Settings, judges: Mapping[Names, Compliance], *,
                 within_s: float, now_ns: int, bag: str | None = None,
                 makers: list[PairMaker] | None = None) -> None:
        self._path, self._makers = path, makers
        self._names, self._judges = [*judges], [*judges.values()]
        self._sensors = list_names(judges)
        self._about = {**_name_settings(settings), 'software': VERSION, 'began_ns': now_ns,
                       'bag': bag, 'code': None if makers is None else hash_code(),
                       'pairs': self._names}
        self.kept, self.began_ns = Kept(), now_ns
        self.resumed = self.set_aside = ''
        self._written: dict[int, list[Any]] = {}
        self._waiting: list[list[Pairs]] = [[] for _ in judges]
        self._moved: list[Motion] = []
        self._quality: list[tuple[str, Quality]] = []
        self._changed: set[int] = set()
        self._numbers: Numbers = {}
        self._due_s = 0.0
        self._n_finished = [0 for _ in judges]
        self._n_batches = 0
        # A run has ended, and what came before it is still in the file.
        self._outgrown = False
        # The publishers of each sensor before a restart, until the next reading comes.
        self._n_before: dict[str, int] = {}
        self._started_ns = now_ns
        size = self._find_size(within_s, now_ns)
        self._journal = Journal(path, self._pack_about(), size)
        self._told_dropped = 0
        if size is not None:
            # The newest recording of the trial.
            self._journal.append(*self._pack_about())
        self._n_finished = self._count_finished()

    @property
    def fault(self) -> str:
        """Why the journal cannot be written now; '' if it can."""
        return self._journal.fault

    def _find_size(self, within_s: float, now_ns: int) -> int | None:
        """Go on with the journal that is there, or set it aside; return its size to go on from."""
        try:
            age_s = now_ns / 1e9 - self._path.stat().st_mtime
            # Another process that writes it would be disturbed.
            Journal.probe(self._path)
            contents = read_journal(self._path)
        except FileNotFoundError:
            return None
        except BagError as error:
            self._put_aside(error.problem)
            return None
        if all(record.kind == ABOUT for record in contents.records):
            return None
        try:
            why = _find_mismatch(json.loads(contents.records[0].data), self._about)
            check_states(contents.records, len(self._judges))
        except (ValueError, KeyError, TypeError, AttributeError, IndexError) as error:
            self._put_aside(f'this version cannot read it: {" ".join(str(error).split())[:200]}')
            return None
        why = why or _find_age(age_s, within_s)
        if why:
            self._put_aside(why, readable=self._names == [TWO])
            return None
        reader = JournalReader(self._path, self._names, makers=self._makers)
        reader.read(contents, self._judges)
        for made in reader.paired_again:
            for waiting, pairs in zip(self._waiting, made):
                waiting += [pairs] * bool(len(pairs))
        self._n_batches = len(reader.paired_again)
        self._n_before = {stream: len(last.numbers.spans)
                          for stream, last in reader.kept.heard.items()
                          if last.numbers.spans}
        self.began_ns = self._about['began_ns'] = json.loads(contents.records[0].data)['began_ns']
        self.kept, self._numbers, self._written = reader.kept, reader.kept.numbers, reader.rows
        self.resumed = (
            f'goes on with {sum(self._count_finished())} runs and the run in progress, '
            f'{self.kept.n_pairs} pairs up to {utc(self.kept.newest_ns)} UTC')
        if contents.torn:
            self.resumed += f'; the last {contents.torn} bytes of {self._path} were cut'
        return contents.size

    def _put_aside(self, why: str, *, readable: bool = False) -> None:
        """Rename the journal, so that nothing of it is lost; say how to read it."""
        at = 1
        while (aside := self._path.with_name(f'{self._path.name}.{at}')).exists():
            at += 1
        self._path.rename(aside)
        self.set_aside = f'the run in progress in {self._path} is not this one: {why}; it is ' \
                         f'kept as {aside}'
        if readable:
            self.set_aside += ('; to judge what it holds: heading-intercompare analyze '
                               f'{shlex.quote(str(aside))}')

    def _pack_about(self) -> Record:
        return Record(ABOUT, _text({**self._about, 'restarts': self.kept.restarts}))

    def _count_finished(self) -> list[int]:
        return [judge.finished_runs for judge in self._judges]

    def _put_pairs(self, kind: bytes, pair: int, pairs: Pairs, **more: Any) -> None:
        self._journal.append(kind, join_parts({'pair': pair, 'numbers': self._numbers, **more},
                                              encode_columns(pairs)))

    def _put_motion_of(self, pair: int | None, rows: Motion) -> None:
        self._journal.append(MOTION, join_parts(
            {'pair': pair, 'newest_ns': self.kept.motion_ns}, encode_columns(rows)))

    def _put_quality_of(self, pair: int | None, sensor: str, rows: Quality) -> None:
        self._journal.append(QUALITY, join_parts(
            {'pair': pair, 'sensor': sensor}, encode_columns(rows)))

    def _pack_ledger(self, message: LedgerMessage, whole: bool = False) -> bytes:
        """Return a ledger; only the segments from the first that has changed, unless `whole`."""
        ledger, final, started_ns, numbers = message
        rows = [[segment.start_ns, {key.value: n for key, n in segment.counts.items()},
                 segment.clock_segment] for segment in ledger.segments]
        before = [] if whole else self._written.get(started_ns, [])
        at = 0
        while at < min(len(rows), len(before)) and rows[at] == before[at]:
            at += 1
        self._written[started_ns] = rows
        return _text({'started_ns': started_ns, 'final': final, 'numbers': numbers,
                      'newest_ns': ledger.newest_ns,
                      'set_backs': [[step.stream, step.stamp_ns, step.size_ns,
                                     step.clock_segment] for step in ledger.all_set_backs],
                      'at': at, 'segments': rows[at:]})

    def add(self, pairs: Pairs, numbers: Numbers | None = None, names: Names = TWO) -> None:
        """
        Keep pairs, before they are judged.

        Parameters
        ----------
        pairs
            Of two sensors.
        numbers
            The numbers of their messages so far, if they were heard as messages.
        names
            The sensors.

        """
        if len(pairs):
            self._waiting[self._names.index(names)].append(pairs)
            self._numbers = numbers or {}

    def add_batch(self, batch: Batch) -> None:
        """Keep readings, before they are paired; the next `flush` writes them."""
        if not (self.kept.heard or batch.losses or any(map(len, batch.headings.values()))):
            # There is no trial before its first reading.
            return
        self._put_beside()
        self._find_restarts(batch)
        self._journal.append(BATCH, encode_batch(batch, self.kept.heard, self._sensors))
        self.kept.heard, self.kept.now_s = batch.heard, batch.now_s
        self._n_batches += 1

    def _find_restarts(self, batch: Batch) -> None:
        """Note whose first readings after a restart are of another publisher."""
        for stream, n_before in [*self._n_before.items()]:
            if batch.heard[stream].numbers == self.kept.heard[stream].numbers:
                continue
            del self._n_before[stream]
            if len(batch.heard[stream].numbers.spans) > n_before:
                self.kept.restarts.append((self._started_ns, stream))
                self._journal.append(*self._pack_about())

    def flush(self, now_s: float) -> None:
        """Let the system have what is kept, with a steady clock in seconds."""
        self._journal.flush(now_s)

    def add_motion(self, motion: Motion) -> None:
        """Keep motion of the ship, before it is judged."""
        if len(motion):
            self._moved.append(motion)
            newest, motion_ns = find_newest(motion), self.kept.motion_ns
            self.kept.motion_ns = {what: max(newest.get(what, 0), motion_ns.get(what, 0))
                                   for what in {**motion_ns, **newest}}

    def add_quality(self, sensor: str, quality: Quality) -> None:
        """Keep what a sensor says of its readings, before they are judged."""
        if len(quality):
            self._quality.append((sensor, quality))

    def mark(self, kind: str, stamp_ns: int) -> None:
        """Keep a mark, before it takes effect; the next `tick` writes it."""
        self._put_rows()
        self.kept.marks.add((kind, stamp_ns))
        self._journal.append(MARK, _text([kind, stamp_ns]))
        # Nobody sends it again.
        self._due_s = 0.0

    def book(self, message: LedgerMessage) -> None:
        """Keep the newest ledger of a synchronizer."""
        self.kept.book(message)
        self._changed.add(message.started_ns)

    def _put_rows(self, ended: Sequence[int] = ()) -> None:
        """Append all that waits; for the pairs of sensors whose run has `ended`, their state."""
        self._put_beside()
        for pair, waiting in enumerate(self._waiting):
            if pair in ended:
                self._put_state(pair)
            elif waiting:
                self._put_pairs(PAIRS, pair, Pairs.concatenate(waiting))
            waiting.clear()
        if self._makers is not None:
            # With this state the batches before it are no longer needed.
            self._journal.append(MAKERS, join_parts(
                {'now_s': self.kept.now_s, 'heard': self.kept.heard}, freeze(self._makers)))
            self._n_batches = 0

    def _put_state(self, pair: int) -> None:
        """Append the judged runs of two sensors, and what their next run has."""
        judge, waiting = self._judges[pair], self._waiting[pair]
        start_ns = judge.run_start_ns
        # The run has begun within the newest chunk, or it would not be the one after a judged run.
        chunk = waiting[-1] if waiting and start_ns is not None else Pairs.empty()
        self._put_pairs(STATE, pair, chunk if start_ns is None else chunk[
            (chunk.stamp_ns >= start_ns) & (chunk.segment == judge.segment)],
            state=judge.keep().to_text(), marks=sorted(self.kept.marks))
        if self.kept.motion_ns:
            rows = judge.motion.rows
            self._put_motion_of(pair, Motion.empty() if rows is None else rows)
        for stream, quality in judge.quality.by_stream().items():
            self._put_quality_of(pair, self._names[pair][TWO.index(stream)], quality)

    def _put_beside(self) -> None:
        """Append what came beside the readings: motion and quality."""
        if self._moved:
            self._put_motion_of(None, Motion.concatenate(self._moved))
            self._moved.clear()
        for sensor, quality in self._quality:
            self._put_quality_of(None, sensor, quality)
        self._quality.clear()

    def tick(self, now_s: float) -> None:
        """Write what is due; call it after each judgement, with a steady clock in seconds."""
        n_finished = self._count_finished()
        if n_finished != self._n_finished:
            # Where no run is in progress, nothing of the runs before is needed.
            self._put_rows([pair for pair, judge in enumerate(self._judges)
                            if n_finished[pair] != self._n_finished[pair]
                            or judge.run_start_ns is None])
            self._n_finished, self._outgrown = n_finished, True
        if self._outgrown:
            self._leave_out_unused(now_s)
        if now_s < self._due_s:
            return
        self._due_s = now_s + _PERIOD_S
        if self._makers is None or self._n_batches >= _MOST_BATCHES:
            self._put_rows()
        for started_ns in sorted(self._changed):
            self._journal.append(LEDGER, self._pack_ledger(self.kept.ledgers[started_ns]))
        self._changed.clear()
        if self._journal.dropped > self._told_dropped:
            self._journal.append(HOLE, _text(self._journal.dropped - self._told_dropped))
            self._told_dropped = self._journal.dropped
            # The batches after the hole do not follow those before it.
            self._put_rows()
        self._journal.flush(now_s)

    def _leave_out_unused(self, now_s: float) -> None:
        """Replace the journal by what a restart would use, if that is less than half of it."""
        self._journal.flush(now_s)
        if self._journal.fault:
            return
        self._outgrown = False
        with self._path.open('rb') as file:
            survey = survey_records(iterate_records(file), len(self._judges))
            if 2 * survey.live_bytes > self._journal.size:
                return
            self._journal.replace(chain([self._pack_about()], (
                record for at, record in enumerate(iterate_records(file))
                if record.kind not in (ABOUT, LEDGER)
                and survey.uses(at, record.kind, find_pair(record))), self._pack_ledgers()),
                now_s)
        if self._journal.fault:
            # The former records stay. They do not hold the segments that were to be written.
            self._written.clear()
            self._changed |= set(self.kept.ledgers)
        else:
            self._changed.clear()

    def _pack_ledgers(self) -> Iterator[Record]:
        for message in self.kept.ledgers.values():
            yield Record(LEDGER, self._pack_ledger(message, whole=True))

    def close(self, *, over: bool) -> None:
        """Remove the journal if the trial is over, otherwise write what waits."""
        if not over:
            self._put_rows()
        self._journal.close(remove=over)


def _text(value: Any) -> bytes:
    return json.dumps(value, separators=(',', ':')).encode()


def _name_settings(settings: Settings) -> dict[str, Any]:
    """Return the settings and their hash, by which a journal knows its trial."""
    mapping = settings.to_mapping()
    return {'settings_sha256': settings_sha256(mapping), 'settings': mapping}


def _find_mismatch(theirs: Mapping[str, Any], ours: Mapping[str, Any]) -> str:
    """Say which settings of a journal differ from those of this trial; '' if none."""
    if theirs.get('settings_sha256') == ours['settings_sha256']:
        return '' if 'code' not in ours or theirs.get('code') == ours['code'] else (
            'other code wrote it, or a node that did not pair the readings itself')
    return f'it has other settings: {compare_settings(theirs.get("settings"), ours["settings"])}'


def _find_age(age_s: float, within_s: float) -> str:
    """Say that a journal is too old; '' if it is not."""
    return '' if age_s <= within_s else (
        f'it was last written {age_s / 3600.0:.1f} h ago, more than {within_s:g} s')


def find_bag(path: Path, settings: Settings, *, within_s: float, now_ns: int) -> str | None:
    """
    Return the newest recording of the trial that a journal would go on with.

    Parameters
    ----------
    path
        The journal.
    settings, within_s, now_ns
        As for `RunJournal`.

    Returns
    -------
    str or None
        None if there is no such trial, or it was not recorded.

    """
    try:
        if _find_age(now_ns / 1e9 - path.stat().st_mtime, within_s):
            return None
        Journal.probe(path)
        records = read_journal(path).records
        about = [json.loads(record.data) for record in records if record.kind == ABOUT]
        if not about or _find_mismatch(about[0], _name_settings(settings)):
            return None
        bag = about[-1].get('bag')
    except (OSError, ValueError, AttributeError, IndexError):
        return None
    return bag if isinstance(bag, str) else None
