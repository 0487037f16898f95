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

"""Chunks that unpack to gigabytes are read piece by piece, and only if they prove themselves."""

from __future__ import annotations

from pathlib import Path
import tracemalloc

from bags.mcap_bytes import channel, chunk, message, schema, write
import numpy as np
import pytest

from heading_intercompare.bags.mcap import chunk_runs, chunks, record_stream
from heading_intercompare.bags.rosbag2.bag_check import check_bag
from heading_intercompare.bags.rosbag2.bag_reader import BagReader
from heading_intercompare.core.records import Headings
from heading_intercompare.messages.heading_messages import encode_imu, IMU
from heading_intercompare.messages.schemas import shipped_schema

TOPIC = '/ts/heading'
START_NS = 10**18


def bomb(path: Path, count: int, zeros: int, compression: str = 'zstd', **options) -> Path:
    """Write a chunk of headings, each with zeros after it that nobody reads."""
    rows = encode_imu(Headings.of(START_NS + np.arange(count), np.arange(count) % 360.0), 'x')
    return write(path, chunk(
        schema(1, IMU, shipped_schema(IMU).text.encode()), channel(1, TOPIC),
        *(message(1, START_NS + at, row.tobytes() + bytes(zeros)) for at, row in enumerate(rows)),
        compression=compression, **options))


def read(path: Path) -> list[int]:
    return [stamp for found in BagReader(path).headings({TOPIC: 'enu'})
            for stamp in found[TOPIC].stamp_ns.tolist()]


@pytest.fixture
def small(monkeypatch) -> None:
    """Let chunks of 100 kB count as large, and let pieces be small."""
    monkeypatch.setattr(chunks, 'LARGE_BYTES', 100_000)
    monkeypatch.setattr(chunks, '_PIECE_BYTES', 10_000)
    monkeypatch.setattr(chunks, '_PACKED_BYTES', 777)


@pytest.mark.slow
@pytest.mark.parametrize('compression', ['zstd', 'lz4'])
def test_memory_is_that_of_a_few_pieces(tmp_path, compression):
    path = bomb(tmp_path / 'x.mcap', 300, 2**20, compression)
    assert path.stat().st_size < 2e6
    tracemalloc.start()
    try:
        assert len(read(path)) == check_bag(path).messages == 300
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert peak < 100e6


@pytest.mark.usefixtures('small')
@pytest.mark.parametrize('compression', ['', 'lz4', 'zstd'])
def test_pieces_give_the_same_readings(tmp_path, compression):
    path = bomb(tmp_path / 'x.mcap', 500, 137, compression)
    assert read(path) == [*range(START_NS, START_NS + 500)]
    assert [m.log_time_ns for m in BagReader(path).messages(
        [TOPIC], START_NS + 10, START_NS + 20)] == [*range(START_NS + 10, START_NS + 20)]
    assert check_bag(path).messages == 500


@pytest.mark.usefixtures('small')
@pytest.mark.parametrize('compression', ['', 'lz4', 'zstd'])
@pytest.mark.parametrize('options', [{'crc': 1}, {'size': 200_001}, {'size': 2**31 - 1}])
def test_nothing_is_read_of_a_large_chunk_that_is_not_what_its_head_says(tmp_path, compression,
                                                                        options):
    sound = bomb(tmp_path / 'y.mcap', 500, 137, compression).read_bytes()
    piece = bomb(tmp_path / 'x.mcap', 500, 137, compression, **options).read_bytes()[29:]
    path = tmp_path / 'x.mcap'
    path.write_bytes(sound + piece)
    reader = BagReader(path)
    assert 'chunk damaged' in reader.incomplete
    assert read(path) == [*range(START_NS, START_NS + 500)]


@pytest.mark.usefixtures('small')
def test_a_record_that_claims_to_fill_the_memory_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(chunks, 'RECORD_BYTES', 50_000)
    claim = b'\3' + (60_000).to_bytes(8, 'little') + bytes(160_000)
    path = write(tmp_path / 'x.mcap', chunk(claim, times=(0, 0)))
    assert 'a record in it claims more than 50000 bytes' in BagReader(path).incomplete


CAMERA = '/camera'


def with_images(path: Path, images: tuple[int, ...], size: int, compression: str | None) -> Path:
    """Write 200 headings, with images between them, in one chunk or outside of chunks."""
    rows = encode_imu(Headings.of(START_NS + np.arange(200), np.arange(200) % 360.0), 'x')
    records = [schema(1, IMU, shipped_schema(IMU).text.encode()), channel(1, TOPIC),
               schema(2, 'sensor_msgs/msg/Image', b'uint8[] data'), channel(2, CAMERA, 2)]
    for at, row in enumerate(rows):
        records.append(message(1, START_NS + at, row.tobytes()))
        records += [message(2, START_NS + at, bytes(size)) for _ in range(images.count(at))]
    return write(path, *(records if compression is None else [
        chunk(*records, compression=compression)]))


@pytest.mark.usefixtures('small')
@pytest.mark.parametrize('compression', ['', 'lz4', 'zstd', None])
@pytest.mark.parametrize('images', [(0,), (50, 50), (3, 120), (199,), (0, 0, 199, 199)])
@pytest.mark.parametrize('size', [60_000, 160_001])
def test_a_large_message_of_another_topic_is_passed_over(tmp_path, monkeypatch, compression,
                                                         images, size):
    for module in (chunks, record_stream):
        monkeypatch.setattr(module, 'RECORD_BYTES', 50_000)
    monkeypatch.setattr(record_stream, '_BARE_BYTES', 10_000)
    path = with_images(tmp_path / 'x.mcap', images, size, compression)
    assert read(path) == [*range(START_NS, START_NS + 200)]
    checked = check_bag(path)
    assert checked.messages == 200 + len(images)
    reader = BagReader(path)
    assert reader.topics[CAMERA].count == len(images)
    assert [m.log_time_ns for m in reader.messages([TOPIC])] == [*range(START_NS, START_NS + 200)]
    assert not any('passed over' in oddity for oddity in reader.oddities)
    assert {m.topic for m in reader.messages()} == {TOPIC}
    assert sum(f'messages of {CAMERA} with more than' in oddity
               for oddity in reader.oddities) == 1


@pytest.mark.usefixtures('small')
@pytest.mark.parametrize('compression', ['', 'lz4', 'zstd'])
def test_a_large_message_that_ends_after_its_chunk_is_damage(tmp_path, monkeypatch, compression):
    monkeypatch.setattr(chunks, 'RECORD_BYTES', 50_000)
    path = write(tmp_path / 'x.mcap', chunk(message(2, START_NS, bytes(160_000))[:-5],
                                            times=(0, 0), compression=compression))
    assert 'a record in it has a wrong length' in BagReader(path).incomplete


@pytest.mark.usefixtures('small')
@pytest.mark.parametrize('compression', ['none', 'lz4', 'zstd'])
def test_a_large_chunk_is_where_the_index_says(write_bag, monkeypatch, compression):
    monkeypatch.setattr(chunk_runs, 'LARGE_BYTES', 100_000)
    checked = check_bag(write_bag(chunk_bytes=200_000, compression=compression))
    assert checked.faults == [] and checked.chunks > 1


@pytest.mark.slow
@pytest.mark.parametrize('compression', ['', 'zstd', None])
def test_an_image_of_200_mb_does_not_fill_the_memory(tmp_path, compression):
    path = with_images(tmp_path / 'x.mcap', (100,), 200_000_000, compression)
    tracemalloc.start()
    try:
        assert len(read(path)) == check_bag(path).messages - 1 == 200
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert peak < 60e6


@pytest.mark.usefixtures('small')
@pytest.mark.parametrize('wrong', [b'\5' + (2**40).to_bytes(8, 'little') + bytes(400_000),
                                   bytes(400_000)])
def test_of_a_large_chunk_with_a_wrong_record_nothing_is_counted(tmp_path, wrong):
    """The messages before it come in blocks, but the chunk is no part of what can be read."""
    rows = encode_imu(Headings.of(START_NS + np.arange(500), np.arange(500) % 360.0), 'x')
    text = shipped_schema(IMU).text.encode()
    messages = [message(1, START_NS + at, row.tobytes()) for at, row in enumerate(rows)]
    path = write(tmp_path / 'x.mcap', chunk(schema(1, IMU, text), channel(1, TOPIC), *messages),
                 chunk(*messages, wrong, times=(START_NS, START_NS + 500)))
    reader = BagReader(path)
    assert 'chunk damaged: a record in it' in reader.incomplete
    assert reader.topics[TOPIC].count == len(read(path)) == len(list(reader.messages())) == 500
