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

"""How many headings were published, and which were judged, as the ledgers tell it."""

from __future__ import annotations

from heading_intercompare.core.pairing.ledger_keys import LedgerKey
from heading_intercompare.messages.errors import MessageError
from heading_intercompare.messages.ledger_messages import decode_ledger

__all__ = ['PublishedHeadings']


class PublishedHeadings:
    """
    Counts the published headings of each sensor, and says which ones were judged.

    A recorder that missed the last headings cannot know it from their numbers. The synchronizer
    received them, and each of its ledgers says so. Publishers that go on when the synchronizer has
    ended send headings that nobody judges.
    """

    def __init__(self) -> None:
        self._newest: dict[int, dict[str, int]] = {}
        self._spans: dict[str, tuple[int | None, int | None]] = {}

    def take(self, message: bytes) -> None:
        """Take a message of ``pairs/ledger``; a damaged one says nothing."""
        try:
            newest = decode_ledger(message)
        except MessageError:
            return
        total = newest.ledger.total
        self._newest[newest.started_ns] = {
            stream: (total.received(stream)
                     - total.counts.get(LedgerKey.of_rejected(stream, 'burst'), 0)
                     + total.counts.get(LedgerKey.of_lost(stream, 'on_the_way'), 0))
            for stream in ('ts', 'rs')}
        if newest.started_ns == max(self._newest):
            self._spans = {
                stream: (numbers.first or None, numbers.last or None if newest.final else None)
                for stream, numbers in newest.numbers.items()}

    def find_span(self, stream: str) -> tuple[int | None, int | None]:
        """
        Return the numbers of the first and the last heading that the newest synchronizer took.

        None for the first one before there is one, for the last one before its end.
        """
        return self._spans.get(stream, (None, None))

    def count(self, stream: str) -> int:
        """Return how many headings of ``'ts'`` or ``'rs'`` all synchronizers have counted."""
        return sum(counts[stream] for counts in self._newest.values())
