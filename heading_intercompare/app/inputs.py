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
The inputs of an analysis with their runs: recordings, tables of pairs, and journals of live runs.

A bag is an MCAP file or a rosbag2 directory.
"""

from __future__ import annotations

from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import replace
from functools import partial
import os
from pathlib import Path
from typing import Any, Callable, Iterable, Iterator, Mapping, Protocol, Sequence

from heading_intercompare.app.sources.file_hash import hash_files
from heading_intercompare.bags.errors import BagError
from heading_intercompare.bags.recording.recorded_headings import find_problems, read_marks
from heading_intercompare.bags.recording.recorder_losses import (
    BagLosses,
    RECORDING,
    tell_judged,
)
from heading_intercompare.bags.rosbag2.bag_files import find_files
from heading_intercompare.bags.rosbag2.bag_reader import BagReader
from heading_intercompare.bags.rosbag2.motion_topics import read_bag_motion, read_fixes
from heading_intercompare.bags.rosbag2.provenance import read_notes
from heading_intercompare.bags.rosbag2.quality_topics import (
    find_quality_topic,
    has_claims,
    read_quality,
)
from heading_intercompare.bags.rosbag2.readable import Readable
from heading_intercompare.bags.rosbag2.trial_parts import is_joined
from heading_intercompare.core.count_words import count_words
from heading_intercompare.core.declared_settings import SettingsError
from heading_intercompare.core.kept_state import KeptState
from heading_intercompare.core.motion.antennas import find_baseline_headings
from heading_intercompare.core.pairing.ledger import Ledger, LedgerKey, LedgerSegment
from heading_intercompare.core.pairing.pair_maker import PairMaker
from heading_intercompare.core.pairing.pairer import Pairer
from heading_intercompare.core.pipeline import Compliance
from heading_intercompare.core.records import Headings, Losses, Motion, Pairs, Quality
from heading_intercompare.core.sensor_table import Sensor
from heading_intercompare.core.sensors.compared_sensors import list_sensors, pair_with_reference
from heading_intercompare.core.sensors.pair_names import TWO
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.utc_text import utc
from heading_intercompare.core.verdict.verdict_document import Input, OperatorNote
from heading_intercompare.drivers.settings import DEFAULT_DRIVER, DriverSettings
from heading_intercompare.journal.journal_file import (
    is_journal,
    read_journal,
)
from heading_intercompare.journal.journal_reading import (
    compare_settings,
    describe_gaps,
    JournalReader,
    read_origin,
)
from heading_intercompare.readers.registry import open_recording, sources_of
from heading_intercompare.readers.stream_recording import StreamOptions, StreamRecording, UNSTATED
from heading_intercompare.report import SegmentSketches

from .config import Config, load_config
from .logs.antenna_logs import describe_baseline
from .logs.log_import import describe_far_stamps
from .run_table import RunTable
from .sources.csv_source import has_pairs, judge_csv
from .sources.input_comparison import describe_two, InputComparison, PairTakers, Spans
from .sources.judged_input import JudgedInput

#: Its settings are at the start of a journal.
_HEAD_BYTES = 1_000_000
#: Headings paired and judged at once: enough that calls cost little, few enough for the cache.
_AT_ONCE = 1 << 15


def load_config_or_journal(path: str | None, inputs: Sequence[str]) -> Config:
    """
    Read a ROS parameter file; without one, the settings that the inputs hold if all are journals.

    Parameters
    ----------
    path
        The parameter file.
    inputs
        The inputs to judge.

    Raises
    ------
    OSError, BagError
        If the parameter file, or every journal, cannot be read.
    SettingsError
        If the file is not a ROS parameter file, or if journals have different settings.

    """
    if path is not None or not all(map(is_journal, inputs)):
        return load_config(path)
    stored: dict[str, Mapping[str, Any]] = {}
    for journal_path in inputs:
        try:
            stored[journal_path] = read_settings_of_journal(journal_path)
        except (OSError, ValueError):
            # The judging names the journal, and goes on with the other inputs.
            if journal_path == inputs[-1] and not stored:
                raise
    first = next(iter(stored))
    for journal, settings in stored.items():
        if differing := compare_settings(settings, stored[first]):
            raise SettingsError(f'{journal}: has other settings than {first}: {differing}; '
                                'give the settings for all with --config')
    return Config(first, stored[first])


def read_settings_of_journal(path: str) -> Mapping[str, Any]:
    """Return the settings of the trial of a journal; OSError or BagError if it has none."""
    return read_origin(read_journal(Path(path), _HEAD_BYTES), Path(path)).settings


def options_of(settings: Settings, driver: DriverSettings,
               progress: Callable[[str], None] = lambda text: None) -> StreamOptions:
    """Return what is stated of a recording with the streams of all sensors."""
    return StreamOptions(driver, tuple(sensor.heading_topic for sensor in list_sensors(settings)),
                         settings.unit_of, progress)


def judge_input(path: str, settings: Settings, table: RunTable | None = None,
                takers: PairTakers | None = None,
                progress: Callable[[str], None] = lambda text: None, *, name: str | None = None,
                helpers: int = 0, parts: Sequence[str] = (), sketched: bool = False,
                driver: DriverSettings = DEFAULT_DRIVER) -> JudgedInput:
    """
    Judge the runs of one input.

    Parameters
    ----------
    path
        A recording that `open_recording` reads, a table of pairs or a journal of a live run.
    settings
        By which it is judged.
    table : sequence of (start_ns, stop_ns, source), optional
        Runs; those with a source apply only to the input of that name, see `assign_runs`.
    takers : mapping of str to sequence of callable, optional
        Each is called with the pairs of a tested sensor, chunk by chunk.
    progress
        Called with the progress in words.
    name
        Name of the input in results, notes and the table of runs; `path` by default.
    helpers
        Processes that decode a bag in parallel with this one.
    parts
        Bags that go on with the trial of this one, in their order.
    sketched
        Collect the data for the figures of each tested sensor.
    driver
        Column and form of the stamps in a table.

    Returns
    -------
    JudgedInput

    Raises
    ------
    OSError
        If the input cannot be read.
    BagError
        If it is damaged, or not a bag or table of pairs with the topics or columns needed, or a
        journal of another version; if it holds the pairs of two sensors and `sensors` names more.

    """
    name = path if name is None else name
    spans = None if table is None else [
        (start, stop) for start, stop, source in table if source in ('', name)]
    options = options_of(settings, driver, progress)
    holds_pairs = is_journal(path) or has_pairs(path, options)
    if not holds_pairs:
        readers: list[Readable] = [open_recording(part, settings.bag_namespace, options)
                                   for part in (path, *parts)]
        comparison = InputComparison(settings, name, spans, takers=takers, sketched=sketched,
                                     progress=progress)
        return _judge_recording(readers, path, name, settings, comparison, progress, helpers,
                                options)
    sketch = SegmentSketches(name) if sketched else None
    pair_takers = (takers or {}).get('ts', ())
    if is_journal(path):
        return _judge_journal(path, name, settings, spans, pair_takers, progress, sketch)
    _check_for_two(path, settings)
    return judge_csv(path, name, settings, spans, pair_takers, progress, sketch)


def _check_for_two(path: str, settings: Settings) -> None:
    """Raise BagError if the settings are of more sensors than the two of an input."""
    if settings.sensors is not None:
        raise BagError('holds the pairs of two sensors, and the setting sensors names more; '
                       'choose them with --ts NAME --rs NAME', path)


class _Resumed:
    """A compliance that goes on from a journal, and hands out the pairs."""

    def __init__(self, compliance: Compliance, whole: bool, ignore_marks: bool,
                 takers: Sequence[Callable[[Pairs], None]], progress: Callable[[str], None],
                 ) -> None:
        self._compliance, self._whole, self._ignore_marks = compliance, whole, ignore_marks
        self._takers, self._progress, self._n = takers, progress, 0

    def update(self, pairs: Pairs) -> None:
        self._compliance.update(pairs)
        self._hand_out(pairs)

    def take_motion(self, motion: Motion) -> None:
        self._compliance.take_motion(motion)

    def take_quality(self, stream: str, quality: Quality) -> None:
        self._compliance.take_quality(stream, quality)

    def mark(self, kind: str, stamp_ns: int) -> None:
        self._compliance.mark(kind, stamp_ns)

    def go_on(self, state: KeptState, pairs: Pairs) -> None:
        if self._whole:
            self._compliance.go_on(state, pairs)
        elif state.cutter.marked and not self._ignore_marks:
            # The marks before stay in force.
            segments = tuple(replace(segment, finished=(), n_short=0, earlier_ns=None)
                             for segment in state.segments)
            self._compliance.go_on(replace(state, segments=segments, n_earlier=0), pairs)
        else:
            self._compliance.update(pairs)
        self._hand_out(pairs)

    def _hand_out(self, pairs: Pairs) -> None:
        for take in self._takers:
            take(pairs)
        self._n += len(pairs)
        self._progress(f'{self._n:,} pairs')


def _leave_out_names(settings: Mapping[str, Any]) -> dict[str, Any]:
    """Return settings without the names of the trial, which change no figure."""
    return {name: value for name, value in settings.items() if not name.startswith('trial.')}


def _judge_journal(path: str, name: str, settings: Settings, runs: Spans | None,
                   takers: Sequence[Callable[[Pairs], None]], progress: Callable[[str], None],
                   sketch: SegmentSketches | None) -> JudgedInput:
    # A node may be writing the journal: the hash is that of the bytes that were read.
    contents = read_journal(Path(path))
    origin = read_origin(contents, Path(path))
    if origin.names != (TWO,):
        raise BagError('is the journal of several sensors: analyze the recording', path)
    _check_for_two(path, settings)
    compliance = Compliance(settings, source=name, table=runs, progress=progress)
    others = compare_settings(*map(_leave_out_names, (
        origin.settings or {}, settings.to_mapping())))
    whole = runs is None and not others
    if sketch is not None:
        takers = (*takers, partial(sketch.update, settings=settings))
    reader = JournalReader(Path(path), makers=[PairMaker(Pairer(Settings.from_mapping(
        origin.settings)))] if origin.holds_readings else None)
    resumed = _Resumed(compliance, whole, runs is not None, takers, progress)
    judged, trial = reader.read(contents, [resumed]), reader.kept
    total, = reader.finish([resumed])
    compliance.finish()
    # The node called the source of the runs that it judged by another name.
    results, earlier = (
        [replace(result, verdict=replace(result.verdict, source=name)) for result in run_results]
        for run_results in (compliance.results(total), compliance.take_earlier(total)))
    problems = [f'is the journal of a live run, begun at {utc(origin.began_ns)} UTC by version '
                f'{origin.software}' + (f', recorded to {origin.bag}' if origin.bag else '')
                + f': it holds {count_words(trial.n_pairs, "pair")}, '
                f'{count_words(len(trial.marks), "mark")} and {count_words(judged, "judged run")}']
    if others:
        problems.append('its pairs were judged by other settings than those of its node: '
                        f'{others}')
    if judged and not whole:
        problems.append(f'left out: {count_words(judged, "judged run")}, whose pairs are not in '
                        'it: ' + ('the table of runs' if not others else
                                                   'these settings') + ' cannot judge them again')
    problems += describe_gaps(trial, contents.torn)
    if total is None or not total.paired:
        n = dict.fromkeys((LedgerKey.PAIRED, LedgerKey.TS_PAIRED, LedgerKey.RS_USED),
                          trial.n_pairs)
        total = Ledger.from_segments([LedgerSegment(None, n)])
    described = Input(path=name, sha256=contents.sha256, ts_topic=origin.settings.get('ts_topic'),
                      rs_topic=origin.settings.get('rs_topic'), ledger_problems=tuple(problems))
    return describe_two(results, earlier, described, problems, total, settings, table=runs,
                        marks=sorted(trial.marks), sketch=sketch)


def _judge_recording(readers: Sequence[Readable], path: str, name: str, settings: Settings,
                     comparison: InputComparison, progress: Callable[[str], None],
                     helpers: int, options: StreamOptions) -> JudgedInput:
    """Judge the recording at `path`, and those that go on with its trial."""
    first = readers[0]
    conventions = _list_conventions(comparison, settings)
    problems: list[str] = []
    remarks: list[str] = []
    n, whole = 0, _count_headings(readers, conventions)
    comparison.take_motion(Motion.concatenate(
        [read_motion(reader, settings, problems) for reader in readers]))
    read_quality_of(readers, settings, comparison, problems)
    joined = [is_joined(*two, conventions) for two in zip(readers, readers[1:])]
    for reader, before, goes_on, is_continued in zip(
            readers, [None, *readers], [False, *joined], [*joined, False]):
        _begin_reading(reader, before, goes_on, comparison, problems)
        for headings in read_sensors_of(reader, settings, comparison, remarks, helpers,
                                        goes_on=reader is not first):
            n += sum(map(len, headings.values()))
            comparison.update(headings)
            progress(f'{n:,} of {whole:,} headings' if n <= whole else f'{n:,} headings')
        describe_reading(reader, is_continued, problems, remarks)
    with ThreadPoolExecutor(1) as beside:
        # Beside the last runs, once all is read: only a process with a single thread can start
        # helpers.
        digest: Future[str] = beside.submit(sha256, path, options)
        results = comparison.finish()
    notes = tuple(OperatorNote(note.stamp_ns, note.text) for note in read_notes(first))
    entry = Input(name, digest.result(), notes=notes or None,
                  ledger_problems=tuple(problems) or None)
    return comparison.describe(
        results, [entry], lambda ts, rs: [_name_topics(entry, ts, rs, settings)],
        [f'{name}: {note}' for note in (*remarks, *problems)], path=name, label=name)


class TakesReadings(Protocol):
    """What takes the readings of a recording: a comparison of its sensors, or an import."""

    @property
    def sensors(self) -> tuple[Sensor, ...]:
        """Return the sensors."""

    @property
    def reference(self) -> Sensor | None:
        """Return the reference of all others; None if there is none."""

    @property
    def newest_ns(self) -> int | None:
        """Return the newest stamp of the readings taken so far; None before the first."""

    def lose(self, name: str, key: LedgerKey, losses: Losses) -> None:
        """Take readings of a sensor that never came; `key` is that of a TS."""

    def take_quality(self, name: str, quality: Quality) -> None:
        """Take what a sensor says of its readings, before these."""


def read_sensors_of(reader: Readable, settings: Settings, taker: TakesReadings,
                    remarks: list[str], helpers: int = 0, *, goes_on: bool = False,
                    ) -> Iterator[dict[str, Headings]]:
    """
    Yield the readings of a recording by the names of their sensors.

    Parameters
    ----------
    reader
        The recording.
    settings
        Topics, conventions, antennas.
    taker
        Gets the losses, and what is claimed; it takes the readings before it asks for more.
    remarks
        Gets what to know of two antennas.
    helpers
        Processes that decode a bag in parallel with this one.
    goes_on
        Another recording of this trial was read before.

    """
    conventions = _list_conventions(taker, settings)
    losses = BagLosses(reader, {sensor.heading_topic: sensor.name for sensor in taker.sensors
                                if sensor.heading_topic in conventions},
                       taker.lose, goes_on=goes_on)
    baseline = (None if settings.antennas.fore_topic is None
                else _read_antennas(reader, settings, remarks))
    claimed = {sensor.heading_topic: partial(taker.take_quality, sensor.name)
               for sensor in taker.sensors if sensor.heading_topic in conventions
               and _claims_come_along(reader, sensor.heading_topic, conventions)
               and has_claims(reader, sensor.heading_topic)}
    for chunk in _join_chunks(reader.headings(conventions, helpers, losses.take, claimed)):
        headings = {sensor.name: chunk.get(sensor.heading_topic, Headings.empty())
                    for sensor in taker.sensors}
        if baseline is not None and taker.reference is not None:
            headings[taker.reference.name], baseline = baseline, Headings.empty()
        yield headings
    losses.read_told()
    losses.finish(taker.newest_ns)


def _begin_reading(reader: Readable, before: Readable | None, goes_on: bool,
                   comparison: InputComparison, problems: list[str]) -> None:
    """Begin with a recording: after the last message of the one `before`, or again; with marks."""
    if goes_on and isinstance(reader, BagReader) and isinstance(before, BagReader):
        reader.go_on_from(before)
    elif before is not None:
        comparison.begin_again()
        problems.append(f'{reader.path} goes on with this trial; readings between the two '
                        'are not counted')
    if comparison.takes_marks:
        for kind, stamp_ns in read_marks(reader):
            comparison.mark(kind, stamp_ns)


def describe_reading(reader: Readable, is_continued: bool, problems: list[str],
                      remarks: list[str]) -> None:
    """Add what is wrong with a recording that was read to its end, and what else to know."""
    missing = find_problems(reader)
    if is_continued and reader.incomplete in missing:
        missing.remove(reader.incomplete)
        remarks.append(f'{reader.incomplete}; the next bag goes on after its last message')
    problems += missing
    remarks += filter(None, [tell_judged(reader.metadata().get(RECORDING, {}))])
    remarks += reader.oddities
    if isinstance(reader, StreamRecording):
        remarks += describe_far_stamps(reader.start_ns, reader.end_ns)
        if reader.not_taken:
            problems.append(f'{reader.kind}: {reader.words_present}')


def _list_conventions(comparison: TakesReadings, settings: Settings) -> dict[str, str]:
    """Return the convention of each topic of headings to read; two antennas have none."""
    conventions = {sensor.heading_topic: sensor.convention for sensor in comparison.sensors}
    if settings.antennas.fore_topic is not None:
        if comparison.reference is None:
            raise SettingsError('antennas.fore_topic: two antennas are the reference, but no row '
                                'of sensors has the word rs')
        del conventions[comparison.reference.heading_topic]
    return conventions


def describe_recording(path: str, entry: Input, settings: Settings) -> JudgedInput:
    """Return a recording without runs of its own, with its entries in the verdicts."""
    return JudgedInput(path=path, results={}, entries=[entry], entries_of_tested={
        sensor.name: [_name_topics(entry, sensor, reference, settings)]
        for sensor, reference in pair_with_reference(settings)})


def _name_topics(entry: Input, ts: Sensor, rs: Sensor, settings: Settings) -> Input:
    """Return the entry of a recording with the topics of a pair of sensors."""
    rule = settings.antennas
    return replace(entry, ts_topic=ts.heading_topic,
                   rs_topic=rs.heading_topic if rule.fore_topic is None
                   else f'{rule.fore_topic} - {rule.aft_topic}')


def _join_chunks(chunks: Iterable[dict[str, Headings]]) -> Iterator[dict[str, Headings]]:
    """Join neighbouring chunks, so that the calls for each cost little beside the work."""
    waiting: list[dict[str, Headings]] = []
    n = 0
    for chunk in chunks:
        waiting.append(chunk)
        n += sum(len(headings) for headings in chunk.values())
        if n >= _AT_ONCE:
            yield _join(waiting)
            waiting, n = [], 0
    if waiting:
        yield _join(waiting)


def _join(chunks: Sequence[dict[str, Headings]]) -> dict[str, Headings]:
    return {topic: Headings.concatenate([chunk[topic] for chunk in chunks])
            for topic in chunks[0]}


def _read_antennas(reader: Readable, settings: Settings, remarks: list[str]) -> Headings:
    """Return the headings of the baseline between two antennas; say what it is like."""
    rule = settings.antennas
    (fore, bad), (aft, worse) = (read_fixes(reader, topic or '')
                                 for topic in (rule.fore_topic, rule.aft_topic))
    baseline = find_baseline_headings(fore, aft, rule)
    counts = {**baseline.rejected, 'unreadable': bad + worse}
    lacking = ', '.join(f'{n} {why}' for why, n in counts.items() if n)
    remarks.append(f'reference sensor (RS): {len(baseline.headings)} headings of two antennas, '
                   f'{describe_baseline(baseline)}; not taken: {lacking or "nothing"}')
    return baseline.headings


def read_motion(reader: Readable, settings: Settings, problems: list[str]) -> Motion:
    """Return the motion of the ship in a bag, and add what could not be read to the problems."""
    if not settings.motion.compare:
        return Motion.empty()
    if isinstance(reader, StreamRecording):
        return Motion.concatenate([rows for _, rows in reader.choose_motion().values()])
    bag_motion = read_bag_motion(reader, settings.motion)
    if bag_motion.unreadable:
        problems.append(f'{bag_motion.unreadable} messages of the motion of the ship cannot be '
                        'read')
    return bag_motion.rows


def read_quality_of(readers: Sequence[Readable], settings: Settings, taker: TakesReadings,
                    problems: list[str]) -> None:
    """
    Hand over what each sensor says of its readings in recordings; add what is unreadable.

    What comes along with the readings is left out; `read_sensors_of` hands it over.
    """
    conventions = _list_conventions(taker, settings)
    for sensor in taker.sensors:
        topic = sensor.heading_topic
        if topic in conventions:
            taker.take_quality(sensor.name, Quality.concatenate(
                [read_quality(reader, topic, problems) for reader in readers
                 if not _claims_come_along(reader, topic, conventions)]))


def _claims_come_along(reader: Readable, topic: str, conventions: Mapping[str, str]) -> bool:
    """Tell whether the claims of a topic are told with its readings, of topics that are there."""
    return (None not in map(reader.find, conventions) and reader.tells_claims(conventions)
            and find_quality_topic(reader, topic) is None)


def _count_headings(readers: Sequence[Readable], topics: Iterable[str]) -> int:
    """Return the number of headings in bags, by their indexes."""
    return sum(reader.topics[name].count for reader in readers for topic in topics
               if (name := reader.find(topic)) is not None)


def sha256(path: str, options: StreamOptions = UNSTATED) -> str:
    """Return the SHA-256 of a file, or of the files of a bag in the order of their names."""
    return hash_files(sorted(sources_of(path, options) or find_files(Path(path)).paths))


def find_input(path: str, verdict: str) -> str | None:
    """Return where an input of a verdict lies: at its path, or beside the file of the verdict."""
    name = os.path.basename(path.rstrip(os.sep))
    places = (path, os.path.join(os.path.dirname(verdict), name))
    # A device or a pipe, which anybody may state, has no end.
    return next((place for place in places if os.path.isfile(place) or os.path.isdir(place)), None)
