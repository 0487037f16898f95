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

"""The motion of the ship beside logs: from a log of its own, or from those of the sensors."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Callable, Mapping, Sequence

from heading_intercompare.core.records import Motion
from heading_intercompare.drivers.motion.motion_log import LoggedMotion, read_log_motion
from heading_intercompare.drivers.motion.motion_sentences import MOTION_WORDS
from heading_intercompare.drivers.settings import DriverError, DriverSettings
from heading_intercompare.readers.registry import has_streams, open_log_of_streams

from .log_import import options_for

_WORDS = {'velocity': 'course and speed', 'fix': 'positions', 'rate': 'rate of turn'}


@dataclass(frozen=True, slots=True)
class FoundMotion:
    """
    The motion of the ship, and where it comes from.

    Attributes
    ----------
    things
        Its rows by what they tell, in the order of their log; empty if no log has any.
    notes : tuple of str
        What was used, and what else there was; empty without motion.
    origin
        The provenance as a bag keeps it.

    """

    things: Mapping[str, Motion] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    origin: Mapping[str, Any] = field(default_factory=dict)

    @property
    def rows(self) -> Motion:
        """Return all rows as one chunk."""
        return Motion.concatenate(self.things.values())


def find_motion(paths: Mapping[str, str], drivers: Mapping[str, DriverSettings],
                motion_log: str | None = None,
                progress: Callable[[str], None] = lambda text: None) -> FoundMotion:
    """
    Read the motion of the ship.

    Parameters
    ----------
    paths
        The logs of the sensors, by their names or 'ts' and 'rs'. Courses, positions and rates are
        each taken from the last log that has them: that of the RS before that of the TS.
    drivers
        How to read each log, and 'motion'.
    motion_log
        A log of the motion alone; then the logs of the sensors are not searched.
    progress
        Called with the progress in words.

    Raises
    ------
    OSError
        If a log cannot be read.
    DriverError
        If the log of the motion alone has no motion of the ship.

    """
    sources: Sequence[tuple[str, str]] = [('motion', motion_log)] if motion_log is not None else [
        *reversed([*paths.items()])]
    things: dict[str, Motion] = {}
    used: list[str] = []
    unused: list[str] = []
    origin: dict[str, Any] = {}
    seen: set[str] = set()
    for role, path in sources:
        if path in seen:
            continue
        seen.add(path)
        motion = _read_motion(path, drivers[role], progress)
        if motion_log is not None and not motion.rows:
            lacking = ', '.join(f'{n} {why}' for why, n in motion.not_taken.items())
            raise DriverError(f'{path}: has no motion of the ship: no VTG, RMC, GNS, GGA, GLL or '
                              f'ROT with a stamp{f" (not taken: {lacking})" if lacking else ""}')
        for what, rows in motion.rows.items():
            words = f'{_WORDS[what]} of {motion.sentences[what]} in {path}'
            if what in origin:
                unused.append(words)
                continue
            origin[what] = f'{motion.sentences[what]} {path}'
            things[what] = rows
            used.append(f'{words} ({len(rows)})')
    notes = [f'motion of the ship: {", ".join(used)}'
             + (f'; not used: {", ".join(unused)}' if unused else '')] if used else []
    return FoundMotion(things, tuple(notes), {
        MOTION_WORDS[what]: sentence for what, sentence in origin.items()})


def _read_motion(path: str, driver: DriverSettings,
                 progress: Callable[[str], None]) -> LoggedMotion:
    """Return the motion in a log; of another program, of the preferred stream for each thing."""
    options = options_for(driver)
    if not has_streams(path, options):
        return read_log_motion(path, driver, progress)
    recording = open_log_of_streams(path, options)
    chosen = {} if recording is None else recording.choose_motion()
    return LoggedMotion({what: rows for what, (_, rows) in chosen.items()},
                        {what: stream for what, (stream, _) in chosen.items()})
