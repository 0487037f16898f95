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

"""The command ``import-nmea``: the logs of two or more sensors into one bag."""

from __future__ import annotations

import argparse
from dataclasses import replace
from functools import partial
import time
from typing import Callable, Mapping, NamedTuple, Sequence, TypeVar

import numpy as np

from heading_intercompare.app.config import load_config, settings_for
from heading_intercompare.app.logs.log_motion import find_motion, FoundMotion
from heading_intercompare.app.logs.trial_logs import import_sensor, name_logs, plan_logs, ROLES
from heading_intercompare.bags.mcap.chunk_writer import Rows
from heading_intercompare.bags.recording.bag_writer import BagWriter
from heading_intercompare.bags.rosbag2.motion_topics import motion_topics
from heading_intercompare.bags.rosbag2.provenance import describe_origin, Notes, RECORD
from heading_intercompare.cli.terminal.console import say_lines
from heading_intercompare.cli.terminal.progress import Progress
from heading_intercompare.core.records import Headings, Integers, Motion
from heading_intercompare.core.sensor_table import read_sensors, Sensor
from heading_intercompare.core.sensors.compared_sensors import list_sensors
from heading_intercompare.core.settings import Settings
from heading_intercompare.drivers.settings import DriverSettings
from heading_intercompare.messages.heading_messages import encode_imu, IMU
from heading_intercompare.messages.motion.motion_messages import encode_motion, MOTION_TYPES
from heading_intercompare.messages.stamps import fits_message

from .analyze import (
    add_antenna_arguments,
    add_log_arguments,
    add_motion_argument,
    add_settings_arguments,
    drivers_for,
)
from .note import add_note_argument, read_notes

_PIECE = 20_000
_Rows = TypeVar('_Rows', Headings, Motion)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    parser.add_argument('logs', nargs='*', metavar='NAME=LOG',
                        help='log of each sensor of the setting sensors, instead of --ts and --rs')
    for role, words in (('ts', 'tested'), ('rs', 'reference')):
        parser.add_argument(f'--{role}', metavar='FILE',
                            help=f'log of the {words} sensor: a file, a folder, or a pattern in '
                            'quotes')
    add_log_arguments(parser)
    add_motion_argument(parser)
    add_antenna_arguments(parser)
    parser.add_argument('-o', '--output', metavar='BAG', required=True,
                        help='the rosbag2 directory to write')
    add_note_argument(parser)
    add_settings_arguments(parser)


def run(arguments: argparse.Namespace) -> int:
    """Read the logs, write the bag, print the counts of headings and of rejected lines."""
    settings = settings_for(load_config(arguments.config), arguments.set,
                            **{'antennas.baseline_m': arguments.baseline_m,
                               'antennas.baseline_angle_deg': arguments.baseline_angle})
    notes = read_notes(arguments)
    paths, sensors, drivers = _choose(arguments, settings)
    logs = {}
    for name, path in paths.items():
        with Progress(path, arguments.quiet) as progress:
            logs[name] = import_sensor(sensors[name], path, drivers[name], settings,
                                       (arguments.rs_antennas or (None, None))[1], progress.show)
    origins = {name: log.origin for name, log in logs.items()}
    read = {name: _that_fit(log.headings) for name, log in logs.items()}
    for name, log in logs.items():
        if len(log.headings) and not len(read[name]):
            raise ValueError(f'{log.path}: a bag holds no stamp before 1970 or from 19 January '
                             '2038 on; analyze reads the log itself')
    moved = FoundMotion()
    if settings.motion.compare or arguments.motion:
        moved = find_motion(paths, drivers, arguments.motion)
    if moved.origin:
        origins['motion'] = dict(moved.origin)
    streams = [_of_headings(sensors[name].heading_topic, headings, f'{name}_heading')
               for name, headings in read.items()]
    streams += _of_motion(_that_fit(moved.rows), motion_topics(settings.motion))
    _write(arguments.output, streams, describe_origin(settings.to_mapping(), origins), notes)
    for name, log in logs.items():
        beyond = len(log.headings) - len(read[name])
        say_lines([f'{name if arguments.logs else name.upper()} {log.path}: {len(read[name])} '
                   f'headings on {"; ".join((sensors[name].heading_topic, *log.remarks))}; '
                   f'not taken: {log.words_not_taken}'
                   + f'; {beyond} with a stamp that a bag cannot hold' * (beyond > 0)])
    say_lines([*moved.notes, f'bag: {arguments.output}'])
    return 0


def _choose(arguments: argparse.Namespace, settings: Settings,
            ) -> tuple[dict[str, str], dict[str, Sensor], dict[str, DriverSettings]]:
    """Return the path of each log, its sensor, and how to read it, by the sensor's name."""
    drivers = drivers_for(arguments)
    antennas = arguments.rs_antennas
    if antennas and (log := next(iter(arguments.logs), arguments.rs)):
        raise ValueError(f'--rs-antennas {" ".join(antennas)}: {log} is another log of the RS '
                         'or of several sensors; give --ts FILE and the two antennas alone')
    if not arguments.logs:
        logs = {'ts': arguments.ts, 'rs': antennas[0] if antennas else arguments.rs}
        for role, path in logs.items():
            if path is None:
                raise ValueError(f'--{role}: is missing; give --ts FILE and --rs FILE, or '
                                 'NAME=LOG for each sensor of the setting sensors')
        return _plan(logs, replace(settings, sensors=None), drivers)
    if named := next((role for role in ROLES if getattr(arguments, role) is not None), None):
        raise ValueError(f'--{named} {getattr(arguments, named)}: goes without NAME=LOG; give '
                         'one or the other')
    paths = name_logs(arguments.logs, settings)
    if paths is None:
        names = ', '.join(sensor.name for sensor in read_sensors(settings.sensors))
        raise ValueError(f'{arguments.logs[0]}: must be NAME=LOG with a sensor of the setting '
                         f'sensors: {names or "there are none"}')
    return _plan(paths, settings, drivers)


def _plan(logs: Mapping[str, str], settings: Settings, drivers: Mapping[str, DriverSettings],
          ) -> tuple[dict[str, str], dict[str, Sensor], dict[str, DriverSettings]]:
    paths, drivers_of = plan_logs(logs, settings, drivers)
    return paths, {sensor.name: sensor for sensor in list_sensors(settings)}, drivers_of


class _Stream(NamedTuple):
    """The messages of a topic: their type, stamps, log times, and bytes of a part of them."""

    topic: str
    type_name: str
    stamp_ns: Integers
    log_ns: Integers
    encode: Callable[[int, int], np.ndarray]


def _log_times(stamp_ns: Integers) -> Integers:
    """Return log times: the largest stamp so far keeps a stream in order if stamps step back."""
    return np.maximum.accumulate(stamp_ns)


def _that_fit(rows: _Rows) -> _Rows:
    """Return the rows whose stamps a message of ROS can hold."""
    return rows[fits_message(rows.stamp_ns)]


def _of_headings(topic: str, headings: Headings, frame_id: str) -> _Stream:
    return _Stream(topic, IMU, headings.stamp_ns, _log_times(headings.stamp_ns),
                   lambda lo, hi: encode_imu(headings[lo:hi], frame_id))


def _of_motion(motion: Motion, topics: dict[str, str]) -> list[_Stream]:
    """Return the streams of the motion of the ship; none of what no log tells."""
    return [_Stream(topics[what], MOTION_TYPES[what][0], rows.stamp_ns, _log_times(rows.stamp_ns),
                    partial(_encode_part, rows, what))
            for what, rows in motion.split().items() if len(rows)]


def _encode_part(rows: Motion, what: str, lo: int, hi: int) -> np.ndarray:
    return encode_motion(rows[lo:hi], what, 'ship')


def _write(path: str, streams: Sequence[_Stream], record: dict[str, object], notes: str) -> None:
    """Write the streams merged by stamp, each in the order of its log."""
    edges = _edges([stream.log_ns for stream in streams if len(stream.log_ns)])
    with BagWriter(path) as bag:
        for stream in streams:
            bag.add_topic(stream.topic, stream.type_name)
        bag.metadata(RECORD, record)
        Notes(bag.metadata).add(notes, time.time_ns())
        for begin, end in zip(edges[:-1], edges[1:]):
            batches = []
            for stream in streams:
                lo, hi = np.searchsorted(stream.log_ns, [begin, end])
                batches.append(Rows(stream.topic, stream.encode(lo, hi), stream.log_ns[lo:hi],
                                    stream.stamp_ns[lo:hi], np.arange(lo, hi)))
            bag.write_rows(batches)


def _edges(logs: list[Integers]) -> list[int]:
    """Return the bounds of the pieces that are merged one at a time, to bound the memory."""
    joined = np.sort(np.concatenate(logs))
    return [*np.unique(joined[::_PIECE]).tolist(), int(joined[-1]) + 1]
