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

"""Heartbeats: who is missed and when, and what is no trouble."""

from __future__ import annotations

from dataclasses import replace

import pytest

from heading_intercompare.core.alarms.alarm import Priority
from heading_intercompare.core.alarms.graph_watch import (
    Beat,
    estimate_judging_s,
    GraphWatch,
    LOST_ON_THE_WAY,
    TROUBLE_RULES,
    WITHIN_S,
)

RECORDER = Beat('recorder', Priority.CAUTION)


def watch_of(*beats, seconds=20, step_s=1.0, **how):
    """Return a watch that heard beats for some seconds, the last ones at this time."""
    watch = GraphWatch('compliance', **how)
    at = 0
    while at * step_s <= seconds:
        for beat in beats:
            watch.take(beat, at * step_s)
        at += 1
    return watch


def active(watch, now_s):
    """Return the names of the alarms that are active at a time."""
    return [name for name, sign in watch.look(now_s).items() if sign.active]


def test_a_node_is_missed_after_5_s_and_no_more_when_it_is_back():
    watch = watch_of(RECORDER)
    assert active(watch, 20.0 + WITHIN_S) == []
    assert active(watch, 20.1 + WITHIN_S) == ['recorder_silent']
    assert watch.look(30.0)['recorder_silent'].words == (
        'recorder has not been heard for more than 5 s: it hangs, was killed or cannot be reached')
    watch.take(RECORDER, 40.0)
    assert active(watch, 40.5) == []


def test_the_alarm_of_a_node_is_made_when_it_is_heard_first():
    watch = GraphWatch('compliance')
    rule = watch.take(RECORDER, 0.0)
    assert (rule.name, rule.priority) == ('recorder_silent', Priority.CAUTION)
    assert watch.take(RECORDER, 1.0) is None


def test_nobody_misses_a_node_that_was_never_heard_nor_itself():
    watch = watch_of(Beat('compliance'))
    assert 'compliance_silent' not in watch.look(100.0) and active(watch, 100.0) == []
    assert GraphWatch('compliance').take(Beat('compliance'), 0.0) is None


def test_a_node_that_ends_in_order_is_not_missed_unless_it_comes_again():
    watch = watch_of(RECORDER)
    watch.take(replace(RECORDER, ending=True), 21.0)
    assert active(watch, 100.0) == []
    watch.take(RECORDER, 200.0)
    assert active(watch, 210.0) == ['recorder_silent']


@pytest.mark.parametrize('step_s', [1.0, 2.0, 4.0])
def test_the_time_allowed_follows_the_load(step_s):
    """Where all nodes are heard every 4 s, 20 s of silence say as much as 5 s elsewhere."""
    watch = watch_of(RECORDER, Beat('ts_driver'), seconds=80, step_s=step_s)
    assert watch.load == step_s
    assert active(watch, 80.0 + step_s * WITHIN_S) == []
    assert active(watch, 80.1 + step_s * WITHIN_S) == ['recorder_silent', 'ts_driver_silent']


def test_a_node_that_stood_still_does_not_count_as_load():
    watch = watch_of(RECORDER)
    watch.take(RECORDER, 80.0)
    assert watch.load == 1.0


def test_a_node_that_judges_much_says_that_it_is_not_heard_meanwhile():
    """A run of 12 h at 100 Hz has 4.3 million pairs; judging them took 10.8 s."""
    assert estimate_judging_s(0) == 0.0
    within_s = WITHIN_S + estimate_judging_s(12 * 3600 * 100)
    watch = GraphWatch('synchronizer', keepers_only=True)
    watch.take(Beat('compliance', within_s=within_s, keeper=True), 0.0)
    assert active(watch, 40.0) == [] and active(watch, 60.0) == ['compliance_silent']


def test_what_nodes_say_is_wrong_is_one_alarm_with_the_names_of_the_nodes():
    watch = watch_of(replace(RECORDER, troubles={LOST_ON_THE_WAY: '3 messages lost on the way'}),
                     Beat('compliance', troubles={LOST_ON_THE_WAY: '5 messages'}))
    assert watch.look(20.0)[LOST_ON_THE_WAY].words == (
        'recorder: 3 messages lost on the way; compliance: 5 messages')
    assert [active(watch, at_s) for at_s in (20.0, 30.0)] == [
        [LOST_ON_THE_WAY], ['recorder_silent']]
    watch.take(RECORDER, 31.0)
    watch.take(Beat('compliance'), 31.0)
    assert active(watch, 31.0) == []
    assert set(watch.look(31.0)) == {'recorder_silent', *(rule.name for rule in TROUBLE_RULES)}


def test_who_watches_the_keepers_leaves_the_rest_to_them():
    watch = watch_of(RECORDER, Beat('compliance', keeper=True, troubles={LOST_ON_THE_WAY: 'x'}),
                     keepers_only=True)
    watch._name = 'synchronizer'
    assert active(watch, 20.0) == []
    assert active(watch, 100.0) == ['compliance_silent']


def test_names_without_end_do_not_fill_the_memory():
    watch = GraphWatch('compliance')
    assert sum(watch.take(Beat(f'n{n}'), 0.0) is not None for n in range(1000)) == 50
    assert len(watch.look(100.0)) == 50 + len(TROUBLE_RULES)
