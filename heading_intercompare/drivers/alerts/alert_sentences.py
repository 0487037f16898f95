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
The sentences of alerts: ALF, ALC, ARC and HBT are written, ACN is read.

The order of the fields is that of IEC 61162-1 as the manuals of several makers print it;
`docs/howto/alerts_to_the_bridge.md` says what was checked. A sentence has at most 82 characters
with its start and its line end.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import reduce
from operator import xor
from typing import Iterable, Sequence

from heading_intercompare.drivers.sentences import Rejected

#: Most characters between the start of a sentence and its checksum.
_MOST = 82 - len('$*hh\r\n')
_MOST_TITLE = 16
#: Characters with a meaning of their own; they are written as ^ and two hex digits.
_RESERVED = frozenset('$*,!\\^~')
_PLAIN = str.maketrans({'°': ' deg', '−': '-', '–': '-', '±': '+-', 'σ': 'sigma', '²': '2'})
_DAY_CS = 24 * 3600 * 100


@dataclass(frozen=True, slots=True)
class AlertEntry:
    """
    What ALF and ALC say of one alert.

    Attributes
    ----------
    identifier, instance
        Number of the kind of alert, and which one of that kind.
    revision
        Counts its changes, 1 to 99.
    escalation
        Counts its repetitions, 0 to 9.
    priority : {'W', 'C'}
        Warning or caution.
    state : {'V', 'S', 'A', 'U', 'N'}
        Active and unacknowledged, silenced, acknowledged or active; rectified and
        unacknowledged; normal.
    changed_ns
        Time of the last change, nanoseconds UTC.
    title, description
        Its name and its words; without a description it takes one sentence.

    """

    identifier: int
    instance: int
    revision: int
    escalation: int
    priority: str
    state: str
    changed_ns: int
    title: str
    description: str = ''


@dataclass(frozen=True, slots=True)
class AlertCommand:
    """
    A command of the bridge, ACN.

    Attributes
    ----------
    manufacturer
        Mnemonic code of the alert, empty for none.
    identifier, instance
        Which alert; the instance is None if the field is empty.
    letter
        A: acknowledge, S: silence, Q: repeat, O: take over the responsibility.

    """

    manufacturer: str
    identifier: int
    instance: int | None
    letter: str


def frame(body: str) -> bytes:
    r"""
    Return a sentence with its start, checksum and line end.

    Examples
    --------
    >>> frame('IIALF,1,1,0,124304.50,A,W,A,,192,1,1,0,LOST TARGET')
    b'$IIALF,1,1,0,124304.50,A,W,A,,192,1,1,0,LOST TARGET*14\r\n'

    """
    data = body.encode('ascii')
    return b'$%s*%02X\r\n' % (data, reduce(xor, data, 0))


def time_of_day(ns: int) -> str:
    """
    Return a time, nanoseconds UTC, as hhmmss.ss.

    Examples
    --------
    >>> time_of_day(1_700_000_000_129_000_000)
    '221320.12'

    """
    seconds, hundredths = divmod(ns // 10_000_000 % _DAY_CS, 100)
    return (f'{seconds // 3600:02d}{seconds // 60 % 60:02d}{seconds % 60:02d}.'
            f'{hundredths:02d}')


def _cut(text: str, most: int) -> str:
    """Return a text as the field of a sentence, cut to a length; no escape is divided."""
    field = ''
    for letter in text.translate(_PLAIN):
        plain = letter if ' ' <= letter <= '~' else '?'
        escaped = f'^{ord(plain):02X}' if plain in _RESERVED else plain
        if len(field) + len(escaped) > most:
            break
        field += escaped
    return field.rstrip()


def write_alf(talker: str, manufacturer: str, sequence: int, entry: AlertEntry,
              ) -> tuple[str, ...]:
    """
    Return the sentences that tell an alert: its title, then its description if it has one.

    Parameters
    ----------
    talker, manufacturer
        Two letters; three letters or nothing.
    sequence
        Number of the message, 0 to 9.
    entry
        The alert.

    """
    n = 2 if entry.description else 1
    name = (f'{manufacturer},{entry.identifier},{entry.instance},{entry.revision},'
            f'{entry.escalation},')
    # Category B: it needs no more than what the bridge shows of it.
    first = (f'{talker}ALF,{n},1,{sequence},{time_of_day(entry.changed_ns)},B,{entry.priority},'
             f'{entry.state},{name}')
    sentences = [first + _cut(entry.title, min(_MOST_TITLE, _MOST - len(first)))]
    if entry.description:
        second = f'{talker}ALF,2,2,{sequence},,,,,{name}'
        sentences.append(second + _cut(entry.description, _MOST - len(second)))
    return tuple(sentences)


def write_alc(talker: str, manufacturer: str, sequence: int, entries: Sequence[AlertEntry],
              ) -> tuple[str, ...]:
    """
    Return the sentences that list alerts; one without entries if there are none.

    No entry is divided between two sentences.

    Parameters
    ----------
    talker, manufacturer
        As for `write_alf`.
    sequence
        Number of the message, 0 to 99.
    entries
        The alerts; those that do not fit into 99 sentences are left out.

    """
    room = _MOST - len(f'{talker}ALC,00,00,00,00')
    lists: list[list[str]] = [[]]
    for entry in entries:
        fields = f',{manufacturer},{entry.identifier},{entry.instance},{entry.revision}'
        if len(''.join(lists[-1])) + len(fields) > room:
            lists.append([])
        lists[-1].append(fields)
    lists = lists[:99]
    return tuple(f'{talker}ALC,{len(lists):02d},{number:02d},{sequence:02d},{len(fields)}'
                 f'{"".join(fields)}' for number, fields in enumerate(lists, 1))


def write_arc(talker: str, command: AlertCommand, now_ns: int) -> tuple[str, ...]:
    """Return the sentence that refuses a command at a time, nanoseconds UTC."""
    instance = '' if command.instance is None else command.instance
    return (f'{talker}ARC,{time_of_day(now_ns)},{command.manufacturer},{command.identifier},'
            f'{instance},{command.letter}',)


def write_hbt(talker: str, period_s: float, sequence: int, *, is_well: bool) -> tuple[str, ...]:
    """Return the heartbeat; `sequence` is 0 to 9."""
    return (f'{talker}HBT,{period_s:.1f},{"A" if is_well else "V"},{sequence}',)


def read_command(text: bytes) -> AlertCommand | None:
    """
    Return the command in a sentence, or None if it is another sentence.

    Parameters
    ----------
    text
        What stands between the start of a sentence and its checksum.

    Raises
    ------
    Rejected
        If it is an ACN that names no alert or no command.

    Examples
    --------
    >>> read_command(b'BMACN,093015.00,,10001,1,A,C').letter
    'A'

    """
    fields = text.decode('latin-1').split(',')
    if len(fields[0]) != 5 or fields[0][2:] != 'ACN':
        return None
    if len(fields) < 7 or fields[6].strip() != 'C':
        raise Rejected('no_command')
    manufacturer, identifier, instance, letter = (field.strip() for field in fields[2:6])
    if not _is_number(identifier) or (instance and not _is_number(instance)) or not (
            len(letter) == 1 and letter.isalpha()):
        raise Rejected('bad_command')
    return AlertCommand(manufacturer, int(identifier), int(instance) if instance else None,
                        letter)


def _is_number(text: str) -> bool:
    return text.isascii() and text.isdigit() and len(text) <= 7


def tag(parts: Iterable[str]) -> bytes:
    r"""
    Return a TAG block.

    Examples
    --------
    >>> tag(['s:II0001', 'n:7'])
    b'\\s:II0001,n:7*07\\'

    """
    data = ','.join(parts).encode('ascii')
    return b'\\%s*%02X\\' % (data, reduce(xor, data, 0))
