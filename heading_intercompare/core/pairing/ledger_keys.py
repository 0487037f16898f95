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

"""The possible fates of a reading, and their counts in a part of a recording."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum
from typing import Mapping

from heading_intercompare.core.raw_streams.decimal_steps import DECIMAL_STEPS

__all__ = ['APART_DEG2', 'LedgerKey', 'LedgerSegment', 'LOSSES', 'REASONS']

REASONS = ('invalid', 'out_of_range', 'no_stamp', 'stamp_not_increasing', 'jump', 'burst')
"""Reasons to reject a reading before pairing; its driver rejects a `burst`."""

APART_DEG2 = 1e-9
"""Unit of the squared distances between values interpolated in two ways, square degrees."""

LOSSES = ('on_the_way', 'at_source', 'before_start')
"""
Where a reading was lost: from publisher to subscriber, before the driver read it, or because it
was published before the first one that was taken. The last kind lies in no run.
"""


class LedgerKey(str, Enum):
    """
    The possible fates of a reading; topics and bags use the same words.

    `PAIRED` counts pairs. Every other key counts readings of one sensor: in a pair without
    interpolation (`TS_PAIRED`), only used for interpolation (`TS_USED`), either (`RS_USED`),
    neither (`TS_UNPAIRED`, `RS_UNUSED`), repeating a value that a logger holds (`TS_HELD`,
    `RS_HELD`), undecided (`TS_PENDING`, `RS_PENDING`), rejected, or lost. Lost readings are not
    received. `TS_UNBRIDGED` and `RS_UNBRIDGED` also have no pair,
    because a few readings of the other sensor are missing there.

    Other keys: `STANDING` counts values that a logger held, `CHANGES` those of value compared by
    `raw_streams.sequence_match` and those that differ, `TS_STEP` and `RS_STEP` changes of value by
    the coarsest step of which they are multiples, hundredths of a degree. `GAPS` counts usual
    steps without a reading, `BRIDGED` pairs by the readings interpolated, `COMPARED` those
    compared with fewer readings. `STEP` sums up steps, microseconds, `APART` squared distances,
    units of `APART_DEG2`.
    """

    PAIRED = 'paired'
    TS_PAIRED = 'ts_paired'
    TS_USED = 'ts_used'
    TS_UNPAIRED = 'ts_unpaired'
    TS_UNBRIDGED = 'ts_unbridged'
    TS_HELD = 'ts_held'
    TS_PENDING = 'ts_pending'
    TS_INVALID = 'ts_rejected.invalid'
    TS_OUT_OF_RANGE = 'ts_rejected.out_of_range'
    TS_NO_STAMP = 'ts_rejected.no_stamp'
    TS_STAMP_NOT_INCREASING = 'ts_rejected.stamp_not_increasing'
    TS_JUMP = 'ts_rejected.jump'
    TS_BURST = 'ts_rejected.burst'
    TS_LOST_ON_THE_WAY = 'ts_lost.on_the_way'
    TS_LOST_AT_SOURCE = 'ts_lost.at_source'
    TS_LOST_BEFORE_START = 'ts_lost.before_start'
    RS_USED = 'rs_used'
    RS_UNUSED = 'rs_unused'
    RS_UNBRIDGED = 'rs_unbridged'
    RS_HELD = 'rs_held'
    RS_PENDING = 'rs_pending'
    RS_INVALID = 'rs_rejected.invalid'
    RS_OUT_OF_RANGE = 'rs_rejected.out_of_range'
    RS_NO_STAMP = 'rs_rejected.no_stamp'
    RS_STAMP_NOT_INCREASING = 'rs_rejected.stamp_not_increasing'
    RS_JUMP = 'rs_rejected.jump'
    RS_BURST = 'rs_rejected.burst'
    RS_LOST_ON_THE_WAY = 'rs_lost.on_the_way'
    RS_LOST_AT_SOURCE = 'rs_lost.at_source'
    RS_LOST_BEFORE_START = 'rs_lost.before_start'
    TS_STANDING = 'standing.ts'
    RS_STANDING = 'standing.rs'
    CHANGES_COMPARED = 'changes.compared'
    CHANGES_DIFFERING = 'changes.differing'
    TS_STEP_100 = 'step.ts.100'
    TS_STEP_50 = 'step.ts.50'
    TS_STEP_25 = 'step.ts.25'
    TS_STEP_20 = 'step.ts.20'
    TS_STEP_10 = 'step.ts.10'
    TS_STEP_5 = 'step.ts.5'
    TS_STEP_4 = 'step.ts.4'
    TS_STEP_2 = 'step.ts.2'
    TS_STEP_1 = 'step.ts.1'
    TS_STEP_0 = 'step.ts.0'
    RS_STEP_100 = 'step.rs.100'
    RS_STEP_50 = 'step.rs.50'
    RS_STEP_25 = 'step.rs.25'
    RS_STEP_20 = 'step.rs.20'
    RS_STEP_10 = 'step.rs.10'
    RS_STEP_5 = 'step.rs.5'
    RS_STEP_4 = 'step.rs.4'
    RS_STEP_2 = 'step.rs.2'
    RS_STEP_1 = 'step.rs.1'
    RS_STEP_0 = 'step.rs.0'
    TS_GAPS = 'gaps.ts'
    RS_GAPS = 'gaps.rs'
    BRIDGED_8 = 'bridged.8'
    BRIDGED_6 = 'bridged.6'
    BRIDGED_4 = 'bridged.4'
    BRIDGED_2 = 'bridged.2'
    STEP = 'bridged.step'
    COMPARED = 'compared'
    APART_6 = 'apart.6'
    APART_4 = 'apart.4'
    APART_2 = 'apart.2'

    def __str__(self) -> str:
        return self.value

    @classmethod
    def of_rejected(cls, stream: str, reason: str) -> 'LedgerKey':
        """
        Return the key of readings of ``'ts'`` or ``'rs'`` rejected for one of `REASONS`.

        Examples
        --------
        >>> print(LedgerKey.of_rejected('ts', 'no_stamp'))
        ts_rejected.no_stamp

        """
        return cls(f'{stream}_rejected.{reason}')

    @classmethod
    def of_pending(cls, stream: str) -> 'LedgerKey':
        """Return the key of readings of ``'ts'`` or ``'rs'`` that still wait for a partner."""
        return cls(f'{stream}_pending')

    @classmethod
    def of_held(cls, stream: str) -> 'LedgerKey':
        """Return the key of readings of ``'ts'`` or ``'rs'`` that only repeat a held value."""
        return cls(f'{stream}_held')

    @classmethod
    def of_standing(cls, stream: str) -> 'LedgerKey':
        """Return the key of the values of ``'ts'`` or ``'rs'`` that were held."""
        return cls(f'standing.{stream}')

    @classmethod
    def of_lost(cls, stream: str, where: str) -> 'LedgerKey':
        """Return the key of readings of ``'ts'`` or ``'rs'`` lost at one of `LOSSES`."""
        return cls(f'{stream}_lost.{where}')

    @classmethod
    def of_step(cls, stream: str, step: int) -> 'LedgerKey':
        """Return the key of changes of ``'ts'`` or ``'rs'`` by a step, hundredths of a degree."""
        return cls(f'step.{stream}.{step}')

    @classmethod
    def of_gaps(cls, stream: str) -> 'LedgerKey':
        """Return the key of the usual steps without a reading of ``'ts'`` or ``'rs'``."""
        return cls(f'gaps.{stream}')

    @classmethod
    def of_told(cls, stream: str, lost_as: str) -> 'LedgerKey':
        """Return the key of what the driver of a sensor tells, such as ``lost.at_source``."""
        return cls(f'{stream}_{lost_as}')

    def of_stream(self, stream: str) -> 'LedgerKey':
        """
        Return the key of the same fate of readings of ``'ts'`` or ``'rs'``.

        Examples
        --------
        >>> print(LedgerKey.TS_LOST_AT_SOURCE.of_stream('rs'))
        rs_lost.at_source

        """
        return LedgerKey(f'{stream}{self.value[2:]}')

    @property
    def stream(self) -> str:
        """Return the sensor of these readings, ``'ts'`` or ``'rs'``; '' for no readings."""
        return self.value[:2] if self.value[:3] in ('ts_', 'rs_') else ''

    @property
    def reason(self) -> str:
        """Reason of a rejection; '' for any other key."""
        return self.value.partition('_rejected.')[2]

    @property
    def lost(self) -> str:
        """Where these readings were lost; '' if they were received."""
        return self.value.partition('_lost.')[2]


@dataclass(frozen=True, slots=True)
class LedgerSegment:
    """
    Counts of the readings from one boundary to the next.

    Attributes
    ----------
    start_ns : int or None
        First stamp of the segment; None for the first segment, which has no beginning.
    counts : mapping of LedgerKey to int
        Pairs, and readings by fate. An absent key is 0.

    """

    start_ns: int | None
    counts: Mapping[LedgerKey, int] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Turn strings into keys."""
        object.__setattr__(self, 'counts', {LedgerKey(k): n for k, n in self.counts.items()})

    def received(self, stream: str) -> int:
        """Return how many readings of ``'ts'`` or ``'rs'`` came, whatever became of them."""
        return sum(n for key, n in self.counts.items() if key.stream == stream and not key.lost)

    def reported(self, stream: str) -> int:
        """Return how many of the readings that came do not only repeat a held value."""
        return self.received(stream) - self.counts.get(LedgerKey.of_held(stream), 0)

    def changes(self, stream: str) -> dict[int, int]:
        """Return the changes of value of ``'ts'`` or ``'rs'`` by step, see `StepCount`."""
        return {step: n for step in (*DECIMAL_STEPS, 0)
                if (n := self.counts.get(LedgerKey.of_step(stream, step)))}

    def times_held(self, stream: str) -> float | None:
        """Return for how many readings each held value stands; None if none was held."""
        n = self.counts.get(LedgerKey.of_held(stream), 0)
        values = self.counts.get(LedgerKey.of_standing(stream), 0)
        return 1.0 + n / max(1, values) if n else None

    def rejected(self, stream: str) -> dict[str, int]:
        """Return how many readings of ``'ts'`` or ``'rs'`` were rejected, by reason."""
        return {reason: n for reason in REASONS
                if (n := self.counts.get(LedgerKey.of_rejected(stream, reason)))}

    def lost(self, stream: str) -> dict[str, int]:
        """Return what of ``'ts'`` or ``'rs'`` was lost, by where: at the source datagrams."""
        return {where: n for where in LOSSES
                if (n := self.counts.get(LedgerKey.of_lost(stream, where)))}

    def lost_at_source(self, stream: str) -> int:
        """
        Return how many readings of ``'ts'`` or ``'rs'`` were lost at the source, at most.

        A driver tells datagrams, whatever they held. No more readings can be lost than the gaps of
        the stream have room for, beside those lost on the way.
        """
        lost = self.lost(stream)
        room = self.counts.get(LedgerKey.of_gaps(stream), 0) - lost.get('on_the_way', 0)
        return max(0, min(lost.get('at_source', 0), room))

    @property
    def unbridged(self) -> int:
        """Return how many readings have no pair for a gap of the other sensor around them."""
        return sum(self.counts.get(key, 0)
                   for key in (LedgerKey.TS_UNBRIDGED, LedgerKey.RS_UNBRIDGED))
