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

"""The messages of the nodes as rclpy objects, as other programs send and receive them."""

from __future__ import annotations

from diagnostic_msgs.msg import DiagnosticArray
from message_rows import read_headings
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import Imu

from heading_intercompare.core.records import Headings, Pairs
from heading_intercompare.messages.heading_messages import (
    imu_messages,
    PAIRS_TYPE,
    read_pairs,
)
from heading_intercompare.messages.ledger_messages import decode_ledger
from heading_intercompare.messages.status_messages import decode_marks, encode_mark


def name_of(message):
    """Return the name of the type of a message, as package/msg/Type."""
    package, folder, _ = type(message).__module__.split('.')
    return f'{package}/{folder}/{type(message).__name__}'


def heading_messages(headings, frame_id, **claims):
    """Return headings as messages."""
    return [deserialize_message(data, Imu) for data in imu_messages(headings, frame_id, **claims)]


def headings_from(messages, convention):
    """Return the headings of messages of one type."""
    if not messages:
        return Headings.empty()
    headings, refused = read_headings(name_of(messages[0]), convention,
                                      [serialize_message(m) for m in messages])
    assert not refused
    return headings


def pairs_from(messages):
    """Return the pairs of messages."""
    assert {name_of(m) for m in messages} <= {PAIRS_TYPE}
    pairs, refused = read_pairs([serialize_message(m) for m in messages])
    assert not refused and isinstance(pairs, Pairs)
    return pairs


def ledger_from(message):
    """Return the ledger of a message, and whether it is the final one."""
    return decode_ledger(serialize_message(message))


def marker_message(kind, ns):
    """Return a mark."""
    return deserialize_message(encode_mark(kind, ns), DiagnosticArray)


def marks_from(message):
    """Return kind and stamp of the marks in a message."""
    return decode_marks(serialize_message(message))
