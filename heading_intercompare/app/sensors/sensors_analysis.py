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

"""The analysis of several sensors: recordings, logs or readings to one verdict."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
import os
from typing import Callable, Mapping, Sequence

from heading_intercompare.app.campaign import count_cores, MOST_READERS
from heading_intercompare.app.job import explain_unreadable, UNREADABLE
from heading_intercompare.app.run_table import assign_runs, read_run_table, RunTable
from heading_intercompare.bags.csv.pairs_account import PairsAccount
from heading_intercompare.bags.rosbag2.trial_parts import find_parts
from heading_intercompare.core.pipeline import join
from heading_intercompare.core.records import Headings, Motion
from heading_intercompare.core.rows.sensor_table import find_reference
from heading_intercompare.core.sensors.judging import judge_sensors
from heading_intercompare.core.sensors.pair_settings import check_sensors, settings_of_pair
from heading_intercompare.core.sensors.sensors_verdict import SensorsVerdict
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.verdict.judge import RunResult
from heading_intercompare.core.verdict.verdict_document import Input, RunVerdict, Verdict
from heading_intercompare.drivers.settings import DriverSettings
from heading_intercompare.report import SeriesSketch
from heading_intercompare.report.figures.notebook import Plotter

from .sensors_reading import (
    compare_bag,
    compare_headings,
    compare_logs,
    Compared,
    Names,
    Takers,
)

__all__ = ['analyze_sensors', 'judge_sensor_bags', 'judge_sensor_logs', 'SensorsJudgement']


@dataclass(frozen=True, slots=True)
class SensorsJudgement:
    """
    The verdict on several sensors, with notes.

    Attributes
    ----------
    verdict : SensorsVerdict
    notes : tuple of str
        What the user should know about the inputs.
    sketches : dict of str to tuple of SeriesSketch
        Data for the figures of each tested sensor; empty unless requested.
    earlier : dict of str to tuple of RunVerdict
        Runs of each tested sensor that are too old for the verdict (`runs.keep`).
    accounts : dict of str to PairsAccount
        What belongs beside a csv of the pairs of each tested sensor; empty of several inputs.

    """

    verdict: SensorsVerdict
    notes: tuple[str, ...] = ()
    sketches: Mapping[str, tuple[SeriesSketch, ...]] = field(default_factory=dict)
    earlier: Mapping[str, tuple[RunVerdict, ...]] = field(default_factory=dict)
    accounts: Mapping[str, PairsAccount] = field(default_factory=dict)


def judge_sensor_bags(paths: Sequence[str], settings: Settings, *,
                      runs: str | RunTable | None = None, sketched: bool = False,
                      jobs: int | None = None, takers: Takers | None = None,
                      progress: Callable[[str], None] = lambda text: None) -> SensorsJudgement:
    """
    Judge several sensors from recordings.

    Parameters
    ----------
    paths : sequence of str
        Recordings with the topics of all sensors, at least one.
    settings : Settings
        With `sensors` and the norms.
    runs : str or table, optional
        Table of runs, as for `judge_bags`.
    sketched : bool
        Collect the data for the figures.
    jobs : int, optional
        Processes that read one recording; by default one per core.
    takers : mapping of str to sequence of callable, optional
        Each is called with the pairs of a tested sensor, chunk by chunk; for one recording.
    progress : callable
        Called with the progress in words.

    Returns
    -------
    SensorsJudgement
        An unreadable recording does not stop the others, but then no sensor is compliant.

    Raises
    ------
    SettingsError
        If there are no sensors, or one has no norm.
    OSError, ValueError
        If no recording can be read, or the table of runs is wrong.

    """
    check_sensors(settings)
    table: RunTable | None = None
    elsewhere: list[str] = []
    if runs is not None:
        table, elsewhere = assign_runs(read_run_table(runs) if isinstance(runs, str) else runs,
                                       paths)
    trials = find_parts(paths)
    continued = {part for parts in trials.values() for part in parts}
    helpers = min(jobs or count_cores(), MOST_READERS) - 1
    compared: list[Compared] = []
    for path in paths:
        if path in continued:
            continue
        spans = None if table is None else [
            (start, stop) for start, stop, source in table if source in ('', path)]
        try:
            parts = [os.path.abspath(one) for one in trials.get(path, ())]
            compared.append(compare_bag(path, settings, spans, parts=parts, helpers=helpers,
                                        sketched=sketched, takers=takers,
                                        progress=progress))
        except UNREADABLE as error:
            if len(paths) == 1:
                raise
            why = explain_unreadable(error, path)
            compared.append(Compared({}, {}, (Input(path, error=why),),
                                     [f'{path}: not judged: {why}']))
    compared = _drop_repeats(compared)
    if all(each.described[0].error for each in compared):
        first = compared[0].described[0]
        raise ValueError(f'none of the {len(paths)} inputs can be read: {first.path}: '
                         f'{first.error}')
    found = _conclude(compared, settings)
    return replace(found, notes=(*found.notes, *(
        f'runs: source {source} is not one of the INPUTs' for source in elsewhere)))


def judge_sensor_logs(logs: Mapping[str, str], settings: Settings,
                      drivers: DriverSettings | None = None, *,
                      runs: str | None = None, motion: str | None = None, sketched: bool = False,
                      takers: Takers | None = None,
                      progress: Callable[[str], None] = lambda text: None) -> SensorsJudgement:
    """
    Judge several sensors, each from a log.

    Parameters
    ----------
    logs : mapping of str to str
        Path of each sensor's log, by its name.
    settings : Settings
        With `sensors` and the norms.
    drivers : DriverSettings, optional
        How to read the logs.
    runs : str, optional
        Table of runs, a csv file; its source is the first log.
    motion : str, optional
        A log with the motion of the ship.
    sketched, takers, progress
        As for `judge_sensor_bags`.

    Raises
    ------
    SettingsError
        If there are no sensors, or one has no norm.
    OSError, ValueError
        If a log cannot be read or has no heading, or the table of runs is wrong.

    """
    check_sensors(settings)
    spans = None
    if runs is not None:
        table, _ = assign_runs(read_run_table(runs), [next(iter(logs.values()))])
        spans = [(start, stop) for start, stop, _ in table]
    return _conclude([compare_logs(logs, settings, drivers, spans, motion=motion,
                                   sketched=sketched, takers=takers,
                                   progress=progress)], settings)


def analyze_sensors(headings: Mapping[str, Headings], settings: Settings,
                    motion: Motion | None = None) -> SensorsVerdict:
    """
    Judge several sensors from their readings.

    Parameters
    ----------
    headings : mapping of str to Headings
        The readings of each sensor, by its name.
    settings : Settings
        With `sensors` and the norms.
    motion : Motion, optional
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
        If a sensor has no readings.

    """
    for sensor in check_sensors(settings):
        if sensor.name not in headings:
            raise ValueError(f'headings: has no {sensor.name}; the setting sensors names it')
    return _conclude([compare_headings(headings, settings, motion=motion,
                                       sketched=True)], settings).verdict


def _drop_repeats(compared: Sequence[Compared]) -> list[Compared]:
    """Drop the runs of recordings that have the same data as an earlier one."""
    first: dict[str, str] = {}
    found = []
    for each in compared:
        given = each.described[0]
        same = first.setdefault(given.sha256, given.path) if given.sha256 else given.path
        found.append(each if same == given.path else Compared(
            {}, {}, (replace(given, same_as=same),),
            [f'{given.path}: not judged again: it has the data of {same}']))
    return found


def _lacks_run(names: Names, compared: Sequence[Compared]) -> bool:
    """Tell whether a pair has no run in an input, other than one that repeats another."""
    return any(not each.results.get(names) for each in compared
               if not any(given.same_as for given in each.described))


def _conclude(compared: Sequence[Compared], settings: Settings) -> SensorsJudgement:
    """Join what was found in all inputs."""
    sensors = check_sensors(settings)
    inputs = [given for each in compared for given in each.described]
    results: dict[Names, list[RunResult]] = {}
    for each in compared:
        for names, runs in each.results.items():
            results.setdefault(names, []).extend(runs)
    reference = find_reference(sensors)
    verdicts: dict[str, Verdict] = {}
    sketches: dict[str, tuple[SeriesSketch, ...]] = {}
    for sensor in sensors:
        if reference is None or sensor is reference:
            continue
        names = sensor.name, reference.name
        incomplete = _lacks_run(names, compared)
        verdict = join(results[names], settings_of_pair(settings, sensor, reference), inputs,
                       incomplete=incomplete)
        sketches[sensor.name] = tuple(
            each.sketches[sensor.name] for each in compared if each.sketches)
        if sketches[sensor.name]:
            verdict = replace(verdict, plotter=Plotter(sketches[sensor.name]))
        verdicts[sensor.name] = verdict
    earlier = {name: tuple(one.verdict for each in compared for one in each.earlier.get(name, ()))
               for name in verdicts}
    others = {names: runs for names, runs in results.items()
              if reference is None or reference.name not in names}
    lacking = [names for names in others if _lacks_run(names, compared)]
    return SensorsJudgement(judge_sensors(settings, verdicts, others, inputs, incomplete=lacking),
                            tuple(note for each in compared for note in each.notes), sketches,
                            earlier, compared[0].accounts if len(compared) == 1 else {})
