# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""
Everything readable of a damaged bag into a new one, with a count of what was lost.

Each file is read twice: once to learn what is sound and which topics there are, for these may be
defined behind the messages, and once to copy.
"""

from __future__ import annotations

from dataclasses import dataclass, field
import os
from pathlib import Path
from typing import Callable, Iterator

from mcap import records as mcap
from mcap.opcode import Opcode
import numpy as np

from .bag_yaml import listed_parts, Qos
from .blocks import Block, Record
from .errors import BagError
from .fields import full_name
from .part import mcap_files, parsed
from .salvage import Gap, Salvage, Sound
from .schemas import Schema
from .settings import BagSettings
from .writer import BagWriter

__all__ = ['recover', 'Recovered']

_NOTES = 100


@dataclass(slots=True)
class Recovered:
    """
    What was read and what was not.

    Attributes
    ----------
    files, bytes : int
        Read; bytes are those of the files as they are.
    bytes_lost : int
        Bytes that could not be read or understood.
    chunks : int
        Chunks kept, those of which only a part could be kept among them.
    chunks_lost : int
        Chunks of which nothing or not all could be kept, as far as they are recognised as such.
    messages : int
        Messages kept.
    messages_lost : int
        Messages that are known to be lost: by the index behind a damaged chunk, by the summary of
        a file that was closed, or for want of a definition of their topic.
    messages_known : bool
        No others can have been lost within the files; what was never written is not known.
    counts : dict of str to int
        Messages kept, by topic.
    notes : list of str
        What was wrong, and where; of very many the first.

    """

    files: int = 0
    bytes: int = 0
    bytes_lost: int = 0
    chunks: int = 0
    chunks_lost: int = 0
    messages: int = 0
    messages_lost: int = 0
    messages_known: bool = True
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


@dataclass(slots=True)
class _File:
    """What the first reading of a file found."""

    path: Path
    #: The best definition of each number: (how far to be trusted, definition).
    schemas: dict[int, tuple[int, mcap.Schema]] = field(default_factory=dict)
    channels: dict[int, tuple[int, mcap.Channel]] = field(default_factory=dict)
    counts: dict[int, int] = field(default_factory=dict)
    chunks: int = 0
    damage: list[Gap | Sound] = field(default_factory=list)
    indexed: int = 0
    statistics: mcap.Statistics | None = None
    closed: bool = False
    extras: int = 0

    def topic(self, number: int) -> tuple[mcap.Channel, mcap.Schema] | None:
        """Return the definition of a channel; None if it is lost or not of ROS 2."""
        channel = self.channels.get(number, (0, None))[1]
        if channel is None or channel.message_encoding != 'cdr' or (
                channel.schema_id not in self.schemas):
            return None
        return channel, self.schemas[channel.schema_id][1]

    def define(self, opcode: int, content: bytes, trust: int) -> None:
        """Take a definition if there is no better one."""
        try:
            if opcode == Opcode.SCHEMA:
                schema = parsed(mcap.Schema, content)
                if trust > self.schemas.get(schema.id, (0, None))[0]:
                    self.schemas[schema.id] = trust, schema
            elif opcode == Opcode.CHANNEL:
                channel = parsed(mcap.Channel, content)
                if trust > self.channels.get(channel.id, (0, None))[0]:
                    self.channels[channel.id] = trust, channel
        except BagError:
            pass


def _survey(path: Path, progress: Callable[[str], None]) -> _File:
    """Read a file for the first time."""
    found = _File(path)
    indexing = False
    with open(path, 'rb') as file:
        salvage = Salvage(file)
        for item in salvage.scan():
            if isinstance(item, Gap):
                found.damage.append(item)
                indexing = item.chunk
                continue
            opcode = item.record.opcode
            if item.block is not None:
                _take_block(found, item)
                progress(f'{item.end / salvage.size:.0%} looked at')
            elif opcode == Opcode.MESSAGE_INDEX and indexing:
                found.indexed += (item.record.length - 6) // 16
            elif opcode == Opcode.STATISTICS:
                found.statistics = parsed(mcap.Statistics, salvage.content(item.record))
            elif opcode == Opcode.FOOTER:
                found.closed = True
            elif opcode in (Opcode.METADATA, Opcode.ATTACHMENT):
                found.extras += 1
            indexing = indexing and opcode == Opcode.MESSAGE_INDEX
            if item.fault:
                found.damage.append(item)
    return found


def _take_block(found: _File, item: Sound) -> None:
    """Take definitions and counts of a block."""
    block, chunk = item.block, item.record.opcode == Opcode.CHUNK
    found.chunks += chunk
    for record in block.others:
        found.define(record.opcode, bytes(block.data[record.start:record.start + record.length]),
                     2 if chunk and not item.fault else 1)
    if len(block.start):
        for number, count in zip(*np.unique(block.heads['channel'], return_counts=True)):
            found.counts[int(number)] = found.counts.get(int(number), 0) + int(count)


def _judge(files: list[_File]) -> Recovered:
    """Return the counts of all files."""
    total = Recovered(files=len(files))
    for found in files:
        size = found.path.stat().st_size
        kept = {n: count for n, count in found.counts.items() if found.topic(n) is not None}
        strange = sum(found.counts.values()) - sum(kept.values())
        damaged = [d for d in found.damage if isinstance(d, Sound) or d.chunk]
        total.bytes += size
        total.bytes_lost += sum(d.end - d.start for d in found.damage if isinstance(d, Gap))
        total.chunks += found.chunks
        total.chunks_lost += len(damaged)
        total.messages += sum(kept.values())
        lost = found.indexed + strange
        if found.statistics is not None:
            lost = max(lost, found.statistics.message_count - sum(kept.values()))
        elif damaged or found.damage:
            total.messages_known = False
        total.messages_lost += lost
        for d in found.damage:
            start = d.start if isinstance(d, Gap) else d.record.start - 9
            total.note(found.path, f'bytes {start} to {d.end}: {d.fault}')
        if strange:
            total.note(found.path, f'{strange} messages of topics that are not defined any more, '
                       'or not encoded as cdr')
        if not size:
            total.note(found.path, 'is empty (0 bytes)')
        elif not found.closed:
            total.note(found.path, 'was not closed')
            total.messages_known = total.messages_known and not found.damage
    return total


def _messages(block: Block) -> Iterator[tuple[int, bytes, int, int, int]]:
    """Yield channel, message, log time, publish time and sequence of each message."""
    view = memoryview(block.data)
    for head, start, stop in zip(block.heads.tolist(), block.start.tolist(), block.stop.tolist()):
        _, _, number, sequence, log, publish = head
        yield number, view[start:stop].tobytes(), log, publish, sequence


class _Copier:
    """Writes what is sound in the files of a bag into another."""

    def __init__(self, bag: BagWriter, total: Recovered) -> None:
        self._bag = bag
        self._total = total
        self._types: dict[str, str] = {}

    def copy(self, found: _File, progress: Callable[[str], None]) -> None:
        """Read a file for the second time."""
        names: dict[int, str | None] = {}
        with open(found.path, 'rb') as file:
            salvage = Salvage(file)
            for item in salvage.scan():
                if isinstance(item, Gap):
                    continue
                if item.block is not None:
                    self._copy_block(found, item.block, names)
                    progress(f'{item.end / salvage.size:.0%} copied')
                elif item.record.opcode in (Opcode.METADATA, Opcode.ATTACHMENT):
                    self._copy_extra(item.record, salvage.content(item.record))

    def _copy_block(self, found: _File, block: Block, names: dict[int, str | None]) -> None:
        for number, data, log, publish, sequence in _messages(block):
            if number not in names:
                names[number] = self._added(found, number)
            name = names[number]
            if name is None:
                continue
            if log < 0:
                self._total.messages -= 1
                self._total.messages_lost += 1
                continue
            self._bag.write(name, data, log, publish if publish >= 0 else log, sequence)
            self._total.counts[name] = self._total.counts.get(name, 0) + 1

    def _added(self, found: _File, number: int) -> str | None:
        """Return the topic of a channel, which is now known to the new bag."""
        definition = found.topic(number)
        if definition is None:
            return None
        channel, schema = definition
        name = channel.topic
        kind = full_name(schema.name)
        while self._types.setdefault(name, kind) != kind:
            # One topic with two types cannot be in one rosbag2; both are kept, the second renamed.
            name = f'{name}_{kind.rpartition("/")[2].lower()}'
        if name != channel.topic:
            self._total.note(found.path, f'{channel.topic} is also {kind}: kept as {name}')
        self._bag.add_topic(
            name, kind, Qos.of_yaml(channel.metadata.get('offered_qos_profiles', '')),
            schema=Schema(kind, schema.data.decode(errors='replace'),
                          channel.metadata.get('topic_type_hash', ''), schema.encoding))
        return name if name.startswith('/') else f'/{name}'

    def _copy_extra(self, record: Record, content: bytes) -> None:
        if record.opcode == Opcode.METADATA:
            metadata = parsed(mcap.Metadata, content)
            if metadata.name != 'rosbag2':
                self._bag.metadata(metadata.name, metadata.metadata)
            return
        try:
            attachment = parsed(mcap.Attachment, content)
            self._bag.attachment(attachment.name, attachment.media_type, attachment.data,
                                 attachment.log_time)
        except BagError as error:
            self._total.notes.append(error.problem)


def recover(source: str | os.PathLike[str], target: str | os.PathLike[str],
            settings: BagSettings | None = None,
            progress: Callable[[str], None] = lambda text: None) -> Recovered:
    """
    Write everything readable of a bag into a new one.

    Parameters
    ----------
    source : str or path
        An MCAP file or a rosbag2 directory, cut, damaged or whole; metadata.yaml may be missing.
        It is only read.
    target : str or path
        The rosbag2 directory to write; it must not exist. It gets a metadata record `recovery`
        with the counts.
    settings : BagSettings, optional
        Of the new bag.
    progress : callable
        Told what has been done.

    Returns
    -------
    Recovered
        What was kept and what was lost.

    Raises
    ------
    OSError
        If the source cannot be read or the target cannot be written.
    BagError
        If nothing in the source is readable, or the target exists.

    """
    source, target = Path(source), Path(target)
    if target.exists():
        raise BagError('exists already; a bag is never overwritten', target)
    paths = mcap_files(source)
    files = [_survey(path, progress) for path in paths]
    total = _judge(files)
    if source.is_dir():
        for name in listed_parts(source / 'metadata.yaml'):
            if not (source / name).is_file():
                total.note(source / name, 'is missing')
                total.messages_known = False
    if not total.messages and (total.damaged or not any(f.closed for f in files)):
        raise BagError('nothing in it is readable: '
                       + ('; '.join(total.notes[:3]) or 'it holds no message'), source)
    with BagWriter(target, settings) as bag:
        copier = _Copier(bag, total)
        for found in files:
            copier.copy(found, progress)
        bag.metadata('recovery', {
            'source': source.name, 'files': total.files, 'bytes': total.bytes,
            'bytes_lost': total.bytes_lost, 'chunks': total.chunks,
            'chunks_lost': total.chunks_lost, 'messages': total.messages,
            'messages_lost': total.messages_lost,
            'messages_lost_is': 'all' if total.messages_known else 'at least',
            **{f'note.{n}': note for n, note in enumerate(total.notes, 1)}})
    return total
