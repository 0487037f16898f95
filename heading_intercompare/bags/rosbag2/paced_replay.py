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

"""Replay of a bag in step with its log times: at a rate, with pauses, in rounds."""

from __future__ import annotations

import math
import time
from typing import Callable, Collection, Iterator

from heading_intercompare.core.declared_settings import SettingsError

from .bag_reader import BagMessage, BagReader

# No log time reaches this.
_NEVER_NS = 2 ** 63


def _ns(span_s: float) -> int:
    """Return a span in nanoseconds, cut to more than any bag can last."""
    return round(min(span_s, 9e9) * 1e9)


class Pace:
    """
    Log time by a steady clock: the origin plus the elapsed time times the rate.

    Parameters
    ----------
    origin_ns
        Log time at the beginning.
    rate
        Speed; 0 for no waiting.
    paused
        Start paused, until `resume`.
    clock_ns
        A steady clock, nanoseconds.

    Attributes
    ----------
    paused
        Whether it is paused.

    Notes
    -----
    It does not drift: the log time is computed from the clock, never added up from steps. A
    pause counts from the last look before it, so the messages due by then are out and no others.
    It shifts the beginning by its length, in whole nanoseconds. The end of a round shifts the
    origin by the length of the round, in whole nanoseconds of log time.

    Examples
    --------
    >>> clock = iter([100, 103, 999, 1000])
    >>> pace = Pace(5000, 2.0, clock_ns=lambda: next(clock))
    >>> pace.begin()
    >>> pace.look_ns()
    5006
    >>> pace.pause()
    >>> pace.look_ns()
    5006
    >>> pace.resume()
    >>> pace.look_ns()
    5008

    """

    def __init__(self, origin_ns: int, rate: float, *, paused: bool = False,
                 clock_ns: Callable[[], int] = time.monotonic_ns) -> None:
        self._origin_ns, self._rate, self._clock_ns = origin_ns, rate, clock_ns
        self._began_ns = self._seen_ns = 0
        self.paused = paused

    def begin(self) -> None:
        """Start the clock at the origin."""
        self._began_ns = self._seen_ns = self._clock_ns()

    def look_ns(self) -> float:
        """Return the log time up to which messages are due, an integer or infinity."""
        if self._rate == 0.0:
            return math.inf
        if not self.paused:
            self._seen_ns = self._clock_ns()
        gone_ns = (self._seen_ns - self._began_ns) * self._rate
        return self._origin_ns + round(gone_ns) if gone_ns < math.inf else math.inf

    def pause(self) -> None:
        """Stop the clock at the last look."""
        self.paused = True

    def resume(self) -> None:
        """Continue from the pause."""
        if self.paused:
            now_ns = self._clock_ns()
            self._began_ns += now_ns - self._seen_ns
            self._seen_ns = now_ns
            self.paused = False

    def rewind(self, length_ns: int) -> None:
        """Begin another round at the end of one that took this much log time."""
        self._origin_ns -= length_ns


class Replay:
    """
    The messages of a bag, each returned when it is due.

    Parameters
    ----------
    reader
        The bag.
    topics
        Topics to replay.
    rate
        Speed relative to the recording; 0: no waiting.
    start_s
        Where to start, seconds after the first message of the bag.
    duration_s
        Length, the end excluded, seconds; None: to the end of the bag.
    loop
        Begin again at the end.
    paused
        Wait at the start until `pause(False)`.
    clock_ns
        A steady clock, nanoseconds.

    Attributes
    ----------
    shown_ns : int
        The log time reached: at or after every message taken, never after one that was not. It
        returns to the start in each round.
    round : int
        Number of the round, from 1.
    over : bool
        There are no more messages to take.

    Raises
    ------
    SettingsError
        If it would start after the last message.
    BagError
        If a topic is absent, or if the bag is damaged; the latter also while messages are taken.

    Notes
    -----
    A message is due when its time from the start of the replay, divided by the rate, has passed
    since `begin`. A round begins with the last message of the round before.

    """

    def __init__(self, reader: BagReader, topics: Collection[str], *, rate: float = 1.0,
                 start_s: float = 0.0, duration_s: float | None = None, loop: bool = False,
                 paused: bool = False,
                 clock_ns: Callable[[], int] = time.monotonic_ns) -> None:
        self._reader, self._topics, self._loop = reader, topics, loop
        self._first_ns = reader.start_ns or 0
        self._length_s = ((reader.end_ns or 0) - self._first_ns) / 1e9
        self._origin_ns = self._first_ns
        if reader.end_ns is not None:
            self._origin_ns += _ns(start_s)
            if self._origin_ns > reader.end_ns:
                raise SettingsError(f'start_s = {start_s!r}: {reader.path} is '
                                    f'{self._length_s:.3f} s long; must be at most that')
        self._stop_ns = _NEVER_NS
        if duration_s is not None:
            self._stop_ns = min(_NEVER_NS, self._origin_ns + _ns(duration_s))
        self._pace = Pace(self._origin_ns, rate, paused=paused, clock_ns=clock_ns)
        self.round = 0
        self._open_round()
        self.over = self._next is None

    def _open_round(self) -> None:
        self._messages: Iterator[BagMessage] = self._reader.messages(
            self._topics, self._origin_ns, self._stop_ns, in_order=True)
        self._next = next(self._messages, None)
        self.shown_ns = self._origin_ns
        self.round += 1

    @property
    def paused(self) -> bool:
        """Whether the replay waits for `pause(False)`."""
        return self._pace.paused

    @property
    def place_s(self) -> float:
        """Time from the first message of the bag to the log time reached, seconds."""
        return (self.shown_ns - self._first_ns) / 1e9

    @property
    def place(self) -> str:
        """Return the place in the bag, in words."""
        again = f', round {self.round}' if self._loop else ''
        return f'{self.place_s:.3f} s of {self._length_s:.3f} s{again}'

    @property
    def part(self) -> str:
        """Return the part of the bag that is replayed, in words."""
        begin_s, end_s = ((ns - self._first_ns) / 1e9 for ns in (self._origin_ns, self._stop_ns))
        end = 'its end' if self._stop_ns == _NEVER_NS else f'before {end_s:g} s'
        return f'{self._reader.path} from {begin_s:g} s to {end}'

    def begin(self) -> None:
        """Start the clock."""
        self._pace.begin()

    def pause(self, paused: bool | None = None) -> str:
        """Pause (True), resume (False) or toggle (None); return what was done, in words."""
        paused = not self.paused if paused is None else paused
        if paused == self.paused:
            return f'{"already paused" if paused else "not paused,"} at {self.place}'
        if paused:
            self._pace.pause()
        else:
            self._pace.resume()
        return f'{"paused" if paused else "resumed"} at {self.place}'

    def take(self) -> BagMessage | None:
        """Return the next message if it is due; otherwise None. Each is returned once."""
        if self._next is None or self.paused:
            return None
        due_ns, message = self._pace.look_ns(), self._next
        if message.log_time_ns > due_ns:
            self.shown_ns = int(due_ns)
            return None
        self.shown_ns = max(self.shown_ns, message.log_time_ns)
        self._next = next(self._messages, None)
        if self._next is None and self._loop:
            self._pace.rewind(self.shown_ns - self._origin_ns)
            self._open_round()
        self.over = self._next is None
        return message
