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
Statuses to diagnostic messages and back.

Numbers are plain texts with the unit in the key, so that tools can plot them. Integers stay
integers; reals read back to the bit.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import lru_cache
import struct
from typing import Any, Iterable, Mapping

from .cdr import decode, encode
from .errors import MessageError
from .stamps import stamp_fields, stamp_ns

TEXT_TYPE = 'std_msgs/msg/String'


def encode_text(text: str) -> bytes:
    """Return a text as std_msgs/msg/String."""
    return encode(TEXT_TYPE, {'data': text})


def decode_text(data: bytes) -> str:
    """Return the text of a std_msgs/msg/String; MessageError if it is damaged."""
    text: str = decode(TEXT_TYPE, data)['data']
    return text


MARKER_TOPIC = 'compliance/marker'

ALARMS_TOPIC = 'compliance/alarms'

MARKS = ('start', 'stop')


def encode_mark(kind: str, ns: int, operator: str | None = None) -> bytes:
    """Return a mark, 'start' or 'stop', as `STATUS_TYPE`; `ns` is the stamp of the newest pair."""
    return encode_statuses(ns, [Status('marker', OK, kind, {'operator': operator})])


def decode_marks(data: bytes) -> list[tuple[str, int]]:
    """Return the kind and stamp (ns) of the marks in a message; MessageError if damaged."""
    ns, statuses = decode_statuses(data)
    return [(status.message, ns) for status in statuses]


STATUS_TYPE = 'diagnostic_msgs/msg/DiagnosticArray'

#: Ten times the ledger of a year of watches; to decode more would hold up a node for seconds.
_MOST_BYTES = 1 << 21
_LENGTH = struct.Struct('<I')
#: The final zero of a string and what fills it up to four bytes, by its length modulo four.
_ENDS = (bytes(4), bytes(3), bytes(2), bytes(1))
#: The empty `hardware_id`.

OK, WARN, ERROR = range(3)

LEVELS = {'ok': OK, 'warn': WARN, 'error': ERROR}
"""The levels by name."""


def value_text(value: Any) -> str:
    """Return a figure as the text in a message."""
    if isinstance(value, bool):
        return 'true' if value else 'false'
    return repr(float(value)) if isinstance(value, float) else str(value)


@dataclass(frozen=True, slots=True)
class Status:
    """
    One status of a diagnostic_msgs/msg/DiagnosticArray.

    Attributes
    ----------
    name
        The thing whose status it is.
    level
        `OK`, `WARN` or `ERROR`.
    message
        The state in words.
    values
        Figures, in display order; None is skipped.
    owner
        The node that says so, `hardware_id` in the message; see `nodes/presence/sole_node`.

    """

    name: str
    level: int
    message: str
    values: Mapping[str, Any] = field(default_factory=dict)
    owner: str = ''


def encode_statuses(ns: int, statuses: Iterable[Status], owner: str = '') -> bytes:
    """
    Return statuses, all of one owner, as a message of `STATUS_TYPE` with a stamp, nanoseconds.

    The bytes are those of `cdr.encode`, which takes ten times as long: nodes publish figures with
    every batch.
    """
    statuses = list(statuses)
    # Header with an empty frame, without the length of the sequence.
    body = bytearray(encode(STATUS_TYPE, {'header': {'stamp': stamp_fields(ns)}})[:-4])
    body += _LENGTH.pack(len(statuses))
    end = len(body)
    for status in statuses:
        # The level is a byte, so it stands where the last string ends; all else is aligned.
        del body[end:]
        body.append(status.level)
        body += (bytes(-len(body) % 4) + _words(status.name) + _words(status.message)
                 + _words(owner))
        values = [(key, value) for key, value in status.values.items() if value is not None]
        body += _LENGTH.pack(len(values))
        end = len(body)
        for key, value in values:
            body += _words(key)
            text = _words(value) if isinstance(value, str) else _string(value_text(value))
            end = len(body) + 4 + _LENGTH.unpack_from(text)[0]
            body += text
    return bytes(body[:end])


def _string(text: str) -> bytes:
    """Return a string with its length, filled up to four bytes."""
    data = text.encode()
    return _LENGTH.pack(len(data) + 1) + data + _ENDS[len(data) % 4]


_words = lru_cache(maxsize=1024)(_string)


def decode_statuses(data: bytes) -> tuple[int, list[Status]]:
    """Return stamp and statuses of a message, values as texts; MessageError if damaged or huge."""
    if len(data) > _MOST_BYTES:
        raise MessageError(f'{STATUS_TYPE} message of {len(data)} bytes: must have at most '
                           f'{_MOST_BYTES}')
    fields = decode(STATUS_TYPE, data)
    return stamp_ns(fields['header']['stamp']), [
        Status(status['name'], status['level'], status['message'],
               {pair['key']: pair['value'] for pair in status['values']}, status['hardware_id'])
        for status in fields['status']]


def encode_figures(name: str, figures: Mapping[str, Any], ns: int, owner: str = '') -> bytes:
    """Return figures of the window or the run in progress as a message; None is skipped."""
    return encode_statuses(ns, [Status(name, OK, 'figures, not a verdict', figures)], owner)
