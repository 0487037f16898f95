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

"""Bags of several files and chunks, and changes of them that leave every checksum right."""

from __future__ import annotations

from io import BytesIO
import zlib

from bags.mcap_bytes import MAGIC, record
from mcap import records as mcap
from mcap.data_stream import ReadDataStream

from heading_intercompare.bags.mcap.message_blocks import HEAD
from heading_intercompare.bags.recording.bag_writer import BagWriter
from heading_intercompare.bags.settings import BagSettings

TOPIC, STRING = '/x', 'std_msgs/msg/String'


def message(number: int) -> bytes:
    return b'\0\1\0\0\5\0\0\0%04d\0' % number


def write(path, compression='none', files=3):
    """Return a bag of five chunks in each of some files, and the chain of its writer."""
    with BagWriter(path, BagSettings(chunk_bytes=1024, compression=compression)) as bag:
        bag.add_topic(TOPIC, STRING)
        for part in range(files):
            if part:
                bag.split()
            for number in range(100):
                bag.write(TOPIC, message(number), 1000 * part + number, None, number)
    return path, bag.chain


def list_records(data: bytes):
    """Return the records of a file, each with its opcode."""
    at, records = 8, []
    while at < len(data) - 8:
        opcode, length = HEAD.unpack_from(data, at)
        records.append((opcode, data[at:at + HEAD.size + length]))
        at += HEAD.size + length
    return records


def change_a_byte(path):
    """Change a byte of a message within a chunk, and make the checksum of the chunk right."""
    file = path / 'bag_1.mcap'
    data = file.read_bytes()
    old = next(part for opcode, part in list_records(data) if opcode == 6)
    chunk = mcap.Chunk.read(ReadDataStream(BytesIO(old[HEAD.size:])))
    chunk.data = chunk.data.replace(b'0003', b'0009')
    chunk.uncompressed_crc = zlib.crc32(chunk.data)
    file.write_bytes(data.replace(old, record(chunk)))


def remove_a_chunk(path):
    """Remove the second chunk with its index; the first one has the definitions."""
    file = path / 'bag_1.mcap'
    records = [data for opcode, data in list_records(file.read_bytes()) if opcode in (1, 6, 7)]
    at = [at for at, data in enumerate(records) if data[0] == 6][1]
    file.write_bytes(MAGIC + b''.join([*records[:at], *records[at + 2:]]))


def swap_chunks(path):
    """Swap two chunks of a file, each with its index."""
    file = path / 'bag_1.mcap'
    records = [data for opcode, data in list_records(file.read_bytes()) if opcode in (1, 6, 7)]
    at = next(at for at, data in enumerate(records) if data[0] == 6)
    records[at:at + 4] = [*records[at + 2:at + 4], *records[at:at + 2]]
    file.write_bytes(MAGIC + b''.join(records))


def swap_files(path):
    (path / 'bag_0.mcap').rename(path / 'x')
    (path / 'bag_1.mcap').rename(path / 'bag_0.mcap')
    (path / 'x').rename(path / 'bag_1.mcap')


CHANGES = [change_a_byte, remove_a_chunk, swap_chunks, swap_files]
