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

"""What the counts of a driver say about its line."""

from __future__ import annotations

import pytest

from heading_intercompare.core.alarms.sentence_watch import (
    LATE_REPEATS,
    SENDER_CHANGES,
    SentenceWatch,
)


def signs(watch, seconds, per_s, headings=10):
    """Return the signs after each of some seconds in which counts grew evenly."""
    return [watch.look({key: n * (at + 1) for key, n in per_s.items()}, headings * (at + 1),
                       float(at)) for at in range(seconds)]


def test_a_flood_of_damaged_sentences_is_a_condition_within_two_seconds():
    found = signs(SentenceWatch(None), 2, {'bad_checksum': 5})
    assert found[-1]['checksum'].active is True
    assert found[-1]['checksum'].words.startswith('33 % of the sentences')


def test_a_line_on_which_everything_is_damaged_is_found_at_once():
    assert signs(SentenceWatch(None), 1, {'bad_checksum': 10}, headings=0)[0]['checksum'].active


def test_one_damaged_sentence_now_and_then_is_none():
    """One in 600 s among 10 per second, and one in 10 s among one per second."""
    watch = SentenceWatch(None)
    for at in range(1200):
        sign = watch.look({'bad_checksum': at // 600}, 10 * at, float(at))['checksum']
        assert sign.active is False
    assert all(not s['checksum'].active for s in signs(SentenceWatch(None), 60, {}, headings=1))


def test_the_condition_ends_when_sound_sentences_come():
    watch = SentenceWatch(None)
    signs(watch, 5, {'bad_checksum': 10})
    later = [watch.look({'bad_checksum': 50}, 10 * at, float(at)) for at in range(5, 20)]
    assert later[-1]['checksum'].active is False


@pytest.mark.parametrize('talker, active', [(None, True), ('HE', False)])
def test_a_second_talker_is_a_condition_unless_the_user_chose_one(talker, active):
    found = signs(SentenceWatch(talker), 1, {'other_talker.GP': 10})[0]['second_talker']
    assert found.active is active
    if active:
        assert 'GP' in found.words and 'set talker' in found.words


@pytest.mark.parametrize('counts, expected, active', [
    ({SENDER_CHANGES: 1}, False, None), ({SENDER_CHANGES: 2}, False, None),
    ({SENDER_CHANGES: 3}, False, True), ({SENDER_CHANGES: 3}, True, None),
    ({LATE_REPEATS: 5}, True, True), ({'repeated': 500}, False, False),
    ({'old_number': 8}, False, None), ({'old_number': 9}, False, True), ({}, False, False)])
def test_a_second_sender_is_a_condition_and_a_takeover_or_a_restart_is_none(
        counts, expected, active):
    signs = SentenceWatch(None, expected).look(counts, 100, 0.0, ('10.0.0.5', '10.0.0.6'))
    assert signs['second_sender'].active is active


def test_bursts_and_drops_are_told_and_end_ten_seconds_later():
    watch = SentenceWatch(None)
    found = watch.look({'burst': 3, 'kernel_dropped': 7}, 10, 0.0)
    assert (found['burst'].active, found['dropped'].active) == (True, True)
    found = watch.look({'burst': 3, 'kernel_dropped': 7}, 110, 10.0)
    assert (found['burst'].active, found['dropped'].active) == (False, False)


def test_other_sentences_are_no_trouble():
    found = signs(SentenceWatch(None), 30, {'not_heading': 50, 'other_sentence.THS': 10})
    assert not any(sign.active for one in found for sign in one.values())
