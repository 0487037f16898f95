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

"""One recording, or the logs of one trial, through the comparison of several sensors."""

from __future__ import annotations

from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Callable, Mapping, Sequence

from heading_intercompare.app.inputs import explain_no_run, read_motion, sha256
from heading_intercompare.app.logs.log_import import import_log
from heading_intercompare.app.logs.log_motion import find_motion, FoundMotion
from heading_intercompare.app.sources.found import Found, make_account
from heading_intercompare.bags.csv.pairs_account import PairsAccount
from heading_intercompare.bags.recording.bag_losses import BagLosses
from heading_intercompare.bags.recording.recorded_headings import find_problems, read_marks
from heading_intercompare.bags.rosbag2.provenance import read_notes
from heading_intercompare.bags.rosbag2.readable import Readable
from heading_intercompare.core.offline import judge_aligned
from heading_intercompare.core.pairing.ledger_keys import LedgerKey
from heading_intercompare.core.pipeline import Intercomparison
from heading_intercompare.core.records import Headings, Losses, Motion, Pairs
from heading_intercompare.core.rows.sensor_table import describe_driver, read_sensors, Sensor
from heading_intercompare.core.sensors.comparison import SensorsComparison
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.verdict.judge import RunResult
from heading_intercompare.core.verdict.verdict_document import Input, OperatorNote
from heading_intercompare.drivers.settings import DriverSettings
from heading_intercompare.readers.registry import open_recording
from heading_intercompare.report import SeriesSketch

__all__ = ['compare_bag', 'compare_headings', 'compare_logs', 'Compared', 'name_logs',
           'plan_logs', 'Takers']

Names = tuple[str, str]
Spans = Sequence[tuple[int, int]]

#: Who takes the pairs of each tested sensor with the reference, chunk by chunk, by its name.
Takers = Mapping[str, Sequence[Callable[[Pairs], None]]]


@dataclass(frozen=True, slots=True)
class Compared:
    """
    The runs of all pairs of sensors in one input.

    Attributes
    ----------
    results : dict of (str, str) to list of RunResult
        The runs of each pair, by the names of its sensors.
    earlier : dict of str to list of RunResult
        Runs of each tested sensor that are too old for the verdict.
    described : tuple of Input
        Its entries in the verdict: a bag, or several logs.
    notes : list of str
        What the user should know about it.
    sketches : dict of str to SeriesSketch
        Data for the figures of each tested sensor; empty unless requested.
    accounts : dict of str to PairsAccount
        What belongs beside a csv of the pairs of each tested sensor.

    """

    results: dict[Names, list[RunResult]]
    earlier: dict[str, list[RunResult]]
    described: tuple[Input, ...]
    notes: list[str] = field(default_factory=list)
    sketches: dict[str, SeriesSketch] = field(default_factory=dict)
    accounts: dict[str, PairsAccount] = field(default_factory=dict)


class _Feed:
    """A comparison that hands out the pairs of the tested sensors, to figures and tables."""

    def __init__(self, settings: Settings, source: str, table: Spans | None, sketched: bool,
                 takers: Takers | None, progress: Callable[[str], None]) -> None:
        self._takers = takers or {}
        self.comparison = SensorsComparison(settings, source=source, table=table,
                                            progress=progress)
        self.sketches = {name: SeriesSketch(source) for name in self.comparison.tested
                         if sketched}
        # Aligning a run needs all readings a second time.
        self._keeps = settings.alignment.skew == 'apply'
        self._kept: dict[str, list[Headings]] = {one.name: [] for one in self.comparison.sensors}
        self._lost: list[tuple[str, LedgerKey, Losses]] = []
        self._source = source
        self._motion = Motion.empty()

    def take_motion(self, motion: Motion) -> None:
        self.comparison.take_motion(motion)
        self._motion = motion
        for sketch in self.sketches.values():
            sketch.take_motion(motion)

    def update(self, headings: Mapping[str, Headings]) -> None:
        if self._keeps:
            for name, chunk in headings.items():
                self._kept[name].append(chunk)
        self._draw(self.comparison.update(headings))

    def lose(self, name: str, key: LedgerKey, losses: Losses) -> None:
        self.comparison.lose(name, key, losses)
        if self._keeps:
            self._lost.append((name, key, losses))

    def begin_again(self) -> None:
        self._draw(self.comparison.begin_again())

    def finish(self) -> Compared:
        self._draw(self.comparison.finish())
        found = {names: self._align(names, one) for names, one in self.comparison.pairs.items()}
        earlier = {name: one.compliance.take_earlier()
                   for name, one in self.comparison.tested.items()}
        return Compared(found, earlier, (), sketches=self.sketches)

    def _align(self, names: Names, one: Intercomparison) -> list[RunResult]:
        results = one.results()
        if not self._keeps:
            return results
        first, second = (Headings.concatenate(self._kept[name]) for name in names)
        lost = [(key if name == names[0] else key.of_stream('rs'), losses)
                for name, key, losses in self._lost if name in names]
        return judge_aligned(first, second, results, one.compliance.settings,
                             source=self._source, lost=lost, motion=self._motion)

    def _draw(self, found: Mapping[str, Pairs]) -> None:
        for name, sketch in self.sketches.items():
            sketch.update(found[name], self.comparison.tested[name].compliance.settings)
        for name, takers in self._takers.items():
            for take in takers:
                take(found[name])

    def make_accounts(self, found: Compared, inputs: Callable[[Sensor, Sensor], Sequence[Input]],
                      table: Spans | None, marks: Sequence[tuple[str, int]] = (),
                      ) -> dict[str, PairsAccount]:
        """Return the account of the pairs of each sensor, given what tells of its readings."""
        of = {one.name: one for one in self.comparison.sensors}
        spans, made = None if table is None else tuple(table), {}
        for name, one in self.comparison.tested.items():
            names = next(some for some in self.comparison.pairs if some[0] == name)
            first, *others = inputs(*(of[each] for each in names))
            made[name] = make_account(
                Found(found.results[names], [], one.ledger, first, marks=tuple(marks),
                      table=spans, motion=self._motion), one.compliance.settings, *others)
        return made

    def explain(self, table: Spans | None) -> list[str]:
        """Return why pairs have no run."""
        return [f'{" and ".join(names)}: no run: '
                f'{explain_no_run(one.ledger, one.compliance.settings, table)}'
                for names, one in self.comparison.pairs.items()
                if not one.compliance.finished_runs]


def compare_bag(path: str, settings: Settings, table: Spans | None = None, *, name: str = '',
                parts: Sequence[str] = (), helpers: int = 0, sketched: bool = False,
                takers: Takers | None = None,
                progress: Callable[[str], None] = lambda text: None) -> Compared:
    """
    Compare the sensors of one recording.

    Parameters
    ----------
    path : str
        A recording that `open_recording` reads.
    settings : Settings
        With `sensors`.
    table : sequence of (start_ns, stop_ns), optional
        Runs; without one marks and silences decide.
    name : str
        Name of the input in results; by default the path.
    parts : sequence of str
        Bags that go on with the trial of this one, in their order.
    helpers : int
        Processes that decode in parallel with this one.
    sketched : bool
        Collect the data for the figures.
    takers : mapping of str to sequence of callable, optional
        Each is called with the pairs of a tested sensor, chunk by chunk.
    progress : callable
        Called with the progress in words.

    Raises
    ------
    OSError
        If the recording cannot be read.
    BagError, ReaderError
        If it is damaged, or lacks the topic of a sensor.

    """
    name = name or path
    sensors = read_sensors(settings.sensors)
    conventions = {one.heading_topic: one.convention for one in sensors}
    feed = _Feed(settings, name, table, sketched, takers, progress)
    readers = [open_recording(one, settings.bag_namespace, settings.unit_of)
               for one in (path, *parts)]
    notes: list[str] = []
    marks: list[tuple[str, int]] = []
    n = 0
    feed.take_motion(Motion.concatenate(
        [read_motion(reader, settings, notes) for reader in readers]))
    for reader in readers:
        if reader is not readers[0]:
            feed.begin_again()
            notes.append(f'{reader.path} goes on with this trial; readings between the two are '
                         'not counted')
        if table is None:
            for kind, stamp_ns in read_marks(reader):
                marks.append((kind, stamp_ns))
                feed.comparison.mark(kind, stamp_ns)
        told = _Told(reader, sensors, feed, goes_on=reader is not readers[0])
        for chunk in reader.headings(conventions, helpers, told.take):
            n += sum(map(len, chunk.values()))
            feed.update({one.name: chunk[one.heading_topic] for one in sensors})
            progress(f'{n:,} headings')
        told.finish()
        notes += find_problems(reader)
    with ThreadPoolExecutor(1) as beside:
        # Beside the last runs, once all is read: helpers start from a process of one thread.
        digest: Future[str] = beside.submit(sha256, path)
        found = feed.finish()
    given = tuple(OperatorNote(note.stamp_ns, note.text) for note in read_notes(readers[0]))
    described = Input(name, digest.result(), notes=given or None,
                      ledger_problems=tuple(notes) or None)
    accounts = feed.make_accounts(found, lambda ts, rs: (replace(
        described, ts_topic=ts.heading_topic, rs_topic=rs.heading_topic),), table, marks)
    notes += [*feed.explain(table), *(text for reader in readers for text in reader.oddities)]
    if not any(found.results.values()):
        described = replace(described, no_run='no pair of sensors has a run')
    return replace(found, described=(described,), accounts=accounts,
                   notes=[f'{name}: {note}' for note in notes])


class _Told:
    """What is missing of each sensor in a recording, as numbers, drivers and recorder tell it."""

    def __init__(self, reader: Readable, sensors: Sequence[Sensor], feed: _Feed, *,
                 goes_on: bool) -> None:
        self._feed = feed
        self._of = {one.heading_topic: BagLosses(
            reader, {one.heading_topic: 'ts'}, partial(feed.lose, one.name), goes_on=goes_on)
            for one in sensors}

    def take(self, topic: str, lost_as: str, losses: Losses) -> None:
        self._of[topic].take(topic, lost_as, losses)

    def finish(self) -> None:
        for one in self._of.values():
            one.read_told()
            one.finish(self._feed.comparison.newest_ns)


def name_logs(inputs: Sequence[str], settings: Settings) -> dict[str, str] | None:
    """
    Return the logs of the sensors by name, from inputs ``NAME=PATH``.

    Returns
    -------
    dict of str to str, or None
        None if no input has this form.

    Raises
    ------
    ValueError
        If some have it and others not, a name is unknown or comes twice, or a sensor has none.

    """
    sensors = [one.name for one in read_sensors(settings.sensors)]
    parts = [given.partition('=') for given in inputs]
    if not any(name in sensors and equals for name, equals, _ in parts):
        return None
    found: dict[str, str] = {}
    for given, (name, equals, path) in zip(inputs, parts):
        if not equals or name not in sensors:
            raise ValueError(f'{given}: must be NAME=LOG with a sensor of the settings: '
                             f'{", ".join(sensors)}')
        if name in found:
            raise ValueError(f'{given}: {name} has the log {found[name]} already')
        found[name] = path
    if missing := [name for name in sensors if name not in found]:
        raise ValueError(f'{missing[0]}: has no log; give {missing[0]}=LOG, or take its row out '
                         'of the setting sensors')
    return found


def compare_logs(logs: Mapping[str, str], settings: Settings,
                 drivers: DriverSettings | None = None, table: Spans | None = None, *,
                 motion: str | None = None, sketched: bool = False, takers: Takers | None = None,
                 progress: Callable[[str], None] = lambda text: None) -> Compared:
    """
    Compare the sensors of a trial, each from a log.

    Parameters
    ----------
    logs : mapping of str to str
        Path of each sensor's log, by its name; one log may hold several.
    settings : Settings
        With `sensors`.
    drivers : DriverSettings, optional
        How to read the logs; a row of `sensors` chooses sentence, talker and instrument.
    motion : str, optional
        A log with the motion of the ship; by default that of the reference or of another sensor,
        if it has any.
    table, sketched, takers, progress
        As for `compare_bag`.

    Raises
    ------
    OSError, ValueError
        If a log cannot be read or has no heading.

    """
    sensors = read_sensors(settings.sensors)
    paths, of = plan_logs(logs, settings, drivers or DriverSettings())
    imported = {one.name: import_log(logs[one.name], of[one.name], progress,
                                     role='rs' if one.is_reference else 'ts',
                                     unit=one.unit) for one in sensors}
    moved = (find_motion(paths, of, motion) if settings.motion.compare or motion
             else FoundMotion())
    described = tuple(Input(log.path, log.sha256, log.sentence or 'csv',
                            not_taken=dict(log.not_taken)) for log in imported.values())
    notes = [f'{name}: {log.path}, {len(log.headings)} headings of '
             f'{"; ".join((log.sentence or "a csv", *log.remarks))}; not taken: '
             f'{log.words_not_taken}' for name, log in imported.items()]
    feed = _Feed(settings, next(iter(logs.values())), table, sketched, takers, progress)
    found = _compare(feed, {name: log.headings for name, log in imported.items()},
                     moved.rows if settings.motion.compare else None, table)
    given = dict(zip(imported, described))
    accounts = feed.make_accounts(found, lambda ts, rs: (given[ts.name], replace(
        given[rs.name], ts_topic=None, rs_topic=given[rs.name].ts_topic)), table)
    return replace(found, described=described, accounts=accounts,
                   notes=[*notes, *moved.notes, *found.notes])


def compare_headings(headings: Mapping[str, Headings], settings: Settings,
                     table: Spans | None = None, *, source: str = '',
                     motion: Motion | None = None, sketched: bool = False,
                     progress: Callable[[str], None] = lambda text: None) -> Compared:
    """Compare sensors whose readings are in memory, by their names; see `compare_bag`."""
    feed = _Feed(settings, source, table, sketched, None, progress)
    return _compare(feed, headings, motion if settings.motion.compare else None, table)


def _compare(feed: _Feed, headings: Mapping[str, Headings], motion: Motion | None,
             table: Spans | None) -> Compared:
    if motion is not None:
        feed.take_motion(motion)
    feed.update(headings)
    found = feed.finish()
    return replace(found, notes=feed.explain(table))


def plan_logs(logs: Mapping[str, str], settings: Settings, drivers: DriverSettings,
              ) -> tuple[dict[str, str], dict[str, DriverSettings]]:
    """
    Return the log of each sensor, and how to read it and a log of the motion, by name.

    The reference is last, so that `find_motion` searches its log first.
    """
    order = sorted(read_sensors(settings.sensors), key=lambda one: one.is_reference)
    return ({one.name: logs[one.name] for one in order},
            {'motion': drivers,
             **{one.name: replace(drivers, **describe_driver(one)) for one in order}})
