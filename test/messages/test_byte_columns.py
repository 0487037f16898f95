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

"""Values at any offsets, and chunks of single messages."""

from __future__ import annotations

from functools import partial

import numpy as np

from heading_intercompare.core.records import Headings
from heading_intercompare.messages.byte_columns import (
    decode_readable,
    gather,
    join_messages,
    split_rows,
)
from heading_intercompare.messages.heading_messages import decode_headings, encode_imu, IMU


def test_values_are_gathered_wherever_they_are_in_either_byte_order():
    data = b'x' + (7).to_bytes(4, 'little') + b'yz' + (9).to_bytes(4, 'little')
    assert gather(data, '<u4', np.array([7, 1])).tolist() == [9, 7]
    assert gather(data, '>u4', np.array([1])).tolist() == [7 << 24]


def test_messages_of_any_length_are_joined_and_found_again():
    data, start, stop = join_messages([b'ab', b'', b'c'])
    assert [data[lo:hi] for lo, hi in zip(start, stop)] == [b'ab', b'', b'c']


def test_no_messages_are_joined_to_nothing():
    data, start, stop = join_messages([])
    assert (data, len(start), len(stop)) == (b'', 0, 0)
    assert start.dtype == stop.dtype == np.int64


def test_rows_are_split_into_messages():
    assert split_rows(np.array([[1, 2], [3, 4]], np.uint8)) == [b'\1\2', b'\3\4']
    assert split_rows(np.empty((0, 8), np.uint8)) == []


def test_an_empty_message_takes_no_other_with_it():
    """It has the offset of the message after it."""
    sent = Headings.of(10**18 + np.arange(4), np.arange(4.0))
    rows = [row.tobytes() for row in encode_imu(sent, 'x')]
    rows[1:3] = [b''] * 2
    data, start, stop = join_messages(rows)
    found, readable, problem = decode_readable(
        partial(decode_headings, IMU, 'enu', data), start, stop)
    assert readable.tolist() == [True, False, False, True]
    assert found.stamp_ns.tolist() == [10**18, 10**18 + 3] and problem
