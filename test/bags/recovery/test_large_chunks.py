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

"""Recovery of chunks that unpack to gigabytes: piece by piece, with the same result."""

from __future__ import annotations

import io
from pathlib import Path
import random
import tracemalloc

from bags.mcap_bytes import (
    assert_exact,
    channel,
    chunk,
    indexed,
    message,
    record,
    schema,
    Sent,
    sent,
    write,
)
from mcap.records import Metadata
import pytest

from heading_intercompare.bags.mcap import chunk_runs, chunks
from heading_intercompare.bags.recovery import scanner
from heading_intercompare.bags.recovery.recover_bag import recover
from heading_intercompare.bags.recovery.recovered import Recovered
from heading_intercompare.bags.recovery.scanner import Salvage
from heading_intercompare.bags.rosbag2.bag_reader import BagReader

COMPRESSIONS = ['', 'lz4', 'zstd']
#: The messages of a large chunk; they fill several blocks of the compression.
N = 500


def payload(number: int) -> bytes:
    return b'\0\1\0\0%04d' % number + random.Random(number).randbytes(1000 + number % 200)


def row(number: int, topic: int = 1) -> bytes:
    return message(topic, 1000 + number, payload(number))


def as_sent(numbers: range, topic: str = '/a') -> list[Sent]:
    return [Sent(topic, 1000 + n, 1000 + n, 0, payload(n)) for n in numbers]


def large(compression: str = 'zstd', *others: bytes, **options) -> bytes:
    return chunk(schema(1), channel(1, '/a'), *map(row, range(N)), *others,
                 compression=compression, **options)


def small(first: int, count: int) -> bytes:
    return indexed(schema(1), channel(1, '/a'), *map(row, range(first, first + count)))


@pytest.fixture
def of_pieces(monkeypatch) -> None:
    """Let chunks of 20 kB count as large, and let pieces be small."""
    for module in (chunks, chunk_runs, scanner):
        monkeypatch.setattr(module, 'LARGE_BYTES', 20_000)
    monkeypatch.setattr(chunk_runs, '_RUN_BYTES', 20_000)
    monkeypatch.setattr(chunks, '_PIECE_BYTES', 3_000)
    monkeypatch.setattr(chunks, '_PACKED_BYTES', 777)


def recovered(path: Path) -> tuple[Recovered, list[Sent]]:
    new = path.with_suffix('.new')
    total = recover(path, new)
    assert_exact(new)
    assert BagReader(new).incomplete is None
    return total, sent(new)


@pytest.mark.slow
@pytest.mark.parametrize('compression', ['zstd', 'lz4'])
def test_memory_is_that_of_a_few_pieces(tmp_path, compression):
    rows = [message(1, n, bytes(2**20)) for n in range(400)]
    path = write(tmp_path / 'x.mcap', chunk(schema(1), channel(1, '/a'), *rows,
                                            compression=compression))
    del rows
    assert path.stat().st_size < 2e6
    tracemalloc.start()
    try:
        assert recover(path, tmp_path / 'new').messages == 400
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert peak < 100e6


@pytest.mark.usefixtures('of_pieces')
@pytest.mark.parametrize('compression', COMPRESSIONS)
@pytest.mark.parametrize('crc', [None, 0])
def test_a_whole_large_chunk_comes_back_whole(tmp_path, compression, crc):
    path = write(tmp_path / 'x.mcap', small(N, 5), large(compression, crc=crc), small(N + 5, 5))
    total, found = recovered(path)
    assert found == as_sent(range(N, N + 5)) + as_sent(range(N)) + as_sent(range(N + 5, N + 10))
    assert (total.messages, total.messages_lost, total.chunks_lost, total.bytes_lost) == (
        N + 10, 0, 0, 0)


@pytest.mark.usefixtures('of_pieces')
@pytest.mark.parametrize('compression', COMPRESSIONS)
@pytest.mark.parametrize('share', [0.3, 0.9])
@pytest.mark.parametrize('rest', [b'', small(N, 5)])
def test_the_beginning_of_a_large_chunk_that_is_cut_is_kept(tmp_path, compression, share, rest):
    whole = large(compression)
    path = write(tmp_path / 'x.mcap', whole[:int(share * len(whole))], rest)
    total, found = recovered(path)
    kept = total.messages - (5 if rest else 0)
    assert 0.5 * share * N < kept < N
    assert found == as_sent(range(kept)) + (as_sent(range(N, N + 5)) if rest else [])
    assert total.chunks_lost == 1
    assert ('a chunk ends early' if rest else 'the file ends within a chunk') in total.notes[0]


@pytest.mark.usefixtures('of_pieces')
@pytest.mark.parametrize('compression', COMPRESSIONS)
def test_a_large_chunk_whose_checksum_is_wrong_is_left_out(tmp_path, compression):
    path = write(tmp_path / 'x.mcap', small(N, 5), large(compression, crc=1), small(N + 5, 5))
    total, found = recovered(path)
    assert found == as_sent(range(N, N + 10))
    assert total.chunks_lost == 1


@pytest.mark.usefixtures('of_pieces')
@pytest.mark.parametrize('compression', COMPRESSIONS)
def test_the_wrong_size_of_a_large_chunk_is_mended(tmp_path, compression):
    path = write(tmp_path / 'x.mcap', small(N, 5), large(compression, size=200_001))
    total, found = recovered(path)
    assert found == as_sent(range(N, N + 5)) + as_sent(range(N))
    assert (total.messages_lost, total.chunks_lost, total.damaged) == (0, 0, True)


@pytest.mark.usefixtures('of_pieces')
@pytest.mark.parametrize('wrong', [
    b'\5' + (7).to_bytes(8, 'little') + bytes(7),
    b'\5' + (2**40).to_bytes(8, 'little') + bytes(40)])
@pytest.mark.parametrize('crc', [None, 0])
def test_the_messages_before_a_wrong_record_are_kept(tmp_path, wrong, crc):
    path = write(tmp_path / 'x.mcap', large('zstd', wrong, row(N), crc=crc), small(N + 5, 5))
    total, found = recovered(path)
    assert found == as_sent(range(N)) + as_sent(range(N + 5, N + 10))
    assert 'a record in it has a wrong length' in total.notes[0]
    assert total.chunks_lost == 1


@pytest.mark.usefixtures('of_pieces')
def test_other_records_in_a_chunk_that_proves_itself_do_not_end_it(tmp_path):
    extra = record(Metadata(name='x', metadata={}))
    path = write(tmp_path / 'x.mcap', large('zstd', extra, row(N)))
    assert recovered(path)[1] == as_sent(range(N + 1))


@pytest.mark.usefixtures('of_pieces')
def test_a_channel_that_is_defined_after_its_messages_names_them(tmp_path):
    rows = [row(n, 1 + n % 2) for n in range(N)]
    path = write(tmp_path / 'x.mcap', chunk(schema(1), channel(1, '/a'), *rows, channel(2, '/b')))
    total, found = recovered(path)
    assert total.counts == {'/a': N / 2, '/b': N / 2} and not total.chunks_lost
    assert [(m.topic, m.data) for m in found] == [
        ('/b' if n % 2 else '/a', payload(n)) for n in range(N)]


@pytest.mark.usefixtures('of_pieces')
@pytest.mark.parametrize('left, messages', [(1.0, N), (0.9, 350), (0.3, 100)])
def test_a_large_chunk_tells_how_much_of_it_is_lost(left, messages):
    data = large()
    item, *_ = Salvage(io.BytesIO(data[:int(left * len(data))])).scan()
    assert sum(len(block.start) for block in item.part.blocks()) >= messages
    assert (item.part.lost == 0.0) is (left == 1.0) and item.part.lost < 0.5


@pytest.mark.usefixtures('of_pieces')
def test_a_large_chunk_with_a_wrong_checksum_is_kept_if_asked_for(tmp_path):
    path = write(tmp_path / 'x.mcap', large('zstd', crc=1), small(N, 5))
    total = recover(path, tmp_path / 'new', unproven=True)
    assert (total.messages, total.messages_unproven) == (N + 5, N)
    assert sent(tmp_path / 'new') == as_sent(range(N + 5))
