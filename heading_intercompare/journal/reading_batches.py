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

"""The readings that a synchronizer took at once, as bytes of a journal and back, to the bit."""

from __future__ import annotations

from dataclasses import dataclass
import struct
from typing import Any, Mapping, NamedTuple, Sequence

from heading_intercompare.core.pairing.incarnations import StreamNumbers
from heading_intercompare.core.pairing.ledger import LedgerKey
from heading_intercompare.core.pairing.names import Span
from heading_intercompare.core.pairing.pair_maker import PairMaker
from heading_intercompare.core.pairing.pairer import Pairer
from heading_intercompare.core.records import Headings, Losses, Pairs
from heading_intercompare.core.sensors.pair_names import Names, TWO

from .journal_file import decode_columns, encode_columns, join_parts, split_parts

_NOW, _STREAM = struct.Struct('<d'), struct.Struct('<IqI')


class LastHeard(NamedTuple):
    """The numbers of the readings of one sensor so far, and when the newest was sent, UTC ns."""

    numbers: StreamNumbers
    sent_ns: int


@dataclass(frozen=True, slots=True)
class Batch:
    """
    What a node that pairs took at once.

    Attributes
    ----------
    headings
        Readings by sensor; two sensors are ``'ts'`` and ``'rs'``.
    losses
        Readings that never came: the sensor, their fate as one of `LOST_AS`, and the gaps.
    now_s
        The clock by which readings wait, seconds.
    heard
        The numbers of the readings so far, by sensor.

    """

    headings: Mapping[str, Headings]
    losses: Sequence[tuple[str, str, Losses]]
    now_s: float
    heard: Mapping[str, LastHeard]


def encode_batch(batch: Batch, before: Mapping[str, LastHeard],
                 streams: Sequence[str]) -> bytes:
    """
    Return a batch as bytes.

    Parameters
    ----------
    batch
        The batch.
    before
        What was heard before: most numbers follow those.
    streams
        The sensors of the journal, in their order.

    """
    if not (any(map(len, batch.headings.values())) or batch.losses or batch.heard != before):
        return _NOW.pack(batch.now_s)
    steps = {stream: batch.heard[stream].numbers.last - before[stream].numbers.last
             if stream in before else 0 for stream in streams}
    details: dict[str, Any] = {}
    if changed := {stream: batch.heard[stream].numbers for stream in streams
                   if stream not in before or steps[stream] < 0 or batch.heard[stream].numbers
                   != _go_on(before[stream].numbers, steps[stream])}:
        details['heard'] = changed
    if batch.losses:
        details['lost'] = [(stream, lost_as, losses.stamp_ns.tolist(), losses.since_ns.tolist(),
                            losses.count.tolist()) for stream, lost_as, losses in batch.losses]
    parts = []
    for stream in streams:
        columns = encode_columns(batch.headings[stream])
        step = 0 if stream in changed else steps[stream]
        parts += [_STREAM.pack(step, batch.heard[stream].sent_ns, len(columns)), columns]
    return _NOW.pack(batch.now_s) + join_parts(details, b''.join(parts))


def decode_batch(data: bytes, before: Mapping[str, LastHeard], streams: Sequence[str]) -> Batch:
    """
    Return the batch in bytes of `encode_batch`.

    Parameters
    ----------
    data
        The bytes.
    before
        What was heard before.
    streams
        The sensors of the journal, in their order.

    Raises
    ------
    BagError, ValueError, KeyError, TypeError, struct.error
        If the bytes are wrong.

    """
    now_s, = _NOW.unpack_from(data)
    if len(data) == _NOW.size:
        return Batch(dict.fromkeys(streams, Headings.empty()), (), now_s, before)
    details, columns = split_parts(data[_NOW.size:])
    changed = {stream: decode_numbers(plain) for stream, plain in details.get('heard', {}).items()}
    headings, heard, at = {}, {}, 0
    for stream in streams:
        step, sent_ns, size = _STREAM.unpack_from(columns, at)
        at += _STREAM.size + size
        headings[stream] = decode_columns(columns[at - size:at], Headings)
        heard[stream] = LastHeard(changed.get(stream) or _go_on(before[stream].numbers, step),
                                  sent_ns)
    return Batch(headings, tuple((stream, lost_as, Losses.of(*gaps)) for stream, lost_as, *gaps
                                 in details.get('lost', ())), now_s, heard)


def count_losses(pairer: Pairer, losses: Sequence[tuple[str, str, Losses]],
                 names: Names = TWO) -> None:
    """Count the readings of two sensors that never came; see `Batch.losses`."""
    for name, lost_as, gaps in losses:
        if name in names:
            pairer.lose(LedgerKey.of_told('ts' if name == names[0] else 'rs', lost_as), gaps)


def pair_batch(pairer: Pairer, batch: Batch, names: Names = TWO) -> Pairs:
    """Return the pairs of two sensors that a batch completes, with their losses counted."""
    count_losses(pairer, batch.losses, names)
    first, second = (batch.headings[name] for name in names)
    return pairer.update(first, second, batch.now_s)


def choose_pairs(maker: PairMaker, batch: Batch, names: Names, *, end: bool = False) -> Pairs:
    """
    Return the pairs of two sensors that a batch completes and that are to be judged.

    With `end` no batch follows: what waits for further readings is paired without these.
    """
    pairs = pair_batch(maker.pairer, batch, names)
    return maker.choose(pairs + maker.pairer.flush() if end else pairs, end)


def decode_numbers(plain: Sequence[Any]) -> StreamNumbers:
    """Return the numbers of the readings of a sensor from their form in JSON."""
    *fields, spans = plain
    return StreamNumbers(*fields)._replace(spans=tuple(Span(*span) for span in spans))


def _go_on(numbers: StreamNumbers, step: int) -> StreamNumbers:
    """Return the numbers after further readings of the newest publisher."""
    *spans, newest = numbers.spans or (None,)
    if newest is not None:
        spans.append(newest._replace(last=newest.last + step))
    return numbers._replace(last=numbers.last + step, spans=tuple(filter(None, spans)))
