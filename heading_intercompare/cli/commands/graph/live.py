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

"""The command ``live``: the graph in one process, from drivers or topics, with recording."""

from __future__ import annotations

import argparse
import os
from pathlib import Path
import time
from typing import Any, Mapping, Sequence

from heading_intercompare.app.config import choose_pair, LIVE, load_config, settings_for
from heading_intercompare.bags.rosbag2.trial_parts import name_first, name_next
from heading_intercompare.cli.commands.analyze import (
    add_settings_arguments,
    add_verdict_arguments,
    conclude,
)
from heading_intercompare.cli.commands.note import add_note_argument, read_notes
from heading_intercompare.cli.node_command import add_namespace_argument
from heading_intercompare.cli.terminal.console import tell
from heading_intercompare.cli.terminal.live_view import LiveView
from heading_intercompare.core.decision.coverage import least_duration_words
from heading_intercompare.core.declared_settings import from_mapping, SettingsError
from heading_intercompare.core.sensor_table import describe_driver, read_sensors
from heading_intercompare.core.sensors.pair_settings import check_norms
from heading_intercompare.core.settings import Settings
from heading_intercompare.journal.run_journal import find_bag
from heading_intercompare.nodes.settings import ComplianceNode

from .web_option import add_web_argument, read_web


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    parser.add_argument('--ts', metavar='TOPIC', help='topic of the tested sensor')
    parser.add_argument('--rs', metavar='TOPIC', help='topic of the reference sensor')
    add_settings_arguments(parser)
    parser.add_argument('-o', '--output', metavar='BAG',
                        help='the bag to record (default: heading_<UTC> in this folder)')
    add_namespace_argument(parser)
    add_note_argument(parser)
    add_web_argument(parser)
    add_verdict_arguments(parser)


def run(arguments: argparse.Namespace) -> int:
    """Run until the sources end or the user presses Ctrl-C; print the verdict."""
    config = load_config(arguments.config)
    settings = choose_pair(settings_for(config, arguments.set, LIVE, ts_topic=arguments.ts,
                                        rs_topic=arguments.rs), arguments.ts, arguments.rs)
    check_norms(settings)
    usual = _describe_drivers(settings)
    drivers, moved = _plan_drivers(usual, config.sections, arguments.config)
    recorder = {**config.sections.get('recorder', {}), **(
        {'parameter_file': arguments.config} if arguments.config else {})}
    if notes := read_notes(arguments):
        recorder['note'] = notes
    page = read_web(arguments, config.sections.get('dashboard', {}))
    compliance = {**config.sections.get('compliance', {})}
    output = arguments.output or recorder.get('output')
    compliance.setdefault('journal', f'{output or "heading"}.journal')
    rule = from_mapping(ComplianceNode, {
        name: value for name, value in compliance.items() if name == 'resume_within_s'})
    before = find_bag(Path(compliance['journal']), settings, within_s=rule.resume_within_s,
                      now_ns=time.time_ns())
    if before is not None:
        recorder['continues'] = os.path.basename(before)
    if output is None:
        output = name_first()
    elif before is not None:
        output = name_next(output)

    from heading_intercompare.nodes.graph import intercompare, Source
    from heading_intercompare.nodes.motion_driver import MotionDriver
    from heading_intercompare.nodes.nmea_driver import NmeaDriver

    if before is not None:
        tell(f'goes on with the trial of {before}; records {output}')
    if not arguments.quiet:
        _tell_start(settings, [defaults['topic'] for name, defaults in usual.items()
                               if name not in drivers])
    with LiveView(f'heading-intercompare live: {output}', 'Ctrl-C ends the trial',
                  arguments.quiet) as shown:
        verdict = intercompare(
            [*(Source(NmeaDriver, name, driver) for name, driver in drivers.items()),
             *([Source(MotionDriver, 'motion_driver', moved)] if moved is not None else [])],
            {k: v for k, v in settings.to_mapping().items() if v is not None},
            output=output, report_dir=config.sections.get('compliance', {}).get('report_dir'),
            own={**config.sections, 'compliance': compliance, 'recorder': recorder},
            namespace=arguments.namespace, page=page,
            show=None if arguments.quiet else shown.show,
            tell=None if arguments.quiet else shown.tell)
    return conclude(verdict, arguments)


def _plan_drivers(usual: Mapping[str, Mapping[str, Any]],
                  sections: Mapping[str, Mapping[str, Any]], config: str,
                  ) -> tuple[dict[str, dict[str, Any]], Mapping[str, Any] | None]:
    """Return the settings of the drivers to run, by name, and of that of the motion, if any."""
    drivers = {name: {**defaults, **sections[name]}
               for name, defaults in usual.items() if name in sections}
    for name, driver in drivers.items():
        _check_source(driver, config, name, f'{driver["topic"]} is heard as a topic')
    moved = sections.get('motion_driver')
    if moved is not None:
        _check_source(moved, config, 'motion_driver', 'the drivers of the sensors tell the motion '
                      'of the ship')
        drivers = {name: {**driver, 'motion': False} for name, driver in drivers.items()}
    return drivers, moved


def _tell_start(settings: Settings, heard: Sequence[str]) -> None:
    """Print how long a trial lasts, and on which topics its sensors are heard."""
    if not settings.sensors:
        tell(least_duration_words(settings.risk))
    if heard:
        tell(f'listening to {" and ".join(heard)}; Ctrl-C ends the trial')


def _check_source(driver: Mapping[str, Any], config: str, name: str, otherwise: str) -> None:
    """Raise SettingsError if the section of a driver names no source."""
    if driver.get('source') is None:
        raise SettingsError(f'{config}: section {name!r}: source is missing, e.g. '
                            f'source: udp://239.192.0.3:60003; without the section {otherwise}')


def _describe_drivers(settings: Settings) -> dict[str, dict[str, Any]]:
    """Return what each driver would be given, by its name: the topic, and words of its row."""
    sensors = read_sensors(settings.sensors)
    if not sensors:
        return {'ts_driver': {'topic': settings.ts_topic},
                'rs_driver': {'topic': settings.rs_topic}}
    return {f'{sensor.name}_driver': {'topic': sensor.heading_topic, **describe_driver(sensor)}
            for sensor in sensors}
