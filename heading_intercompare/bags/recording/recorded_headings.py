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

"""All headings of a bag at once, with its marks and notes, for scripts and notebooks."""

from __future__ import annotations

from dataclasses import dataclass
import os
from typing import Iterator
import warnings

from heading_intercompare.bags.errors import BagError
from heading_intercompare.bags.rosbag2.bag_reader import BagReader
from heading_intercompare.bags.rosbag2.provenance import Note, read_notes
from heading_intercompare.bags.rosbag2.readable import Readable
from heading_intercompare.bags.rosbag2.topic_names import find_elsewhere
from heading_intercompare.core.records import Headings
from heading_intercompare.core.settings import Settings
from heading_intercompare.messages.status_messages import (
    decode_marks,
    MARKER_TOPIC,
    MARKS,
    STATUS_TYPE,
)

from .recorder_losses import RECORDING, tell_missing


@dataclass(frozen=True, slots=True)
class RecordedHeadings:
    """
    What a bag holds for an intercomparison.

    Attributes
    ----------
    ts, rs
        All readings of the two sensors, in the order of the bag.
    marks
        Marks of runs: 'start' or 'stop' and the stamp, nanoseconds; in the order of the bag.
    notes : tuple of Note
        Notes of the operator, with `stamp_ns` and `text`.
    problems
        What is missing from the recording, or odd, in words; empty if it is whole.

    """

    ts: Headings
    rs: Headings
    marks: tuple[tuple[str, int], ...]
    notes: tuple[Note, ...]
    problems: tuple[str, ...]

    def __repr__(self) -> str:
        """Return the numbers of headings."""
        return f'<RecordedHeadings: {len(self.ts)} of the TS, {len(self.rs)} of the RS>'


def read_bag(path: str | os.PathLike[str], settings: Settings | None = None) -> RecordedHeadings:
    """
    Read the headings of both sensors from a bag.

    Parameters
    ----------
    path
        ``.mcap`` file or rosbag2 directory.
    settings
        Only the topics of the headings, their conventions and `bag_namespace` are used; the
        defaults name the topics of this package. ``Settings.of(ts_topic='/gyro/imu')`` names
        others.

    Returns
    -------
    RecordedHeadings
        Stamps are those of the messages, unchecked. What is missing from the recording is in
        `problems`, and is issued as warnings.

    Raises
    ------
    OSError
        If the bag cannot be read.
    BagError
        If it is no bag, is damaged, or has no such topic; one line that names the topics it has.

    """
    rule = settings or Settings()
    reader = BagReader(path, rule.bag_namespace)
    topics = {rule.ts_topic: rule.ts_convention, rule.rs_topic: rule.rs_convention}
    chunks = list(reader.headings(topics))
    marks = tuple(read_marks(reader))
    problems = (*find_problems(reader), *reader.oddities)
    for problem in problems:
        warnings.warn(f'{reader.path}: {problem}', stacklevel=2)
    ts, rs = (Headings.concatenate([chunk[topic] for chunk in chunks])
              for topic in (rule.ts_topic, rule.rs_topic))
    return RecordedHeadings(ts, rs, marks, tuple(read_notes(reader)), problems)


def read_marks(reader: Readable) -> Iterator[tuple[str, int]]:
    """Yield the marks of a bag: 'start' or 'stop', and the stamp; BagError for another message."""
    topic = reader.find(MARKER_TOPIC)
    if others := find_elsewhere(reader.topics, MARKER_TOPIC, reader.namespace):
        reader.oddities.append(f'the marks of another graph ({", ".join(others)}) do not count; '
                               'bag_namespace names another')
    for message in [] if topic is None else reader.messages([topic]):
        try:
            if message.type_name != STATUS_TYPE:
                raise BagError(f'is {message.type_name}, must be {STATUS_TYPE}')
            marks = decode_marks(message.data)
            if wrong := [kind for kind, _ in marks if kind not in MARKS]:
                raise BagError(f"mark = {wrong[0]!r}: use 'start' or 'stop'")
        except ValueError as error:
            raise BagError(f'topic {message.topic!r}: {error}; --runs ignores all marks',
                           reader.path) from error
        yield from marks


def find_problems(reader: Readable) -> list[str]:
    """Return what is missing from a recording, in words; call it once all is read."""
    missing = tell_missing(reader.metadata().get(RECORDING, {}))
    return [why for why in (reader.incomplete, reader.recovered, missing) if why]
