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

"""What the indexes of a file say is compared with its chunks."""

from __future__ import annotations

from pathlib import Path
import struct
from typing import Callable
import zlib

from mcap.opcode import Opcode
from mcap.reader import make_reader
import pytest

from heading_intercompare.bags.errors import BagError
from heading_intercompare.bags.recovery.recover_bag import recover
from heading_intercompare.bags.rosbag2.bag_check import check_bag
from heading_intercompare.bags.rosbag2.bag_reader import BagReader

TOPICS = ('/ts/heading', '/rs/heading')


@pytest.fixture
def file(write_bag) -> Path:
    """Return a file of chunks of equal size, as the messages of each topic have one size."""
    return write_bag(chunk_bytes=20_000, compression='none') / 'trial_0.mcap'


def chunks_of(path: Path) -> list[tuple[int, int]]:
    """Return the first byte of each chunk, and the byte after its message indexes."""
    with open(path, 'rb') as file:
        rows = make_reader(file).get_summary().chunk_indexes
    return sorted((row.chunk_start_offset, row.chunk_start_offset + row.chunk_length
                   + row.message_index_length) for row in rows)


def swap_chunks(path: Path) -> None:
    """Swap the chunks of a file, of two of equal length each with its place in the index."""
    data = path.read_bytes()
    places = chunks_of(path)
    first, second = places[1], next(each for each in places[2:]
                                    if each[1] - each[0] == places[1][1] - places[1][0])
    (a, b), (c, d) = first, second
    path.write_bytes(data[:a] + data[c:d] + data[b:c] + data[a:b] + data[d:])


def change_index(path: Path, change: Callable[[bytearray], None]) -> None:
    """Change the first entry of the index, and renew the checksum of the summary."""
    data = bytearray(path.read_bytes())
    footer = len(data) - 8 - 29
    start, = struct.unpack_from('<Q', data, footer + 9)
    at = start
    while data[at] != Opcode.CHUNK_INDEX:
        at += 9 + int.from_bytes(data[at + 1:at + 9], 'little')
    entry = bytearray(data[at + 9:at + 9 + int.from_bytes(data[at + 1:at + 9], 'little')])
    change(entry)
    data[at + 9:at + 9 + len(entry)] = entry
    data[footer + 25:footer + 29] = zlib.crc32(data[start:footer + 25]).to_bytes(4, 'little')
    path.write_bytes(data)


def add_to(place: int, n: int = 1) -> Callable[[bytearray], None]:
    def change(entry: bytearray) -> None:
        at = place % len(entry)
        value = int.from_bytes(entry[at:at + 8], 'little') + n
        entry[at:at + 8] = value.to_bytes(8, 'little')
    return change


def test_swapped_chunks_are_named_refused_and_recovered(file, tmp_path):
    sound = list(BagReader(file).messages())
    swap_chunks(file)
    faults = check_bag(file).faults
    assert any('does not fit this chunk' in fault for fault in faults)
    with pytest.raises(BagError, match='the index of the file does not fit this chunk'):
        list(BagReader(file).headings(dict.fromkeys(TOPICS, 'enu')))
    total = recover(file, tmp_path / 'new')
    assert total.messages == len(sound) and total.messages_lost == 0 and total.damaged
    assert any('not the chunks that its index names' in note for note in total.notes)
    assert check_bag(tmp_path / 'new').faults == []
    assert set(check_bag(tmp_path / 'new').late) == set(TOPICS)
    reader = BagReader(tmp_path / 'new')
    assert sorted(reader.messages()) == sorted(sound)
    stamps = [stamp for chunk in reader.headings({TOPICS[0]: 'enu'})
              for stamp in chunk[TOPICS[0]].stamp_ns.tolist()]
    assert stamps == sorted(stamps) and len(reader.oddities) == 1


@pytest.mark.parametrize('place, words', [
    (0, 'does not fit this chunk'), (8, 'does not fit this chunk'),
    (16, 'does not fit this chunk'), (-8, 'does not fit this chunk'),
    (24, 'the index has other length of the chunk at byte'),
    (38, 'the index has other places of its message indexes of the chunk at byte'),
    (-16, 'the index has other sizes of the chunk at byte')])
def test_each_field_of_the_index_is_compared(file, place, words):
    change_index(file, add_to(place))
    assert any(words in fault for fault in check_bag(file).faults)


def test_a_message_index_that_names_other_messages_is_found(file):
    data = bytearray(file.read_bytes())
    begin, end = chunks_of(file)[0]
    length = int.from_bytes(data[begin + 1:begin + 9], 'little')
    # The log time of the first entry of the first message index.
    data[begin + 9 + length + 15] ^= 1
    file.write_bytes(data)
    assert any('message indexes after the chunk at byte' in fault
               for fault in check_bag(file).faults)


def test_a_sound_bag_has_no_fault_and_no_late_message(write_bag):
    for compression in ('none', 'zstd'):
        found = check_bag(write_bag(compression, chunk_bytes=5000, compression=compression))
        assert found.faults == [] and found.late == {}


def test_faults_without_number_are_cut_short(file):
    data = bytearray(file.read_bytes())
    for begin, _ in chunks_of(file):
        length = int.from_bytes(data[begin + 1:begin + 9], 'little')
        data[begin + 9 + length + 15] ^= 1
    file.write_bytes(data)
    faults = check_bag(file).faults
    assert len(faults) == 6 and 'more such faults' in faults[-1]
