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

"""Missing messages of one publisher and of several."""

from __future__ import annotations

import numpy as np
import pytest

from heading_intercompare.bags.rosbag2.publisher_starts import KnownStarts, PublisherStart
from heading_intercompare.bags.rosbag2.sequence_gaps import Numbering
from heading_intercompare.core.pairing.names import Span
from heading_intercompare.core.records import Losses


def counted(*chunks):
    """Return the result for numbers that arrive in chunks."""
    found = Numbering()
    for chunk in chunks:
        found.take(np.array(chunk, np.uint32))
    return found.numbered, found.missing, found.restarts


@pytest.mark.parametrize('chunks, expected', [
    ([[1, 2, 3], [4, 5]], (True, 0, 0)),
    ([[5, 6, 9], [12]], (True, 4, 0)),
    ([[0, 0, 0], [0]], (False, 0, 0)),
    ([[0, 1, 2]], (True, 0, 0)),
    ([[1], [2], [4]], (True, 1, 0)),
    ([[7, 8, 1, 2], [1]], (True, 0, 2)),
    ([[70, 71, 1, 4], [5, 6, 10]], (True, 5, 1)),
    ([[2**32 - 2, 2**32 - 1], [0, 2]], (True, 1, 0)),
    ([[2**32 - 2, 1], [3]], (True, 3, 0))])
def test_numbers_left_out_are_counted(chunks, expected):
    assert counted(*chunks) == expected


@pytest.mark.parametrize('begin', [1, 40, 250, 5000])
@pytest.mark.parametrize('lost', [(), (60,), (60, 61, 62, 90)])
@pytest.mark.parametrize('size', [1, 7, 1000])
def test_of_several_publishers_what_each_lost_is_counted(rng, begin, lost, size):
    """The second one begins later, or was first heard when it had sent some."""
    one = [n for n in range(1, 200) if n not in lost]
    other = [begin + n for n in range(200) if n not in lost]
    turns = rng.permuted(np.repeat([0, 1], [len(one) - 30, len(other)])).tolist()
    streams = iter(one[30:]), iter(other)
    numbers = one[:30] + [next(streams[turn]) for turn in turns]
    found = counted(*(numbers[lo:lo + size] for lo in range(0, len(numbers), size)))
    assert found == (True, 2 * len(lost), 1)


def test_where_the_numbers_begin_is_kept():
    found = Numbering()
    found.take(np.array([1147, 1148], np.uint32))
    assert (found.first, found.missing) == (1147, 0)


@pytest.mark.parametrize('numbers, before', [
    ([221, 222], [(6999, 0, 220)]), ([1, 2], []), ([0, 0, 5], [(8999, 0, 4)]), ([0, 0], [])])
def test_what_was_sent_before_the_first_message_is_told_once(numbers, before):
    found = Numbering()
    assert len(found.take_before()) == 0
    found.take(numbers, [7000 + 1000 * at for at in range(len(numbers))])
    told = found.take_before()
    assert [*zip(told.stamp_ns.tolist(), told.since_ns.tolist(), told.count.tolist())] == before
    assert len(found.take_before()) == 0 and found.missing == 0


def rows(numbers, size):
    """Return the gaps among numbers that are also the stamps, in seconds."""
    found = Numbering()
    return Losses.concatenate(found.take(numbers[lo:lo + size], numbers[lo:lo + size])
                              for lo in range(0, len(numbers), size))


@pytest.mark.parametrize('size', [1, 2, 3, 100])
def test_a_gap_is_at_the_stamps_around_it(size):
    assert rows([3, 4, 9, 10, 12], size) == Losses.of([9, 12], [4, 10], [4, 1])


def rows_in_order(numbers, size, starts=None):
    """Return the gaps among numbers whose stamps are 1, 2, 3 and so on, and the numbering."""
    found, stamps = Numbering(), [*range(1, len(numbers) + 1)]
    known = starts or {}
    losses = [found.take(numbers[lo:lo + size], stamps[lo:lo + size],
                         lambda number, stamp_ns: known.get((number, stamp_ns)))
              for lo in range(0, len(numbers), size)]
    return Losses.concatenate(losses), found


@pytest.mark.parametrize('size', [1, 2, 100])
def test_a_gap_that_another_publisher_explains_is_taken_back(size):
    """The second publisher is first heard at 90; then the first one goes on, without 8."""
    assert rows_in_order([5, 6, 90, 7, 91, 9], size)[0] == Losses.of(
        [3, 3, 6], [2, 2, 4], [83, -83, 1])


@pytest.mark.parametrize('size', [1, 2, 100])
def test_what_a_later_publisher_sent_before_it_was_heard_is_missing(size):
    """It is told by numbers that fall; the first one lacks nothing: nobody heard it before."""
    losses, found = rows_in_order([7, 8, 9, 4, 5, 2, 3], size)
    assert losses == Losses.of([4, 6], [3, 5], [3, 1])
    assert found.spans == (('', 7, 9), ('', 4, 5), ('', 2, 3))
    assert (found.missing, found.restarts) == (4, 2)


@pytest.mark.parametrize('size', [1, 3, 100])
def test_a_publisher_that_is_known_to_begin_owns_a_number_that_rises(size):
    """Without that knowledge 20 are missing of the first one; with it 29 of the second one."""
    numbers, starts = [7, 8, 9, 30, 31, 33], {(7, 1): 'a', (30, 4): 'b'}
    losses, found = rows_in_order(numbers, size, starts)
    assert losses == Losses.of([4, 6], [3, 5], [29, 1])
    assert found.spans == (('a', 7, 9), ('b', 30, 33))
    assert rows_in_order(numbers, size)[0] == Losses.of([4, 6], [3, 5], [20, 1])


@pytest.mark.parametrize('size', [1, 2, 3, 100])
def test_a_publisher_that_is_known_to_begin_owns_a_number_that_follows(size):
    """The first one ended with 9, and the second one was first heard at 10: 9 are missing."""
    numbers, starts = [0, 7, 8, 9, 10, 11, 13], KnownStarts([
        PublisherStart('a', 7, 2), PublisherStart('b', 10, 5)])
    numbering, losses = Numbering(), []
    for lo in range(0, len(numbers), size):
        part, stamps = numbers[lo:lo + size], [*range(1, len(numbers) + 1)][lo:lo + size]
        losses.append(starts.find_gaps(numbering, part, stamps))
    assert Losses.concatenate(losses) == Losses.of([5, 7], [4, 6], [9, 1])
    assert numbering.spans == (('a', 7, 9), ('b', 10, 13))


def test_a_publisher_that_is_known_goes_on_after_its_last_number():
    """As in a bag that goes on with another one."""
    found = Numbering.go_on([Span('a', 1, 40)])
    losses = found.take([43, 44], [7, 8], lambda number, stamp_ns: 'a')
    assert losses == Losses.of([7], [0], [2]) and found.spans == (('a', 1, 44),)


@pytest.mark.parametrize('size', [1, 2, 100])
def test_messages_that_come_late_close_their_holes_and_begin_nothing(size):
    """Their stamps lie in the hole, too; 5 and 7 never come."""
    numbers = [*range(1, 5), *range(9, 14), 6, 8, 14]
    found = Numbering()
    losses = Losses.concatenate(found.take(numbers[lo:lo + size], numbers[lo:lo + size])
                                for lo in range(0, len(numbers), size))
    assert losses == Losses.of([9, 9, 9], [4, 4, 4], [4, -1, -1])
    assert (found.missing, found.restarts, found.spans) == (2, 0, (('', 1, 14),))


@pytest.mark.parametrize('size', [1, 2, 100])
def test_zeros_before_the_first_number_are_none(size):
    """Whether they come in the same chunk as the first number or before it."""
    assert rows([0, 0, 0, 7, 9], size) == Losses.of([9], [7], [1])
