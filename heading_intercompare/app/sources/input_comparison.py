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
"""The readings of one input through the comparison of its sensors, to the runs of each pair."""

from __future__ import annotations

from dataclasses import replace
from typing import Callable, Mapping, Sequence

from heading_intercompare.bags.csv.pairs_account import (
    PairsAccount,
    text_of_motion,
    text_of_quality,
)
from heading_intercompare.core.offline import judge_aligned
from heading_intercompare.core.pairing.ledger import Ledger, LedgerKey
from heading_intercompare.core.pairing.stream_pieces import cut_streams
from heading_intercompare.core.pipeline import Intercomparison
from heading_intercompare.core.records import Headings, Losses, Motion, Pairs, Quality
from heading_intercompare.core.runs.growing_columns import GrowingHeadings
from heading_intercompare.core.sensor_table import find_reference, Sensor
from heading_intercompare.core.sensors.comparison import SensorsComparison
from heading_intercompare.core.sensors.pair_names import Names
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.verdict.judge import RunResult
from heading_intercompare.core.verdict.verdict_document import Input
from heading_intercompare.report import SegmentSketches

from .judged_input import JudgedInput
from .stream_spans import explain_apart, StreamSpan

PairTakers = Mapping[str, Sequence[Callable[[Pairs], None]]]
"""Who takes the pairs of each tested sensor with the reference, chunk by chunk, by its name."""

Spans = Sequence[tuple[int, int]]
"""Start and stop of each run, nanoseconds."""


class InputComparison:
    """
    Compare the sensors of one input, and hand their pairs to figures and tables.

    Parameters
    ----------
    source
        Name of the input in the runs.
    table : sequence of (start_ns, stop_ns), optional
        Runs; without one marks and silences decide.
    takers : mapping of str to sequence of callable, optional
        Each is called with the pairs of a tested sensor, chunk by chunk.
    sketched
        Collect the data for the figures of each tested sensor.
    progress
        Called with the progress in words.

    """

    def __init__(self, settings: Settings, source: str = '', table: Spans | None = None, *,
                 takers: PairTakers | None = None, sketched: bool = False,
                 progress: Callable[[str], None] = lambda text: None) -> None:
        self.comparison = SensorsComparison(settings, source=source, table=table,
                                            progress=progress)
        self.marks: list[tuple[str, int]] = []
        self._several = settings.sensors is not None
        self._source, self._table, self._takers = source, table, takers or {}
        self._sketches = {name: SegmentSketches(source) for name in self.comparison.tested
                          if sketched}
        # Aligning a run needs all readings a second time; otherwise they are dropped.
        self._readings = {sensor.name: GrowingHeadings() for sensor in self.comparison.sensors
                          if settings.alignment.skew == 'apply'}
        self._spans = {sensor.name: StreamSpan() for sensor in self.comparison.sensors}
        self._losses: list[tuple[str, LedgerKey, Losses]] = []
        self._motion: list[Motion] = []
        self._quality: dict[str, list[Quality]] = {}

    @property
    def sensors(self) -> tuple[Sensor, ...]:
        """Return the sensors."""
        return self.comparison.sensors

    @property
    def reference(self) -> Sensor | None:
        """Return the reference of all others; None if there is none."""
        return find_reference(self.sensors)

    @property
    def newest_ns(self) -> int | None:
        """Return the newest stamp of the readings compared so far; None before the first."""
        return self.comparison.newest_ns

    @property
    def takes_marks(self) -> bool:
        """Whether marks start and stop runs: no table of runs does."""
        return self._table is None

    def take_motion(self, motion: Motion) -> None:
        """Take the motion of the ship, before the first readings."""
        self.comparison.take_motion(motion)
        self._motion.append(motion)
        for sketch in self._sketches.values():
            sketch.take_motion(motion)

    def take_quality(self, name: str, quality: Quality) -> None:
        """Take what a sensor says of its readings, before these."""
        if len(quality):
            self.comparison.take_quality(name, quality)
            self._quality.setdefault(name, []).append(quality)

    def mark(self, kind: str, stamp_ns: int) -> None:
        """Start or stop a run after the pair with this stamp."""
        self.marks.append((kind, stamp_ns))
        self.comparison.mark(kind, stamp_ns)

    def update(self, headings: Mapping[str, Headings]) -> None:
        """Take readings by the names of their sensors."""
        for name, span in self._spans.items():
            span.update(headings[name].stamp_ns)
        for name, readings in self._readings.items():
            readings.append(headings[name])
        for piece in cut_streams(headings):
            self._hand_out(self.comparison.update(piece))

    def lose(self, name: str, key: LedgerKey, losses: Losses) -> None:
        """Count readings of a sensor that never came; `key` is that of a TS."""
        self.comparison.lose(name, key, losses)
        if self._readings:
            self._losses.append((name, key, losses))

    def begin_again(self) -> None:
        """Go on as after a restart; see `Intercomparison.begin_again`."""
        self._hand_out(self.comparison.begin_again())

    def _hand_out(self, pairs_of: Mapping[str, Pairs]) -> None:
        for name, sketch in self._sketches.items():
            sketch.update(pairs_of[name], self.comparison.tested[name].compliance.settings)
        for name, takers in self._takers.items():
            for take in takers:
                take(pairs_of[name])

    def finish(self) -> dict[Names, list[RunResult]]:
        """End all streams; return the runs of each pair."""
        self._hand_out(self.comparison.finish())
        return {names: self._align(names, pair) for names, pair in self.comparison.pairs.items()}

    def _align(self, names: Names, pair: Intercomparison) -> list[RunResult]:
        results = pair.results()
        if not self._readings:
            return results
        first, second = (self._readings[name].headings for name in names)
        lost = [(key if name == names[0] else key.of_stream('rs'), losses)
                for name, key, losses in self._losses if name in names]
        return judge_aligned(first, second, results, pair.compliance.settings,
                             source=self._source, lost=lost, motion=self._motion,
                             quality=self._quality_of(names))

    def _quality_of(self, names: Names) -> dict[str, Quality]:
        """Return what two sensors say of their readings, as ``'ts'`` and ``'rs'``."""
        return {stream: Quality.join(self._quality[name])
                for stream, name in zip(('ts', 'rs'), names) if name in self._quality}

    def describe(self, results: Mapping[Names, list[RunResult]], entries: Sequence[Input],
                 entries_of_pair: Callable[[Sensor, Sensor], Sequence[Input]],
                 notes: Sequence[str] = (), *, path: str = '', label: str = '') -> JudgedInput:
        """
        Return the runs with what the user should know about them.

        Parameters
        ----------
        results : mapping of (str, str) to list of RunResult
            What `finish` returned.
        entries
            Entries of the input in the verdict on several sensors.
        entries_of_pair
            Returns the entries of the input in the verdict on a pair of sensors.
        notes : sequence of str
            What the user should know, before what is said of pairs without a run.
        path
            The input.
        label
            What the notes on the input begin with.

        """
        notes, sensors = [*notes], {sensor.name: sensor for sensor in self.sensors}
        # Only a table of pairs needs it, and it takes more memory than the motion.
        motion = text_of_motion(Motion.concatenate(self._motion)) if self._takers else None
        entries_of_tested: dict[str, Sequence[Input]] = {}
        accounts = {}
        apart = {}
        for names, pair in self.comparison.pairs.items():
            ledger, settings = pair.ledger, pair.compliance.settings
            if not ledger.paired and (words := self._explain_apart(names, settings)):
                apart[names] = words
            why = None if results[names] else _explain_no_run(ledger, settings, self._table,
                                                              apart.get(names, ''))
            if why is not None:
                note = (label, ' and '.join(names) if self._several else '', f'no run: {why}')
                notes.append(': '.join(filter(None, note)))
            if self.comparison.tested.get(names[0]) is not pair:
                continue
            pair_entries = [*entries_of_pair(*(sensors[name] for name in names))]
            if pair_entries and why is not None:
                pair_entries[0] = replace(pair_entries[0], no_run=why)
            entries_of_tested[names[0]] = pair_entries
            if pair_entries:
                accounts[names[0]] = _make_account(pair_entries, settings, ledger, self.marks,
                                                   self._table, motion,
                                                   text_of_quality(self._quality_of(names))
                                                   if self._takers else None)
        if entries and not any(results.values()):
            entries = [replace(entries[0], no_run='no pair of sensors has a run'), *entries[1:]]
        earlier = {name: [result.verdict for result in pair.compliance.take_earlier(pair.ledger)]
                   for name, pair in self.comparison.tested.items()}
        none_paired = not any(pair.ledger.paired for pair in self.comparison.pairs.values())
        return JudgedInput(path=path, results=results, entries=entries,
                           entries_of_tested=entries_of_tested, notes=notes, earlier=earlier,
                           sketches=self._sketches, accounts=accounts,
                           apart=next(iter(apart.values()), '') if none_paired else '')

    def _explain_apart(self, names: Names, settings: Settings) -> str:
        """Return why the stamps of two sensors do not meet; empty if they do."""
        first, second = (self._spans[name] for name in names)
        return explain_apart(first, second, settings.alignment.skew_s,
                             names if self._several else ('TS', 'RS'))


def describe_two(results: list[RunResult], earlier: Sequence[RunResult], entry: Input,
                 notes: Sequence[str], ledger: Ledger, settings: Settings, *,
                 table: Spans | None = None, marks: Sequence[tuple[str, int]] = (),
                 account: PairsAccount | None = None,
                 sketch: SegmentSketches | None = None) -> JudgedInput:
    """
    Return the runs of two sensors whose pairs were made elsewhere.

    Parameters
    ----------
    results, earlier
        The runs of the verdict, and those that are too old for it.
    entry
        Its entry in the verdict, and the name that its notes begin with.
    notes : sequence of str
        What the user should know about it.
    ledger
        The account of its readings.
    settings
        By which they were judged.
    table, marks
        What its runs were cut by.
    account
        That of the recording that its pairs came from.
    sketch
        Data for the figures.

    """
    notes = [f'{entry.path}: {note}' for note in notes]
    if not results:
        entry = replace(entry, no_run=_explain_no_run(ledger, settings, table))
        notes.append(f'{entry.path}: no run: {entry.no_run}')
    if account is None:
        account = _make_account([entry], settings, ledger, marks, table)
    return JudgedInput(path=entry.path, results={('ts', 'rs'): results}, entries=[entry],
                       entries_of_tested={'ts': [entry]}, notes=notes,
                       earlier={'ts': [result.verdict for result in earlier]},
                       sketches={} if sketch is None else {'ts': sketch}, accounts={'ts': account})


def _make_account(entries: Sequence[Input], settings: Settings, ledger: Ledger,
                 marks: Sequence[tuple[str, int]], table: Spans | None,
                 motion: Mapping[str, str] | None = None,
                 quality: Mapping[str, str] | None = None) -> PairsAccount:
    """Return the account to lay beside a csv of the pairs of two sensors."""
    return PairsAccount(inputs=tuple(entries), settings=settings.to_mapping(), marks=tuple(marks),
                        table=None if table is None else tuple(table), newest_ns=ledger.newest_ns,
                        segments=ledger.segments, set_backs=tuple(ledger.all_set_backs),
                        motion=motion, quality=quality)


def _explain_no_run(ledger: Ledger, settings: Settings, table: Spans | None,
                    apart: str = '') -> str:
    """Return in words why an input gave no run, and how its readings were counted."""
    total = ledger.total
    # In the order in which the keys first occurred.
    keys = dict.fromkeys(key for segment in ledger.segments for key in segment.counts)
    rejected = [f'{total.counts[key]} {key.stream.upper()} {key.reason}' for key in keys
                if key.reason]
    why = ('the table of runs has no row for it' if table is not None and not table else
           f'no pair was made, because {apart}' if apart else
           'no pair was made' if not ledger.paired else
           'none of its pairs is in a run of at least runs.min_duration_s = '
           f'{settings.runs.min_duration_s:g} s')
    return (f'{why}; {total.received("ts")} TS and {total.received("rs")} RS readings received, '
            f'{ledger.paired} paired, rejected: {", ".join(rejected) or "none"}')
