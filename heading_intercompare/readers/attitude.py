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

"""Roll and pitch of the ship in a recording: a bag, a csv, or a log of NMEA sentences."""

from __future__ import annotations

from functools import partial
import math
import os

import numpy as np

from heading_intercompare.bags.csv.csv_rows import CsvRows
from heading_intercompare.bags.errors import BagError
from heading_intercompare.bags.rosbag2.readable import read_rows, Readable
from heading_intercompare.bags.rosbag2.topic_names import locate_in
from heading_intercompare.core.records import Attitude, ColumnBuffer
from heading_intercompare.drivers.motion.motion_log import read_log_attitude
from heading_intercompare.drivers.sentences import Rejected
from heading_intercompare.drivers.settings import DEFAULT_DRIVER, DriverSettings
from heading_intercompare.messages.heading_messages import ORIENTATION_TYPES, read_attitude

from .registry import has_one_sensor
from .stamp_columns import find_time_columns, StampColumns
from .stream_recording import ReaderError

_ROLLS, _PITCHES = ('roll_deg', 'roll'), ('pitch_deg', 'pitch')


def find_attitude(path: str | os.PathLike[str], driver: DriverSettings) -> Attitude:
    """
    Return roll and pitch in a file that is no bag; empty if it has none.

    Parameters
    ----------
    path
        A log of NMEA sentences, or a csv.
    driver
        How the lines of a log are stamped.

    Raises
    ------
    OSError
        If it cannot be read.
    ValueError
        If it is damaged.

    """
    name = os.fspath(path)
    if has_one_sensor(name) and len(rows := read_log_attitude(name, driver)):
        return rows
    is_table = name.endswith('.csv') and os.path.isfile(name)
    return attitude_of_table(name, driver) if is_table else Attitude.empty()


def attitude_of_table(path: str, driver: DriverSettings = DEFAULT_DRIVER) -> Attitude:
    """
    Return roll and pitch in a csv with columns of times, `roll_deg` and `pitch_deg`.

    Roll is positive with starboard down, pitch with bow up. Rows without them are left out.
    """
    angles = ColumnBuffer(2)
    try:
        with CsvRows(path, 'of times') as rows:
            by_name = {name.lower(): place for place, name in enumerate(rows.names)}
            places = [next((by_name[name] for name in names if name in by_name), None)
                      for names in (_ROLLS, _PITCHES)]
            if None in places or not find_time_columns(rows.names, driver.time_column):
                return Attitude.empty()
            stamps = StampColumns(path, rows.names, driver)
            for row in rows:
                try:
                    stamp_ns = stamps.read(rows, row)
                    values = [float(rows.plain(row[place])) for place in places
                              if place is not None]
                except (Rejected, ValueError, IndexError):
                    continue
                if all(map(math.isfinite, values)):
                    angles.add(stamp_ns, *values)
    except BagError as error:
        raise ReaderError(path, error.problem) from error
    return Attitude(*angles.columns())


def attitude_of_bag(bag: Readable, topic: str, convention: str) -> Attitude:
    """
    Return roll and pitch of a topic with orientations; empty if all of them are level.

    Parameters
    ----------
    bag
        The recording.
    topic
        A topic of a heading.
    convention : {'enu', 'ned'}
        World axes of the orientations.

    """
    name = bag.resolve(topic)
    axes = locate_in(name, topic).axes or convention
    kind = bag.topics[name].type_name
    if kind not in ORIENTATION_TYPES:
        return Attitude.empty()
    chunks, _ = read_rows(bag, {name: [partial(read_attitude, kind, axes)]})
    rows = Attitude.concatenate(chunks)
    rows = rows[np.isfinite(rows.roll_deg) & np.isfinite(rows.pitch_deg)]
    # A message of a heading alone has a level orientation.
    return rows if np.any(rows.roll_deg) or np.any(rows.pitch_deg) else Attitude.empty()
