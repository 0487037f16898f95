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
The ledger of a pairing, and what a source lost of its readings, to messages and back.

A driver, or a replayer in its place, says on a topic of its own what the numbers of the headings
cannot show: the readings that it never published.
"""

from __future__ import annotations

from typing import Iterator, Mapping, NamedTuple

from heading_intercompare.core.pairing.incarnations import StreamNumbers
from heading_intercompare.core.pairing.ledger import Ledger, LedgerKey, LedgerSegment
from heading_intercompare.core.pairing.names import Span
from heading_intercompare.core.raw_streams.stamp_jumps import SetBack
from heading_intercompare.core.records import Losses

from .errors import MessageError
from .status_messages import decode_statuses, encode_statuses, OK, Status, WARN

LOST_AS = ('lost.on_the_way', 'lost.at_source', 'lost.before_start', 'rejected.burst',
           'rejected.repeated', 'rejected.old_number')
"""What may have become of the readings: the keys of the ledger without the sensor."""

_FIGURES = ('stamp_ns', 'since_ns', 'count')
_MOST = 2**63

_SEGMENT, _SET_BACK = 'segment', 'clock set back'


class LedgerMessage(NamedTuple):
    """
    A ledger, and what its synchronizer says beside it.

    Attributes
    ----------
    final
        It is the last one.
    started_ns
        When the synchronizer was started, UTC ns.
    numbers
        The numbers of the headings that it took, by sensor.

    """

    ledger: Ledger
    final: bool
    started_ns: int
    numbers: Mapping[str, StreamNumbers] = {}


def encode_ledger(ledger: Ledger, final: bool = False, started_ns: int = 0,
                  numbers: Mapping[str, StreamNumbers] | None = None, owner: str = '') -> bytes:
    """Return a ledger as a message: total, segments, clocks that were set back; newest stamp."""
    total = Status('ledger', OK, 'final' if final else 'so far',
                   {'incarnation_ns': started_ns or None, 'final': final, **_words(ledger.total),
                    **{f'{stream}_{name}': value for stream, fields in (numbers or {}).items()
                       for name, value in _number_words(fields).items()}})
    segments = [Status(f'{_SEGMENT} {number}', OK, '', {
        'start_ns': s.start_ns, 'clock_segment': s.clock_segment, **_words(s)})
                for number, s in enumerate(ledger.segments)]
    set_backs = [Status(f'{_SET_BACK} {number}', WARN, '', {
        'stream': step.stream, 'stamp_ns': step.stamp_ns, 'size_ns': step.size_ns,
        'clock_segment': step.clock_segment or None})
        for number, step in enumerate(ledger.all_set_backs)]
    return encode_statuses(ledger.newest_ns or 0, [total, *segments, *set_backs], owner)


def _number_words(numbers: StreamNumbers) -> dict[str, str | int]:
    """Return the numbers of a sensor by name; each span as publisher, first and last number."""
    spans = ' '.join(f'{span.publisher}:{span.first}:{span.last}' for span in numbers.spans)
    return {**numbers._asdict(), 'spans': spans}


def _spans(text: str) -> tuple[Span, ...]:
    """Return the spans in a text of `_number_words`."""
    spans = []
    for word in text.split():
        publisher, first, last = word.rsplit(':', 2) if word.count(':') > 1 else (word, '', '')
        spans.append(Span(publisher, _integer('ledger', 'spans', first),
                          _integer('ledger', 'spans', last)))
    return tuple(spans)


def _words(segment: LedgerSegment) -> dict[str, int]:
    return {key.value: n for key, n in segment.counts.items()}


def _integer(topic: str, key: str, text: str) -> int:
    try:
        value = int(text)
    except ValueError:
        value = _MOST
    if not -_MOST < value < _MOST:
        raise MessageError(f'{topic}: {key} = {text[:40]!r} must be an integer of 64 bits')
    return value


def _key(word: str) -> LedgerKey:
    try:
        return LedgerKey(word)
    except ValueError:
        raise MessageError(f'ledger: {word[:40]!r} is not a key of a ledger') from None


def _set_back(values: Mapping[str, str]) -> SetBack:
    stream = values.get('stream', '')
    if stream not in ('ts', 'rs'):
        raise MessageError(f"ledger: stream = {stream[:40]!r} must be 'ts' or 'rs'")
    stamp_ns, size_ns = (_integer('ledger', key, values.get(key, ''))
                         for key in ('stamp_ns', 'size_ns'))
    return SetBack(stream, stamp_ns, size_ns,
                   _integer('ledger', 'clock_segment', values.get('clock_segment', '0')))


def _numbers(values: Mapping[str, str]) -> dict[str, StreamNumbers]:
    """Return the numbers in the values of a status, by sensor; only sensors that have them."""
    numbers = {}
    for stream in ('ts', 'rs'):
        texts = [values.get(f'{stream}_{name}') for name in StreamNumbers._fields]
        if None not in texts:
            first_publisher, first, last_publisher, last, spans = (str(text) for text in texts)
            numbers[stream] = StreamNumbers(
                first_publisher, _integer('ledger', f'{stream}_first', first),
                last_publisher, _integer('ledger', f'{stream}_last', last), _spans(spans))
    return numbers


def decode_ledger(data: bytes) -> LedgerMessage:
    """
    Return the ledger in a message of `encode_ledger`.

    Raises
    ------
    MessageError
        If the message is damaged, if a count is not a number or has an unknown key, or if a later
        segment has no start.

    """
    newest_ns, statuses = decode_statuses(data)
    segments, set_backs, final, started_ns = [], [], False, 0
    numbers: dict[str, StreamNumbers] = {}
    for status in statuses:
        values = dict(status.values)
        final = final or values.pop('final', '') == 'true'
        started_ns = _integer('ledger', 'incarnation_ns',
                              values.pop('incarnation_ns', str(started_ns)))
        numbers |= _numbers(values)
        if status.name.startswith(_SEGMENT):
            counts = {key: _integer('ledger', key, text) for key, text in values.items()}
            start_ns = counts.pop('start_ns', None)
            clock_segment = counts.pop('clock_segment', None)
            segments.append(LedgerSegment(
                start_ns, {_key(word): n for word, n in counts.items()},
                clock_segment=clock_segment))
        elif status.name.startswith(_SET_BACK):
            set_backs.append(_set_back(values))
    if any(segment.start_ns is None and segment.clock_segment == before.clock_segment
           for before, segment in zip(segments, segments[1:])):
        raise MessageError('ledger: a segment after the first has no start_ns')
    numbers_of_clock = [segment.clock_segment or 0 for segment in segments]
    if numbers_of_clock != sorted(numbers_of_clock) or not (
            0 <= max(numbers_of_clock, default=0) <= len(segments)):
        raise MessageError('ledger: the clock segments are not in order')
    ledger = Ledger.from_segments(segments, newest_ns or None, set_backs)
    return LedgerMessage(ledger, final, started_ns, numbers)


def lost_topic(heading_topic: str) -> str:
    """Return the topic of the losses beside a topic of headings."""
    return f'{heading_topic}/lost'


def encode_losses(losses_by_cause: Mapping[str, Losses]) -> bytes:
    """Return losses, by one of `LOST_AS`, as a message with the stamp of the newest."""
    statuses = list(_statuses(losses_by_cause))
    newest_ns = max((status.values['stamp_ns'] for status in statuses), default=0)
    return encode_statuses(newest_ns, statuses)


def _statuses(losses_by_cause: Mapping[str, Losses]) -> Iterator[Status]:
    for lost_as, losses in losses_by_cause.items():
        columns = (getattr(losses, name).tolist() for name in _FIGURES)
        for row in zip(*columns):
            yield Status(lost_as, OK, '', dict(zip(_FIGURES, row)))


def decode_losses(data: bytes) -> dict[str, Losses]:
    """
    Return the losses in a message of `encode_losses`.

    Raises
    ------
    MessageError
        If the message is damaged, or a figure is absent or no integer.

    """
    _, statuses = decode_statuses(data)
    rows: dict[str, list[list[int]]] = {}
    for status in statuses:
        if status.name not in LOST_AS:
            raise MessageError(f'losses: {status.name[:40]!r} must be one of {", ".join(LOST_AS)}')
        rows.setdefault(status.name, []).append([
            _integer('losses', name, status.values.get(name, '')) for name in _FIGURES])
    return {lost_as: Losses.of(*zip(*of)) for lost_as, of in rows.items()}
