# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""
Ledger, marks and figures to diagnostic messages and back; every field is typed here.

Numbers are bare texts with the unit in the key, so that tools can plot them; integers stay
integers, reals are written so that they read back to the bit.
"""

from __future__ import annotations

from typing import Any, Iterable, Mapping

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue

from heading_intercompare.core.pairing.ledger import Ledger, LedgerSegment

from .message_stamps import stamp_ns, time_message

__all__ = ['ERROR', 'figures_message', 'ledger_from', 'ledger_message', 'marker_message',
           'MARKS', 'marks_from', 'OK', 'status', 'status_array', 'WARN']

OK, WARN, ERROR = DiagnosticStatus.OK, DiagnosticStatus.WARN, DiagnosticStatus.ERROR

MARKS = ('start', 'stop')

_SEGMENT = 'segment'


def _text(value: Any) -> str:
    if isinstance(value, bool):
        return 'true' if value else 'false'
    return repr(float(value)) if isinstance(value, float) else str(value)


def status(name: str, level: bytes, message: str,
           values: Mapping[str, Any] = {}) -> DiagnosticStatus:  # noqa: B006
    """Return one status; values that are None are left out."""
    return DiagnosticStatus(
        level=bytes(level), name=str(name), message=str(message),
        values=[KeyValue(key=str(k), value=_text(v)) for k, v in values.items() if v is not None])


def status_array(ns: int, statuses: Iterable[DiagnosticStatus]) -> DiagnosticArray:
    """Return statuses under a stamp, nanoseconds."""
    message = DiagnosticArray(status=list(statuses))
    message.header.stamp = time_message(ns)
    return message


def _values(one: DiagnosticStatus) -> dict[str, str]:
    return {pair.key: pair.value for pair in one.values}


def ledger_message(ledger: Ledger, final: bool = False) -> DiagnosticArray:
    """Return a ledger: its total, then its segments, stamped with the newest reading."""
    total = status('ledger', OK, 'final' if final else 'so far',
                   {'final': final, **ledger.total.counts})
    segments = [status(f'{_SEGMENT} {number}', OK, '', {'start_ns': s.start_ns, **s.counts})
                for number, s in enumerate(ledger.segments)]
    return status_array(ledger.newest_ns or 0, [total, *segments])


def ledger_from(message: DiagnosticArray) -> tuple[Ledger, bool]:
    """Return the ledger of a message of `ledger_message`, and whether it is the final one."""
    segments, final = [], False
    for one in message.status:
        values = _values(one)
        final = final or values.pop('final', '') == 'true'
        if one.name.startswith(_SEGMENT):
            start_ns = values.pop('start_ns', None)
            segments.append(LedgerSegment(None if start_ns is None else int(start_ns),
                                          {key: int(n) for key, n in values.items()}))
    return Ledger.from_segments(segments, stamp_ns(message.header.stamp) or None), final


def marker_message(kind: str, ns: int) -> DiagnosticArray:
    """Return a mark, 'start' or 'stop', stamped with the newest pair."""
    return status_array(ns, [status('marker', OK, kind)])


def marks_from(message: DiagnosticArray) -> list[tuple[str, int]]:
    """Return kind and stamp of the marks in a message."""
    ns = stamp_ns(message.header.stamp)
    return [(one.message, ns) for one in message.status]


def figures_message(name: str, figures: Mapping[str, Any], ns: int) -> DiagnosticArray:
    """Return figures of the window or of the run in progress; absent ones are left out."""
    return status_array(ns, [status(name, OK, 'figures, not a verdict', figures)])
