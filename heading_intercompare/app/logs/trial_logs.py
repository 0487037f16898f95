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

"""The logs of a trial, one for each sensor, and the verdict on them, imported in memory."""

from __future__ import annotations

from dataclasses import replace
import os
from typing import Callable, Mapping, Sequence

from heading_intercompare.app.analysis import (
    conclude,
    Judgement,
    Place,
    refuse_apart,
    warn_of_notes,
)
from heading_intercompare.app.python_words import python_words
from heading_intercompare.app.run_table import assign_runs, read_run_table
from heading_intercompare.app.sources.input_comparison import (
    InputComparison,
    PairTakers,
    Spans,
)
from heading_intercompare.core.offline import name_apart
from heading_intercompare.core.sensor_table import describe_driver, read_sensors, Sensor
from heading_intercompare.core.sensors.compared_sensors import list_sensors
from heading_intercompare.core.sensors.pair_settings import check_norms
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.verdict.verdict_document import Input, Verdict
from heading_intercompare.drivers.refused_lines import describe_start
from heading_intercompare.drivers.settings import DEFAULT_DRIVER, DriverSettings
from heading_intercompare.readers.registry import has_one_sensor, has_streams
from heading_intercompare.readers.stream_recording import UNSTATED

from .antenna_logs import import_antennas
from .log_import import import_log, ImportedLog, options_for
from .log_motion import find_motion, FoundMotion

ROLES = ('ts', 'rs')
"""The sensors, in the order of their logs."""

_USE = 'give two logs, first that of the TS, then that of the RS, and nothing else'
_OTHERS = ('.mcap', '.csv', '.json', '.journal')
_APART = ('tell its sensors apart with --ts-sentence and --rs-sentence, --ts-talker and '
          '--rs-talker, or --ts-instrument and --rs-instrument')
_APART_IN_ROWS = 'tell them apart with sentence, talker or instrument in their rows of sensors'
_WORDS = {'ts': 'tested sensor (TS)', 'rs': 'reference sensor (RS)'}


def find_logs(inputs: Sequence[str], drivers: Mapping[str, DriverSettings] | None = None, *,
              recordings: bool = False) -> tuple[str, str] | None:
    """
    Return the log of the TS and that of the RS, or None if no input is a log.

    Parameters
    ----------
    inputs
        The inputs as given. One log may hold both sensors.
    drivers : mapping of {'ts', 'rs'} to DriverSettings, optional
        How to read each log; in a log of both sensors they must differ.
    recordings
        A file with several streams is a recording of both sensors, also if there are two.

    Raises
    ------
    OSError
        If one input is a log and another cannot be read.
    ValueError
        If one input is a log and the inputs are neither two different logs nor one log of both.

    """
    _refuse_names(inputs)
    streams = len(inputs) == 2 and not recordings
    options = [options_for(drivers[role]) if drivers else UNSTATED for role in ROLES]
    logs = [path for n, path in enumerate(inputs)
            if has_one_sensor(path) or streams and has_streams(path, options[n])]
    if not logs:
        _check_texts(inputs)
        return None
    for path in inputs:
        if path not in logs:
            os.stat(path)
            start = describe_start(path)
            raise ValueError(f'{path}: is not a log of NMEA sentences or headings, but {logs[0]} '
                             f'is: {start or _USE}')
    apart = drivers is not None and drivers['ts'] != drivers['rs']
    if len(inputs) == 1 and apart:
        return inputs[0], inputs[0]
    if len(inputs) == 1:
        raise ValueError(f'{inputs[0]}: is the log of one sensor: {_USE}; if it is of both, '
                         f'{_APART}')
    if len(inputs) > 2:
        raise ValueError(f'{inputs[0]}: is one of {len(inputs)} logs: {_USE}; give the files of '
                         'one sensor as their folder, or as a pattern in quotes')
    ts, rs = inputs
    if not apart and _is_same_file(ts, rs):
        raise ValueError(f'{rs}: is given as TS and as RS: {_USE}; if it is of both, {_APART}')
    return ts, rs


def _is_same_file(path: str, other: str) -> bool:
    return path == other or (os.path.exists(path) and os.path.exists(other)
                             and os.path.samefile(path, other))


def _refuse_names(inputs: Sequence[str]) -> None:
    """Raise ValueError for an input NAME=LOG without a sensor of that name."""
    for argument in inputs:
        name, equals, path = argument.partition('=')
        if equals and os.path.exists(path) and not os.path.exists(argument):
            raise ValueError(f'{argument}: NAME=LOG is for several sensors, and the setting '
                             f'sensors has no {name}: give it a row for each of them')


def _check_texts(inputs: Sequence[str]) -> None:
    """Raise ValueError for two texts that are neither logs nor anything else that is judged."""
    if len(inputs) == 2 and not any(path.endswith(_OTHERS) or has_streams(path)
                                    for path in inputs):
        for path in inputs:
            start = describe_start(path)
            if start.startswith('first'):
                raise ValueError(f'{path}: is neither a bag nor a log of NMEA sentences: {start}')


def name_logs(inputs: Sequence[str], settings: Settings) -> dict[str, str] | None:
    """
    Return the logs of several sensors by name, from inputs ``NAME=PATH``.

    Returns
    -------
    dict of str to str, or None
        None if no input has this form.

    Raises
    ------
    ValueError
        If some have it and others not, a name is unknown or comes twice, or a sensor has none.

    """
    sensors = [sensor.name for sensor in read_sensors(settings.sensors)]
    parts = [text.partition('=') for text in inputs]
    if not any(name in sensors and equals for name, equals, _ in parts):
        return None
    paths: dict[str, str] = {}
    for text, (name, equals, path) in zip(inputs, parts):
        if not equals or name not in sensors:
            raise ValueError(f'{text}: must be NAME=LOG with a sensor of the settings: '
                             f'{", ".join(sensors)}')
        if name in paths:
            raise ValueError(f'{text}: {name} has the log {paths[name]} already')
        paths[name] = path
    if missing := [name for name in sensors if name not in paths]:
        raise ValueError(f'{missing[0]}: has no log; give {missing[0]}=LOG, or take its row out '
                         'of the setting sensors')
    return paths


def plan_logs(logs: Mapping[str, str], settings: Settings,
              drivers: Mapping[str, DriverSettings] | None = None,
              ) -> tuple[dict[str, str], dict[str, DriverSettings]]:
    """
    Return the log of each sensor, and how to read it and a log of the motion, by name.

    The reference is last, so that `find_motion` searches its log first. A row of `sensors`
    chooses sentence, talker and instrument. Where `drivers` does not name a sensor of these rows,
    its log is read as that of `ts` in all that the row does not say.
    """
    order = sorted(list_sensors(settings), key=lambda sensor: sensor.is_reference)
    drivers = drivers or {}
    shared = drivers.get('ts', DriverSettings()) if settings.sensors else DriverSettings()
    return ({sensor.name: logs[sensor.name] for sensor in order},
            {'motion': drivers.get('motion', DriverSettings()),
             **{sensor.name: replace(drivers.get(sensor.name, shared), **describe_driver(sensor))
                for sensor in order}})


def judge_logs(logs: Mapping[str, str], settings: Settings,
               drivers: Mapping[str, DriverSettings] | None = None, *,
               runs: str | None = None, motion: str | None = None, aft: str | None = None,
               takers: PairTakers | None = None, sketched: bool = False,
               progress: Callable[[str], None] = lambda text: None) -> Judgement:
    """
    Judge sensors, each from a log, as `judge_bags` judges a bag of them.

    Parameters
    ----------
    logs
        Path of each sensor's log, by its name: `ts` and `rs` without the setting `sensors`. One
        log may hold several.
    settings
        Settings with the norms.
    drivers
        How to read each log, and that of the `motion`; see `plan_logs`.
    runs
        Table of runs, a csv file; its source is the first log.
    motion
        A log with the motion of the ship; by default that of the reference or of a tested
        sensor, if it has any.
    aft
        Log of the aft antenna, if the reference is two antennas; its log is that of the fore one.
    takers, sketched, progress
        As for `judge_bags`.

    Returns
    -------
    Judgement
        The inputs of the verdict are the logs; notes say what was taken from each.

    Raises
    ------
    SettingsError
        If a norm is missing.
    OSError, ValueError
        If a log cannot be read or has no heading, the stamps of the logs do not meet, or the
        table of runs is wrong.

    """
    check_norms(settings)
    sensors, first = list_sensors(settings), next(iter(logs.values()))
    table: Spans | None = None
    elsewhere: list[str] = []
    if runs is not None:
        rows, elsewhere = assign_runs(read_run_table(runs), [first])
        table = [(start, stop) for start, stop, _ in rows]
    paths, drivers = plan_logs(logs, settings, drivers)
    imported = {sensor.name: import_sensor(sensor, paths[sensor.name], drivers[sensor.name],
                                           settings, aft, progress) for sensor in sensors}
    _refuse_equal(imported, settings)
    moved = (find_motion(paths, drivers, motion, progress) if settings.motion.compare or motion
             else FoundMotion())
    comparison = InputComparison(settings, first, table, takers=takers, sketched=sketched,
                                 progress=progress)
    if settings.motion.compare:
        for thing in moved.things.values():
            comparison.take_motion(thing)
    for name, log in imported.items():
        if log.quality is not None:
            comparison.take_quality(name, log.quality)
    comparison.update({name: log.headings for name, log in imported.items()})
    results = comparison.finish()
    notes = [f'{name if settings.sensors else _WORDS[name]}: {log.path}, {len(log.headings)} '
             f'headings of {"; ".join((log.sentence or "a csv", *log.remarks))}; not taken: '
             f'{log.words_not_taken}' for name, log in imported.items()]
    label = '' if settings.sensors else ', '.join(logs.values())
    judged = comparison.describe(
        results, [_describe(log, 'ts') for log in imported.values()],
        lambda ts, rs: [_describe(imported[ts.name], 'ts'), _describe(imported[rs.name], 'rs')],
        [*notes, *moved.notes], path=first, label=label)
    for names, pair in comparison.comparison.pairs.items():
        first_log, second_log = (imported[name] for name in names)
        words = name_apart(first_log.headings, second_log.headings, results[names],
                           pair.compliance.settings)
        if words:
            judged.notes.append(f'{label or " and ".join(names)}: {words}')
            judged = replace(judged, apart=judged.apart and f'{judged.apart}; {words}')
    refuse_apart([judged], ', '.join(logs.values()))
    owner = sensors[0].name if settings.sensors else 'the TS'
    return conclude([judged], settings, [f'{runs}: source {source} is not the log of {owner}'
                                         for source in elsewhere])


def analyze_logs(ts: Place, rs: Place, settings: Settings, *,
                 ts_driver: DriverSettings = DEFAULT_DRIVER,
                 rs_driver: DriverSettings = DEFAULT_DRIVER, runs: Place | None = None,
                 motion: Place | None = None,
                 progress: Callable[[str], None] = lambda text: None) -> Verdict:
    """
    Judge a TS against an RS from their logs, as the command ``analyze`` judges two logs.

    Parameters
    ----------
    ts, rs
        The log of each sensor: a file, a folder or a pattern of names. One log may hold both.
    settings
        Settings with the norms; `sensors` is not read.
    ts_driver, rs_driver
        How to read each log: sentence, talker, form and zone of the stamps, and more.
    runs
        Table of runs, a csv file.
    motion
        A log with the motion of the ship; by default that of the RS or of the TS, if it has any.
    progress
        Called with the progress in words.

    Returns
    -------
    Verdict
        Notes on the logs, such as what was not taken of them, are issued as warnings.

    Raises
    ------
    SettingsError
        If a norm is missing.
    OSError, ValueError
        If a log cannot be read or has no heading, the stamps of the logs do not meet, or the
        table of runs is wrong.

    Examples
    --------
    >>> settings = Settings.of(sigma_max_deg=0.2, sigma_ref_max_deg=0.1)
    >>> verdict = analyze_logs('gyro.log', 'seapath.log', settings,
    ...                        ts_driver=DriverSettings(talker='HE'))  # doctest: +SKIP

    """
    drivers = {'ts': ts_driver, 'rs': rs_driver}
    paths = [os.fspath(ts), os.fspath(rs)]
    with python_words():
        pair = find_logs(paths[:1] if paths[0] == paths[1] else paths, drivers)
        if pair is None:
            raise ValueError(f'{paths[0]}: is no log; analyze_bags judges recordings')
        judgement = judge_logs(dict(zip(ROLES, pair)), replace(settings, sensors=None), drivers,
                               runs=None if runs is None else os.fspath(runs),
                               motion=None if motion is None else os.fspath(motion),
                               sketched=True, progress=progress)
    verdict = warn_of_notes(judgement)
    assert isinstance(verdict, Verdict)
    return verdict


def import_sensor(sensor: Sensor, path: str, driver: DriverSettings, settings: Settings,
                  aft: str | None, progress: Callable[[str], None]) -> ImportedLog:
    """Return the headings of a sensor, from its log or, of the reference, of two antennas."""
    if sensor.is_reference and aft is not None:
        return import_antennas((path, aft), driver, settings.antennas, progress)
    return import_log(path, driver, progress, role=sensor.role, unit=sensor.unit)


def _refuse_equal(logs: Mapping[str, ImportedLog], settings: Settings) -> None:
    """Raise ValueError if one log gives the same headings for two sensors."""
    names = [*logs]
    for at, name in enumerate(names):
        for earlier in names[:at]:
            if logs[name].path == logs[earlier].path and (
                    logs[name].headings == logs[earlier].headings):
                several = settings.sensors is not None
                shown = (earlier, name) if several else (earlier.upper(), name.upper())
                raise ValueError(f'{logs[name].path}: gives the same headings as {shown[0]} and '
                                 f'as {shown[1]}: {_APART_IN_ROWS if several else _APART}')


def _describe(log: ImportedLog, role: str) -> Input:
    """Return the entry of a log in the verdict; its topic is the sentence."""
    sentence = log.sentence or 'csv'
    return Input(path=log.path, sha256=log.sha256, ts_topic=sentence if role == 'ts' else None,
                 rs_topic=sentence if role == 'rs' else None, not_taken=dict(log.not_taken))
