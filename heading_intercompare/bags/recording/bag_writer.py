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

"""The writer of bags: the files of rosbag2, but written to the disk chunk by chunk."""

from __future__ import annotations

from contextlib import ExitStack, suppress
from dataclasses import replace
import errno
import os
from pathlib import Path
from shutil import rmtree
from typing import BinaryIO, Iterable, Mapping

from mcap import records as mcap
import numpy as np

from heading_intercompare.bags.errors import BagError, utf8
from heading_intercompare.bags.mcap.chunk_chain import ChunkChain
from heading_intercompare.bags.mcap.chunk_writer import ANY_NUMBER, ChunkWriter, Rows
from heading_intercompare.bags.mcap.message_blocks import LAST_NS
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
from heading_intercompare.messages.schemas import schema_of
from heading_intercompare.replaced_file import draft_beside, replace_file, sync_folder

from .disk_sync import Syncing

_EXISTS = 'already exists; a bag is never overwritten'
#: Keys in the metadata of a channel.
_QOS, _TYPE_HASH = 'offered_qos_profiles', 'topic_type_hash'

def _topic_name(topic: str) -> str:
    return topic if topic.startswith('/') else f'/{topic}'


def _check_time(time_ns: int) -> int:
    if not 0 <= time_ns <= LAST_NS:
        raise BagError(f'a bag cannot hold the time {time_ns} ns: must be from 1970 on and below '
                       '2^63 ns')
    return int(time_ns)


def _remove(file: BinaryIO) -> None:
    with suppress(OSError):
        file.close()
        os.unlink(file.name)


class BagWriter:
    """
    Writes a rosbag2 directory: `name/name_0.mcap` and so on, and `name/metadata.yaml`.

    Parameters
    ----------
    path
        The directory; it must not exist.
    settings : BagSettings
        Chunk size, compression, flush interval, size and duration of a file.
    software
        Name and version of the program, for the header and `custom_data`.
    whole
        The directory appears under its name only when it is closed, whole and on the disk. Until
        then its name ends with ``.part``. False for a recording, which is to survive a power cut.

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
        file then ends with its last whole chunk. Messages taken by `write` stay in memory and
        are written with the next chunk.

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
                 software: str = f'heading_intercompare {VERSION}',
                 whole: bool = False) -> None:
        self.path = Path(path)
        self._settings = settings or BagSettings()
        self._software = software
        self._rows: dict[str, tuple[int, TopicRow, mcap.Channel, mcap.Schema | None]] = {}
        self._records: dict[str, dict[str, str]] = {}
        self._last_flush_s: float | None = None
        self._syncing = Syncing(self._settings.fsync_interval_s)
        self._closed: list[PartInfo] = []
        self._no_file: OSError | None = None
        self._described = True
        self._stem = utf8(Path(os.path.realpath(self.path)).name, 'name of the bag')
        if whole and os.path.lexists(path):
            raise BagError(_EXISTS, self.path)
        self._folder = draft_beside(self.path) if whole else self.path
        try:
            self._folder.mkdir(parents=True)
        except FileExistsError:
            raise BagError(_EXISTS, self.path) from None
        self._number = 0
        with ExitStack() as undo:
            undo.callback(self._withdraw)
            self._file, self._chunks = self._open_file(0)
            undo.callback(_remove, self._file)
            self._describe_record()
            replace_file(*self._description())
            undo.pop_all()

    def _withdraw(self) -> None:
        """Remove the folder of a bag that could not be started."""
        with suppress(OSError):
            (self._folder / 'metadata.yaml').unlink(missing_ok=True)
            self._folder.rmdir()

    def _open_file(self, number: int) -> tuple[BinaryIO, ChunkWriter]:
        """Create a file with all topics and metadata known so far, and the folder if needed."""
        self._folder.mkdir(parents=True, exist_ok=True)
        file = open(self._place(number), 'xb', buffering=0)
        with ExitStack() as undo:
            undo.callback(_remove, file)
            chunks = ChunkWriter(file, self._settings.compression, self._settings.chunk_bytes,
                                 self._software)
            for _, _, channel, definition in self._rows.values():
                chunks.define(channel, definition)
            for name, mapping in self._records.items():
                chunks.add_metadata(name, mapping)
            undo.pop_all()
        return file, chunks

    def _place(self, number: int) -> Path:
        return self._folder / f'{self._stem}_{number}.mcap'

    def __enter__(self) -> 'BagWriter':
        return self

    def abandon(self) -> None:
        """
        Close the file without its end, so that nobody mistakes the bag for complete.

        A bag that was to appear whole is removed.
        """
        self._file.close()
        self._syncing.close()
        if self._folder != self.path:
            rmtree(self._folder, ignore_errors=True)

    def __exit__(self, kind: type | None, *exception: object) -> None:
        if kind is not None and self._folder != self.path:
            self.abandon()
        else:
            self.close()

    @property
    def topics(self) -> tuple[str, ...]:
        """Names of the topics added."""
        return tuple(self._rows)

    @property
    def file(self) -> Path:
        """Return the path at which the current file was created."""
        return self._place(self._number)

    @property
    def chunks(self) -> ChunkWriter:
        """Return the writer of the current file, for whole chunks; then call `split_if_due`."""
        return self._chunks

    @property
    def chain(self) -> ChunkChain:
        """Return the chain through the chunks written to all files."""
        return self._chunks.chain

    def add_topic(self, topic: str, type_name: str, qos: Qos | None = None) -> int:
        """
        Add a topic; call it before the first message of the topic.

        Parameters
        ----------
        topic
            A name without a leading slash gets one, as in ROS.
        type_name
            As package/msg/Type.
        qos
            The QoS of its publisher, which a player offers again; `Qos()` by default.

        Returns
        -------
        int
            The number of its channel.

        Raises
        ------
        BagError
            If there is no definition of the type, or the topic exists with another type.

        """
        name = _topic_name(topic)
        if name in self._rows:
            if self._rows[name][1].type_name != type_name:
                raise BagError(f'topic {name} is already {self._rows[name][1].type_name}; it '
                               f'cannot also be {type_name}', self.path)
            return self._rows[name][0]
        try:
            schema, qos = schema_of(type_name), qos or Qos()
        except MessageError as error:
            raise BagError(error.problem) from None
        return self.add_channel(
            mcap.Channel(id=ANY_NUMBER, topic=name, message_encoding='cdr', metadata={
                _QOS: qos.to_yaml(), _TYPE_HASH: schema.type_hash}, schema_id=ANY_NUMBER),
            mcap.Schema(id=ANY_NUMBER, name=type_name, encoding=schema.encoding,
                        data=schema.text.encode()), type_name)

    def add_channel(self, channel: mcap.Channel, schema: mcap.Schema | None,
                    type_name: str) -> int:
        """
        Add a topic that is not there from its records; return the number of its channel.

        Parameters
        ----------
        channel, schema
            The records, of whatever encoding. They keep their numbers if these are free.
        type_name
            The type that metadata.yaml says.

        """
        row = TopicRow(channel.topic, type_name, channel.metadata.get(_TYPE_HASH, ''),
                       Qos.of_yaml(channel.metadata.get(_QOS, '')),
                       encoding=channel.message_encoding)
        number = self._chunks.define(channel, schema)
        self._rows[channel.topic] = number, row, channel, schema
        self._described = False
        return number

    def _channel(self, topic: str) -> int:
        name = _topic_name(topic)
        if name not in self._rows:
            raise BagError(f'topic {name} was not added; the topics added are '
                           f'{", ".join(self._rows) or "none"}', self.path)
        return self._rows[name][0]

    def write(self, topic: str, data: bytes, log_time_ns: int, publish_time_ns: int | None = None,
              sequence: int = 0) -> None:
        """
        Take one CDR message; it reaches the disk when its chunk ends.

        Parameters
        ----------
        topic
            A topic that was added.
        data
            The message with its four bytes of encapsulation.
        log_time_ns, publish_time_ns : int
            When it was received and sent, nanoseconds; by default sent when received.
        sequence
            Number that its publisher gave it.

        """
        log_time_ns = _check_time(log_time_ns)
        publish_time_ns = (log_time_ns if publish_time_ns is None
                           else _check_time(publish_time_ns))
        self._chunks.add(self._channel(topic), data, log_time_ns, publish_time_ns,
                         sequence % 2**32)
        if not self._chunks.pending:
            self.split_if_due()

    def write_rows(self, batches: Iterable[Rows]) -> None:
        """Take many messages of several topics, and merge them in the order of their log times."""
        records: list[bytes] = []
        channels, logs = [], []
        for rows in batches:
            number = self._channel(rows.topic)
            log = np.asarray(rows.log_time_ns, np.int64)
            if len(log):
                _check_time(int(log.min()))
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
        """Write a metadata record, also into later files of the bag; values become text."""
        self._records[name] = {str(k): str(v) for k, v in mapping.items()}
        self._chunks.add_metadata(name, self._records[name])

    def attachment(self, name: str, media_type: str, data: bytes, time_ns: int = 0) -> None:
        """Write a file into the bag."""
        self._chunks.add_attachment(name, media_type, data, _check_time(time_ns))

    def flush(self) -> None:
        """Write the messages in memory."""
        self._chunks.end_chunk()

    def flush_if_due(self, now_s: float) -> bool:
        """
        Write the messages in memory if `flush_interval_s` has passed; return whether it has.

        Call it often, at least twice per interval.

        Parameters
        ----------
        now_s
            The caller's steady clock, seconds.

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
        """Take the unwritten messages out of memory, each as arguments of `write`."""
        names = {number: name for name, (number, *_) in self._rows.items()}
        return [(names[number], data, log_time_ns, publish_time_ns, sequence)
                for number, data, log_time_ns, publish_time_ns, sequence
                in self._chunks.take_pending()]

    def check(self) -> None:
        """Raise FileNotFoundError if the current file is no longer in its place."""
        if not os.path.samestat(os.stat(self.file), os.fstat(self._file.fileno())):
            raise FileNotFoundError(errno.ENOENT, 'is another file now', str(self.file))

    @property
    def problem(self) -> OSError | None:
        """
        Why a new file or metadata.yaml could not be written; None if they could.

        No message is lost by this, and the writer tries again; `close` raises what remains.
        """
        return self._no_file or self._syncing.problem

    @property
    def absent(self) -> int:
        """Return the number of messages written to files that are no longer in their place."""
        parts = [*self._closed, self._part()]
        return sum(part.count for part in parts if not (self._folder / part.path).exists())

    def split(self) -> None:
        """
        Continue in a new file, and end the one before if it can be written.

        Raises
        ------
        OSError
            If no file can be created; the bag is then unchanged.

        """
        number = self._number + 1
        while self._place(number).exists():
            number += 1
        file, chunks = self._open_file(number)
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
        chunks.chain = old.chain
        self._file, self._chunks, self._number = file, chunks, number
        self._no_file = self._syncing.problem = None
        for message in waiting:
            chunks.add(*message)
        self._describe_record()
        self._described = False

    def split_if_due(self) -> None:
        """Continue in a new file if the settings say so; a failure only sets `problem`."""
        settings, chunks = self._settings, self._chunks
        if chunks.start_ns is None or chunks.end_ns is None:
            return
        span_s = (chunks.end_ns - chunks.start_ns) / 1e9
        if 0 < settings.split_bytes <= chunks.size or 0 < settings.split_duration_s <= span_s:
            try:
                self.split()
            except OSError as error:
                self._no_file = error

    def _part(self) -> PartInfo:
        """Return what metadata.yaml says about the current file."""
        rows = []
        for channel, row, *_ in self._rows.values():
            rows.append(replace(row, count=self._chunks.counts.get(channel, 0)))
        return PartInfo(self.file.name, self._chunks.start_ns, self._chunks.end_ns,
                        sum(self._chunks.counts.values()), rows)

    def _describe_record(self) -> None:
        """Write the metadata record that rosbag2 writes when it opens and closes a file."""
        text = bag_metadata([self._part()], {'software': self._software})
        self._chunks.add_metadata('rosbag2', {'serialized_metadata': text})

    def _description(self) -> tuple[Path, str]:
        """Return the path and text of metadata.yaml, for the files in their place."""
        parts = [part for part in (*self._closed, self._part())
                 if (self._folder / part.path).exists()]
        return self._folder / 'metadata.yaml', metadata_file(parts, {'software': self._software})

    def close(self) -> None:
        """Write the messages in memory and the end of the file; a second call does nothing."""
        if self._file.closed:
            return
        with ExitStack() as undo:
            undo.callback(self.abandon)
            self._chunks.end_chunk()
            self._describe_record()
            self._chunks.finish()
            self._chunks.sync()
            self._file.close()
            self._syncing.close()
            replace_file(*self._description())
            self._take_place()
            undo.pop_all()

    def _take_place(self) -> None:
        """Give a bag that was to appear whole its name."""
        if self._folder == self.path:
            return
        if os.path.lexists(self.path):
            raise BagError(_EXISTS, self.path)
        os.rename(self._folder, self.path)
        self._folder = self.path
        sync_folder(self.path.parent)
