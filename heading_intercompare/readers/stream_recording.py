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

"""A file with the headings of one or several sensors, read whole, and used like a bag."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
import os
from pathlib import Path
from typing import Callable, Iterator, Mapping

import numpy as np

from heading_intercompare.bags.rosbag2.bag_reader import BagMessage, Payloads, TopicInfo
from heading_intercompare.bags.rosbag2.topic_names import find_topic
from heading_intercompare.core.angles import wrap360
from heading_intercompare.core.motion.moved_rows import MovedRow
from heading_intercompare.core.records import ColumnBuffer, Headings, Losses, Motion, Quality
from heading_intercompare.core.units.angle_units import AngleWatch, read_angles
from heading_intercompare.drivers.settings import DEFAULT_DRIVER, DriverSettings


class ReaderError(ValueError):
    """A file of another program cannot be used; the message begins with its path."""

    def __init__(self, path: str | os.PathLike[str], problem: str) -> None:
        super().__init__(f'{os.fspath(path)}: {" ".join(problem.split())}')


def tell_no_unit(stream: str) -> str:
    """Tell that no unit is stated for a stream."""
    return 'auto'


@dataclass(frozen=True, slots=True)
class StreamOptions:
    """
    What a person states of a file of streams.

    Attributes
    ----------
    stamps
        Column, form, zone and date of the times in a table.
    names
        Streams that are wanted: a column so named holds headings, whatever its name.
    unit_of
        Returns the unit that is stated for the angles of a stream, 'auto' if none.
    progress
        Called with the progress in words.

    """

    stamps: DriverSettings = DEFAULT_DRIVER
    names: tuple[str, ...] = ()
    unit_of: Callable[[str], str] = tell_no_unit
    progress: Callable[[str], None] = lambda text: None

    def is_wanted(self, column: str) -> bool:
        """Tell whether a column is one of those named, with or without a leading slash."""
        return any(column in (name, name.lstrip('/')) for name in self.names)


UNSTATED = StreamOptions()
"""A file tells everything itself."""


@dataclass(slots=True)
class Collected:
    """
    The readings of a file by stream, as a reader collects them.

    Attributes
    ----------
    kinds
        What each stream is, in words, by its name.
    not_taken
        What gave no heading, by reason.
    other_columns
        Columns of a table that are not read.
    oddities
        What a reader of the verdict should know of how the file was read, in words.

    """

    kinds: dict[str, str] = field(default_factory=dict)
    not_taken: Counter[str] = field(default_factory=Counter)
    other_columns: list[str] = field(default_factory=list)
    oddities: list[str] = field(default_factory=list)
    _columns: dict[str, ColumnBuffer] = field(default_factory=dict)
    _chunks: dict[str, list[Headings]] = field(default_factory=dict)
    _units: dict[str, str | None] = field(default_factory=dict)
    _angles: dict[str, list[Headings]] = field(default_factory=dict)
    _angle_rows: dict[str, ColumnBuffer] = field(default_factory=dict)
    _moved: dict[tuple[int, str, str], ColumnBuffer] = field(default_factory=dict)
    _moved_chunks: dict[tuple[str, str], list[Motion]] = field(default_factory=dict)

    def add(self, stream: str, kind: str, stamp_ns: int, heading_deg: float) -> None:
        """Take a reading: nanoseconds UTC and degrees, in any turn."""
        columns = self._columns.get(stream)
        if columns is None:
            self.kinds.setdefault(stream, kind)
            columns = self._columns[stream] = ColumnBuffer()
        columns.add(stamp_ns, heading_deg)

    def add_chunk(self, stream: str, kind: str, headings: Headings) -> None:
        """Take many readings of a stream."""
        self.kinds.setdefault(stream, kind)
        self._chunks.setdefault(stream, []).append(headings)

    def add_angle(self, stream: str, kind: str, stamp_ns: int, angle: float,
                  unit: str | None) -> None:
        """Take an angle as it is in a file; the unit is None if the file does not tell it."""
        columns = self._angle_rows.get(stream)
        if columns is None:
            self.kinds.setdefault(stream, kind)
            self._units.setdefault(stream, unit)
            columns = self._angle_rows[stream] = ColumnBuffer()
        columns.add(stamp_ns, angle)

    def add_angles(self, stream: str, kind: str, angles: Headings, unit: str | None) -> None:
        """Take many angles of a stream."""
        self.kinds.setdefault(stream, kind)
        self._units.setdefault(stream, unit)
        chunks = self._angles.setdefault(stream, [])
        if rows := self._angle_rows.get(stream):
            chunks.append(Headings(*rows.drain()))
        chunks.append(angles)

    def add_motion(self, row: MovedRow | None, stream: str, stamp_ns: int, *, rank: int = 0,
                   why_none: str = '') -> None:
        """
        Take what a stream tells of the motion of the ship.

        Parameters
        ----------
        row
            What it tells; None if no ship moves so.
        stream
            Name of the stream.
        stamp_ns
            Nanoseconds UTC.
        rank
            Of the streams that tell one thing, those of the lowest rank are preferred.
        why_none
            The reason under which None is counted.

        """
        if row is None:
            self.not_taken[why_none] += 1
            return
        key = rank, row.what, stream
        rows = self._moved.get(key)
        if rows is None:
            rows = self._moved[key] = ColumnBuffer(len(row.values))
        rows.add(stamp_ns, *row.values)

    def add_motion_chunk(self, what: str, stream: str, rows: Motion, wrong: int) -> None:
        """Take many rows that tell one thing, and the number of values out of range."""
        if len(rows):
            self._moved_chunks.setdefault((what, stream), []).append(rows)
        if wrong:
            self.not_taken[f'{stream}.out_of_range'] += wrong

    def add_all(self, later: Collected) -> None:
        """Take what a later file of the same streams holds."""
        for stream, headings in later._heading_streams().items():
            self.add_chunk(stream, later.kinds[stream], headings)
        for stream, angles, unit in later._unread():
            self.add_angles(stream, later.kinds[stream], angles, unit)
        for what, streams in later.motion().items():
            for stream, rows in streams.items():
                self.add_motion_chunk(what, stream, rows, 0)
        self.not_taken += later.not_taken
        self.other_columns = self.other_columns or later.other_columns
        self.oddities += later.oddities

    @property
    def start_ns(self) -> int:
        """Return the least stamp of the headings; 0 if there are none."""
        streams = [*self._heading_streams().values(),
                   *(angles for _, angles, _ in self._unread())]
        return min((int(headings.stamp_ns.min()) for headings in streams if len(headings)),
                   default=0)

    def motion(self) -> dict[str, dict[str, Motion]]:
        """Return the motion by what it tells, then by stream: the preferred one first."""
        motion: dict[str, dict[str, Motion]] = {}
        for (_, what, stream), columns in sorted(self._moved.items(),
                                                 key=lambda entry: entry[0][0]):
            motion.setdefault(what, {})[stream] = Motion.of(what, *columns.columns())
        for (what, stream), chunks in self._moved_chunks.items():
            motion.setdefault(what, {})[stream] = Motion.concatenate(chunks)
        return motion

    def streams(self) -> dict[str, Headings]:
        """Return the headings by stream, in the order of the file; units as `settle_units`."""
        self.settle_units()
        return self._heading_streams()

    def settle_units(self, unit_of: Callable[[str], str] = tell_no_unit,
                     ) -> dict[str, str]:
        """
        Make headings of the angles, stream by stream, once all of them are there.

        Parameters
        ----------
        unit_of
            Returns the unit that is stated for a stream, 'auto' if none. Then that of the file
            counts, and without one degrees.

        Returns
        -------
        dict of str to str
            Of streams whose unit nobody tells and that do not look like degrees: why not.

        """
        unsure = {}
        for name, angles, named in self._unread():
            # Ten million rows are half a gigabyte: what is read is let go.
            self._angles.pop(name, None)
            self._angle_rows.pop(name, None)
            stated = unit_of(name)
            unit = named or 'deg' if stated == 'auto' else stated
            if stated == 'auto' and unit == 'deg':
                watch = AngleWatch()
                watch.update(angles.stamp_ns, angles.heading_deg)
                unsure[name] = watch.words
            heading_deg, wrong = read_angles(angles.heading_deg, unit)
            missing = np.isnan(angles.heading_deg)
            for reason, lacking in (('empty_heading', missing), ('out_of_range', wrong)):
                if n := int(np.count_nonzero(lacking)):
                    self.not_taken[reason] += n
            headings = Headings(angles.stamp_ns, heading_deg)
            is_heading = ~missing & ~wrong
            self.add_chunk(name, self.kinds[name],
                           headings if is_heading.all() else headings[is_heading])
        self._units.clear()
        return unsure

    def _heading_streams(self) -> dict[str, Headings]:
        headings = {}
        for name, buffer in self._columns.items():
            stamps, headings_deg = buffer.columns()
            headings[name] = Headings(stamps, wrap360(headings_deg))
        return headings | {name: Headings.concatenate(chunks)
                           for name, chunks in self._chunks.items()}

    def _unread(self) -> Iterator[tuple[str, Headings, str | None]]:
        """Yield the streams of angles, and the unit that the file tells of each."""
        for name, unit in self._units.items():
            angles = Headings(*self._angle_rows.get(name, ColumnBuffer()).columns())
            yield name, Headings.concatenate([*self._angles.get(name, []), angles]), unit


class StreamRecording:
    """
    The headings of a file by stream; offers what `BagReader` offers.

    Parameters
    ----------
    path
        The file.
    kind
        What it is, in words.
    read
        Reads the file at a path.
    unit_of
        Returns the unit that is stated for the angles of a stream, 'auto' if none.

    Attributes
    ----------
    streams : dict of str to Headings
        All readings, by stream, in the order of the file.
    not_taken
        What gave no heading, by reason; of the motion of the ship after its kind.
    other_columns : list of str
        Columns of a table that are not read.
    motion : dict of str to (dict of str to Motion)
        What the file tells of the motion of the ship, 'fix', 'velocity', 'rate'; then by stream.
    topics, incomplete, oddities, recovered, start_ns, end_ns
        As of `BagReader`; times are those of the stamps.

    Raises
    ------
    OSError
        If the file cannot be read.
    ReaderError
        If it is damaged.

    """

    incomplete: str | None = None
    recovered: str | None = None
    namespace = ''

    def __init__(self, path: str | os.PathLike[str], kind: str,
                 read: Callable[[str], Collected],
                 unit_of: Callable[[str], str] = tell_no_unit) -> None:
        self.path, self.kind = Path(path), kind
        collected = read(os.fspath(path))
        self.oddities = collected.oddities
        self.other_columns = collected.other_columns
        self._unsure = collected.settle_units(unit_of)
        self.streams, self.motion = collected.streams(), collected.motion()
        self.not_taken: Mapping[str, int] = dict(sorted(collected.not_taken.items()))
        self.topics = {name: TopicInfo(collected.kinds[name], len(headings))
                       for name, headings in self.streams.items()}
        stamps = [headings.stamp_ns for headings in self.streams.values() if len(headings)]
        self.start_ns = min((int(stamp_ns.min()) for stamp_ns in stamps), default=None)
        self.end_ns = max((int(stamp_ns.max()) for stamp_ns in stamps), default=None)

    @property
    def words_present(self) -> str:
        """Return the streams with their counts, and what was not taken."""
        streams = ', '.join(f'{name} ({info.type_name}, {info.count})'
                            for name, info in sorted(self.topics.items())) or 'no heading'
        lacking = ', '.join(f'{n} {why}' for why, n in self.not_taken.items())
        return f'{streams}; not taken: {lacking}' if lacking else streams

    def find(self, topic: str) -> str | None:
        """Return the name of a stream given with or without a leading slash; None without it."""
        return find_topic(self.topics, topic)

    def resolve(self, topic: str) -> str:
        """Return the name of a stream given with or without a leading slash."""
        if (name := self.find(topic)) is not None:
            if why := self._unsure.get(name):
                raise ReaderError(self.path, f'{name}: {why}; state the unit (ts_unit, rs_unit: '
                                  'rad, rev or deg), or in the name of the column: hdg_rad')
            return name
        others = ', '.join(self.other_columns)[:200]
        raise ReaderError(self.path, f'has no stream {topic!r}; it has {self.words_present}; '
                          + (f'other columns: {others}; ' if others else '')
                          + 'choose with --ts and --rs')

    def choose_motion(self) -> dict[str, tuple[str, Motion]]:
        """Return, by what it tells, the preferred stream that was heard first, and its rows."""
        return {what: next(iter(streams.items())) for what, streams in self.motion.items()}

    def only(self, name: str | None = None) -> str:
        """Return a stream, or the only one if no name is given; ReaderError if there are more."""
        if name is not None:
            return self.resolve(name)
        if len(self.topics) == 1:
            return self.resolve(next(iter(self.topics)))
        raise ReaderError(self.path, f'has {len(self.topics)} streams: {self.words_present}; '
                          'choose one with --ts-talker or --rs-talker')

    def headings(self, conventions: Mapping[str, str], helpers: int = 0,
                 lost: Callable[[str, str, Losses], None] | None = None,
                 claimed: Mapping[str, Callable[[Quality], None]] | None = None,
                 ) -> Iterator[dict[str, Headings]]:
        """Return an iterator over the headings of some streams; conventions do not matter."""
        chosen = {asked: self.streams[self.resolve(asked)] for asked in conventions}
        return iter([chosen])

    def tells_claims(self, conventions: Mapping[str, str]) -> bool:
        """Tell that claims are not told beside the headings."""
        return False

    def keeps_numbers(self) -> bool:
        """Tell that there are no numbers of publishers."""
        return False

    def messages(self, topics: object = None) -> Iterator[BagMessage]:
        """Return an iterator over no messages."""
        return iter(())

    def payloads(self, topic: str) -> Iterator[Payloads]:
        """Return an iterator over no messages."""
        return iter(())

    def metadata(self) -> dict[str, dict[str, str]]:
        """Return no metadata records."""
        return {}
