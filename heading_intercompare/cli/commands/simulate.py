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

"""The command ``simulate``: a trial of simulated sensors into a bag, at full speed."""

from __future__ import annotations

import argparse
from collections import Counter
from contextlib import ExitStack
from dataclasses import replace
import os
import time
from typing import Iterator, Mapping, Sequence

import numpy as np

from heading_intercompare.ahrs.gimballed.condition import describe_condition
from heading_intercompare.ahrs.gimballed.modes import AhrsStatus
from heading_intercompare.ahrs.sensors import Readings
from heading_intercompare.ahrs.settings import Scenario
from heading_intercompare.ahrs.simulator import SimulatedChunk, Simulation
from heading_intercompare.app.config import load_config, settings_for
from heading_intercompare.app.scenarios import read_scenario, ScenarioFile
from heading_intercompare.app.simulation.seeds import repeat_trial
from heading_intercompare.app.simulation.trial_traces import TrialTraces
from heading_intercompare.app.simulation.voyage import read_voyage, Voyage
from heading_intercompare.bags.mcap.chunk_writer import Rows
from heading_intercompare.bags.recording.bag_writer import BagWriter
from heading_intercompare.bags.rosbag2.bag_yaml import Qos
from heading_intercompare.bags.rosbag2.motion_topics import motion_topics
from heading_intercompare.bags.rosbag2.provenance import (
    describe_origin,
    Notes,
    RECORD,
    TRUTH_TOPIC,
)
from heading_intercompare.cli.terminal.console import say_lines
from heading_intercompare.cli.terminal.progress import Progress
from heading_intercompare.core.declared_settings import SettingsError
from heading_intercompare.core.records import Headings, Reals
from heading_intercompare.core.sensor_table import simulated_topics
from heading_intercompare.core.settings import Settings
from heading_intercompare.messages.heading_messages import encode_imu, IMU
from heading_intercompare.messages.motion.motion_messages import encode_motion, PUBLISHED_TYPES
from heading_intercompare.messages.status_messages import (
    encode_statuses,
    LEVELS,
    Status,
    STATUS_TYPE,
)
from heading_intercompare.report import check_form, write_trial_page
from heading_intercompare.report.sketching.track import Trace

from .analyze import add_settings_arguments, parse_count
from .note import add_note_argument, read_notes

DIAGNOSTICS = '/diagnostics'
_MOST_SEEDS = 10_000


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    parser.add_argument('--scenario', metavar='F', required=True,
                        help='YAML file of the trial, or the name of one in the package, such as '
                        'sea_trial_12h')
    parser.add_argument('-o', '--output', metavar='BAG',
                        help='the rosbag2 directory to write; required without --seeds')
    parser.add_argument('--page', metavar='F',
                        help='also write a page with true heading, readings, errors, claims and '
                        'modes: a file .html, which needs the extra report')
    parser.add_argument('--seeds', metavar='N', type=int,
                        help='simulate and judge the trial with N seeds from the first on, '
                        'without a bag: mean, spread and coverage of the analysis')
    parser.add_argument('--jobs', metavar='N', type=parse_count,
                        help='number of processes for --seeds (default: one per core)')
    parser.add_argument('--seed', metavar='N', type=int,
                        help='seed of the random numbers (default: that of the scenario)')
    parser.add_argument('--track', metavar='F',
                        help='bag, log or csv of a voyage that the ship repeats (default: the '
                        'setting track.file of the scenario, otherwise its legs)')
    parser.add_argument('--track-heading', metavar='NAME',
                        help='topic, sentence or column of its headings (default: the setting '
                        'track.heading)')
    add_note_argument(parser)
    add_settings_arguments(parser)


def run(arguments: argparse.Namespace) -> int:
    """Simulate, write the bag, and print its contents; or judge the trial with many seeds."""
    _check(arguments)
    settings = settings_for(load_config(arguments.config), arguments.set)
    source = _choose_track(read_scenario(arguments.scenario, arguments.seed), arguments)
    voyage = (read_voyage(source.scenario.track, source.folder)
              if source.scenario.track.file else None)
    if arguments.seeds is not None:
        return _repeat(arguments, source, settings, voyage)
    simulation = Simulation(source.scenario, track=None if voyage is None else voyage.track)
    scenario = simulation.scenario
    source = source._replace(scenario=scenario)
    moved = motion_topics(settings.motion) if scenario.motion_hz > 0.0 else {}
    topics = {**simulated_topics(settings.sensors, scenario.sensors, settings.ts_topic,
                                 settings.rs_topic), 'truth': TRUTH_TOPIC,
              **{name: f'{name}/heading' for name in scenario.sensors
                 if name not in ('ts', 'rs')}, **moved}
    if len({topic.lstrip('/') for topic in topics.values()}) < len(topics):
        raise SettingsError(f'ts_topic = {topics["ts"]!r}, rs_topic = '
                            f'{topics["rs"]!r}: must differ from each other and from '
                            + ', '.join(repr(topic) for name, topic in topics.items()
                                        if name not in ('ts', 'rs')))
    counts: Counter[str] = Counter()
    traces = TrialTraces(simulation.truth(), scenario.duration_s) if arguments.page else None
    with Progress(arguments.output, arguments.quiet) as progress, _begin(
            arguments.output, source, topics, settings.to_mapping(), read_notes(arguments),
            {} if voyage is None else voyage.origin) as bag:
        for chunk in simulation.chunks():
            _write(bag, chunk, topics, scenario, simulation.start_ns, counts)
            if traces is not None:
                traces.take(chunk)
            progress.show(f'{min(chunk.end_s, scenario.duration_s):,.0f} of '
                          f'{scenario.duration_s:,.0f} s simulated')
    lines = [*name_trial(source, f'seed {scenario.seed}'),
             *(() if voyage is None else voyage.words)]
    for role in scenario.sensors:
        shown = role.upper() if role in ('ts', 'rs') else role
        lines.append(f'{shown} {counts[role]} headings on {topics[role]}, '
                     f'{counts[f"{role}.invalid"]} of them marked invalid')
    lines += [f'{counts[what]} messages of the motion of the ship on {topic}'
              for what, topic in moved.items()]
    lines += [f'{counts["truth"]} true headings on {TRUTH_TOPIC}; {counts["statuses"]} statuses '
              f'of gimballed sensors on {DIAGNOSTICS}', f'bag: {arguments.output}']
    say_lines(lines)
    if traces is not None:
        _write_page(arguments.page, source, lines, traces.traces())
    return 0


def _check(arguments: argparse.Namespace) -> None:
    """Raise ValueError for options that do not fit each other, before anything is simulated."""
    if arguments.seeds is None and arguments.output is None:
        raise ValueError('-o BAG: must be given, unless the trial is repeated with --seeds N')
    if arguments.seeds is not None and arguments.output is not None:
        raise ValueError(f'-o {arguments.output}: no bag is written with --seeds; leave one out')
    if arguments.seeds is not None and not 2 <= arguments.seeds <= _MOST_SEEDS:
        raise ValueError(f'--seeds {arguments.seeds}: must be between 2 and {_MOST_SEEDS}')
    if arguments.jobs is not None and arguments.seeds is None:
        raise ValueError(f'--jobs {arguments.jobs}: is for --seeds N; leave it out')
    check_page(arguments.page)


def check_page(path: str | None) -> None:
    """Raise ValueError for a page that cannot be written, before anything is simulated."""
    if path and not path.endswith('.html'):
        raise ValueError(f'--page {path}: must end with .html')
    if path:
        # The libraries of a page may not be installed, and a trial may take long.
        check_form(path)


def name_trial(source: ScenarioFile, seed: str) -> list[str]:
    """Return the line that says which trial it is."""
    scenario = source.scenario
    return [f'{source.name}: {scenario.duration_s:g} s, {seed}'
            + (f': {scenario.title}' if scenario.title else '')]


def _repeat(arguments: argparse.Namespace, source: ScenarioFile, settings: Settings,
            voyage: Voyage | None) -> int:
    """Simulate and judge the trial with many seeds; print and draw what they have in common."""
    first = source.scenario.seed
    with Progress(source.name, arguments.quiet) as progress:
        repeated = repeat_trial(source.scenario, range(first, first + arguments.seeds), settings,
                                track=None if voyage is None else voyage.track,
                                jobs=arguments.jobs, progress=progress.show)
    lines = [*name_trial(source, f'seeds {first} to {first + arguments.seeds - 1}'),
             *(() if voyage is None else voyage.words), *repeated.words]
    say_lines(lines)
    if arguments.page:
        _write_page(arguments.page, source, lines, (), repeated.table)
    return 0


def _write_page(path: str, source: ScenarioFile, lines: Sequence[str], traces: Sequence[Trace],
                table: Mapping[str, Sequence[float] | Reals] | None = None) -> None:
    """Write the page of the trial."""
    write_trial_page(path, source.scenario.title or source.name, lines, traces, table)
    say_lines([f'page: {path}'])


def _choose_track(source: ScenarioFile, arguments: argparse.Namespace) -> ScenarioFile:
    """Return the scenario with the voyage that the command line names."""
    options = {'file': arguments.track and os.path.abspath(arguments.track),
               'heading': arguments.track_heading}
    named = {name: value for name, value in options.items() if value is not None}
    if 'heading' in named and not (arguments.track or source.scenario.track.file):
        raise SettingsError('--track-heading: needs a voyage; give its file with --track')
    return source._replace(scenario=replace(
        source.scenario, track=replace(source.scenario.track, **named)))


def _begin(path: str, source: ScenarioFile, topics: dict[str, str],
           settings: dict[str, object], notes: str, track: Mapping[str, object]) -> BagWriter:
    """Return a bag with its topics, and with everything needed to repeat the trial."""
    bag = BagWriter(path, whole=True)
    with ExitStack() as undo:
        undo.callback(bag.abandon)
        for what, topic in topics.items():
            bag.add_topic(topic, PUBLISHED_TYPES.get(what, IMU))
        bag.add_topic(DIAGNOSTICS, STATUS_TYPE, Qos(depth=10))
        bag.metadata(RECORD, describe_origin(settings))
        Notes(bag.metadata).add(notes, time.time_ns())
        bag.metadata('scenario', {
            'file': source.name, **source.scenario.to_mapping()})
        if track:
            bag.metadata('track', track)
        bag.attachment(source.name, 'application/yaml', source.data)
        undo.pop_all()
    return bag


def _write(bag: BagWriter, chunk: SimulatedChunk, topics: dict[str, str], scenario: Scenario,
           start_ns: int, counts: Counter[str]) -> None:
    """Write the messages that the sensors send in one span, in that order."""
    sent = {'ts': (chunk.ts_readings, chunk.ts_statuses),
            'rs': (chunk.rs_readings, chunk.rs_statuses), **chunk.others}
    sensors = scenario.sensors
    batches = [_rows(topics[name], readings, sensors[name].latency_s, start_ns, counts[name])
               for name, (readings, _) in sent.items()]
    batches.append(Rows(topics['truth'], _imu(topics['truth'], chunk.truth),
                        chunk.truth.stamp_ns, None,
                        counts['truth'] + np.arange(len(chunk.truth))))
    for name, (_, statuses) in sent.items():
        batches += _status_rows(name, statuses, sensors[name].latency_s, start_ns,
                                counts['statuses'])
        counts['statuses'] += len(statuses)
    for what, rows in chunk.motion.split().items() if len(chunk.motion) else ():
        batches.append(Rows(topics[what], encode_motion(rows, what, 'ship'), rows.stamp_ns, None,
                            counts[what] + np.arange(len(rows))))
        counts[what] += len(rows)
    bag.write_rows(batches)
    for name, headings in (*((name, readings.headings) for name, (readings, _) in sent.items()),
                           ('truth', chunk.truth)):
        counts[name] += len(headings)
        counts[f'{name}.invalid'] += int(np.isnan(headings.heading_deg).sum())


def _imu(topic: str, headings: Headings, **claims: np.ndarray) -> np.ndarray:
    return encode_imu(headings, topic.strip('/').replace('/', '_'), **claims)


def _rows(topic: str, readings: Readings, latency_s: float, start_ns: int, first: int) -> Rows:
    """Return readings as messages whose log time is that of sending."""
    data = _imu(topic, readings.headings, sigma_deg=readings.sigma_deg,
                turn_rate_deg_s=readings.rate_deg_s)
    log_ns = start_ns + np.rint((readings.t_s + latency_s) * 1e9).astype(np.int64)
    return Rows(topic, data, log_ns, None, first + np.arange(len(readings)))


def _status_rows(role: str, statuses: Sequence[AhrsStatus], latency_s: float, start_ns: int,
                 first: int) -> Iterator[Rows]:
    """Yield statuses as messages, each stamped with its instant."""
    for number, status in enumerate(statuses, first):
        condition = describe_condition(status)
        ns = start_ns + round(status.t_s * 1e9)
        message = encode_statuses(ns, [Status(f'sensor_simulator: {role}', LEVELS[condition.level],
                                              condition.words, condition.figures)])
        yield Rows(DIAGNOSTICS, np.frombuffer(message, np.uint8).reshape(1, -1),
                   [ns + round(latency_s * 1e9)], None, number)
