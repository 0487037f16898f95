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
The states of the parts of a graph, as its nodes say them on /diagnostics.

A recording keeps a message if it says something new, and otherwise one per period. At the end it
says the last state of each part in a metadata record.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Mapping, NamedTuple, TYPE_CHECKING

from heading_intercompare.core.utc_text import utc
from heading_intercompare.messages.errors import MessageError
from heading_intercompare.messages.status_messages import (
    decode_statuses,
    LEVELS,
    Status,
    STATUS_TYPE,
)

if TYPE_CHECKING:
    from heading_intercompare.bags.rosbag2.bag_reader import BagReader


DIAGNOSTICS_TOPIC = '/diagnostics'

STATES = 'diagnostics'
"""The metadata record with the last state of each part."""

#: How far from its end a bag without that record is read, nanoseconds.
_LAST_NS = 60_000_000_000
#: More parts than this are those of other programs.
_MOST = 1000
#: Letters kept of a name and of words.
_LONGEST = 500
_WORDS = {level: word.upper() for word, level in LEVELS.items()}


class _LastState(NamedTuple):
    """A state, when it was last heard, and when a message with it was last kept."""

    level: int
    message: str
    heard_ns: int
    kept_ns: int


class PartStates:
    """
    The last state of each part, and which messages are worth keeping.

    Parameters
    ----------
    period_s
        A message that says nothing new is kept if the last one kept is this old, seconds.
        0 if none are to be kept at all.

    Attributes
    ----------
    kept : bool
        Whether messages are to be kept.
    cut
        Parts of whose name or words only the first 500 letters were ever kept.

    """

    def __init__(self, period_s: float = 0.0) -> None:
        self._period_ns, self.kept = round(period_s * 1e9), period_s > 0.0
        self._parts: dict[str, _LastState] = {}
        self._cut: set[str] = set()

    @property
    def cut(self) -> int:
        """Return the number of parts with a name or words that were cut."""
        return len(self._cut)

    def take(self, data: bytes, now_ns: int) -> bool:
        """
        Take a message that came at a time; tell whether to keep it.

        A message is kept if a part in it is new, changed its level or its words, or was not kept
        for a period; and if it cannot be read.
        """
        try:
            _, statuses = decode_statuses(data)
        except MessageError:
            return True
        cut = {status.name[:_LONGEST] for status in statuses
               if max(len(status.name), len(status.message)) > _LONGEST}
        statuses = [replace(status, name=status.name[:_LONGEST], message=status.message[:_LONGEST])
                    for status in statuses]
        keep = any(self._is_due(status, now_ns) for status in statuses)
        for status in statuses:
            before = self._parts.get(status.name)
            if before is None and len(self._parts) >= _MOST:
                continue
            kept_ns = now_ns if keep or before is None else before.kept_ns
            self._parts[status.name] = _LastState(status.level, status.message, now_ns, kept_ns)
        self._cut |= cut & self._parts.keys()
        return keep

    def _is_due(self, status: Status, now_ns: int) -> bool:
        before = self._parts.get(status.name)
        return (before is None or (before.level, before.message) != (status.level, status.message)
                or now_ns - before.kept_ns >= self._period_ns)

    def record(self) -> dict[str, str]:
        """Return the last state of each part in words, with the time at which it was said."""
        return {name: f'{utc(state.heard_ns)} UTC  {_WORDS.get(state.level, "STALE"):5}  '
                      f'{" ".join(state.message.split())}'
                for name, state in sorted(self._parts.items())}


def read_states(bag: BagReader) -> Mapping[str, str]:
    """
    Return the last state of each part in a bag, in words.

    It is in a metadata record. Where the recorder was killed before it wrote that, the states are
    those of the last minute.

    Raises
    ------
    OSError, BagError
        If the bag cannot be read.

    """
    record = bag.metadata().get(STATES)
    if record is not None:
        return record
    info = bag.topics.get(DIAGNOSTICS_TOPIC)
    states = PartStates()
    if info is not None and info.count and info.type_name == STATUS_TYPE:
        for message in bag.messages([DIAGNOSTICS_TOPIC], (bag.end_ns or 0) - _LAST_NS):
            states.take(message.data, message.log_time_ns)
    return states.record()
