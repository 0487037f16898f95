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

"""The commands ``analyze`` and ``report`` for several sensors: the setting ``sensors``."""

from __future__ import annotations

import argparse
from contextlib import ExitStack
from dataclasses import replace
import os
import sys
from typing import Mapping, Sequence

from heading_intercompare.app.outputs import check_outputs, name_file, open_tables, Outputs
from heading_intercompare.app.sensors.sensors_analysis import (
    judge_sensor_bags,
    judge_sensor_logs,
    SensorsJudgement,
)
from heading_intercompare.app.sensors.sensors_reading import name_logs
from heading_intercompare.cli.terminal.console import say, say_lines, tell, VERDICT_MARKS
from heading_intercompare.cli.terminal.progress import Progress
from heading_intercompare.core.rows.sensor_table import find_reference, list_tested, read_sensors
from heading_intercompare.core.sensors.pair_settings import (
    check_sensors,
    settings_of_pair,
    settings_of_tested,
)
from heading_intercompare.core.sensors.sensors_verdict import SensorsVerdict
from heading_intercompare.core.settings import Settings
from heading_intercompare.drivers.settings import DriverSettings
from heading_intercompare.logbook.logbook_file import Logbook
from heading_intercompare.logbook.run_row import make_rows
from heading_intercompare.readers.registry import has_one_sensor
from heading_intercompare.report import json, SeriesSketch
from heading_intercompare.report.runs_csv import write_sensor_runs
from heading_intercompare.report.sensors_report import sensor_path, write_sensors

__all__ = ['choose_pair', 'deliver_sensors', 'run_sensors']

_OF_TWO = ('dask', 'rs_antennas')
_OF_TESTED = ('csv', 'ensembles', 'runs_csv')


def choose_pair(settings: Settings, ts: str | None, rs: str | None) -> Settings:
    """
    Return the settings of two of several sensors that ``--ts`` and ``--rs`` name.

    Parameters
    ----------
    settings : Settings
        With `ts` and `rs` as topics.
    ts, rs : str or None
        As given: names of sensors, or topics.

    Returns
    -------
    Settings
        Without sensors if both are given; otherwise as they are.

    Raises
    ------
    ValueError
        If one of them is given without the other.

    """
    if settings.sensors is None or ts is None and rs is None:
        return settings
    if ts is None or rs is None:
        given = f'--ts {ts}' if rs is None else f'--rs {rs}'
        raise ValueError(f'{given}: with the setting sensors give --ts and --rs, to compare these '
                         'two alone, or neither')
    by_name = {one.name: one for one in read_sensors(settings.sensors)}
    if ts in by_name and rs in by_name:
        return settings_of_pair(settings, by_name[ts], by_name[rs])
    return replace(settings, sensors=None)


def run_sensors(arguments: argparse.Namespace, settings: Settings, ship: str,
                drivers: Mapping[str, DriverSettings], book: Logbook | None) -> int:
    """Judge several sensors; print and write the verdict; return the exit code."""
    from .analyze import check_report
    check_sensors(settings)
    logs = name_logs(arguments.inputs, settings)
    if logs is None:
        _refuse_unnamed(arguments.inputs, settings)
    inputs = arguments.inputs if logs is None else [*logs.values()]
    _check_options(arguments, settings, len(inputs) if logs is None else 1)
    check_report(arguments)
    outputs = _plan_outputs(arguments, settings)
    _check_outputs(arguments, outputs, inputs)
    shared = drivers['ts']
    if logs is None and arguments.motion:
        raise ValueError(f'--motion {arguments.motion}: is for logs, and no INPUT is NAME=LOG; '
                         'leave it out')
    if logs is None and drivers != dict.fromkeys(drivers, DriverSettings()):
        raise ValueError('options of logs: no INPUT is NAME=LOG; leave them out')
    if logs is not None and shared != drivers['rs']:
        raise ValueError('--ts-... and --rs-...: with several sensors the rows of the setting '
                         'sensors choose sentence, talker and instrument')
    with ExitStack() as files, Progress(
            f'{len(inputs)} inputs' if len(inputs) > 1 else inputs[0],
            arguments.quiet) as progress:
        sketched = bool(arguments.report)
        tables = {name: [files.enter_context(file) for file in open_tables(
            wanted, settings_of_tested(settings, name))] for name, wanted in outputs.items()}
        takers = {name: [table.write for table in some] for name, some in tables.items()}
        judged = judge_sensor_bags(
            inputs, settings, runs=arguments.runs or None, sketched=sketched, takers=takers,
            jobs=arguments.jobs, progress=progress.show) if logs is None else judge_sensor_logs(
                logs, settings, shared, runs=arguments.runs or None, motion=arguments.motion,
                sketched=sketched, takers=takers, progress=progress.show)
        for name, some in tables.items():
            for table in some:
                table.add_account(judged.accounts.get(name))
    for note in judged.notes:
        tell(note)
    if book is not None:
        _write_rows(book, judged, ship)
    return deliver_sensors(judged.verdict, arguments, judged.sketches)


def _refuse_unnamed(inputs: Sequence[str], settings: Settings) -> None:
    """Reject the log of one sensor that nothing says the name of."""
    names = ', '.join(one.name for one in read_sensors(settings.sensors))
    for path in inputs:
        if os.path.exists(path) and has_one_sensor(path):
            raise ValueError(f'{path}: is the log of one sensor; say of which, NAME={path} with '
                             f'one of {names}, or take the setting sensors out')


def _check_options(arguments: argparse.Namespace, settings: Settings, inputs: int) -> None:
    """Reject options that several sensors, or these inputs, do not have."""
    of_two = 'is for two sensors; choose them with --ts NAME --rs NAME'
    free = find_reference(read_sensors(settings.sensors)) is None
    for option in (*_OF_TWO, *_OF_TESTED):
        value, why = getattr(arguments, option, None), of_two
        if option in _OF_TESTED:
            why = f'no sensor is the reference, and it {of_two}' if free else (
                f'takes the pairs of one INPUT, but {inputs} are given'
                if inputs > 1 and option != 'runs_csv' else '')
        if value is not None and why:
            shown = ' '.join(value) if isinstance(value, list) else value
            raise ValueError(f'--{option.replace("_", "-")} {shown}: {why}')


def _plan_outputs(arguments: argparse.Namespace, settings: Settings) -> dict[str, Outputs]:
    """Return the files of each tested sensor, named after it."""
    def of(path: str | None, name: str) -> str | None:
        return os.fspath(sensor_path(path, name)) if path and path != '-' else path
    return {one.name: Outputs(
        of(arguments.csv, one.name), of(arguments.ensembles, one.name),
        of(arguments.report, one.name), ensemble_s=arguments.ensemble_s)
        for one in list_tested(read_sensors(settings.sensors))}


def _check_outputs(arguments: argparse.Namespace, outputs: Mapping[str, Outputs],
                   inputs: Sequence[str]) -> None:
    """Check the files of all sensors, and those of each beside them."""
    whole = Outputs(report=arguments.report, json=arguments.json, runs_csv=arguments.runs_csv)
    for some in (whole, *(replace(whole, report=one.report, csv=one.csv, ensembles=one.ensembles)
                          for one in outputs.values())):
        check_outputs(some, inputs, config=arguments.config, runs=arguments.runs)


def _write_rows(book: Logbook, judged: SensorsJudgement, ship: str) -> None:
    """Write the runs of each tested sensor; its name follows that of the ship."""
    for name, verdict in judged.verdict.verdicts.items():
        book.write(make_rows(verdict, ship=f'{ship}/{name}' if ship else name,
                             earlier=judged.earlier.get(name, ()), find_bag=os.path.abspath))
    if not judged.verdict.verdicts:
        tell('--logbook: no row, because no sensor is the reference')


def deliver_sensors(verdict: SensorsVerdict, arguments: argparse.Namespace,
                    sketches: Mapping[str, Sequence[SeriesSketch]] | None = None) -> int:
    """Print and write the verdict, write the protocols if asked for; return the exit code."""
    from .analyze import code_of
    if arguments.json == '-':
        sys.stdout.write(json.render(verdict))
    else:
        say(str(verdict), VERDICT_MARKS)
        if arguments.json:
            with name_file(arguments.json):
                json.write(verdict, arguments.json)
    if arguments.runs_csv:
        if not verdict.verdicts:
            raise ValueError(f'--runs-csv {arguments.runs_csv}: no sensor is the reference, so '
                             'the verdict has no run of a sensor; leave it out')
        with name_file(arguments.runs_csv):
            write_sensor_runs(verdict.verdicts, arguments.runs_csv)
    if arguments.report:
        with name_file(arguments.report), Progress(arguments.report, arguments.quiet) as progress:
            progress.show('drawing the protocols')
            files = write_sensors(verdict, arguments.report, sketches, progress.show)
        if arguments.json != '-':
            say_lines(['protocols: ' + ', '.join(map(str, files))])
    return code_of(verdict.outcome, verdict.validity_effect) if arguments.check else 0
