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

"""The recorded voyage that a simulated ship repeats, read from a bag, a log or a csv."""

from __future__ import annotations

from dataclasses import dataclass, replace
import glob
import os
from pathlib import Path
from typing import Mapping

from heading_intercompare.ahrs.settings import TrackSettings
from heading_intercompare.ahrs.ship.track_course import Track
from heading_intercompare.ahrs.track_smoothing import fit_track, TrackRecord
from heading_intercompare.app.logs.log_import import import_log
from heading_intercompare.app.logs.log_motion import find_motion
from heading_intercompare.app.sources.file_hash import hash_files
from heading_intercompare.bags.errors import BagError
from heading_intercompare.bags.rosbag2.motion_topics import read_bag_motion
from heading_intercompare.bags.rosbag2.provenance import TRUTH_TOPIC
from heading_intercompare.bags.rosbag2.topic_names import find_topic
from heading_intercompare.core.declared_settings import SettingsError
from heading_intercompare.core.records import Headings, Motion
from heading_intercompare.core.settings import MotionRule
from heading_intercompare.drivers.settings import DriverError, DriverSettings
from heading_intercompare.messages.heading_messages import HEADING_TYPES
from heading_intercompare.readers.attitude import attitude_of_bag, find_attitude
from heading_intercompare.readers.registry import has_one_sensor, open_recording
from heading_intercompare.readers.stream_recording import StreamRecording
from heading_intercompare.readers.tables import read_table


@dataclass(frozen=True, slots=True)
class Voyage:
    """
    A recorded voyage, ready to be repeated.

    Attributes
    ----------
    track
        Smooth functions of time.
    words
        Where it is from and how it was smoothed, a line each.
    origin
        Files with their hashes, for the bag.

    """

    track: Track
    words: tuple[str, ...]
    origin: Mapping[str, object]


def read_voyage(settings: TrackSettings, folder: Path = Path()) -> Voyage:
    """
    Read the voyage that a scenario names, and make it smooth.

    Parameters
    ----------
    settings
        `file` is not empty.
    folder
        Where relative names begin: the folder of the scenario.

    Raises
    ------
    OSError
        If a file cannot be read.
    ValueError
        If a file is damaged or has no headings, or the settings do not fit it; one line.

    """
    path = os.fspath(folder / settings.file)
    moved = os.fspath(folder / settings.motion_file) if settings.motion_file else ''
    stream, record = _read(path, settings.heading)
    if moved:
        _, motion_record = _read(moved, settings.heading, needs_heading=False)
        record = replace(record, motion=motion_record.motion, attitude=(
            motion_record.attitude if len(motion_record.attitude) else record.attitude))
    try:
        fitted = fit_track(record, settings)
    except SettingsError as error:
        raise SettingsError(f'{path}: {error}') from error
    origin: dict[str, object] = {'file': path, 'heading': stream, 'sha256': _hash(path)}
    if moved:
        origin |= {'motion_file': moved, 'motion_sha256': _hash(moved)}
    return Voyage(fitted.track, (f'track: {stream} of {path}, {fitted.track.duration_s:.1f} s',
                                 *fitted.words), origin)


def _hash(path: str) -> str:
    """Return the hash of a file, or of several files in the order of their names."""
    return hash_files(_files_of(path))


def _files_of(path: str) -> list[str]:
    """Return the files of a file, a folder, or a pattern of names; OSError if there are none."""
    if os.path.isdir(path):
        return sorted(os.fspath(file) for file in Path(path).rglob('*') if file.is_file())
    files = [path] if os.path.exists(path) else sorted(glob.glob(path))
    if not files:
        os.stat(path)
    return files


def _read(path: str, stream: str, needs_heading: bool = True) -> tuple[str, TrackRecord]:
    """Return the stream taken, and what a file tells of a voyage."""
    _files_of(path)
    table = path.endswith('.csv') and os.path.isfile(path)
    if not table and has_one_sensor(path):
        return _read_log(path, stream, needs_heading)
    recording = (StreamRecording(path, 'csv', read_table) if table
                 else open_recording(path))
    if isinstance(recording, StreamRecording):
        motion = Motion.concatenate([rows for _, rows in recording.choose_motion().values()])
        attitude = find_attitude(path, DriverSettings())
        if not needs_heading:
            return '', TrackRecord(Headings.empty(), motion, attitude)
        name = recording.resolve(_choose(path, stream, list(recording.streams)))
        return name, TrackRecord(recording.streams[name], motion, attitude)
    bag_motion = read_bag_motion(recording, MotionRule()).rows
    if not needs_heading:
        return '', TrackRecord(Headings.empty(), bag_motion)
    name = _choose(path, stream, [topic for topic, info in recording.topics.items()
                                  if info.type_name in HEADING_TYPES], recording.namespace)
    headings = Headings.concatenate(
        chunk[name] for chunk in recording.headings({name: 'enu'}))
    return name, TrackRecord(headings, bag_motion, attitude_of_bag(recording, name, 'enu'))


def _read_log(path: str, sentence: str, needs_heading: bool) -> tuple[str, TrackRecord]:
    driver = DriverSettings(sentence=sentence) if sentence and needs_heading else DriverSettings()
    moved = find_motion({'log': path}, {'log': driver})
    attitude = find_attitude(path, driver)
    if not needs_heading:
        return '', TrackRecord(Headings.empty(), moved.rows, attitude)
    log = import_log(path, driver)
    if not len(log.headings):
        raise DriverError(f'{path}: has no heading; not taken: {log.words_not_taken}')
    return log.sentence or 'csv', TrackRecord(log.headings, moved.rows, attitude)


def _choose(path: str, asked: str, present: list[str], namespace: str = '') -> str:
    """Return the stream with the headings that count as true."""
    if not present:
        raise BagError('has no headings', path)
    topic = find_topic(present, asked or TRUTH_TOPIC, namespace) or find_topic(present, asked)
    if topic is None and not asked and len(present) == 1:
        topic = present[0]
    if topic is None:
        problem = f'has no headings {asked!r}' if asked else 'has headings of several sensors'
        raise BagError(f'{problem}; it has {", ".join(present)}; choose with track.heading', path)
    return topic
