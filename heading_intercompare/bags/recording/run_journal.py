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

The journal holds what the judgement was given: pairs, motion, marks and ledgers, in their order.
Whatever is computed from them is computed again, by the same code, so the verdict is the same to
the bit. When a run ends, the journal is replaced by the judged runs, and the pairs and the motion
of the next run. So it never holds more than one run.
"""

from __future__ import annotations

import json
from pathlib import Path
import shlex
from typing import Any, Iterator, Mapping

from heading_intercompare.bags.errors import BagError
from heading_intercompare.core.declared_settings import settings_sha256
from heading_intercompare.core.motion.motion_record import find_newest
from heading_intercompare.core.pipeline import Compliance
from heading_intercompare.core.records import Motion, Pairs
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.utc_text import utc
from heading_intercompare.core.version import VERSION
from heading_intercompare.messages.ledger_messages import LedgerMessage

from .journal import encode_columns, Journal, read_journal, Record
from .journal_reading import (
    ABOUT,
    compare_settings,
    HOLE,
    JournalReader,
    Kept,
    LEDGER,
    LENGTH,
    MARK,
    MOTION,
    Numbers,
    PAIRS,
    read_state,
    RUN,
    STATE,
)

#: Pairs wait at most this long for the system to take them.
_PERIOD_S = 0.25


class RunJournal:
    """
    Keeps what a `Compliance` is given, and gives it again after a crash.

    Parameters
    ----------
    path
        The journal.
    compliance
        Judges; as it is after construction. It goes on from the journal.
    within_s
        A journal that was not written for longer than this is another trial.
    now_ns
        Time of day, UTC ns.
    bag
        The recording of this trial.

    Attributes
    ----------
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

    def __init__(self, path: Path, compliance: Compliance, *, within_s: float, now_ns: int,
                 bag: str | None = None) -> None:
        self._path, self._compliance = path, compliance
        self._about = {**_name_settings(compliance.settings), 'software': VERSION,
                       'began_ns': now_ns, 'bag': bag}
        self.kept = Kept()
        self.resumed = self.set_aside = ''
        self._written: dict[int, list[Any]] = {}
        self._waiting: list[Pairs] = []
        self._moved: list[Motion] = []
        self._changed: set[int] = set()
        self._numbers: Numbers = {}
        self._due_s = 0.0
        self._n_finished = 0
        size = self._find_size(within_s, now_ns)
        self._journal = Journal(path, Record(ABOUT, _text(self._about)), size)
        self._told_dropped = 0
        if size is not None:
            # The newest recording of the trial.
            self._journal.append(ABOUT, _text(self._about))
        self._n_finished = compliance.finished_runs

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
            read_state(contents.records)
        except (ValueError, KeyError, TypeError, AttributeError) as error:
            self._put_aside(f'this version cannot read it: {" ".join(str(error).split())[:200]}')
            return None
        why = why or _find_age(age_s, within_s)
        if why:
            self._put_aside(why, readable=True)
            return None
        reader = JournalReader(self._path)
        reader.read(contents, self._compliance)
        self.kept, self._numbers, self._written = reader.kept, reader.kept.numbers, reader.rows
        newest_ns = self._compliance.newest_ns
        self.resumed = (
            f'goes on with {self._compliance.finished_runs} runs and the run in progress, '
            f'{self.kept.n_pairs} pairs up to '
            f'{"-" if newest_ns is None else utc(newest_ns)} UTC')
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

    def _pack_pairs(self, pairs: Pairs) -> bytes:
        numbers = _text(self._numbers)
        return LENGTH.pack(len(numbers)) + numbers + encode_columns(pairs)

    def _pack_motion(self, rows: Motion) -> bytes:
        newest = _text(self.kept.motion_ns)
        return LENGTH.pack(len(newest)) + newest + encode_columns(rows)

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

    def add(self, pairs: Pairs, numbers: Numbers) -> None:
        """Keep pairs, before they are judged, and the numbers of their messages so far."""
        if len(pairs):
            self._waiting.append(pairs)
            self._numbers = numbers

    def add_motion(self, motion: Motion) -> None:
        """Keep motion of the ship, before it is judged."""
        if len(motion):
            self._moved.append(motion)
            newest, motion_ns = find_newest(motion), self.kept.motion_ns
            self.kept.motion_ns = {what: max(newest.get(what, 0), motion_ns.get(what, 0))
                                   for what in {**motion_ns, **newest}}

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

    def _put_rows(self) -> None:
        if self._waiting:
            self._journal.append(PAIRS, self._pack_pairs(Pairs.concatenate(self._waiting)))
            self._waiting.clear()
        if self._moved:
            self._journal.append(MOTION, self._pack_motion(Motion.concatenate(self._moved)))
            self._moved.clear()

    def tick(self, now_s: float) -> None:
        """Write what is due; call it after each judgement, with a steady clock in seconds."""
        if self._compliance.finished_runs != self._n_finished:
            self._n_finished = self._compliance.finished_runs
            self._begin_again(now_s)
        if now_s < self._due_s:
            return
        self._due_s = now_s + _PERIOD_S
        self._put_rows()
        for started_ns in sorted(self._changed):
            self._journal.append(LEDGER, self._pack_ledger(self.kept.ledgers[started_ns]))
        self._changed.clear()
        if self._journal.dropped > self._told_dropped:
            self._journal.append(HOLE, _text(self._journal.dropped - self._told_dropped))
            self._told_dropped = self._journal.dropped
        self._journal.flush(now_s)

    def _begin_again(self, now_s: float) -> None:
        """Replace the journal by the judged runs and the pairs of the run that has begun."""
        self._journal.replace(self._records(), now_s)
        if self._journal.fault:
            # The former records stay. They do not hold the segments that were to be written.
            self._written.clear()
            self._changed |= set(self.kept.ledgers)
        else:
            self._waiting.clear()
            self._moved.clear()
            self._changed.clear()

    def _records(self) -> Iterator[Record]:
        yield Record(ABOUT, _text(self._about))
        yield Record(STATE, _text({'state': self._compliance.keep().to_text(),
                                    'marks': sorted(self.kept.marks)}))
        start_ns = self._compliance.run_start_ns
        # The run has begun within the newest chunk, or it would not be the one after a judged run.
        chunk = self._waiting[-1] if self._waiting and start_ns is not None else Pairs.empty()
        yield Record(RUN, self._pack_pairs(
            chunk if start_ns is None else chunk[
                (chunk.stamp_ns >= start_ns) & (chunk.segment == self._compliance.segment)]))
        if self.kept.motion_ns:
            rows = self._compliance.motion.rows
            yield Record(MOTION, self._pack_motion(Motion.empty() if rows is None else rows))
        before = () if self.kept.before is None else (self.kept.before,)
        for message in (*before, *self.kept.ledgers.values()):
            yield Record(LEDGER, self._pack_ledger(message, whole=True))

    def close(self, *, over: bool) -> None:
        """Remove the journal if the trial is over, otherwise write what waits."""
        if not over:
            self._due_s = 0.0
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
        return ''
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
