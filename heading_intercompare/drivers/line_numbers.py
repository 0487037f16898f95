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

"""
The numbers that a sender gives to its lines: which line came before, and which are missing.

IEC 61162-450 numbers the lines of a source, `s:`, from 1 to 999 and from 1 on. A line that came
before has the number that it had. That shows the second of two network paths, and a line that
somebody sends a second time.
"""

from __future__ import annotations

from .log_lines.tag_blocks import tag_blocks

#: Numbers before the first one comes again; those of other rules are larger, and are not used.
_N_NUMBERS = 999
#: A number up to this far ahead goes on; any other one is old.
_AHEAD = _N_NUMBERS // 2
#: Steps ahead that prove a numbering; one that restarts proves itself with twice the steps.
_PROOF = 8
#: Old lines, one after the other, that show a restart; of lines that all came before.
_RESTART, _RESTART_OF_REPEATS = 8, 64
#: If lines before a jump of this size go on, somebody else sent the line that jumped.
_JUMP = 50
#: Sources followed; names can be forged without end.
_MOST_SOURCES = 64
#: A second network path is faster than this.
_LATE_NS = 1_000_000_000


class _Numbering:
    """
    Follows the numbers of the lines of one source.

    Attributes
    ----------
    n_missing
        Lines missing so far by their numbers. A gap counts once the line after it goes on, and no
        longer when a line of it comes late.
    n_restarts
        How often the numbers began elsewhere.

    """

    def __init__(self, number: int) -> None:
        self._newest = self._before = number
        self._lines: dict[int, tuple[bytes, int | None]] = {}
        self._steps, self._needed = 0, _PROOF
        self._n_old, self._n_repeated = 0, 0
        #: Numbers skipped: those of a gap that may be a jump, and those that count as missing.
        self._gap: set[int] = set()
        self._missing: set[int] = set()
        self.n_missing = self.n_restarts = 0

    def refuse(self, number: int, text: bytes, received_ns: int | None) -> str:
        """Return why a line is no new one, or ''; see `LineNumbers.refuse`."""
        ahead = (number - self._newest) % _N_NUMBERS
        reason = ''
        self.take_late(number)
        if 0 < ahead <= _AHEAD:
            self._go_on(number, ahead)
        elif self._lines and not self._goes_on_before(number):
            reason = self._look_back(number, text)
        if not reason:
            self._lines[number] = text, received_ns
        return reason

    def came_ns(self, number: int) -> int | None:
        """Return when the line of a number was first received; None if that is unknown."""
        return self._lines[number][1] if number in self._lines else None

    def _go_on(self, number: int, ahead: int) -> None:
        if ahead == 1:
            if self._steps >= self._needed:
                self.n_missing += len(self._gap)
                self._missing |= self._gap
            self._gap.clear()
        else:
            self._gap |= {(number - back) % _N_NUMBERS for back in range(1, ahead)}
        self._before, self._newest = self._newest, number
        self._steps += 1
        self._n_old = self._n_repeated = 0

    def take_late(self, number: int) -> None:
        """Take a line that comes late out of those that are missing."""
        is_late = (self._newest - number) % _N_NUMBERS < _AHEAD
        number %= _N_NUMBERS
        self._gap.discard(number)
        if number in self._missing:
            self._missing.remove(number)
            # One of the round before has this number only by chance.
            self.n_missing -= is_late

    def _goes_on_before(self, number: int) -> bool:
        """Tell whether a line goes on before the last jump, which was that of another sender."""
        jump = (self._newest - self._before) % _N_NUMBERS
        if jump < _JUMP or not 0 < (number - self._before) % _N_NUMBERS < _JUMP:
            return False
        self._newest = self._before = number
        self._gap.clear()
        return True

    def _look_back(self, number: int, text: bytes) -> str:
        is_repeated = self._lines.get(number, (b'',))[0] == text
        self._n_old += 1
        self._n_repeated += is_repeated
        proven = self._steps >= self._needed
        if self._n_old >= (_RESTART_OF_REPEATS if self._n_repeated == self._n_old else _RESTART):
            self._newest = self._before = number
            self._needed *= 2 if proven else 1
            self._steps = self._n_old = self._n_repeated = 0
            self._gap.clear()
            self._missing.clear()
            self.n_restarts += 1
            return ''
        return '' if not proven else 'repeated' if is_repeated else 'old_number'


class LineNumbers:
    """
    Tells by the numbers in TAG blocks which lines of a stream came before.

    Attributes
    ----------
    source : str
        Name `s:` of the source of the last line; empty if it has none.
    kind
        Source and kind of the last line; None if it has no number.
    restarted
        With the last line the numbers of its kind began elsewhere, with the lines refused before.
    n_late
        Lines that came a second time, more than a second after the first one.

    Notes
    -----
    The numbers count where they prove themselves: by eight steps ahead of the lines of one kind of
    one source. So a sender that gives each line the number 1, or numbers the lines of a datagram,
    loses nothing. A sender that restarts begins at 1. Its lines count when eight of one kind in
    a row were old, or 64 if all of these came before. The caller holds the lines until then.

    A source may number the lines for each of its destinations, and a log may have several. So the
    lines of each kind are followed by themselves. Only missing lines are counted over all kinds.

    """

    def __init__(self) -> None:
        self._by_kind: dict[tuple[str, bytes], _Numbering] = {}
        self._by_source: dict[str, _Numbering] = {}
        self._prefix, self._reason = b'', ''
        self.source = ''
        self.kind: tuple[str, bytes] | None = None
        self.restarted = False
        self.n_late = self._n_missing_before = 0

    def begin_file(self) -> None:
        """Take note that the next line is from another file: its numbers begin anywhere."""
        self._n_missing_before = self.n_missing
        self._by_kind.clear()
        self._by_source.clear()

    @property
    def n_missing(self) -> int:
        """Return how many lines are missing by their numbers."""
        return self._n_missing_before + sum(
            numbering.n_missing for numbering in self._by_source.values())

    def refuse(self, prefix: bytes, text: bytes, received_ns: int | None) -> str:
        """
        Return why a line is no new one, or ''.

        Parameters
        ----------
        prefix, text
            A sentence, and the bytes before it.
        received_ns
            When it was received, nanoseconds; None in a log.

        Returns
        -------
        {'', 'repeated', 'old_number'}
            A `repeated` line came before, word for word. Another line had an `old_number` before,
            or nobody sent it in its time.

        """
        if b'\\' not in prefix:
            self.source, self.kind = '', None
            return ''
        if prefix is self._prefix:
            # The second sentence of a line has the prefix of the first one, and its fate.
            return self._reason
        self._prefix = prefix
        self.source, number = _read_origin(prefix)
        self.kind, self._reason = None, ''
        if number:
            self._reason = self._follow((self.source, text[:5]), number, text, received_ns)
        return self._reason

    def _follow(self, kind: tuple[str, bytes], number: int, text: bytes,
                received_ns: int | None) -> str:
        if kind not in self._by_kind and len(self._by_kind) >= _MOST_SOURCES:
            return ''
        self.kind = kind
        numbering = self._by_kind.setdefault(kind, _Numbering(number))
        n_restarts = numbering.n_restarts
        reason = numbering.refuse(number, text, received_ns)
        self.restarted = numbering.n_restarts > n_restarts
        if reason:
            if self.source in self._by_source:
                self._by_source[self.source].take_late(number)
            came_ns = numbering.came_ns(number)
            self.n_late += (reason == 'repeated' and came_ns is not None
                            and received_ns is not None and received_ns - came_ns > _LATE_NS)
        else:
            self._by_source.setdefault(self.source, _Numbering(number)).refuse(
                number, text, received_ns)
        return reason


def _read_origin(prefix: bytes) -> tuple[str, int]:
    """Return the source and the number in the TAG blocks of a line: '' and 0 if it has none."""
    source, number = '', 0
    for fields in tag_blocks(prefix):
        for field in fields:
            value = field[2:]
            if field[:2] == b's:' and not source:
                source = value.decode('ascii', 'replace')
            elif field[:2] == b'n:' and not number and value.isdigit() and len(value) <= 3:
                number = int(value)
    return source, number


class SenderTurns:
    """
    Notes whether the readings of one sensor come from several senders in turns.

    One sender that takes over from another one changes once. Two that send at a time change all
    the time.

    Attributes
    ----------
    n_changes
        How often a reading came from another sender than the one before.
    names
        The last two senders.

    """

    def __init__(self) -> None:
        self.n_changes = 0
        self.names: tuple[str, ...] = ()

    def hear(self, name: str) -> None:
        """Take note of the sender of a reading."""
        if self.names and self.names[-1] == name:
            return
        self.n_changes += bool(self.names)
        self.names = (*self.names[-1:], name)
