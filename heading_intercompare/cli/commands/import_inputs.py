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

"""The command ``import``: a recording, or the logs of two or more sensors, into one bag."""

from __future__ import annotations

import argparse
from collections import deque
from dataclasses import dataclass, field, replace
from functools import partial
import re
import time
from typing import Any, Callable, Iterator, Mapping, NamedTuple, Sequence, TypeVar

import numpy as np

from heading_intercompare.app.config import choose_pair, load_config, settings_for
from heading_intercompare.app.logs.log_motion import find_motion, FoundMotion
from heading_intercompare.app.logs.trial_logs import import_sensor, plan_logs, ROLES
from heading_intercompare.app.recording_import import import_recording
from heading_intercompare.bags.mcap.chunk_writer import Rows
from heading_intercompare.bags.recording.bag_writer import BagWriter
from heading_intercompare.bags.rosbag2.motion_topics import motion_topics
from heading_intercompare.bags.rosbag2.provenance import describe_origin, Note, Notes, RECORD
from heading_intercompare.cli.terminal.console import say_lines
from heading_intercompare.cli.terminal.progress import Progress
from heading_intercompare.core.angles import wrap360
from heading_intercompare.core.pairing.stream_pieces import find_edges, follow_stamps
from heading_intercompare.core.records import Headings, Integers, Losses, Motion, Quality
from heading_intercompare.core.sensor_table import read_sensors, Sensor, write_sensors
from heading_intercompare.core.sensors.compared_sensors import list_sensors
from heading_intercompare.core.settings import Settings
from heading_intercompare.drivers.settings import DriverSettings
from heading_intercompare.messages.heading_messages import encode_imu, IMU
from heading_intercompare.messages.ledger_messages import encode_losses, lost_topic
from heading_intercompare.messages.motion.motion_messages import encode_motion, MOTION_TYPES
from heading_intercompare.messages.quality_messages import encode_quality, quality_topic
from heading_intercompare.messages.stamps import fits_message
from heading_intercompare.messages.status_messages import encode_mark, MARKER_TOPIC, STATUS_TYPE

from .analyze import (
    add_antenna_arguments,
    add_motion_argument,
    add_settings_arguments,
    check_input_options,
    choose_logs,
)
from .log_options import add_log_arguments, add_unit_arguments, drivers_for
from .note import add_note_argument, read_notes

_PIECE = 20_000
_ROWS = 1_000
_TOPIC = re.compile(r'/?[A-Za-z_]\w*(/[A-Za-z_]\w*)*')
_Rows = TypeVar('_Rows', Headings, Losses, Motion, Quality)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    parser.add_argument('inputs', nargs='*', metavar='INPUT',
                        help='as of analyze: a recording with the headings of all sensors, the '
                        'logs of the tested and of the reference sensor in this order, or '
                        'NAME=LOG for each sensor of the setting sensors')
    for role, words in (('ts', 'tested'), ('rs', 'reference')):
        parser.add_argument(f'--{role}', metavar='NAME',
                            help=f'topic, stream or column of the {words} sensor in the '
                            'recording; without INPUT its log: a file, a folder, or a pattern in '
                            'quotes')
    add_unit_arguments(parser)
    add_log_arguments(parser)
    add_motion_argument(parser)
    add_antenna_arguments(parser)
    parser.add_argument('-o', '--output', metavar='BAG', required=True,
                        help='the rosbag2 directory to write')
    add_note_argument(parser)
    add_settings_arguments(parser)


@dataclass(slots=True)
class _Contents:
    """What goes into a bag, and the lines about it: of each sensor, then of the rest."""

    headings: Mapping[str, Headings]
    origins: dict[str, Mapping[str, Any]]
    sensor_lines: Mapping[str, tuple[str, str]]
    motion: Mapping[str, Motion]
    quality: Mapping[str, Quality]
    lines: Sequence[str] = ()
    losses: Sequence[tuple[str, str, Losses]] = ()
    marks: Sequence[tuple[str, int]] = ()
    notes: list[Note] = field(default_factory=list)


def run(arguments: argparse.Namespace) -> int:
    """Read the inputs, write the bag, print the counts of headings and of rejected lines."""
    config = load_config(arguments.config)
    options = {'antennas.baseline_m': arguments.baseline_m,
               'antennas.baseline_angle_deg': arguments.baseline_angle}
    plain = settings_for(config, arguments.set, **options)
    settings = plain
    if arguments.inputs:
        settings = choose_pair(settings_for(config, arguments.set, ts_topic=arguments.ts,
                                            rs_topic=arguments.rs, ts_unit=arguments.ts_unit,
                                            rs_unit=arguments.rs_unit, **options),
                               arguments.ts, arguments.rs)
    note_text = read_notes(arguments)
    drivers = drivers_for(arguments)
    logs = _choose_logs(arguments, settings, drivers)
    if not arguments.inputs:
        settings = replace(settings, sensors=None)
    contents = (_read_recording(arguments, settings, drivers['ts']) if logs is None
                else _read_logs(logs, arguments, settings, drivers))
    settings = _writable(replace(settings, ts_topic=plain.ts_topic, rs_topic=plain.rs_topic))
    sensors = {sensor.name: sensor for sensor in list_sensors(settings)}
    fitting = _leave_out(contents)
    streams = [_of_headings(sensors[name], headings, contents.quality.get(name))
               for name, headings in fitting.items()]
    streams += _of_motion(contents.motion, motion_topics(settings.motion))
    messages = _single_messages(contents, sensors)
    with BagWriter(arguments.output, whole=True) as bag:
        bag.metadata(RECORD, describe_origin(settings.to_mapping(), contents.origins))
        notes = Notes(bag.metadata)
        for note in contents.notes:
            notes.add(note.text, note.stamp_ns)
        notes.add(note_text, time.time_ns())
        _write(bag, streams, messages)
    several = settings.sensors is not None
    for name, (before, after) in contents.sensor_lines.items():
        beyond = len(contents.headings[name]) - len(fitting[name])
        say_lines([f'{name if several else name.upper()} {before}: {len(fitting[name])} '
                   f'headings on {sensors[name].heading_topic}{after}'
                   + f'; {beyond} with a stamp that a bag cannot hold' * (beyond > 0)])
    say_lines([*contents.lines, f'bag: {arguments.output}'])
    return 0


def _choose_logs(arguments: argparse.Namespace, settings: Settings,
                 drivers: Mapping[str, DriverSettings]) -> dict[str, str] | None:
    """Return the log of each sensor by its name; None for a recording."""
    if arguments.inputs:
        logs = choose_logs(arguments, settings, drivers)
        check_input_options(arguments, settings, logs is not None, drivers['ts'])
        return logs
    antennas = arguments.rs_antennas
    if antennas and arguments.rs:
        raise ValueError(f'--rs-antennas {" ".join(antennas)}: {arguments.rs} is another log of '
                         'the RS; give --ts FILE and the two antennas alone')
    paths = {'ts': arguments.ts, 'rs': antennas[0] if antennas else arguments.rs}
    for role in ROLES:
        if paths[role] is None:
            raise ValueError(f'--{role}: is missing; give the INPUTs of analyze, or --ts FILE '
                             'and --rs FILE')
    return paths


def _read_logs(logs: Mapping[str, str], arguments: argparse.Namespace, settings: Settings,
               drivers: Mapping[str, DriverSettings]) -> _Contents:
    """Return what the logs of the sensors hold."""
    paths, drivers = plan_logs(logs, settings, drivers)
    sensors = {sensor.name: sensor for sensor in list_sensors(settings)}
    moved = FoundMotion()
    aft = (arguments.rs_antennas or (None, None))[1]
    with Progress(f'{len(paths)} logs', arguments.quiet) as progress:
        imported = {name: import_sensor(sensors[name], path, drivers[name], settings, aft,
                                        progress.show) for name, path in paths.items()}
        if settings.motion.compare or arguments.motion:
            moved = find_motion(paths, drivers, arguments.motion, progress.show)
    return _Contents(
        {name: log.headings for name, log in imported.items()},
        {**{name: log.origin for name, log in imported.items()},
         **({'motion': dict(moved.origin)} if moved.origin else {})},
        {name: (log.path, ''.join(f'; {remark}' for remark in log.remarks)
                + f'; not taken: {log.words_not_taken}') for name, log in imported.items()},
        moved.things, {name: log.quality for name, log in imported.items()
                       if log.quality is not None}, moved.notes)


def _read_recording(arguments: argparse.Namespace, settings: Settings,
                    driver: DriverSettings) -> _Contents:
    """Return what a recording of all sensors holds."""
    path, *more = arguments.inputs
    if more:
        raise ValueError(f'{more[0]}: is a second recording, and a bag is made of one; import '
                         'each by itself')
    with Progress(path, arguments.quiet) as progress:
        recording = import_recording(path, settings, driver, progress.show)
    return _Contents(
        recording.headings, {'recording': recording.origin},
        {sensor.name: (f'{sensor.heading_topic} of {path}', '')
         for sensor in list_sensors(settings)},
        recording.motion.split(), recording.quality,
        [f'note: {problem}' for problem in recording.problems],
        recording.losses, recording.marks, list(recording.notes))


def _writable(settings: Settings) -> Settings:
    """Return the settings that hold for the bag: with names of topics, and without antennas."""
    default = Settings()
    sensors = [sensor if _TOPIC.fullmatch(sensor.heading_topic) else replace(sensor, topic='')
               for sensor in read_sensors(settings.sensors)]
    return replace(
        settings, **{name: getattr(settings, name) if _TOPIC.fullmatch(getattr(settings, name))
                     else getattr(default, name) for name in ('ts_topic', 'rs_topic')},
        sensors=settings.sensors if tuple(sensors) == read_sensors(settings.sensors)
        else write_sensors(sensors),
        antennas=replace(settings.antennas, fore_topic=None, aft_topic=None))


def _leave_out(contents: _Contents) -> dict[str, Headings]:
    """Return the headings that a bag can hold; ValueError if it can hold none of a sensor."""
    fitting = {name: _that_fit(headings) for name, headings in contents.headings.items()}
    for name, headings in fitting.items():
        before, _ = contents.sensor_lines[name]
        if not len(contents.headings[name]):
            raise ValueError(f'{before}: has no heading')
        if not len(headings):
            raise ValueError(f'{before}: a bag holds no stamp before 1970 or from 19 January '
                             '2038 on; analyze reads the log itself')
    return fitting


class _Stream(NamedTuple):
    """The messages of a topic: their type, stamps, log times, and bytes of a part of them."""

    topic: str
    type_name: str
    stamp_ns: Integers
    log_ns: Integers
    encode: Callable[[int, int], np.ndarray]


class _Message(NamedTuple):
    """A message beside the streams: its time, its topic, and its bytes."""

    log_ns: int
    topic: str
    data: bytes


def _that_fit(rows: _Rows) -> _Rows:
    """Return the rows whose stamps a message of ROS can hold."""
    fits = fits_message(rows.stamp_ns)
    return rows if fits.all() else rows[fits]


def _of_headings(sensor: Sensor, headings: Headings, quality: Quality | None) -> _Stream:
    """Return the stream of a sensor; the settings read its axes back as they are written."""
    sigma_deg = np.zeros(len(headings))
    if quality is not None:
        _, stated_deg = quality.match(headings.stamp_ns)
        sigma_deg = np.nan_to_num(stated_deg)
    if sensor.convention == 'ned':
        # The messages have the yaw of ENU, 90 - heading; that of NED is the heading.
        headings = Headings(headings.stamp_ns, wrap360(90.0 - headings.heading_deg))
    return _Stream(sensor.heading_topic, IMU, headings.stamp_ns, follow_stamps(headings.stamp_ns),
                   lambda lo, hi: encode_imu(headings[lo:hi], f'{sensor.name}_heading',
                                             sigma_deg=sigma_deg[lo:hi]))


def _of_motion(motion: Mapping[str, Motion], topics: dict[str, str]) -> list[_Stream]:
    """Return the streams of the motion of the ship; none of what no log tells."""
    fitting = {what: _that_fit(motion[what]) for what in MOTION_TYPES if what in motion}
    return [_Stream(topics[what], MOTION_TYPES[what][0], rows.stamp_ns,
                    follow_stamps(rows.stamp_ns), partial(_encode_part, rows, what))
            for what, rows in fitting.items() if len(rows)]


def _encode_part(rows: Motion, what: str, lo: int, hi: int) -> np.ndarray:
    return encode_motion(rows[lo:hi], what, 'ship')


def _single_messages(contents: _Contents, sensors: Mapping[str, Sensor]) -> list[_Message]:
    """Return marks, losses and quality that a bag can hold, in the order of their times."""
    messages = [_Message(stamp_ns, MARKER_TOPIC, encode_mark(kind, stamp_ns))
                for kind, stamp_ns in contents.marks if fits_message(np.array([stamp_ns]))[0]]
    for name, lost_as, all_losses in contents.losses:
        topic = lost_topic(sensors[name].heading_topic)
        messages += [_Message(int(rows.stamp_ns.max()), topic, encode_losses({lost_as: rows}))
                     for rows in _cut(_that_fit(all_losses))]
    for name, quality in contents.quality.items():
        topic = quality_topic(sensors[name].heading_topic)
        before_ns = None
        for rows in _cut(_that_fit(quality)):
            # A replay tells it before the readings that it holds for: those after the last row.
            messages.append(_Message(int(rows.stamp_ns[0]) if before_ns is None else before_ns,
                                     topic, encode_quality(rows)))
            before_ns = int(rows.stamp_ns[-1])
    return sorted(messages, key=lambda message: message.log_ns)


def _cut(rows: _Rows) -> Iterator[_Rows]:
    """Yield the rows in pieces, one for each message."""
    for at in range(0, len(rows), _ROWS):
        yield rows[at:at + _ROWS]


def _write(bag: BagWriter, streams: Sequence[_Stream], messages: Sequence[_Message]) -> None:
    """
    Write the streams merged by stamp, each in the order of its log, and single messages.

    A single message stands before the readings of its time, for a replay keeps this order.
    """
    edges = find_edges([stream.log_ns for stream in streams], _PIECE)
    edges = sorted({*edges, *(message.log_ns for message in messages
                              if edges[0] < message.log_ns < edges[-1])})
    for stream in streams:
        bag.add_topic(stream.topic, stream.type_name)
    for topic in dict.fromkeys(message.topic for message in messages):
        bag.add_topic(topic, STATUS_TYPE)
    waiting = deque(enumerate(messages))
    for begin, end in zip(edges[:-1], edges[1:]):
        while waiting and waiting[0][1].log_ns <= begin:
            _write_single(bag, *waiting.popleft())
        batches = []
        for stream in streams:
            lo, hi = np.searchsorted(stream.log_ns, [begin, end])
            batches.append(Rows(stream.topic, stream.encode(lo, hi), stream.log_ns[lo:hi],
                                stream.stamp_ns[lo:hi], np.arange(lo, hi)))
        bag.write_rows(batches)
    for number, message in waiting:
        _write_single(bag, number, message)


def _write_single(bag: BagWriter, number: int, message: _Message) -> None:
    bag.write(message.topic, message.data, message.log_ns, sequence=number)
