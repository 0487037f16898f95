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
    PublishedHeadings,
    tell_missing,
)
from heading_intercompare.core.pairing.incarnations import StreamNumbers
from heading_intercompare.core.pairing.ledger import Ledger
from heading_intercompare.core.pairing.names import Span
from heading_intercompare.messages.ledger_messages import encode_ledger


def ledger_of(started_ns, *spans, final=False):
    """Return the ledger of a synchronizer that took these spans of the TS."""
    numbers = StreamNumbers(spans[0].publisher, spans[0].first, spans[-1].publisher,
                            spans[-1].last, spans)
    return encode_ledger(Ledger(), final, started_ns, {'ts': numbers})


def published(*messages):
    """Return what ledgers say was taken."""
    headings = PublishedHeadings()
    for message in messages:
        headings.take(message)
    return headings


def test_what_a_restarted_synchronizer_took_again_counts_once():
    """With `auto` it takes all that waited for the choice again: 497 were lost in a whole bag."""
    headings = published(ledger_of(1, Span('aa', 1, 497)), ledger_of(2, Span('aa', 1, 900)))
    assert headings.count_missing('ts', [Span('aa', 1, 900)]) == (0, 0)
    assert headings.count_missing('ts', [Span('aa', 1, 890)]) == (0, 10)
    assert headings.count_missing('rs', []) == (0, 0)


def test_what_was_taken_and_not_heard_is_divided_by_the_first_message_of_its_publisher():
    """A volatile publisher restarts; the recorder hears its second start later."""
    headings = published(ledger_of(1, Span('aa', 3, 100)),
                         ledger_of(1, Span('aa', 3, 200), Span('bb', 6, 80)))
    assert headings.count_missing('ts', [Span('aa', 10, 200), Span('bb', 29, 75)]) == (30, 5)
    # Nobody knows which of the two it is: whatever was heard may be what was taken.
    assert headings.count_missing('ts', [Span('aa', 10, 200), Span('', 29, 75)]) == (30, 5)
    assert headings.count_missing('ts', [Span('aa', 10, 200), Span('', 2, 75)]) == (0, 5)


def test_a_publisher_that_was_gone_before_the_recorder_came_is_not_lost_by_it():
    headings = published(ledger_of(1, Span('aa', 1, 100), Span('bb', 1, 20)),
                         ledger_of(1, Span('aa', 1, 100), Span('bb', 1, 80), Span('cc', 1, 9)))
    assert headings.count_missing('ts', [Span('bb', 1, 80)]) == (100, 9)


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
