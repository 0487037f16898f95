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

"""The motion of the ship in a log of NMEA sentences, read on its own, beside the headings."""

from __future__ import annotations

from dataclasses import dataclass, field
import os
from typing import Callable, Mapping

from heading_intercompare.core.records import Attitude, Motion, MOTION_COLUMNS
from heading_intercompare.drivers.csv_log import is_csv_file, open_csv
from heading_intercompare.drivers.log_lines.log_files import LogFiles
from heading_intercompare.drivers.log_lines.log_order import open_log
from heading_intercompare.drivers.settings import DriverSettings

from .motion_decoder import may_tell, MotionDecoder
from .motion_sentences import ATTITUDE, Family, MOTION


@dataclass(frozen=True, slots=True)
class LoggedMotion:
    """
    The motion of the ship in a log.

    Attributes
    ----------
    rows
        By what they tell: 'fix', 'velocity', 'rate'. Only what the log has.
    sentences
        The sentence that each came from, such as 'INVTG'.
    not_taken
        Sentences of the motion that gave none, by reason.

    """

    rows: Mapping[str, Motion] = field(default_factory=dict)
    sentences: Mapping[str, str] = field(default_factory=dict)
    not_taken: Mapping[str, int] = field(default_factory=dict)


def read_log_motion(path: str | os.PathLike[str],
                    settings: DriverSettings | None = None,
                    progress: Callable[[str], None] = lambda text: None) -> LoggedMotion:
    """
    Read the motion of the ship from a log.

    Parameters
    ----------
    path
        A log of NMEA sentences: a file, a folder of files, or a pattern of names.
    settings
        How its lines are stamped; `sentence`, `talker` and `instrument` choose headings only.
    progress
        Called with the progress in words.

    Returns
    -------
    LoggedMotion
        Empty for a csv, and for a log without such sentences.

    Raises
    ------
    OSError
        If the log cannot be read.
    DriverError
        If compressed data are damaged, or no file matches.

    Notes
    -----
    Of each thing one kind of sentence is taken, from the talker heard first: for courses VTG
    before RMC; for positions GNS, GGA, RMC, GLL. A sentence takes the stamp of its line or of the
    last line with a stamp. With times of validity it takes its own time, or the time told last.

    """
    rule = settings or DriverSettings()
    log = _open(path, rule, MOTION)
    if log is None:
        return LoggedMotion()
    decoder = MotionDecoder(rule, MOTION, log)
    columns = decoder.read_log(log, progress)
    things = [what for what in MOTION_COLUMNS if what in columns]
    return LoggedMotion({what: Motion.of(what, *columns[what]) for what in things},
                        {what: str(decoder.chosen[what]) for what in things},
                        {why: n for why, n in decoder.counts.items() if why != 'other'})


def read_log_attitude(path: str | os.PathLike[str],
                      settings: DriverSettings | None = None) -> Attitude:
    """
    Read roll and pitch from a log, as `read_log_motion`: of PSXN,23, or of PASHR without it.

    The form PASHR,ATT is not read.
    """
    rule = settings or DriverSettings()
    log = _open(path, rule, ATTITUDE)
    columns = {} if log is None else MotionDecoder(rule, ATTITUDE, log).read_log(log)
    return Attitude.of(*columns['attitude']) if columns else Attitude.empty()


def _open(path: str | os.PathLike[str], rule: DriverSettings, family: Family) -> LogFiles | None:
    """Open a log; None if it cannot have a sentence of the family, as a csv."""
    name = os.fspath(path)
    files = open_csv(name, rule) or open_log(name, rule)
    return files if not is_csv_file(files.paths[0]) and may_tell(files, family) else None
