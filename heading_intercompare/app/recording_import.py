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

"""The import of a recording of several sensors: what a bag can hold of it, and its origin."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Callable, Mapping, Sequence

from heading_intercompare.bags.errors import BagError
from heading_intercompare.bags.recording.recorded_headings import read_marks
from heading_intercompare.bags.rosbag2.provenance import Note, read_notes
from heading_intercompare.core.pairing.ledger import LedgerKey
from heading_intercompare.core.records import Headings, Losses, Motion, Quality
from heading_intercompare.core.sensor_table import find_reference, Sensor
from heading_intercompare.core.sensors.compared_sensors import list_sensors
from heading_intercompare.core.settings import Settings
from heading_intercompare.drivers.settings import DriverSettings
from heading_intercompare.journal.journal_file import is_journal
from heading_intercompare.readers.registry import (
    find_format,
    find_written,
    has_pairs,
    open_recording,
)

from .inputs import (
    describe_reading,
    options_of,
    read_motion,
    read_quality_of,
    read_sensors_of,
    sha256,
)
from .logs.log_import import describe_reading_options


@dataclass(frozen=True, slots=True)
class ImportedRecording:
    """
    What a recording holds of its sensors.

    Attributes
    ----------
    headings
        All readings by the name of their sensor, in the order of the recording.
    losses
        Readings that never came: the name of the sensor, one of `LOST_AS`, and the gaps.
    motion
        The motion of the ship.
    quality
        What the sensors say of their readings, by name; empty of one that says nothing.
    marks
        Kind and stamp of the marks of runs.
    notes : sequence of Note
        The operator's notes.
    problems
        What is missing, and how it was read, in words.
    origin
        The provenance as a bag keeps it.

    """

    headings: Mapping[str, Headings]
    losses: Sequence[tuple[str, str, Losses]]
    motion: Motion
    quality: Mapping[str, Quality]
    marks: Sequence[tuple[str, int]]
    notes: Sequence[Note]
    problems: Sequence[str]
    origin: Mapping[str, Any]


@dataclass(slots=True)
class _Taker:
    """Takes the readings of a recording in place of a comparison."""

    sensors: tuple[Sensor, ...]
    newest_ns: int | None = None
    chunks: dict[str, list[Headings]] = field(default_factory=dict)
    losses: list[tuple[str, str, Losses]] = field(default_factory=list)
    quality: dict[str, list[Quality]] = field(default_factory=dict)

    @property
    def reference(self) -> Sensor | None:
        return find_reference(self.sensors)

    def update(self, headings: Mapping[str, Headings]) -> None:
        for name, chunk in headings.items():
            self.chunks.setdefault(name, []).append(chunk)
            if len(chunk):
                self.newest_ns = max(int(chunk.stamp_ns.max()), self.newest_ns or 0)

    def lose(self, name: str, key: LedgerKey, losses: Losses) -> None:
        self.losses.append((name, key.value.partition('_')[2], losses))

    def take_quality(self, name: str, quality: Quality) -> None:
        if len(quality):
            self.quality.setdefault(name, []).append(quality)


def import_recording(path: str, settings: Settings, driver: DriverSettings,
                     progress: Callable[[str], None] = lambda text: None) -> ImportedRecording:
    """
    Read all that `analyze` reads of a recording.

    Parameters
    ----------
    path
        A recording that `open_recording` reads.
    settings
        Topics, conventions and units of the sensors.
    driver
        Column and form of the stamps in a table.
    progress
        Called with the progress in words.

    Raises
    ------
    OSError
        If it cannot be read.
    ValueError
        If it is damaged, lacks a sensor, or holds pairs.

    """
    options = options_of(settings, driver, progress)
    written = find_written(path)
    if is_journal(path) or has_pairs(path) or written is not None and written.contents == 'pairs':
        raise BagError('holds pairs, and a bag holds headings: give it to analyze', path)
    reader = open_recording(path, settings.bag_namespace, options)
    sensors = list_sensors(settings)
    taker = _Taker(sensors)
    problems: list[str] = []
    motion = read_motion(reader, settings, problems)
    read_quality_of([reader], settings, taker, problems)
    marks = list(read_marks(reader))
    n = 0
    for headings in read_sensors_of(reader, settings, taker, problems):
        taker.update(headings)
        n += sum(map(len, headings.values()))
        progress(f'{n:,} headings')
    describe_reading(reader, False, problems, problems)
    form = find_format(path, options)
    return ImportedRecording(
        {sensor.name: Headings.concatenate(taker.chunks.get(sensor.name, []))
         for sensor in sensors}, taker.losses, motion,
        {sensor.name: Quality.join(taker.quality.get(sensor.name, [])) for sensor in sensors},
        marks, read_notes(reader), problems,
        {'path': path, 'sha256': sha256(path, options),
         'format': 'rosbag2, MCAP' if form is None else form.name,
         'stamp_format': driver.stamp_format, **describe_reading_options(driver),
         **{f'topic.{sensor.name}': sensor.heading_topic for sensor in sensors}})
