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

"""The parts of what the live page shows, each with its age where it can grow old."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum
from typing import Mapping

from heading_intercompare.web.figures.trend import TrendColumn


class Tone(str, Enum):
    """
    How a thing is coloured; its words always say the same.

    Only a verdict that was given can be `GOOD`.
    """

    NONE = 'none'
    GOOD = 'good'
    DOUBT = 'doubt'
    BAD = 'bad'

    def __str__(self) -> str:
        return self.value


@dataclass(frozen=True, slots=True)
class LampView:
    """
    The state lamp: the last verdict given at a look or at the end of a run.

    Attributes
    ----------
    word
        The outcome in capitals; or 'NONE YET'.
    given_ns
        Stamp of the data at which the verdict was given.
    what
        Which look or run gave it, in words; without a verdict, when the next one comes.
    headline
        The result in one line; '' without a verdict.

    """

    word: str = 'NONE YET'
    tone: Tone = Tone.NONE
    given_ns: int | None = None
    what: str = ''
    headline: str = ''


@dataclass(frozen=True, slots=True)
class ValidityView:
    """What speaks against the comparison now, in words, and how grave it is."""

    words: str
    tone: Tone


@dataclass(frozen=True, slots=True)
class AlarmView:
    """
    One alarm that is not normal.

    Attributes
    ----------
    name
        Node and alarm, as `compliance/acknowledge` takes it.
    priority, state
        As on the topic.
    raised_ns
        Stamp at which it was last raised.
    values
        Figures of its condition.

    """

    name: str
    priority: str
    state: str
    words: str
    raised_ns: int | None
    values: Mapping[str, str] = field(default_factory=dict)

    @property
    def acknowledged(self) -> bool:
        """Whether somebody has acknowledged it."""
        return self.state == 'active_acknowledged'

    @property
    def active(self) -> bool:
        """Whether its condition still holds."""
        return self.state.startswith('active')


@dataclass(frozen=True, slots=True)
class AlertView:
    """
    What is wrong, as an officer of the watch reads it: an alarm with its consequences.

    Attributes
    ----------
    priority
        'alarm', 'warning' or 'caution', after IMO MSC.302(87).
    words
        What is wrong, in plain words.
    details
        The same as the node that watches says it, with its figures.
    sensor, state
        The sensor that it is about, '' if none, and the state of that sensor in a word.
    alarms
        Names of the alarm and of its consequences that nobody has acknowledged yet.
    since_ns, age_s
        Stamp at which it was raised, and the time since then, seconds; None if not known.
    active, acknowledged
        Whether its condition still holds, and whether somebody has acknowledged it.
    consequences
        What follows from it, in plain words.

    """

    priority: str
    words: str
    details: str = ''
    sensor: str = ''
    state: str = ''
    alarms: tuple[str, ...] = ()
    since_ns: int | None = None
    age_s: float | None = None
    active: bool = True
    acknowledged: bool = False
    consequences: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class JudgedTestView:
    """A test of the norm: what is limited, its result with figure and limit, why, its gravity."""

    words: str
    result: str
    notes: str
    tone: str


@dataclass(frozen=True, slots=True)
class JudgedRunView:
    """
    A run that was judged.

    Attributes
    ----------
    number, start_ns, end_ns, n
        Its number, the stamps of its first and last pairs, and its analysed differences.
    mean_deg, std_deg
        Of its differences, degrees.
    word, tone
        Its outcome in capitals, and how grave it is.
    reason
        Why, as in the verdict.
    void
        Whether the comparison meant nothing, so that its figures say nothing.

    """

    number: int
    start_ns: int | None
    end_ns: int | None
    n: int
    mean_deg: float | None
    std_deg: float | None
    word: str
    tone: Tone
    reason: str
    void: bool = False


@dataclass(frozen=True, slots=True)
class JudgedDayView:
    """
    The runs that ended on one day of UTC.

    Attributes
    ----------
    date
        '2026-03-01'.
    runs
        Its runs, the newest first.
    n, mean_deg, std_deg
        Of the differences of its runs that are not void, as of one record; degrees.
    word, tone
        The worst outcome of its runs, and how grave it is.

    """

    date: str
    runs: tuple[JudgedRunView, ...]
    n: int
    mean_deg: float | None
    std_deg: float | None
    word: str
    tone: Tone


@dataclass(frozen=True, slots=True)
class NodeView:
    """A node: its worst part in words with its level (0 OK, 1 warning, 2 error), and its age."""

    name: str
    level: int
    words: str
    age_s: float
    stale: bool


@dataclass(frozen=True, slots=True)
class WindowView:
    """
    Mean and scatter of the rolling window, beside the norm; no judgement.

    Attributes
    ----------
    mean_deg, std_deg
        Degrees.
    limit_deg
        The norm for the scatter of the differences, degrees: root of GK (5).
    nu
        Effective degrees of freedom.
    judges_mean
        The norm holds for the mean, too, as the mean is known: variant A.

    """

    n: int = 0
    mean_deg: float | None = None
    std_deg: float | None = None
    limit_deg: float | None = None
    age_s: float | None = None
    stale: bool = True
    nu: float | None = None
    judges_mean: bool = False


@dataclass(frozen=True, slots=True)
class RunView:
    """
    The run in progress and what it lacks.

    Attributes
    ----------
    number
        Number of the run, from 1; 0: no run is in progress.
    n
        Differences analysed.
    span_s, needed_s
        As on `compliance/run`.
    next_look_ns
        When the next look is due.
    lacking
        What is missing, in words.
    ends_ns
        When the clock ends the run.
    start_ns
        Stamp of its first pair.
    marked
        Whether a mark was set; the first start takes all before it out of the record.

    """

    number: int = 0
    n: int = 0
    span_s: float | None = None
    needed_s: float | None = None
    next_look_ns: int | None = None
    lacking: str = 'not heard'
    age_s: float | None = None
    stale: bool = True
    ends_ns: int | None = None
    start_ns: int | None = None
    marked: bool = True


@dataclass(frozen=True, slots=True)
class TrendView:
    """
    The trend of one difference.

    Attributes
    ----------
    columns, span_s, newest_ns
        The extremes per column, the length of the stretch, and the newest stamp.
    center_deg, limit_deg
        Centre and half width of the limits of a single difference, degrees.
    age_s, stale
        Time since the last pair came, and whether that is too long.
    sensor
        The tested sensor.
    longer
        The same over longer stretches: length in seconds, and columns.
    doubtful
        Begin and end of the stretches in which there was no comparison, as ages in seconds.

    """

    columns: tuple[TrendColumn, ...] = ()
    span_s: float = 1800.0
    newest_ns: int | None = None
    center_deg: float = 0.0
    limit_deg: float | None = None
    age_s: float | None = None
    stale: bool = True
    sensor: str = 'ts'
    longer: tuple[tuple[float, tuple[TrendColumn, ...]], ...] = ()
    doubtful: tuple[tuple[float, float], ...] = ()


@dataclass(frozen=True, slots=True)
class BagView:
    """The recording: words and level as on /diagnostics, free bytes on its disk, and its age."""

    words: str = 'nothing is recorded'
    level: int = 0
    free_bytes: int | None = None
    age_s: float | None = None
    stale: bool = True


@dataclass(frozen=True, slots=True)
class WaitingAction:
    """
    An action of a person that can still be undone.

    Attributes
    ----------
    what : {'start', 'stop'}
        What it does to the run.
    operator
        Name of the person who asked for it; '' if it is not known.
    due_s
        When it is done, on the clock of its `Delay`, seconds.
    due_ns
        The same, UTC ns.

    """

    what: str
    operator: str
    due_s: float
    due_ns: int
