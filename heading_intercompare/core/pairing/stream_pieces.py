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

"""Whole streams, cut into pieces of one time, so that pairing them takes little memory."""

from __future__ import annotations

from typing import Iterator, Mapping, Sequence

import numpy as np

from heading_intercompare.core.records import Headings, Integers

#: Headings paired and judged at once: enough that calls cost little, few enough for the cache.
_AT_ONCE = 1 << 15
#: Below the least `pairing.jump_s`: readings that are late by less do not show a clock set back.
_LONGEST_BACK_NS = 10 ** 8


def cut_streams(streams: Mapping[str, Headings],
                late_ns: Mapping[str, int] | None = None) -> Iterator[Mapping[str, Headings]]:
    """
    Yield the readings of streams piece by piece, each stream in its order.

    Parameters
    ----------
    streams
        By the names of their sensors. If stamps step back by more than a tenth of a second, they
        are one piece: the pairer divides that as it came.
    late_ns
        What is subtracted from the stamps of a sensor to compare its clock, nanoseconds.

    Examples
    --------
    >>> stamps = 10 ** 18 + np.arange(60_000)
    >>> streams = {name: Headings.of(stamps, stamps % 360) for name in ('ts', 'rs')}
    >>> [(len(piece['ts']), len(piece['rs'])) for piece in cut_streams(streams)]
    [(16384, 16384), (16384, 16384), (16384, 16384), (10848, 10848)]

    """
    if sum(map(len, streams.values())) <= 2 * _AT_ONCE or any(
            _steps_back(headings.stamp_ns) for headings in streams.values()):
        yield streams
        return
    times = {name: follow_stamps(headings.stamp_ns) for name, headings in streams.items()}
    for name, shift_ns in (late_ns or {}).items():
        times[name] = times[name] - shift_ns
    edges = find_edges([*times.values()], _AT_ONCE)
    for begin_ns, end_ns in zip(edges[:-1], edges[1:]):
        yield {name: headings[slice(*np.searchsorted(times[name], (begin_ns, end_ns)).tolist())]
               for name, headings in streams.items()}


def _steps_back(stamp_ns: Integers) -> bool:
    return bool((stamp_ns[1:] < stamp_ns[:-1] - _LONGEST_BACK_NS).any())


def follow_stamps(stamp_ns: Integers) -> Integers:
    """Return the largest stamp so far: it keeps a stream in order if stamps step back."""
    if (stamp_ns[1:] >= stamp_ns[:-1]).all():
        return stamp_ns
    largest_ns: Integers = np.maximum.accumulate(stamp_ns)
    return largest_ns


def find_edges(times_ns: Sequence[Integers], n: int) -> list[int]:
    """Return the bounds of pieces of some `n` rows of streams; there must be a row."""
    joined_ns = np.concatenate(times_ns)
    joined_ns.sort()
    return [*np.unique(joined_ns[::n]).tolist(), int(joined_ns[-1]) + 1]
