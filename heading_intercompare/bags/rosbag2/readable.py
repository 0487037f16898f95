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

"""What every recording offers to those who read it, whichever program wrote it."""

from __future__ import annotations

from pathlib import Path
from typing import (
    Callable,
    Iterable,
    Iterator,
    Mapping,
    Protocol,
    Sequence,
    TYPE_CHECKING,
    TypeVar,
)

from heading_intercompare.core.records import Headings, Losses, Quality

if TYPE_CHECKING:
    # Live nodes read no bag, and need nothing that reads one.
    from .bag_reader import BagMessage, Payloads, TopicInfo

_BATCH = 20_000
_Chunk = TypeVar('_Chunk')


class Readable(Protocol):
    """A recording with headings by topic; see `BagReader`, which is one."""

    path: Path
    topics: dict[str, TopicInfo]
    incomplete: str | None
    oddities: list[str]
    start_ns: int | None
    end_ns: int | None

    @property
    def namespace(self) -> str:
        """Return where topics without a leading slash are; '' for the root."""

    @property
    def recovered(self) -> str | None:
        """Return what was lost when it was recovered from a damaged one."""

    def find(self, topic: str) -> str | None:
        """Return the name of a topic within the namespace; None if there is none."""

    def resolve(self, topic: str) -> str:
        """Return the name of a topic, within the namespace; an error if there is none."""

    def headings(self, conventions: Mapping[str, str], helpers: int = 0,
                 lost: Callable[[str, str, Losses], None] | None = None,
                 claimed: Mapping[str, Callable[[Quality], None]] | None = None,
                 ) -> Iterator[dict[str, Headings]]:
        """Return an iterator over the headings of some topics."""

    def tells_claims(self, conventions: Mapping[str, str]) -> bool:
        """Tell whether `headings` of these topics tells their claims, if it is asked to."""

    def keeps_numbers(self) -> bool:
        """Tell whether the numbers of the messages are those of their publishers."""

    def messages(self, topics: Iterable[str] | None = None) -> Iterator[BagMessage]:
        """Return an iterator over messages as they are stored."""

    def payloads(self, topic: str) -> Iterator[Payloads]:
        """Return an iterator over the messages of a topic, many at once."""

    def metadata(self) -> dict[str, dict[str, str]]:
        """Return the metadata records by name."""


def read_rows(bag: Readable, readers: Mapping[str, Sequence[
        Callable[[list[bytes]], tuple[_Chunk, list[str]]]]]) -> tuple[list[_Chunk], int]:
    """
    Read the messages of some topics in batches.

    Parameters
    ----------
    bag
        The recording.
    readers
        By topic, each returns the rows in some messages, and what is wrong with the others.

    Returns
    -------
    chunks : list
        The rows, batch by batch.
    unreadable : int
        Messages that could not be read.

    """
    chunks: list[_Chunk] = []
    unreadable = 0
    waiting: dict[str, list[bytes]] = {name: [] for name in readers}

    def take(name: str) -> int:
        problems: list[str] = []
        for read in readers[name]:
            rows, problems = read(waiting[name])
            chunks.append(rows)
        waiting[name] = []
        return len(problems)
    for message in bag.messages(readers) if readers else ():
        waiting[message.topic].append(message.data)
        if len(waiting[message.topic]) >= _BATCH:
            unreadable += take(message.topic)
    unreadable += sum(take(name) for name in readers)
    return chunks, unreadable
