# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Bags written as rosbag2 writes them, but chunk by chunk to the disk."""

from __future__ import annotations

from contextlib import ExitStack, suppress
from dataclasses import replace
import errno
import os
from pathlib import Path
from typing import BinaryIO, Iterable, Mapping

import numpy as np

from heading_intercompare.bags.checked_text import utf8
from heading_intercompare.bags.errors import BagError
from heading_intercompare.bags.mcap.chunk_writer import ChunkWriter
from heading_intercompare.bags.mcap.message_batch import Rows
from heading_intercompare.bags.rosbag2.bag_yaml import (
    bag_metadata,
    metadata_file,
    PartInfo,
    Qos,
    TopicRow,
)
from heading_intercompare.bags.settings import BagSettings
from heading_intercompare.core.version import VERSION
from heading_intercompare.messages.errors import MessageError
from heading_intercompare.messages.schemas import Schema, schema_of

from .disk_sync import replace_file, Syncing

__all__ = ['BagWriter', 'Rows']

#: Of a channel and its schema.
_Numbers = tuple[int | None, int | None]


def _topic_name(topic: str) -> str:
    return topic if topic.startswith('/') else f'/{topic}'


def _checked_time(time_ns: int) -> int:
    if not 0 <= time_ns < 2**63:
        raise BagError(f'a bag holds no time of {time_ns} ns: it must not be before 1970')
    return int(time_ns)


def _remove(file: BinaryIO) -> None:
    with suppress(OSError):
        file.close()
        os.unlink(file.name)


class BagWriter:
    """
    A rosbag2 directory being written: `name/name_0.mcap` and so on, and `name/metadata.yaml`.

    Parameters
    ----------
    path : str or path
        The directory; it must not exist.
    settings : BagSettings
        Chunks, compression, flush interval, size and duration of a file.
    software : str
        Name and version of the program, for the header and `custom_data`.

    Attributes
    ----------
    path : Path
        The directory.

    Raises
    ------
    BagError
        If the path exists.
    OSError
        If the directory or a file cannot be written, here and in every method that writes. The
        file then ends with its last whole chunk; messages taken by `write` stay in memory and go
        with the next chunk.

    Examples
    --------
    >>> import tempfile
    >>> from heading_intercompare.messages.cdr import encode
    >>> folder = tempfile.TemporaryDirectory()
    >>> with BagWriter(folder.name + '/trial') as bag:
    ...     _ = bag.add_topic('/remark', 'std_msgs/msg/String')
    ...     bag.write('/remark', encode('std_msgs/msg/String', {'data': 'all fast'}), 10**18)
    >>> sorted(file.name for file in bag.path.iterdir())
    ['metadata.yaml', 'trial_0.mcap']
    >>> folder.cleanup()

    """

    def __init__(self, path: str | os.PathLike[str], settings: BagSettings | None = None, *,
                 software: str = f'heading_intercompare {VERSION}') -> None:
        self.path = Path(path)
        self._settings = settings or BagSettings()
        self._software = software
        self._rows: dict[str, tuple[int, TopicRow, Schema, _Numbers]] = {}
        self._records: dict[str, dict[str, str]] = {}
        self._last_flush_s: float | None = None
        self._syncing = Syncing(self._settings.fsync_interval_s)
        self._closed: list[PartInfo] = []
        self._no_file: OSError | None = None
        self._described = True
        self._stem = utf8(self.path.resolve().name, 'name of the bag')
        try:
            self.path.mkdir(parents=True)
        except FileExistsError:
            raise BagError('exists already; a bag is never overwritten', self.path) from None
        self._number = 0
        with ExitStack() as undo:
            undo.callback(self._withdraw)
            self._file, self._chunks = self._opened(0)
            undo.callback(_remove, self._file)
            self._describe_record()
            replace_file(*self._description())
            undo.pop_all()

    def _withdraw(self) -> None:
        """Remove the folder of a bag that could not be begun."""
        with suppress(OSError):
            (self.path / 'metadata.yaml').unlink(missing_ok=True)
            self.path.rmdir()

    def _opened(self, number: int) -> tuple[BinaryIO, ChunkWriter]:
        """Return a new file that knows all topics and has all metadata; the folder is made."""
        self.path.mkdir(parents=True, exist_ok=True)
        file = open(self._place(number), 'xb', buffering=0)
        with ExitStack() as undo:
            undo.callback(_remove, file)
            chunks = ChunkWriter(file, self._settings.compression, self._settings.chunk_bytes,
                                 self._software)
            for _, *definition in self._rows.values():
                self._define(chunks, *definition)
            for name, mapping in self._records.items():
                chunks.add_metadata(name, mapping)
            undo.pop_all()
        return file, chunks

    def _place(self, number: int) -> Path:
        return self.path / f'{self._stem}_{number}.mcap'

    @staticmethod
    def _define(chunks: ChunkWriter, row: TopicRow, schema: Schema, numbers: _Numbers) -> int:
        return chunks.add_channel(row.name, row.type_name, schema.text, {
            'offered_qos_profiles': row.qos.to_yaml(), 'topic_type_hash': schema.type_hash},
            schema.encoding, numbers)

    def __enter__(self) -> 'BagWriter':
        return self

    def abandon(self) -> None:
        """Close the file without an end: nobody shall take the bag for whole."""
        self._file.close()
        self._syncing.close()

    def __exit__(self, *exception: object) -> None:
        self.close()

    @property
    def topics(self) -> tuple[str, ...]:
        """Names of the topics added."""
        return tuple(self._rows)

    @property
    def file(self) -> Path:
        """Where the file being written was made."""
        return self._place(self._number)

    @property
    def chunks(self) -> ChunkWriter:
        """The file being written, for whole chunks; call `split_if_due` after each."""
        return self._chunks

    def add_topic(self, topic: str, type_name: str, qos: Qos | None = None, *,
                  schema: Schema | None = None, numbers: _Numbers = (None, None)) -> int:
        """
        Make a topic known; before its first message.

        Parameters
        ----------
        topic : str
            A name without a leading slash gets one, as ROS resolves it.
        type_name : str
            As package/msg/Type.
        qos : Qos
            What its publisher offers, and a player offers again; `Qos()` without it.
        schema : Schema, optional
            Its definition; looked up without it.
        numbers : tuple of int or None
            Those that its channel and schema get in the file if nothing else has them.

        Returns
        -------
        int
            The number of its channel.

        Raises
        ------
        BagError
            If the type has no definition here, or the topic exists with another type.

        """
        name = _topic_name(topic)
        if name in self._rows:
            if self._rows[name][1].type_name != type_name:
                raise BagError(f'topic {name} is {self._rows[name][1].type_name} already, it '
                               f'cannot be {type_name} too', self.path)
            return self._rows[name][0]
        try:
            schema, qos = schema or schema_of(type_name), qos or Qos()
        except MessageError as error:
            raise BagError(error.problem) from None
        row = TopicRow(name, type_name, schema.type_hash, qos)
        number = self._define(self._chunks, row, schema, numbers)
        self._rows[name] = number, row, schema, numbers
        self._described = False
        return number

    def _channel(self, topic: str) -> int:
        name = _topic_name(topic)
        if name not in self._rows:
            raise BagError(f'topic {name} was not added; added are '
                           f'{", ".join(self._rows) or "none"}', self.path)
        return self._rows[name][0]

    def write(self, topic: str, data: bytes, log_time_ns: int, publish_time_ns: int | None = None,
              sequence: int = 0) -> None:
        """
        Take one CDR message; it reaches the disk when its chunk ends.

        Parameters
        ----------
        topic : str
            A topic that was added.
        data : bytes
            The message with its four bytes of encapsulation.
        log_time_ns, publish_time_ns : int
            When it was received and sent, nanoseconds; sent when received unless given.
        sequence : int
            Number that its publisher gave it.

        """
        log_time_ns = _checked_time(log_time_ns)
        publish_time_ns = (log_time_ns if publish_time_ns is None
                           else _checked_time(publish_time_ns))
        self._chunks.add(self._channel(topic), data, log_time_ns, publish_time_ns,
                         sequence % 2**32)
        if not self._chunks.pending:
            self.split_if_due()

    def write_rows(self, batches: Iterable[Rows]) -> None:
        """Take many messages of several topics, merged in the order of their log times."""
        records: list[bytes] = []
        channels, logs = [], []
        for rows in batches:
            number = self._channel(rows.topic)
            log = np.asarray(rows.log_time_ns, np.int64)
            if len(log):
                _checked_time(int(log.min()))
                records += rows.records(number)
                channels.append(np.full(len(log), number))
                logs.append(log)
        if not records:
            return
        log = np.concatenate(logs)
        order = np.argsort(log, kind='stable')
        self._chunks.add_records([records[i] for i in order.tolist()],
                                 np.concatenate(channels)[order], log[order])
        self.split_if_due()

    def metadata(self, name: str, mapping: Mapping[str, object]) -> None:
        """Write a metadata record, into later files of the bag too; values become text."""
        self._records[name] = {str(k): str(v) for k, v in mapping.items()}
        self._chunks.add_metadata(name, self._records[name])

    def attachment(self, name: str, media_type: str, data: bytes, time_ns: int = 0) -> None:
        """Write a file into the bag."""
        self._chunks.add_attachment(name, media_type, data, _checked_time(time_ns))

    def flush(self) -> None:
        """Write what is in memory."""
        self._chunks.end_chunk()

    def flush_if_due(self, now_s: float) -> bool:
        """
        Write what is in memory if `flush_interval_s` has passed; say whether it has.

        Parameters
        ----------
        now_s : float
            The caller's steady clock, seconds. Call it often, at least twice an interval.

        """
        if self._last_flush_s is None:
            self._last_flush_s = now_s
        if now_s - self._last_flush_s < self._settings.flush_interval_s:
            return False
        self._last_flush_s = now_s
        self._chunks.end_chunk()
        self._syncing.begin_if_due(self._file.fileno(), now_s)
        self.split_if_due()
        if not self._described or self._syncing.problem is not None:
            self._described = True
            self._syncing.replace(*self._description())
        return True

    def take_pending(self) -> list[tuple[str, bytes, int, int, int]]:
        """Take the messages out of memory that could not be written; as `write` takes them."""
        names = {number: name for name, (number, *_) in self._rows.items()}
        return [(names[number], *rest) for number, *rest in self._chunks.take_pending()]

    def check(self) -> None:
        """Raise FileNotFoundError if the file that is written is not in its place any more."""
        if not os.path.samestat(os.stat(self.file), os.fstat(self._file.fileno())):
            raise FileNotFoundError(errno.ENOENT, 'is another file now', str(self.file))

    @property
    def problem(self) -> OSError | None:
        """
        Why no new file could be begun or metadata.yaml not be written.

        Nothing is lost by that, and it is tried again. At the end it is raised.
        """
        return self._no_file or self._syncing.problem

    @property
    def absent(self) -> int:
        """Number of messages written to files that are not in their place any more."""
        parts = [*self._closed, self._part()]
        return sum(part.count for part in parts if not (self.path / part.path).exists())

    def split(self) -> None:
        """
        Go on in a new file, and end the one before if that can be written.

        Raises
        ------
        OSError
            If no file can be made; all is then as before.

        """
        number = self._number + 1
        while self._place(number).exists():
            number += 1
        file, chunks = self._opened(number)
        old = self._chunks
        with suppress(OSError):
            old.end_chunk()
            self._describe_record()
            old.finish()
            self._syncing.begin(self._file.fileno())
        self._closed.append(self._part())
        waiting = old.take_pending()
        with suppress(OSError):
            self._file.close()
        self._file, self._chunks, self._number = file, chunks, number
        self._no_file = self._syncing.problem = None
        for message in waiting:
            chunks.add(*message)
        self._describe_record()
        self._described = False

    def split_if_due(self) -> None:
        """Go on in a new file when the settings say so; a failure is a `problem`, no error."""
        settings, chunks = self._settings, self._chunks
        if chunks.start_ns is None:
            return
        span_s = (chunks.end_ns - chunks.start_ns) / 1e9
        if 0 < settings.split_bytes <= chunks.size or 0 < settings.split_duration_s <= span_s:
            try:
                self.split()
            except OSError as error:
                self._no_file = error

    def _part(self) -> PartInfo:
        """Return what there is to say of the file being written."""
        rows = []
        for channel, row, *_ in self._rows.values():
            rows.append(replace(row, count=self._chunks.counts.get(channel, 0)))
        return PartInfo(self.file.name, self._chunks.start_ns, self._chunks.end_ns,
                        sum(self._chunks.counts.values()), rows)

    def _describe_record(self) -> None:
        """Write into the file what rosbag2 writes at open and close."""
        text = bag_metadata([self._part()], {'software': self._software})
        self._chunks.add_metadata('rosbag2', {'serialized_metadata': text})

    def _description(self) -> tuple[Path, str]:
        """Return metadata.yaml, for the files that are there."""
        parts = [part for part in (*self._closed, self._part())
                 if (self.path / part.path).exists()]
        return self.path / 'metadata.yaml', metadata_file(parts, {'software': self._software})

    def close(self) -> None:
        """Write what is in memory and the end of the file; a second time does nothing."""
        if self._file.closed:
            return
        try:
            self._chunks.end_chunk()
            self._describe_record()
            self._chunks.finish()
            self._chunks.sync()
        finally:
            self.abandon()
        replace_file(*self._description())
