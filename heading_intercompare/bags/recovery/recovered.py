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

"""What a recovery kept and lost."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Iterable, Mapping

from heading_intercompare.bags.errors import decimal

_NOTES = 100
#: Counts that are added up when a recovered bag is recovered again.
_LOSSES = ('bytes_lost', 'chunks_lost', 'messages_lost')


@dataclass(slots=True)
class Recovered:
    """
    What a recovery kept and lost.

    Attributes
    ----------
    files, bytes
        Files read, and their size on disk.
    bytes_lost
        Bytes that could not be read or understood.
    chunks
        Chunks kept, whole or in part.
    chunks_lost
        Chunks lost, wholly or in part, as far as they are recognised as chunks.
    messages
        Messages kept.
    messages_lost
        Messages known to be lost: named by the index after a damaged chunk, counted by the
        summary of a closed file, or without a definition of their topic.
    messages_known
        No other messages of the files can be lost; messages that were never written do not count.
    messages_unproven
        Messages kept though the checksum of their chunk is wrong; only if that was asked for.
    counts
        Messages kept, by topic.
    notes : list of str
        What was wrong, and where; at most the first hundred.

    """

    files: int = 0
    bytes: int = 0
    bytes_lost: int = 0
    chunks: int = 0
    chunks_lost: int = 0
    messages: int = 0
    messages_lost: int = 0
    messages_known: bool = True
    messages_unproven: int = 0
    counts: dict[str, int] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)

    @property
    def damaged(self) -> bool:
        """Whether anything was wrong."""
        return bool(self.notes)

    def note(self, path: Path, text: str) -> None:
        """Note what was wrong with a file."""
        if len(self.notes) < _NOTES:
            self.notes.append(f'{path.name}: {text}')

    def count(self, topic: str, messages: int) -> None:
        """Add messages kept, or take some from them."""
        self.messages += messages
        self.counts[topic] = self.counts.get(topic, 0) + messages

    def describe(self, source: Path, earlier: Iterable[Mapping[str, str]]) -> dict[str, object]:
        """Return the metadata record `recovery`; it includes the losses of earlier recoveries."""
        losses = {name: getattr(self, name) for name in _LOSSES}
        unproven, exact = self.messages_unproven, self.messages_known
        notes: list[str] = []
        for before in earlier:
            for name in _LOSSES:
                losses[name] += decimal(before.get(name, '')) or 0
            unproven += decimal(before.get('messages_unproven', '')) or 0
            exact = exact and before.get('messages_lost_is') == 'all'
            notes += [text for name, text in before.items() if name.startswith('note.')]
        notes = (notes + self.notes)[:_NOTES]
        return {'source': source.name, 'files': self.files, 'bytes': self.bytes,
                'chunks': self.chunks, 'messages': self.messages, **losses,
                'messages_lost_is': 'all' if exact else 'at least',
                **({'messages_unproven': unproven} if unproven else {}),
                **{f'note.{n}': note for n, note in enumerate(notes, 1)}}
