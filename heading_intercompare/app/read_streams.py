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

"""What was read of one or two streams of a recording, before anything is judged."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import Mapping, Sequence

from heading_intercompare.bags.rosbag2.readable import Readable
from heading_intercompare.core.pairing.pairer import Pairer
from heading_intercompare.core.records import Headings, Losses, Pairs
from heading_intercompare.core.settings import Settings
from heading_intercompare.readers.stream_recording import StreamRecording


@dataclass(frozen=True, slots=True)
class StreamReadings:
    """
    The readings of one or two streams.

    Attributes
    ----------
    streams
        By name: that of the TS first.
    pairs
        Their pairs; none of a single stream.
    not_taken
        What gave no pair, by reason: lines of the file, and readings that are rejected or lost.

    """

    streams: Mapping[str, Headings]
    pairs: Pairs
    not_taken: Mapping[str, int]


def read_streams(reader: Readable, names: Sequence[str]) -> StreamReadings:
    """
    Read and pair the streams of a recording.

    Parameters
    ----------
    reader
        The recording.
    names
        One or two topics, streams or columns: that of the TS first.

    Raises
    ------
    OSError
        If it cannot be read.
    ValueError
        If it is damaged, or has no such stream.

    """
    not_taken = Counter[str]()

    def lose(name: str, lost_as: str, losses: Losses) -> None:
        not_taken[f'{name}: {lost_as}'] += int(losses.count.sum())
    chunks = [*reader.headings(dict.fromkeys(names, 'enu'), 0, lose)]
    streams = {name: Headings.concatenate(chunk[name] for chunk in chunks) for name in names}
    if isinstance(reader, StreamRecording):
        not_taken.update({f'file: {why}': n for why, n in reader.not_taken.items()})
    settings, pairs = Settings(), Pairs.empty()
    if len(names) == 2:
        pairer = Pairer(settings)
        ts, rs = streams.values()
        pairs = Pairs.concatenate([pairer.update(ts, rs), pairer.flush()])
        for role, name in zip(('ts', 'rs'), names):
            not_taken.update({f'{name}: {why}': n for why, n in
                              pairer.ledger.total.rejected(role).items()})
    return StreamReadings(streams, pairs, +not_taken)
