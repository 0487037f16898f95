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

"""A subscription is made again when the middleware may have forgotten it, and not otherwise."""

from __future__ import annotations

import pytest

from heading_intercompare.nodes.taking.reception import Renewal


def times_due(received_at, missing_at=lambda s: 0, seconds=range(1000)):
    """Return the seconds at which a subscription was to be made again."""
    renewal = Renewal()
    return [s for s in seconds if renewal.is_due(1000.0 + s, received_at(s), missing_at(s))]


@pytest.mark.parametrize('period_s', [1, 7, 60])
def test_a_stream_that_comes_evenly_is_left_alone(period_s):
    assert times_due(lambda s: 1 + s // period_s, seconds=range(40 * period_s)) == []


def test_a_topic_of_few_messages_may_be_silent_for_ever():
    assert times_due(lambda s: min(s, 3)) == []


def test_a_stream_that_falls_silent_is_asked_again_ever_less_often():
    due = times_due(lambda s: 10 * min(s, 100), seconds=range(3600))
    assert due[:2] == [106, 113]
    steps = [after - before for before, after in zip(due, due[1:])]
    assert steps == sorted(steps) and 250 < steps[-1] <= 301 and len(due) < 20


def test_a_silence_as_long_as_those_before_is_usual():
    """A sensor that reports in bursts each half minute."""
    assert times_due(lambda s: 300 * (1 + s // 30)) == []


def test_each_new_gap_is_asked_for_once_when_what_is_under_way_has_come():
    missing = {100: 84, 101: 84}
    assert times_due(lambda s: 10 * s, lambda s: missing.get(s, 0)) == [102]
    gaps = {**dict.fromkeys((100, 101, 102), 84), **dict.fromkeys((200, 201, 202, 203), 5)}
    assert times_due(lambda s: 10 * s, lambda s: gaps.get(s, 0)) == [102, 202]


def test_what_does_not_come_again_is_asked_for_ever_less_often():
    """A network that loses all the time, or more than the publishers keep."""
    due = times_due(lambda s: 10 * s, lambda s: 3 * s, range(3600))
    steps = [after - before for before, after in zip(due, due[1:])]
    assert steps == sorted(steps) and 250 < steps[-1] <= 302 and len(due) < 20


def test_a_process_that_stood_still_asks_for_all():
    seconds = [*range(10), *range(40, 60)]
    assert times_due(lambda s: 3, seconds=seconds) == [42]


def test_a_process_that_stood_still_is_told_so_once():
    renewal = Renewal()
    assert not renewal.stood_still(990.0)
    renewal.is_due(1000.0, received=0, missing=0)
    told = [renewal.stood_still(1000.0 + s) for s in (1, 3, 4, 5)]
    renewal.is_due(1006.0, received=0, missing=0)
    assert told == [False, False, True, False] and not renewal.stood_still(1007.0)
