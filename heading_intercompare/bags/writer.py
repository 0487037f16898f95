# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Bags written as rosbag2 writes them, but chunk by chunk to the disk."""

from __future__ import annotations

from dataclasses import dataclass
import os
from pathlib import Path
from typing import Iterable, Mapping

from mcap.opcode import Opcode
import numpy as np
from numpy.typing import ArrayLike

from heading_intercompare.core.version import VERSION

from .bag_yaml import bag_metadata, PartInfo, Qos, TopicRow
from .blocks import HEAD, MESSAGE_HEADS
from .chunk_writer import ChunkWriter
from .errors import BagError
from .schemas import Schema, schema_of
from .settings import BagSettings

__all__ = ['BagWriter', 'Rows']

@dataclass(frozen=True, slots=True, eq=False)
class Rows:
    """
    Many messages of one topic.

    Attributes
    ----------
    topic : str
        A topic that was added.
    data : ndarray of uint8, shape (n, size)
        One CDR message a row.
    log_time_ns : array_like of int, shape (n,)
        Nanoseconds; also the publish time unless that is given.
    publish_time_ns : array_like of int, shape (n,), optional
        Nanoseconds.
    sequence : array_like of int, shape (n,) or scalar
        Sequence numbers.

    """

    topic: str
    data: np.ndarray
    log_time_ns: ArrayLike
    publish_time_ns: ArrayLike | None = None
    sequence: ArrayLike = 0

    def records(self, channel: int) -> list[bytes]:
        """Return the message records of MCAP."""
        count, size = self.data.shape
        log = np.asarray(self.log_time_ns)
        head = np.empty(count, MESSAGE_HEADS)
        head['opcode'], head['channel'] = Opcode.MESSAGE, channel
        head['length'] = head.itemsize - HEAD.size + size
        head['sequence'], head['log_time'] = self.sequence, log
        head['publish_time'] = log if self.publish_time_ns is None else self.publish_time_ns
        records = np.empty((count, head.itemsize + size), np.uint8)
        records[:, :head.itemsize] = head.view(np.uint8).reshape(count, head.itemsize)
        records[:, head.itemsize:] = self.data
        return records.view(f'V{records.shape[1]}').ravel().tolist()


def _topic_name(topic: str) -> str:
    return topic if topic.startswith('/') else f'/{topic}'


def _checked_time(time_ns: int) -> int:
    if not 0 <= time_ns < 2**63:
        raise BagError(f'a bag holds no time of {time_ns} ns: it must not be before 1970')
    return int(time_ns)


class BagWriter:
    """
    A rosbag2 directory being written: `name/name_0.mcap` and `name/metadata.yaml`.

    Parameters
    ----------
    path : str or path
        The directory; it must not exist.
    settings : BagSettings
        Chunks, compression, flush interval.
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
    >>> from heading_intercompare.bags.cdr import encode
    >>> folder = tempfile.TemporaryDirectory()
    >>> with BagWriter(folder.name + '/trial') as bag:
    ...     bag.add_topic('/remark', 'std_msgs/msg/String')
    ...     bag.write('/remark', encode('std_msgs/msg/String', {'data': 'all fast'}), 10**18)
    >>> sorted(file.name for file in bag.path.iterdir())
    ['metadata.yaml', 'trial_0.mcap']
    >>> folder.cleanup()

    """

    def __init__(self, path: str | os.PathLike[str], settings: BagSettings | None = None, *,
                 software: str = f'heading_intercompare {VERSION}') -> None:
        self.path = Path(path)
        self._settings = settings = settings or BagSettings()
        self._software = software
        self._rows: dict[str, tuple[int, TopicRow]] = {}
        self._last_flush_s: float | None = None
        try:
            self.path.mkdir(parents=True)
        except FileExistsError:
            raise BagError('exists already; a bag is never overwritten', self.path) from None
        self._name = f'{self.path.resolve().name}_0.mcap'
        self._file = open(self.path / self._name, 'xb', buffering=0)
        try:
            self._chunks = ChunkWriter(self._file, settings.compression, settings.chunk_bytes,
                                       software)
            self._describe(record=True)
        except OSError:
            self._file.close()
            raise

    def __enter__(self) -> 'BagWriter':
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    @property
    def topics(self) -> tuple[str, ...]:
        """Names of the topics added."""
        return tuple(self._rows)

    def add_topic(self, topic: str, type_name: str, qos: Qos | None = None, *,
                  schema: Schema | None = None) -> None:
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
            return
        schema, qos = schema or schema_of(type_name), qos or Qos()
        number = self._chunks.add_channel(name, type_name, schema.text, {
            'offered_qos_profiles': qos.to_yaml(), 'topic_type_hash': schema.type_hash},
            schema.encoding)
        self._rows[name] = number, TopicRow(name, type_name, schema.type_hash, qos)
        self._describe(record=False)

    def _number(self, topic: str) -> int:
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
        self._chunks.add(self._number(topic), data, log_time_ns, publish_time_ns,
                         sequence % 2**32)

    def write_rows(self, batches: Iterable[Rows]) -> None:
        """Take many messages of several topics, merged in the order of their log times."""
        records: list[bytes] = []
        channels, logs = [], []
        for rows in batches:
            number = self._number(rows.topic)
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

    def metadata(self, name: str, mapping: Mapping[str, object]) -> None:
        """Write a metadata record; values become text."""
        self._chunks.add_metadata(name, {str(k): str(v) for k, v in mapping.items()})

    def attachment(self, name: str, media_type: str, data: bytes, time_ns: int = 0) -> None:
        """Write a file into the bag."""
        self._chunks.add_attachment(name, media_type, data, _checked_time(time_ns))

    def flush(self) -> None:
        """End the chunk and return when it is on the disk."""
        if self._chunks.pending:
            self._chunks.end_chunk()
            self._chunks.sync()

    def flush_if_due(self, now_s: float) -> bool:
        """
        Flush if `flush_interval_s` has passed since the last time; say whether it did.

        Parameters
        ----------
        now_s : float
            The caller's steady clock, seconds. Call it often, at least twice an interval.

        """
        if self._last_flush_s is None:
            self._last_flush_s = now_s
        if now_s - self._last_flush_s < self._settings.flush_interval_s:
            return False
        self.flush()
        self._last_flush_s = now_s
        return True

    def _describe(self, record: bool) -> None:
        """Write metadata.yaml, and into the file what rosbag2 writes at open and close."""
        for number, row in self._rows.values():
            row.count = self._chunks.counts.get(number, 0)
        part = PartInfo(self._name, self._chunks.start_ns, self._chunks.end_ns,
                        sum(self._chunks.counts.values()), [row for _, row in self._rows.values()])
        file_text, record_text = bag_metadata(part, {'software': self._software})
        if record:
            self._chunks.add_metadata('rosbag2', {'serialized_metadata': record_text})
        target = self.path / 'metadata.yaml'
        draft = target.with_suffix('.yaml.part')
        with open(draft, 'w', encoding='utf-8') as file:
            file.write(file_text)
            file.flush()
            os.fsync(file.fileno())
        os.replace(draft, target)
        folder = os.open(self.path, os.O_RDONLY)
        try:
            os.fsync(folder)
        finally:
            os.close(folder)

    def close(self) -> None:
        """Write what is in memory and the end of the file; a second time does nothing."""
        if self._file.closed:
            return
        try:
            self._chunks.end_chunk()
            self._describe(record=True)
            self._chunks.finish()
            self._chunks.sync()
        finally:
            self._file.close()
