# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""How many headings were published, as the synchronizer counts them in its ledgers."""

from __future__ import annotations

from heading_intercompare.core.pairing.ledger import LedgerKey
from heading_intercompare.messages.errors import MessageError
from heading_intercompare.messages.ledger_messages import decode_ledger

__all__ = ['PublishedHeadings']


class PublishedHeadings:
    """
    Counts the published headings of each sensor.

    A recorder that missed the last headings cannot know it from their numbers. The synchronizer
    received them, and each of its ledgers says so.
    """

    def __init__(self) -> None:
        self._newest: dict[int, dict[str, int]] = {}

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

    def count(self, stream: str) -> int:
        """Return how many headings of ``'ts'`` or ``'rs'`` all synchronizers have counted."""
        return sum(counts[stream] for counts in self._newest.values())
