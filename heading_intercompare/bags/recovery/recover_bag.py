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
The copy of everything readable in a damaged bag into a new one, and the count of losses.

Each file is read twice. The first pass finds the intact records and the topics, which may be
defined after their messages. The second pass copies, and decompresses no chunk that it can copy
unchanged.
"""

from __future__ import annotations

from contextlib import ExitStack
from dataclasses import dataclass, field
import os
from pathlib import Path
from typing import Callable

from heading_intercompare.bags.errors import BagError, decimal
from heading_intercompare.bags.mcap.chunk_writer import COMPRESSIONS
from heading_intercompare.bags.recording.bag_writer import BagWriter
from heading_intercompare.bags.rosbag2.bag_files import BagFiles, find_files, METADATA
from heading_intercompare.bags.rosbag2.bag_yaml import list_parts
from heading_intercompare.bags.settings import BagSettings

from .copier import Transfer
from .inventory import Inventory, take_inventory

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


def _find_files(source: Path) -> tuple[BagFiles, str]:
    """Return the files of a bag, and why its metadata cannot be read: then all count."""
    try:
        list_parts(source / METADATA)
    except BagError as error:
        return find_files(source, []), error.problem.partition(';')[0]
    except OSError as error:
        return find_files(source, []), error.strerror or str(error)
    return find_files(source), ''


def _take_inventories(paths: list[Path], progress: Callable[[str], None], unproven: bool
                      ) -> tuple[list[Inventory], list[tuple[Path, str]]]:
    """Return the inventories of files, and why others cannot be read; OSError if all fail."""
    files: list[Inventory] = []
    others: list[tuple[Path, str]] = []
    for path in paths:
        try:
            files.append(take_inventory(path, progress, unproven))
        except OSError as error:
            if len(others) + 1 == len(paths):
                raise
            others.append((path, error.strerror or str(error)))
    return files, others


def _sum_up(files: list[Inventory]) -> Recovered:
    """Return the counts of all files together."""
    total = Recovered(files=len(files))
    for inventory in files:
        total.bytes += inventory.size
        total.bytes_lost += sum(d.lost for d in inventory.damage)
        total.chunks += inventory.chunks
        total.messages_unproven += inventory.unproven
        damaged = sum(d.chunk for d in inventory.damage)
        total.chunks_lost += damaged
        if inventory.file.problem:
            total.note(inventory.file.source, inventory.file.problem)
            total.messages_known = False
        for damage in inventory.damage[:_NOTES]:
            total.note(inventory.path, f'bytes {damage.start} to {damage.end}: {damage.fault}')
        _count(total, inventory)
        if misplaced := inventory.count_misplaced():
            total.note(inventory.path, f'{misplaced} chunks are not the chunks that its index '
                       'names in their place')
        if not inventory.size:
            total.note(inventory.path, 'is empty (0 bytes)')
        elif not inventory.closed:
            total.note(inventory.path, 'was not closed')
            total.messages_known = total.messages_known and not inventory.damage
    return total


def _count(total: Recovered, inventory: Inventory) -> None:
    """Count the messages of a file, and on its own each file that was appended to it."""
    with_topic, strange = [0] * len(inventory.sections), [0] * len(inventory.sections)
    for (number, channel), count in inventory.counts.items():
        defined = inventory.topic(number, channel) is not None
        (with_topic if defined else strange)[number] += count
    total.messages += sum(with_topic)
    if any(strange):
        total.note(inventory.path, f'{sum(strange)} messages of topics that are not defined, '
                   'defined in two ways, or not encoded as cdr')
    for section in inventory.sections:
        for contradiction in section.definitions.contradictions:
            total.note(inventory.path, contradiction)
    untimed = sum(section.untimed for section in inventory.sections)
    if untimed:
        total.note(inventory.path, f'{untimed} messages with impossible log times')
    before = total.messages_lost
    for section, held, undefined in zip(inventory.sections, with_topic, strange):
        seen = undefined + section.untimed
        lost = seen + section.indexed
        if len(section.said) == 1:
            missing = section.said[0] - held
            if missing > lost:
                total.note(inventory.path,
                           f'{missing - lost} messages are missing, according to its summary')
            elif missing < 0:
                total.note(inventory.path, f'{-missing} messages more than its summary says')
            # Fewer than were seen to be lost: some messages are there twice, or an index is wrong.
            total.messages_known = total.messages_known and missing >= lost
            lost = max(missing, seen)
        elif inventory.damage:
            total.messages_known = False
        total.messages_lost += lost
    if total.messages_lost == before and any(damage.chunk for damage in inventory.damage):
        # A chunk is lost but no message is missing: some messages are there twice.
        total.messages_known = False


def _record(source: Path, total: Recovered,
            earlier: list[dict[str, str]]) -> dict[str, object]:
    """Return the metadata record `recovery`; it includes the losses of earlier recoveries."""
    losses = {name: getattr(total, name) for name in _LOSSES}
    unproven = total.messages_unproven
    exact, notes = total.messages_known, []
    for number, before in enumerate(earlier):
        if before in earlier[:number]:
            continue
        for name in _LOSSES:
            losses[name] += decimal(before.get(name, '')) or 0
        unproven += decimal(before.get('messages_unproven', '')) or 0
        exact = exact and before.get('messages_lost_is') == 'all'
        notes += [text for name, text in before.items() if name.startswith('note.')]
    notes = (notes + total.notes)[:_NOTES]
    return {'source': source.name, 'files': total.files, 'bytes': total.bytes,
            'chunks': total.chunks, 'messages': total.messages, **losses,
            'messages_lost_is': 'all' if exact else 'at least',
            **({'messages_unproven': unproven} if unproven else {}),
            **{f'note.{n}': note for n, note in enumerate(notes, 1)}}


def _settings(settings: BagSettings | None, files: list[Inventory]) -> BagSettings:
    """Return the settings of the new bag; by default the main compression of the source."""
    if settings is not None:
        return settings
    packed: dict[str, int] = {}
    for inventory in files:
        for name, written in COMPRESSIONS.items():
            packed[name] = packed.get(name, 0) + inventory.packed.get(written, 0)
    most = max(packed, key=packed.__getitem__)
    return BagSettings(compression=most) if packed[most] else BagSettings()


def recover(source: str | os.PathLike[str], target: str | os.PathLike[str],
            settings: BagSettings | None = None,
            progress: Callable[[str], None] = lambda text: None, *,
            unproven: bool = False) -> Recovered:
    """
    Write everything readable of a bag into a new one.

    Parameters
    ----------
    source
        An MCAP file or a rosbag2 directory, cut, damaged or complete; metadata.yaml may be
        missing. It is never changed.
    target
        The rosbag2 directory to write; it must not exist. It gets a metadata record `recovery`
        with the counts.
    settings
        Settings of the new bag. Without them, chunks keep their compression; with them, chunks
        with another compression are compressed again. Intact chunks keep their size.
    progress
        Called with the progress in words.
    unproven
        Also keep the messages of chunks whose checksum is wrong, as far as their lengths and log
        times are possible. The new bag says how many there are.

    Returns
    -------
    Recovered
        What was kept and what was lost.

    Raises
    ------
    OSError
        If the source cannot be read or the target cannot be written.
    BagError
        If nothing in the source is readable, the source changes while it is read, or the target
        exists or lies inside the source.

    Notes
    -----
    If the recovery stops for any reason, there is no target.

    """
    source, target = Path(source), Path(target)
    if target.exists():
        raise BagError('already exists; a bag is never overwritten', target)
    listed, problem = _find_files(source)
    if Path(os.path.realpath(source)) in Path(os.path.realpath(target)).parents:
        raise BagError(f'lies inside the bag to recover; write it next to {source}', target)
    files, others = _take_inventories(listed.paths, progress, unproven)
    total = _sum_up(files)
    for path, why in others:
        total.note(path, why)
        total.messages_known = False
    if problem:
        total.note(source / METADATA, problem)
    for oddity in listed.oddities:
        total.note(source, oddity)
    for name in listed.absent:
        total.note(source / name, 'is missing')
        total.messages_known = False
    if not total.messages and (total.messages_lost or not any(
            inventory.extras or inventory.closed and not inventory.damage for inventory in files)):
        raise BagError('nothing in it is readable: '
                       + ('; '.join(total.notes[:3]) or 'it holds no message'), source)
    bag_settings = _settings(settings, files)
    with ExitStack() as undo:
        bag = BagWriter(target, bag_settings, whole=True)
        undo.callback(bag.abandon)
        transfer = Transfer(
            bag, None if settings is None else COMPRESSIONS[bag_settings.compression],
            singly=bag_settings.split_bytes > 0 or bag_settings.split_duration_s > 0,
            note=lambda inventory, text: total.note(inventory.path, text))
        for inventory in files:
            transfer.copy(inventory, progress)
        total.counts = transfer.counts
        total.messages -= transfer.refused
        total.messages_lost += transfer.refused
        bag.metadata('recovery', _record(source, total, [e for f in files for e in f.earlier]))
        bag.close()
        undo.pop_all()
    return total
