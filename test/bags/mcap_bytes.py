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

"""MCAP files built by hand, right and wrong, and the check of a whole bag with `mcap`."""

from __future__ import annotations

from collections import Counter
from io import BytesIO
from pathlib import Path
import struct
from typing import Iterable, Iterator, NamedTuple
import zlib

import lz4.frame
from mcap import records as mcap
from mcap.data_stream import ReadDataStream, RecordBuilder
from mcap.reader import make_reader
from mcap.stream_reader import breakup_chunk, get_chunk_data_stream
import zstandard

from heading_intercompare.bags.rosbag2.bag_reader import BagReader
from heading_intercompare.bags.rosbag2.bag_yaml import Qos

MAGIC = b'\x89MCAP0\r\n'
HEADER = b'\x01' + struct.pack('<QI4sI', 12, 4, b'ros2', 0)
PACK = {'': bytes, 'lz4': lz4.frame.compress, 'zstd': zstandard.ZstdCompressor().compress}


class Sent(NamedTuple):
    """A message as `BagReader.messages` yields it, without its type."""

    topic: str
    log_time_ns: int
    publish_time_ns: int
    sequence: int
    data: bytes


def record(item: mcap.McapRecord) -> bytes:
    """Return a record as the library writes it."""
    builder = RecordBuilder()
    item.write(builder)
    return builder.end()


def schema(number: int, name: str = 'std_msgs/msg/String',
           text: bytes = b'string data\n') -> bytes:
    return record(mcap.Schema(id=number, name=name, encoding='ros2msg', data=text))


def channel(number: int, topic: str, schema_id: int = 1, encoding: str = 'cdr') -> bytes:
    """Return a channel with the metadata of `BagWriter`."""
    metadata = {'offered_qos_profiles': Qos().to_yaml(), 'topic_type_hash': ''}
    return record(mcap.Channel(id=number, topic=topic, message_encoding=encoding,
                               metadata=metadata, schema_id=schema_id))


def message(number: int, log: int, data: bytes, publish: int | None = None,
            sequence: int = 0) -> bytes:
    return b'\x05' + struct.pack('<QHIQQ', 22 + len(data), number, sequence, log,
                                 log if publish is None else publish) + data


def message_index(number: int, entries: Iterable[tuple[int, int]]) -> bytes:
    content = b''.join(struct.pack('<QQ', *entry) for entry in entries)
    return b'\x07' + struct.pack('<QHI', 6 + len(content), number, len(content)) + content


def entries_of(records: bytes) -> dict[int, list[tuple[int, int]]]:
    """Return the entries of the message indexes that belong to the records of a chunk."""
    found, at = {}, 0
    while at < len(records):
        opcode, length = struct.unpack_from('<BQ', records, at)
        if opcode == 5:
            number, _, log = struct.unpack_from('<HIQ', records, at + 9)
            found.setdefault(number, []).append((log, at))
        at += 9 + length
    return found


def chunk(*records: bytes, compression: str = 'zstd', crc: int | None = None,
          times: tuple[int, int] | None = None, size: int | None = None) -> bytes:
    """Return a chunk without indexes; its checksum, times and size are right unless given."""
    data = b''.join(records)
    if times is None:
        logs = [log for entries in entries_of(data).values() for log, _ in entries]
        times = min(logs, default=0), max(logs, default=0)
    return record(mcap.Chunk(
        compression=compression, data=PACK[compression](data), message_start_time=times[0],
        message_end_time=times[1], uncompressed_crc=zlib.crc32(data) if crc is None else crc,
        uncompressed_size=len(data) if size is None else size))


def indexed(*records: bytes, **options) -> bytes:
    """Return a chunk with right indexes."""
    rows = entries_of(b''.join(records))
    return chunk(*records, **options) + b''.join(message_index(*row) for row in rows.items())


def write(path: Path, *pieces: bytes) -> Path:
    """Write a file with a correct beginning and no end."""
    path.write_bytes(b''.join((MAGIC, HEADER, *pieces)))
    return path


def sent(bag: Path) -> list[Sent]:
    """Return the messages of a bag."""
    return [Sent(m.topic, m.log_time_ns, m.publish_time_ns, m.sequence, m.data)
            for m in BagReader(bag).messages()]


def assert_exact(bag: Path) -> None:
    """Check everything a bag says about its messages; decompress and count with `mcap`."""
    import yaml
    loader = getattr(yaml, 'CSafeLoader', yaml.SafeLoader)
    text = (bag / 'metadata.yaml').read_text()
    listed = yaml.load(text, loader)['rosbag2_bagfile_information']
    everything: Counter = Counter()
    spans = []
    for place in sorted(bag.glob('*.mcap'), key=lambda p: int(p.stem.rpartition('_')[2])):
        counts, first, last = _assert_file(place)
        everything += counts
        part = next(f for f in listed['files'] if f['path'] == place.name)
        assert part['message_count'] == sum(counts.values())
        if counts:
            assert part['starting_time']['nanoseconds_since_epoch'] == first
            assert part['duration']['nanoseconds'] == last - first
            spans.append((first, last))
    assert [f['path'] for f in listed['files']] == listed['relative_file_paths']
    assert {t['topic_metadata']['name']: t['message_count']
            for t in listed['topics_with_message_count'] if t['message_count']} == everything
    assert listed['message_count'] == sum(everything.values())
    if spans:
        start = min(first for first, _ in spans)
        assert listed['starting_time']['nanoseconds_since_epoch'] == start
        assert listed['duration']['nanoseconds'] == max(last for _, last in spans) - start


def _assert_file(path: Path) -> tuple[Counter, int, int]:
    """Check chunks, message indexes, chunk indexes and statistics of a file."""
    with open(path, 'rb') as file:
        summary = make_reader(file, validate_crcs=True).get_summary()
    rows = {row.chunk_start_offset: row for row in summary.chunk_indexes}
    topics, counts, logs, defined = {}, Counter(), [], {}
    for item, indexes, at, end in _chunks(path.read_bytes()):
        assert item.uncompressed_crc, 'a chunk without checksum'
        times = []
        for each in breakup_chunk(item, validate_crc=True):
            if isinstance(each, mcap.Message):
                counts[topics[each.channel_id]] += 1
                times.append(each.log_time)
                continue
            assert defined.setdefault((type(each), each.id), each) == each
            if isinstance(each, mcap.Channel):
                assert (mcap.Schema, each.schema_id) in defined
                topics[each.id] = each.topic
        logs += times
        data = get_chunk_data_stream(item)[0].read(item.uncompressed_size)
        assert {number: sorted(index.records, key=lambda entry: entry[1])
                for number, (index, _) in indexes.items() if index.records} == entries_of(data)
        row = rows.pop(at)
        assert row.message_index_offsets == {number: at for number, (_, at) in indexes.items()}
        assert row.message_index_length == sum(15 + 16 * len(index.records)
                                               for index, _ in indexes.values())
        assert (item.message_start_time, item.message_end_time) == (
            row.message_start_time, row.message_end_time) == (min(times), max(times))
        assert (row.chunk_length, row.compression, row.compressed_size, row.uncompressed_size) == (
            end - at, item.compression, len(item.data), len(data))
    assert not rows
    said = summary.statistics
    assert {topics[n]: count for n, count in said.channel_message_counts.items()} == counts
    assert said.message_count == sum(counts.values())
    assert said.chunk_count == len(summary.chunk_indexes)
    assert (said.channel_count, said.schema_count) == (len(summary.channels), len(summary.schemas))
    for definition in (*summary.channels.values(), *summary.schemas.values()):
        assert defined.get((type(definition), definition.id), definition) == definition
    first, last = min(logs, default=0), max(logs, default=0)
    assert (said.message_start_time, said.message_end_time) == (first, last)
    return counts, first, last


def _chunks(data: bytes) -> Iterator[tuple[mcap.Chunk, dict, int, int]]:
    """Yield the chunks of a whole file, message indexes with their places, first and last byte."""
    assert data.startswith(MAGIC) and data.endswith(MAGIC)
    at, opcode, last = len(MAGIC), 0, None
    while opcode != 0x0f:
        opcode, length = struct.unpack_from('<BQ', data, at)
        stream = ReadDataStream(BytesIO(data[at + 9:at + 9 + length]))
        if opcode == 7:
            index = mcap.MessageIndex.read(stream)
            assert index.channel_id not in last[1]
            last[1][index.channel_id] = index, at
        elif last:
            yield last
            last = None
        if opcode == 6:
            last = mcap.Chunk.read(stream), {}, at, at + 9 + length
        at += 9 + length
