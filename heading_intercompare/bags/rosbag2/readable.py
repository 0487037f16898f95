# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""What every recording offers to those who read it, whichever program wrote it."""

from __future__ import annotations

from pathlib import Path
from typing import Callable, Iterable, Iterator, Mapping, Protocol

from heading_intercompare.core.records import Headings, Losses

from .bag_reader import BagMessage, TopicInfo

__all__ = ['Readable']


class Readable(Protocol):
    """A recording with headings by topic; see `BagReader`, which is one."""

    path: Path
    topics: dict[str, TopicInfo]
    incomplete: str | None
    oddities: list[str]
    start_ns: int | None
    end_ns: int | None

    @property
    def recovered(self) -> str | None:
        """Return what was lost when it was recovered from a damaged one."""

    def resolve(self, topic: str) -> str:
        """Return the name of a topic given with or without a leading slash."""

    def headings(self, conventions: Mapping[str, str], helpers: int = 0,
                 lost: Callable[[str, str, Losses], None] | None = None,
                 ) -> Iterator[dict[str, Headings]]:
        """Return an iterator over the headings of some topics."""

    def keeps_numbers(self) -> bool:
        """Tell whether the numbers of the messages are those of their publishers."""

    def messages(self, topics: Iterable[str] | None = None) -> Iterator[BagMessage]:
        """Return an iterator over messages as they are stored."""

    def metadata(self) -> dict[str, dict[str, str]]:
        """Return the metadata records by name."""
