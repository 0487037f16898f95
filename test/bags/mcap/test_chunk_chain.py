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

"""The hash chain through the chunks of a bag: writer and readers agree, and every change shows."""

from __future__ import annotations

from hashlib import sha256
import struct

from bags.chained_bags import CHANGES, list_records, message, STRING, swap_files, TOPIC, write
import pytest

from heading_intercompare.bags.mcap.chunk_chain import ChunkChain
from heading_intercompare.bags.recording.bag_writer import BagWriter
from heading_intercompare.bags.recovery.recover_bag import recover
from heading_intercompare.bags.rosbag2.bag_chain import read_chain
from heading_intercompare.bags.rosbag2.bag_check import check_bag
from heading_intercompare.bags.rosbag2.bag_reader import BagReader
from heading_intercompare.bags.settings import BagSettings


def by_hand(path) -> ChunkChain:
    """H_i = SHA-256(H_(i-1) ' ' SHA-256 of record i), by a plain loop."""
    newest, chunks = '0' * 64, 0
    for file in sorted(path.glob('*.mcap')):
        for opcode, data in list_records(file.read_bytes()):
            if opcode == 6:
                text = f'{newest} {sha256(data).hexdigest()}'
                newest, chunks = sha256(text.encode()).hexdigest(), chunks + 1
    return ChunkChain(chunks, newest)


@pytest.mark.parametrize('compression', ['none', 'lz4', 'zstd'])
@pytest.mark.parametrize('files', [1, 3])
def test_writer_check_and_reader_have_the_chain_of_a_plain_loop(tmp_path, compression, files):
    path, chain = write(tmp_path / 'bag', compression, files)
    assert chain.chunks > 2 * files
    assert by_hand(path) == chain == check_bag(path).chain == read_chain(path, 10**9)
    assert read_chain(path, chain.chunks) == chain
    assert read_chain(path, 1).chunks == 1 and read_chain(path, 0) == ChunkChain()


def test_a_bag_that_was_cut_off_keeps_the_chain_of_its_whole_chunks(tmp_path):
    bag = BagWriter(tmp_path / 'bag', BagSettings(chunk_bytes=1024))
    bag.add_topic(TOPIC, STRING)
    for number in range(100):
        bag.write(TOPIC, message(number), number, None, number)
    chain = bag.chain
    bag.abandon()
    assert chain.chunks > 2 and check_bag(tmp_path / 'bag').chain == chain
    file, = (tmp_path / 'bag').glob('*.mcap')
    with file.open('ab') as torn:
        torn.write(b'\x06' + struct.pack('<Q', 500) + b'torn')
    assert read_chain(tmp_path / 'bag', 10**9) == chain


def test_a_failed_write_is_no_link_of_the_chain(tmp_path, monkeypatch):
    bag = BagWriter(tmp_path / 'bag', BagSettings(chunk_bytes=10**6))
    bag.add_topic(TOPIC, STRING)
    bag.write(TOPIC, message(1), 1, None, 1)
    monkeypatch.setattr(bag.chunks, '_append', lambda data: (_ for _ in ()).throw(OSError('full')))
    with pytest.raises(OSError):
        bag.flush()
    assert bag.chain == ChunkChain()
    monkeypatch.undo()
    bag.close()
    assert bag.chain == check_bag(bag.path).chain and bag.chain.chunks == 1


def test_a_recovered_bag_has_the_chain_of_its_own_chunks(tmp_path):
    path, _ = write(tmp_path / 'bag')
    recover(path, tmp_path / 'recovered')
    assert by_hand(tmp_path / 'recovered') == check_bag(tmp_path / 'recovered').chain


@pytest.mark.parametrize('change', CHANGES)
def test_each_change_that_the_checksums_allow_changes_the_chain(tmp_path, change):
    path, chain = write(tmp_path / 'bag')
    before = [m.data for m in BagReader(path).messages()]
    change(path)
    assert [m.data for m in BagReader(path).messages()] != before or change is swap_files
    assert read_chain(path, chain.chunks) != chain
    assert check_bag(path).chain != chain
