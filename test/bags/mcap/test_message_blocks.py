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

"""The index of a chunk is believed only if it is right; the walk gives the same."""

from __future__ import annotations

import math

from mcap.opcode import Opcode
import numpy as np
import pytest

from heading_intercompare.bags.errors import BagError
from heading_intercompare.bags.mcap.message_blocks import (
    Block,
    block_of,
    HEAD,
    measure_whole,
    MESSAGE_HEAD,
    walk,
)

hypothesis = pytest.importorskip('hypothesis')
st = hypothesis.strategies


def message(channel: int, number: int, size: int) -> bytes:
    return MESSAGE_HEAD.pack(Opcode.MESSAGE, 22 + size, channel, number, 100 + number,
                             200 + number) + bytes([number % 256]) * size


def other(size: int) -> bytes:
    return HEAD.pack(Opcode.SCHEMA, size) + b'\x05' * size


def records(parts: list[tuple[int, int]]) -> tuple[bytes, list[int]]:
    """Return messages, with a channel above 0, and other records, and where the former are."""
    data, offsets = b'', []
    for number, (channel, size) in enumerate(parts):
        if channel:
            offsets.append(len(data))
        data += message(channel, number, size) if channel else other(size)
    return data, offsets


def same(a: Block, b: Block) -> bool:
    return (np.array_equal(a.start, b.start) and np.array_equal(a.stop, b.stop)
            and a.heads.tobytes() == b.heads.tobytes() and a.others == b.others)


PARTS = st.lists(st.tuples(st.integers(0, 3), st.integers(0, 40)), max_size=20)


@pytest.mark.slow
@hypothesis.given(PARTS, st.randoms())
def test_index_and_walk_find_the_same_messages(parts, random):
    data, offsets = records(parts)
    random.shuffle(offsets)
    assert same(block_of(data, 0, lambda: np.array(offsets, np.int64)), block_of(data, 0))


@hypothesis.given(PARTS, st.data())
def test_a_wrong_index_does_no_harm(parts, data):
    content, offsets = records(parts)
    wrong = data.draw(st.lists(st.sampled_from(offsets or [0]), max_size=25)
                      | st.lists(st.integers(-2**63, 2**63 - 1), max_size=5)
                      | st.lists(st.integers(0, len(content)), max_size=25))
    assert same(block_of(content, 0, lambda: np.array(wrong, np.int64)), block_of(content, 0))


def test_columns_are_those_of_the_messages():
    block = block_of(*records([(0, 5), (3, 4), (1, 0), (0, 0), (2, 7)])[:1], 0)
    assert block.heads['channel'].tolist() == [3, 1, 2]
    assert block.heads['sequence'].tolist() == [1, 2, 4]
    assert block.heads['log_time'].tolist() == [101, 102, 104]
    assert block.heads['publish_time'].tolist() == [201, 202, 204]
    assert [block.data[lo:hi] for lo, hi in zip(block.start, block.stop)] == [
        b'\x01' * 4, b'', b'\x04' * 7]


def test_records_that_do_not_fill_the_chunk_are_refused():
    data, offsets = records([(1, 5), (2, 6)])
    for size in range(1, len(data)):
        if size != len(message(1, 0, 5)):
            with pytest.raises(BagError, match='chunk damaged') as caught:
                block_of(data[:size], 4711, lambda: np.array(offsets, np.int64))
            assert caught.value.offset == 4711


def test_a_message_without_room_for_its_head_is_refused():
    with pytest.raises(BagError, match='wrong length'):
        block_of(HEAD.pack(Opcode.MESSAGE, 21) + bytes(21), 0)


def test_zeros_are_no_records():
    """They would be one without content every nine bytes: 0.2 billion in a chunk of 70 kB."""
    first = message(1, 0, 5)
    assert measure_whole(first + bytes(900)) == len(first)
    for data in (bytes(900), first + bytes(900), bytes(9) + first, other(3) + bytes(9) + first):
        with pytest.raises(BagError, match='chunk damaged: a record of type 0'):
            block_of(data, 0)


@pytest.mark.parametrize('opcode', [Opcode.SCHEMA, 0x80])
def test_more_definitions_than_messages_need_are_refused(opcode):
    """A file has numbers for 65 536 schemas and channels; a writer may define anew before each."""
    empty, one = HEAD.pack(opcode, 0), message(1, 0, 5)
    with pytest.raises(BagError, match='chunk damaged: too many records that are no messages'):
        block_of(one + empty * 131_073, 0)
    with pytest.raises(BagError, match='chunk damaged: too many records that are no messages'):
        block_of(one + empty * 131_073 + one, 0, lambda: np.array(
            [0, len(one) + 9 * 131_073], np.int64))
    assert len(block_of(one + empty * 131_072, 0).others) == 131_072
    many = one + (one + empty * 4) * 40_000
    assert len(block_of(many, 0).others) == 160_000
    assert len(walk(empty * 140_000, 0, 9 * 140_000, math.inf)[1]) == 140_000


def test_definitions_after_many_messages_are_allowed_with_an_index_and_without():
    """The index was refused: only the messages between the definitions were counted."""
    empty, messages = HEAD.pack(Opcode.SCHEMA, 0), records([(1, 5), (1, 6)] * 20_000)
    data = messages[0] + empty * 140_000 + message(2, 1, 5)
    offsets = np.array([*messages[1], len(data) - len(message(2, 1, 5))])
    found = block_of(data, 0, lambda: offsets)
    assert (len(found.start), len(found.others)) == (40_001, 140_000)
    assert same(found, block_of(data, 0))


def test_an_index_that_names_a_message_within_another_does_no_harm():
    """The chunk was refused as damaged."""
    inner = message(1, 7, 3)
    outer = MESSAGE_HEAD.pack(Opcode.MESSAGE, 22 + len(inner), 1, 0, 100, 200) + inner
    data = outer + message(1, 1, 5)
    found = block_of(data, 0, lambda: np.array([len(outer) - len(inner), len(outer)]))
    assert same(found, block_of(data, 0)) and found.heads['sequence'].tolist() == [0, 1]


def test_whole_records_end_before_a_cut_and_before_other_kinds():
    data, offsets = records([(1, 5), (2, 6), (0, 3), (1, 1)])
    kinds = (Opcode.MESSAGE,)
    assert measure_whole(data, kinds) == len(message(1, 0, 5)) + len(message(2, 1, 6))
    assert measure_whole(data[:offsets[1] + 30], kinds) == offsets[1]
    assert measure_whole(data[:3], kinds) == 0
