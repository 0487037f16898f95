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

"""Where the publishers of the headings begin is kept in a bag."""

from __future__ import annotations

from heading_intercompare.bags.recording.bag_writer import BagWriter
from heading_intercompare.bags.rosbag2.bag_reader import BagReader
from heading_intercompare.bags.rosbag2.publisher_starts import (
    KnownStarts,
    PublisherRecords,
    PublisherStart,
    read_starts,
)
from heading_intercompare.bags.rosbag2.sequence_gaps import Numbering
from heading_intercompare.core.pairing.names import Span
from heading_intercompare.core.records import Losses

STAMP_NS = 1_700_000_000_123_456_789
STARTS = [PublisherStart('aa', n, STAMP_NS + n) for n in range(1, 12)]


def write(path, more=()):
    """Write a bag with the starts of eleven publishers of one topic, and one of another."""
    with BagWriter(path) as writer:
        records = PublisherRecords(writer.metadata)
        records.add('/ts/heading', STARTS)
        records.add('/rs/heading', [PublisherStart('', 4, 7)])
        for name, entries in more:
            writer.metadata(name, entries)
    return BagReader(path)


def test_the_starts_are_read_as_they_were_written_in_their_order(tmp_path):
    """Ten of one topic would be sorted by their names as 1, 10, 11, 2."""
    assert read_starts(write(tmp_path / 'bag')) == {
        '/ts/heading': STARTS, '/rs/heading': [PublisherStart('', 4, 7)]}


def test_records_of_somebody_else_are_no_starts(tmp_path):
    reader = write(tmp_path / 'bag', [('publisher.20', {'topic': '/ts/heading', 'number': 'x'}),
                                      ('publisher.x', {'number': '1'})])
    assert read_starts(reader)['/ts/heading'] == STARTS


def test_a_bag_holds_no_more_than_a_thousand(tmp_path):
    records = {}
    PublisherRecords(records.__setitem__).add('/ts/heading', STARTS * 100)
    assert len(records) == 1000


def test_who_begins_with_a_message_is_found_by_its_number_and_its_stamp():
    starts = KnownStarts([PublisherStart('aa', 5, 70), PublisherStart('', 2, 90)])
    numbering = Numbering()
    assert starts.find_gaps(numbering, [4, 5, 6, 3, 4], [60, 70, 80, 90, 100]) == Losses.of(
        [70, 90], [60, 80], [4, 2])
    assert numbering.spans == (Span('', 4, 4), Span('aa', 5, 6), Span('', 3, 4))
