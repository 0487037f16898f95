# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Missing messages of one publisher and of several."""

from __future__ import annotations

import numpy as np
import pytest

from heading_intercompare.bags.rosbag2.sequence_gaps import Numbering


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
