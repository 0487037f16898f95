# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The ledger of a pairing, to a message and back."""

from __future__ import annotations

from typing import Mapping

from heading_intercompare.core.pairing.ledger import Ledger, LedgerKey, LedgerSegment
from heading_intercompare.core.pairing.stamp_jumps import SetBack

from .errors import MessageError
from .status_messages import decode_statuses, encode_statuses, OK, Status, WARN

__all__ = ['decode_ledger', 'encode_ledger']

_SEGMENT, _SET_BACK = 'segment', 'clock set back'


def encode_ledger(ledger: Ledger, final: bool = False) -> bytes:
    """Return a ledger as a message: total, segments, clocks that were set back; newest stamp."""
    total = Status('ledger', OK, 'final' if final else 'so far',
                   {'final': final, **_words(ledger.total)})
    segments = [Status(f'{_SEGMENT} {number}', OK, '', {'start_ns': s.start_ns, **_words(s)})
                for number, s in enumerate(ledger.segments)]
    set_backs = [Status(f'{_SET_BACK} {number}', WARN, '', {
        'stream': one.stream, 'stamp_ns': one.stamp_ns, 'size_ns': one.size_ns})
        for number, one in enumerate(step for steps in ledger.set_backs.values()
                                     for step in steps)]
    return encode_statuses(ledger.newest_ns or 0, [total, *segments, *set_backs])


def _words(segment: LedgerSegment) -> dict[str, int]:
    return {key.value: n for key, n in segment.counts.items()}


def _integer(key: str, text: str) -> int:
    try:
        return int(text)
    except ValueError:
        raise MessageError(f'ledger: {key} = {text[:40]!r} must be an integer') from None


def _key(word: str) -> LedgerKey:
    try:
        return LedgerKey(word)
    except ValueError:
        raise MessageError(f'ledger: {word[:40]!r} is not a key of a ledger') from None


def _set_back(values: Mapping[str, str]) -> SetBack:
    stream = values.get('stream', '')
    if stream not in ('ts', 'rs'):
        raise MessageError(f"ledger: stream = {stream[:40]!r} must be 'ts' or 'rs'")
    stamp_ns, size_ns = (_integer(key, values.get(key, '')) for key in ('stamp_ns', 'size_ns'))
    return SetBack(stream, stamp_ns, size_ns)


def decode_ledger(data: bytes) -> tuple[Ledger, bool]:
    """
    Return the ledger in a message of `encode_ledger`, and whether it is the final one.

    Raises
    ------
    MessageError
        If the message is damaged, if a count is not a number or has an unknown key, or if a later
        segment has no start.

    """
    newest_ns, statuses = decode_statuses(data)
    segments, set_backs, final = [], [], False
    for one in statuses:
        values = dict(one.values)
        final = final or values.pop('final', '') == 'true'
        if one.name.startswith(_SEGMENT):
            counts = {key: _integer(key, text) for key, text in values.items()}
            start_ns = counts.pop('start_ns', None)
            segments.append(LedgerSegment(
                start_ns, {_key(word): n for word, n in counts.items()}))
        elif one.name.startswith(_SET_BACK):
            set_backs.append(_set_back(values))
    if any(segment.start_ns is None for segment in segments[1:]):
        raise MessageError('ledger: a segment after the first has no start_ns')
    return Ledger.from_segments(segments, newest_ns or None, set_backs), final
