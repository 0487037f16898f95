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

"""The analysis of readings, of a recording, or of a campaign of several, to one verdict."""

from __future__ import annotations

from concurrent.futures import Executor
from dataclasses import dataclass, field, replace
import os
from typing import Callable, Container, Mapping, Sequence
import warnings

from heading_intercompare.bags.csv.pairs_account import PairsAccount
from heading_intercompare.core.records import Headings, Motion
from heading_intercompare.core.sensors.compared_sensors import pair_with_reference
from heading_intercompare.core.sensors.judging import judge_sensors
from heading_intercompare.core.sensors.pair_names import Names
from heading_intercompare.core.sensors.pair_settings import (
    check_norms,
    check_sensors,
    settings_of_pair,
)
from heading_intercompare.core.sensors.sensors_verdict import SensorsVerdict
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.units.angle_units import AngleWatch
from heading_intercompare.core.verdict.all_runs import join
from heading_intercompare.core.verdict.judge import RunResult
from heading_intercompare.core.verdict.verdict_document import RunVerdict, Verdict
from heading_intercompare.drivers.settings import DEFAULT_DRIVER, DriverSettings
from heading_intercompare.report import SeriesSketch
from heading_intercompare.report.figures.notebook import Plotter

from .campaign import judge_inputs
from .python_words import python_words, speak_python
from .run_table import assign_runs, name_unused, read_run_table, RunTable
from .sources.input_comparison import InputComparison, PairTakers
from .sources.judged_input import JudgedInput

Place = str | os.PathLike[str]


@dataclass(frozen=True, slots=True)
class Judgement:
    """
    The verdict on two sensors or more, with notes.

    Attributes
    ----------
    verdicts
        The verdict on each sensor against the reference, by its name: `ts` of two. Empty if no
        sensor is the reference.
    sensors
        The verdict on all together; None without the setting `sensors`.
    notes : tuple of str
        What the user should know about the inputs: unfinished bag, no run, not judged again.
    sketches
        Data for the figures of each tested sensor, one per input that was read; empty unless
        requested.
    earlier
        Runs of each tested sensor that are too old for the verdict (`runs.keep`).
    accounts
        What belongs beside a csv of the pairs of each tested sensor; empty of several inputs.

    """

    verdicts: Mapping[str, Verdict]
    sensors: SensorsVerdict | None = None
    notes: tuple[str, ...] = ()
    sketches: Mapping[str, tuple[SeriesSketch, ...]] = field(default_factory=dict)
    earlier: Mapping[str, tuple[RunVerdict, ...]] = field(default_factory=dict)
    accounts: Mapping[str, PairsAccount] = field(default_factory=dict)

    @property
    def verdict(self) -> Verdict | SensorsVerdict:
        """Return the verdict on all sensors; without the setting `sensors` that on the TS."""
        return self.verdicts['ts'] if self.sensors is None else self.sensors

    def __repr__(self) -> str:
        """Return the headline."""
        return f'<Judgement: {self.verdict.headline}>'


def judge_bags(paths: Sequence[Place], settings: Settings, *,
               runs: Place | RunTable | None = None, executor: Executor | None = None,
               jobs: int | None = None, takers: PairTakers | None = None,
               sketched: bool = False, driver: DriverSettings = DEFAULT_DRIVER,
               progress: Callable[[str], None] = lambda text: None) -> Judgement:
    """
    Judge recorded runs, as the command ``analyze`` does.

    Parameters
    ----------
    paths
        ``.mcap`` files, rosbag2 directories, ``.csv`` files of pairs or journals, at least one.
    settings
        Settings with the norms; with `sensors` for more than two.
    runs : path or sequence of (start_ns, stop_ns, source), optional
        Table of runs, or the csv file that holds it; see `read_run_table`. Without one, marks in
        the bag and silences decide.
    executor
        Judges the inputs; see `judge_inputs`.
    jobs
        Processes on this machine, without an executor; by default one per core.
    takers : mapping of str to sequence of callable, optional
        Each is called with the pairs of a tested sensor (`ts` of two), chunk by chunk; for one
        input, and not with an executor.
    sketched
        Collect the data for the figures of the report and of `Verdict.plot`.
    driver
        Column, form, zone and date of the stamps in a table.
    progress
        Called with the progress in words.

    Returns
    -------
    Judgement
        An unreadable recording does not stop the others, but then no sensor is compliant.

    Raises
    ------
    SettingsError
        If a norm is missing.
    OSError, ValueError
        If no input can be read or has a pair, because the stamps of its sensors do not meet; or
        if the table of runs is wrong.

    """
    if isinstance(paths, (str, os.PathLike)) or not paths:
        raise ValueError(f'paths = {paths!r}: must be a list of at least one path')
    # Check the norms now; otherwise every input would be reported as unreadable.
    check_norms(settings)
    names = [os.fspath(path) for path in paths]
    table: RunTable | None = None
    elsewhere: list[str] = []
    if runs is not None:
        run_table = (read_run_table(os.fspath(runs)) if isinstance(runs, (str, os.PathLike))
                     else runs)
        table, elsewhere = assign_runs(run_table, names)
    judged = judge_inputs(names, settings, table, takers=takers, sketched=sketched, jobs=jobs,
                          executor=executor, driver=driver, progress=progress)
    refuse_apart(judged, names[0])
    called = os.fspath(runs) if isinstance(runs, (str, os.PathLike)) else 'runs'
    return conclude(judged, settings, [f'{called}: source {source} is not one of the INPUTs'
                                       for source in elsewhere])


def refuse_apart(judged: Sequence[JudgedInput], label: str) -> None:
    """Raise ValueError if no input has a pair, because the stamps of its sensors do not meet."""
    apart = [judged_input for judged_input in judged if judged_input.apart]
    if apart and all(judged_input.apart or judged_input.error for judged_input in judged):
        name = label if len(judged) == 1 else (
            f'none of the {len(judged)} inputs has a pair: {apart[0].path}')
        raise ValueError(f'{name}: no pair was made, because {apart[0].apart}')


def conclude(judged: Sequence[JudgedInput], settings: Settings,
             notes: Sequence[str] = ()) -> Judgement:
    """Join the runs of all inputs to the verdict on each sensor, and on all of them."""
    results: dict[Names, list[RunResult]] = {}
    for judged_input in judged:
        for names, runs in judged_input.results.items():
            results.setdefault(names, []).extend(runs)
    lacking = {names for names in results
               if any(judged_input.lacks_run(names) for judged_input in judged)}
    sketches = {sensor.name: tuple(sketch for judged_input in judged
                                   if sensor.name in judged_input.sketches
                                   for sketch in judged_input.sketches[sensor.name].sketches)
                for sensor, _ in pair_with_reference(settings)}
    verdicts = _join_tested(judged, settings, results, lacking, sketches)
    together = None
    if settings.sensors is not None:
        together = _judge_together(judged, settings, verdicts, results, lacking)
    unused = name_unused([run.verdict for runs in results.values() for run in runs],
                         settings.exclusions)
    input_notes = [note for judged_input in judged for note in judged_input.notes]
    return Judgement(
        verdicts, together, (*input_notes, *notes, *unused), sketches,
        {name: tuple(run for judged_input in judged for run in judged_input.earlier.get(name, ()))
         for name in verdicts}, judged[0].accounts if len(judged) == 1 else {})


def _judge_together(judged: Sequence[JudgedInput], settings: Settings,
                    verdicts: Mapping[str, Verdict],
                    results: Mapping[Names, Sequence[RunResult]], lacking: Container[Names],
                    ) -> SensorsVerdict:
    """Return the verdict on all sensors together."""
    others = {names: runs for names, runs in results.items()
              if names[0] not in verdicts or names[1] in verdicts}
    return judge_sensors(
        settings, verdicts, others,
        [entry for judged_input in judged for entry in judged_input.entries],
        incomplete=[names for names in others if names in lacking])


def _join_tested(judged: Sequence[JudgedInput], settings: Settings,
                 results: Mapping[Names, Sequence[RunResult]], lacking: Container[Names],
                 sketches: Mapping[str, tuple[SeriesSketch, ...]]) -> dict[str, Verdict]:
    """Return the verdict on each sensor against the reference, by its name."""
    verdicts = {}
    for sensor, reference in pair_with_reference(settings):
        names = sensor.name, reference.name
        entries = [entry for judged_input in judged
                   for entry in judged_input.entries_of_tested.get(sensor.name, ())]
        verdict = join(results.get(names, []), settings_of_pair(settings, sensor, reference),
                       entries, incomplete=names in lacking)
        if drawn := sketches[sensor.name]:
            verdict = replace(verdict, plotter=Plotter(drawn))
        verdicts[sensor.name] = verdict
    return verdicts


def analyze(ts: Headings | Sequence[Headings], rs: Headings | Sequence[Headings],
            settings: Settings, *,
            motion: Motion | Sequence[Motion | None] | None = None) -> Verdict:
    """
    Judge a TS against an RS.

    Parameters
    ----------
    ts, rs : Headings, or equally long lists of them
        Readings of the two sensors; each element of a list is a separate input.
    settings
        Must hold the norms; `sensors` is not read.
    motion : Motion, or a list as long as those of the sensors, optional
        The motion of the ship, against which the headings are checked.

    Returns
    -------
    Verdict
        The verdict on all runs of all inputs; never compliant if an input has no run. Its `plot`
        draws the figures.

    Raises
    ------
    SettingsError
        If a norm is missing.
    ValueError
        If the lists differ in length, or headings look like radians or revolutions.

    References
    ----------
    GK (1)-(7); the guarded decision of ``docs/verdict.md``.

    Examples
    --------
    >>> import numpy as np
    >>> rng = np.random.default_rng(1)
    >>> stamp_ns = 1_400_000_000_000_000_000 + np.arange(1800) * 1_000_000_000
    >>> ship_deg = 320.0 + 20.0 * np.sin(np.arange(1800) / 60.0)
    >>> ts = Headings.of(stamp_ns, ship_deg + 0.05 * rng.standard_normal(1800))
    >>> rs = Headings.of(stamp_ns, ship_deg + 0.02 * rng.standard_normal(1800))
    >>> verdict = analyze(ts, rs, Settings.of(sigma_max_deg=0.2, sigma_ref_max_deg=0.1))
    >>> verdict.outcome.value, verdict.runs[0].n
    ('compliant', 1800)

    """
    ts = [ts] if isinstance(ts, Headings) else list(ts)
    rs = [rs] if isinstance(rs, Headings) else list(rs)
    if len(ts) != len(rs):
        raise ValueError(f'{len(ts)} TS inputs but {len(rs)} RS inputs: give one RS for each TS')
    motions = [motion] * len(ts) if motion is None or isinstance(motion, Motion) else list(motion)
    if len(motions) != len(ts):
        raise ValueError(f'{len(ts)} inputs but motion of {len(motions)}: give one for each input')
    return _judge_headings([{'ts': of_ts, 'rs': of_rs} for of_ts, of_rs in zip(ts, rs)], motions,
                           replace(settings, sensors=None)).verdicts['ts']


def analyze_sensors(headings: Mapping[str, Headings], settings: Settings,
                    motion: Motion | None = None) -> SensorsVerdict:
    """
    Judge several sensors from their readings.

    Parameters
    ----------
    headings
        The readings of each sensor, by its name.
    settings
        With `sensors` and the norms.
    motion
        The motion of the ship, against which the headings are checked.

    Returns
    -------
    SensorsVerdict
        Its `verdicts` are those of `analyze` on each sensor and the reference.

    Raises
    ------
    SettingsError
        If there are no sensors, or one has no norm.
    ValueError
        If a sensor has no readings, or headings look like radians or revolutions.

    """
    for sensor in check_sensors(settings):
        if sensor.name not in headings:
            raise ValueError(f'headings: has no {sensor.name}; the setting sensors names it')
    verdict = _judge_headings([headings], [motion], settings).sensors
    assert verdict is not None
    return verdict


def _judge_headings(inputs: Sequence[Mapping[str, Headings]], motions: Sequence[Motion | None],
                    settings: Settings) -> Judgement:
    """Judge sensors whose readings are in memory, by their names."""
    for headings in inputs:
        for name, readings in headings.items():
            _check_degrees(name, readings)
    judged = []
    for headings, motion in zip(inputs, motions):
        comparison = InputComparison(settings, sketched=True)
        if motion is not None:
            comparison.take_motion(motion)
        comparison.update(headings)
        judged.append(comparison.describe(comparison.finish(), (), lambda ts, rs: ()))
    return conclude(judged, settings)


def _check_degrees(name: str, readings: Headings) -> None:
    """Raise ValueError if the headings of a stream are no degrees."""
    watch = AngleWatch()
    watch.update(readings.stamp_ns, readings.heading_deg)
    if watch.words:
        raise ValueError(f'{name}: {watch.words}; make them with Headings.of(stamp_ns, heading, '
                         f'{watch.unit!r})')


def analyze_bag(path: Place, settings: Settings, *, runs: Place | RunTable | None = None,
                jobs: int | None = None,
                progress: Callable[[str], None] = lambda text: None,
                ) -> Verdict | SensorsVerdict:
    """
    Judge the runs of one recording.

    Parameters
    ----------
    path
        ``.mcap`` file, rosbag2 directory, ``.csv`` file of pairs or journal of a live run.
    settings, runs, jobs, progress
        As for `judge_bags`.

    Returns
    -------
    Verdict or SensorsVerdict
        The verdict of ``analyze``, on several sensors if `settings` has `sensors`. Notes on the
        recording are issued as warnings.

    Raises
    ------
    SettingsError
        If a norm is missing.
    OSError, ValueError
        If the recording cannot be read, or the table of runs is wrong.

    Examples
    --------
    >>> settings = Settings.of(sigma_max_deg=0.2, sigma_ref_max_deg=0.1)
    >>> verdict = analyze_bag('trial', settings)  # doctest: +SKIP

    """
    with python_words():
        judgement = judge_bags([path], settings, runs=runs, jobs=jobs, sketched=True,
                               progress=progress)
    return warn_of_notes(judgement)


def analyze_bags(paths: Sequence[Place], settings: Settings, *,
                 runs: Place | RunTable | None = None, executor: Executor | None = None,
                 jobs: int | None = None,
                 progress: Callable[[str], None] = lambda text: None,
                 ) -> Verdict | SensorsVerdict:
    """
    Judge the runs of several recordings together.

    Parameters
    ----------
    paths, settings, runs, executor, jobs, progress
        As for `judge_bags`, which also returns the notes and the graphs.

    Returns
    -------
    Verdict or SensorsVerdict
        The verdict of ``analyze``. An unreadable recording does not stop the others, but then the
        verdict is not compliant. Notes on the recordings are issued as warnings.

    Raises
    ------
    SettingsError
        If a norm is missing.
    OSError, ValueError
        If no recording can be read, or the table of runs is wrong.

    Examples
    --------
    >>> settings = Settings.of(sigma_max_deg=0.2, sigma_ref_max_deg=0.1)
    >>> verdict = analyze_bags(['monday', 'tuesday'], settings)  # doctest: +SKIP

    """
    with python_words():
        judgement = judge_bags(paths, settings, runs=runs, executor=executor, jobs=jobs,
                               sketched=True, progress=progress)
    return warn_of_notes(judgement)


def warn_of_notes(judgement: Judgement) -> Verdict | SensorsVerdict:
    """Issue the notes as warnings at the caller of the caller; return the verdict."""
    for note in judgement.notes:
        warnings.warn(speak_python(note), stacklevel=3)
    return judgement.verdict
