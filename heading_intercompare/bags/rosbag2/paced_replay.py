# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Messages of a bag at the times at which they were logged: at a rate, paused, in rounds."""

from __future__ import annotations

import math
import time
from typing import Callable, Collection, Iterator

from heading_intercompare.core.settings import SettingsError

from .bag_reader import BagMessage, BagReader

__all__ = ['Pace', 'Replay']

# No log time reaches this.
_NEVER_NS = 2 ** 63


def _ns(span_s: float) -> int:
    """Return a span in nanoseconds; what no bag can last is cut."""
    return round(min(span_s, 9e9) * 1e9)


class Pace:
    """
    Log time by a steady clock: the origin, and from there the time gone by, times the rate.

    Parameters
    ----------
    origin_ns : int
        Log time at the begin.
    rate : float
        Speed; 0 for no waiting.
    paused : bool
        Stand still until `resume`.
    clock_ns : callable
        A steady clock, nanoseconds.

    Attributes
    ----------
    paused : bool
        Whether it stands still.

    Notes
    -----
    It does not drift: what it shows is computed from the clock, never added up from steps. A
    pause begins at the last look before it, so that what was due by then is out and nothing else
    is; it moves the begin by its length, in whole nanoseconds. The end of a round moves the
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
        """Let it be the origin now."""
        self._began_ns = self._seen_ns = self._clock_ns()

    def look_ns(self) -> float:
        """Return the log time up to which messages are due, an integer or infinite."""
        if self._rate == 0.0:
            return math.inf
        if not self.paused:
            self._seen_ns = self._clock_ns()
        gone_ns = (self._seen_ns - self._began_ns) * self._rate
        return self._origin_ns + round(gone_ns) if gone_ns < math.inf else math.inf

    def pause(self) -> None:
        """Stand still at the last look."""
        self.paused = True

    def resume(self) -> None:
        """Go on from there."""
        if self.paused:
            now_ns = self._clock_ns()
            self._began_ns += now_ns - self._seen_ns
            self._seen_ns = now_ns
            self.paused = False

    def again(self, length_ns: int) -> None:
        """Let another round begin where one of this length, in log time, ends."""
        self._origin_ns -= length_ns


class Replay:
    """
    Messages of a bag, each when it is due.

    Parameters
    ----------
    reader : BagReader
        The bag.
    topics : collection of str
        Topics of the bag.
    rate : float
        Speed, times that of the recording; 0: no waiting.
    start_s : float
        What is left out, seconds behind the first message of the bag.
    duration_s : float or None
        Length, the end excluded, seconds; None: to the end of the bag.
    loop : bool
        Begin again at the end.
    paused : bool
        Stand at the start until `pause(False)`.
    clock_ns : callable
        A steady clock, nanoseconds.

    Attributes
    ----------
    shown_ns : int
        Log time that has been reached: not before a message that was taken, not behind one that
        was not; back at the start in each round.
    round : int
        Number of the round, from 1.
    over : bool
        There is nothing more to take.

    Raises
    ------
    SettingsError
        If it would start behind the last message.
    BagError
        If a topic is absent; here and while messages are taken, if the bag is damaged.

    Notes
    -----
    The first message is due when `begin` is called, plus its distance from the start divided by
    the rate; so is every other. A round begins with the last message of the one before.

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
            self._topics, self._origin_ns, self._stop_ns)
        self._next = next(self._messages, None)
        self.shown_ns = self._origin_ns
        self.round += 1

    @property
    def paused(self) -> bool:
        """Whether nothing is due until `pause(False)`."""
        return self._pace.paused

    @property
    def place_s(self) -> float:
        """Return how far it is behind the first message of the bag, seconds."""
        return (self.shown_ns - self._first_ns) / 1e9

    @property
    def place(self) -> str:
        """Return where in the bag it is, in words."""
        again = f', round {self.round}' if self._loop else ''
        return f'{self.place_s:.3f} s of {self._length_s:.3f} s{again}'

    @property
    def part(self) -> str:
        """Return what of the bag is replayed, in words."""
        begin_s, end_s = ((ns - self._first_ns) / 1e9 for ns in (self._origin_ns, self._stop_ns))
        end = 'its end' if self._stop_ns == _NEVER_NS else f'before {end_s:g} s'
        return f'{self._reader.path} from {begin_s:g} s to {end}'

    def begin(self) -> None:
        """Let it be the start now."""
        self._pace.begin()

    def pause(self, wanted: bool | None = None) -> str:
        """Pause or go on, None: the other of the two; return what that did, in words."""
        wanted = not self.paused if wanted is None else wanted
        if wanted == self.paused:
            return f'{"already paused" if wanted else "not paused,"} at {self.place}'
        if wanted:
            self._pace.pause()
        else:
            self._pace.resume()
        return f'{"paused" if wanted else "resumed"} at {self.place}'

    def take(self) -> BagMessage | None:
        """Return the next message, once, if it is due; None if none is."""
        if self._next is None or self.paused:
            return None
        due_ns, message = self._pace.look_ns(), self._next
        if message.log_time_ns > due_ns:
            self.shown_ns = int(due_ns)
            return None
        self.shown_ns = max(self.shown_ns, message.log_time_ns)
        self._next = next(self._messages, None)
        if self._next is None and self._loop:
            self._pace.again(self.shown_ns - self._origin_ns)
            self._open_round()
        self.over = self._next is None
        return message
