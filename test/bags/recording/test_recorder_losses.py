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

"""What a recorder says of its own losses."""

from __future__ import annotations

from heading_intercompare.bags.recording.recorder_losses import (
    Counts,
    loss_record,
    loss_words,
    tell_missing,
)


def test_a_recording_without_losses_says_nothing():
    record = loss_record(3, 0, {'/ts/heading': Counts(10, 0, 0)})
    assert record == {'faults': 3, 'absent': 0, 'received./ts/heading': 10,
                      'lost_on_the_way./ts/heading': 0, 'not_written./ts/heading': 0,
                      'missed_at_first./ts/heading': 0}
    assert tell_missing(record) == loss_words(record) == ''


def test_losses_of_all_topics_are_added():
    record = loss_record(1, 1, {'/a': Counts(10, 2, 3), '/b': Counts(10, 4, 5, 7)})
    there = '8 messages received but not written, 1 message in files that were removed or moved'
    assert tell_missing(record) == there
    assert loss_words(record) == (f'{there}, 6 messages lost on the way, 7 messages judged before '
                                  'the first one came')


def test_a_record_of_somebody_else_is_understood_as_far_as_it_is_one():
    assert tell_missing({}) == tell_missing({'absent': 'often', 'not_written': '',
                                             'by': 'hand'}) == ''
    assert tell_missing({'not_written': '9' * 5000, 'absent': '²'}) == ''
    assert tell_missing({'not_written': '2'}) == '2 messages received but not written'
