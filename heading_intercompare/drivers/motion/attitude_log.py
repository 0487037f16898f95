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

"""Roll and pitch of the ship in a log of NMEA sentences: PSXN,23 and PASHR."""

from __future__ import annotations

from array import array
from collections import Counter
from dataclasses import dataclass, field
import math
import os
from typing import Mapping

import numpy as np

from heading_intercompare.core.records import Attitude
from heading_intercompare.drivers.csv_log import is_csv_file, open_csv
from heading_intercompare.drivers.log_lines.log_order import open_log
from heading_intercompare.drivers.settings import DriverSettings

from .motion_lines import MotionLines

__all__ = ['LoggedAttitude', 'read_log_attitude']

_BLOCK = 1 << 20
#: Beginning of a sentence -> its fields of roll (starboard down) and pitch (bow up), degrees.
_FIELDS = {b'PSXN,23,': (2, 3), b'PASHR,': (4, 5)}
_STEEPEST_DEG = 90.0


@dataclass(frozen=True, slots=True)
class LoggedAttitude:
    """
    Roll and pitch in a log.

    Attributes
    ----------
    rows : Attitude
        In the order of the log; empty if it has none.
    sentence : str
        The sentence that they came from; empty if there are none.
    not_taken : mapping of str to int
        Sentences that gave none, by reason.

    """

    rows: Attitude = field(default_factory=Attitude.empty)
    sentence: str = ''
    not_taken: Mapping[str, int] = field(default_factory=dict)


def read_log_attitude(path: str | os.PathLike[str],
                      settings: DriverSettings | None = None) -> LoggedAttitude:
    """
    Read roll and pitch from a log.

    Parameters
    ----------
    path : path
        A log of NMEA sentences: a file, a folder of files, or a pattern of names.
    settings : DriverSettings, optional
        How its lines are stamped.

    Raises
    ------
    OSError
        If the log cannot be read.
    DriverError
        If compressed data are damaged, or no file matches.

    Notes
    -----
    PSXN,23 is read if there is any, otherwise PASHR with a time of its own: both have roll with
    starboard down and pitch with bow up. The form PASHR,ATT is not read.

    """
    rule = settings or DriverSettings()
    files = open_csv(os.fspath(path), rule) or open_log(os.fspath(path), rule)
    if is_csv_file(files.paths[0]):
        return LoggedAttitude()
    for token, places in _FIELDS.items():
        attitude = _read(path, rule, token, places)
        if len(attitude.rows):
            return attitude
    return LoggedAttitude()


def _read(path: str | os.PathLike[str], rule: DriverSettings, token: bytes,
          places: tuple[int, int]) -> LoggedAttitude:
    files, counts = open_log(os.fspath(path), rule), Counter[str]()
    lines = MotionLines(rule, counts, files)
    stamps, roll, pitch = array('q'), array('d'), array('d')

    def take(block: bytes) -> None:
        for stamp_ns, text in lines.feed_texts(block, token):
            angles = _parse(text.split(b','), places)
            if angles is None:
                counts['bad_field'] += 1
                continue
            stamps.append(stamp_ns)
            roll.append(angles[0])
            pitch.append(angles[1])
    for begins, block in files.blocks(_BLOCK):
        if begins is not None:
            lines.begin_file(begins)
        take(block)
    take(b'')
    return LoggedAttitude(Attitude.of(np.array(stamps, np.int64), roll, pitch),
                          token.decode().rstrip(','), dict(sorted(counts.items())))


def _parse(fields: list[bytes], places: tuple[int, int]) -> tuple[float, float] | None:
    """Return roll and pitch; None if there are no such numbers."""
    try:
        roll_deg, pitch_deg = (float(fields[place]) for place in places)
    except (IndexError, ValueError):
        return None
    steepest = max(abs(roll_deg), abs(pitch_deg))
    return (roll_deg, pitch_deg) if math.isfinite(roll_deg + pitch_deg) and (
        steepest <= _STEEPEST_DEG) else None
