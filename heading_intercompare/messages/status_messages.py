# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""
Statuses to diagnostic messages and back.

Numbers are plain texts with the unit in the key, so that tools can plot them. Integers stay
integers; reals read back to the bit.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Iterable, Mapping

from .cdr import decode, encode
from .stamps import stamp_fields, stamp_ns

__all__ = ['decode_statuses', 'encode_figures', 'encode_statuses', 'ERROR', 'LEVELS', 'OK',
           'Status', 'STATUS_TYPE', 'WARN']

STATUS_TYPE = 'diagnostic_msgs/msg/DiagnosticArray'

OK, WARN, ERROR = range(3)

LEVELS = {'ok': OK, 'warn': WARN, 'error': ERROR}
"""The levels by name."""


def _text(value: Any) -> str:
    if isinstance(value, bool):
        return 'true' if value else 'false'
    return repr(float(value)) if isinstance(value, float) else str(value)


@dataclass(frozen=True, slots=True)
class Status:
    """
    One status of a diagnostic_msgs/msg/DiagnosticArray.

    Attributes
    ----------
    name : str
        The thing whose status it is.
    level : int
        `OK`, `WARN` or `ERROR`.
    message : str
        The state in words.
    values : mapping of str to object
        Figures, in display order; None is skipped.
    owner : str
        The node that says so, `hardware_id` in the message; see `nodes/runtime/sole_node`.

    """

    name: str
    level: int
    message: str
    values: Mapping[str, Any] = field(default_factory=dict)
    owner: str = ''


def encode_statuses(ns: int, statuses: Iterable[Status], owner: str = '') -> bytes:
    """Return statuses, all of one owner, as a message of `STATUS_TYPE` with a stamp."""
    return encode(STATUS_TYPE, {'header': {'stamp': stamp_fields(ns)}, 'status': [
        {'level': one.level, 'name': one.name, 'message': one.message, 'hardware_id': owner,
         'values': [{'key': key, 'value': _text(value)} for key, value in one.values.items()
                    if value is not None]} for one in statuses]})


def decode_statuses(data: bytes) -> tuple[int, list[Status]]:
    """Return stamp and statuses of a message, with values as texts; MessageError if damaged."""
    fields = decode(STATUS_TYPE, data)
    return stamp_ns(fields['header']['stamp']), [
        Status(one['name'], one['level'], one['message'],
               {pair['key']: pair['value'] for pair in one['values']}, one['hardware_id'])
        for one in fields['status']]


def encode_figures(name: str, figures: Mapping[str, Any], ns: int) -> bytes:
    """Return figures of the window or the run in progress as a message; None is skipped."""
    return encode_statuses(ns, [Status(name, OK, 'figures, not a verdict', figures)])
