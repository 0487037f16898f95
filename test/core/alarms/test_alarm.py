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

"""The states of one alarm after MSC.302(87)."""

from __future__ import annotations

from hypothesis import given, strategies as st

from heading_intercompare.core.alarms.alarm import Alarm, AlarmState, Rule, Sign

S_NS = 10 ** 9
NORMAL, UNACKNOWLEDGED, ACKNOWLEDGED, RECTIFIED = AlarmState
YES, NO, UNKNOWN = Sign(True, 'TS - RS jumped'), Sign(False), Sign(None)

#: Every change of state that the resolution knows, without responsibility transfer.
ALLOWED = {(NORMAL, UNACKNOWLEDGED), (UNACKNOWLEDGED, ACKNOWLEDGED), (UNACKNOWLEDGED, RECTIFIED),
           (ACKNOWLEDGED, NORMAL), (RECTIFIED, NORMAL), (RECTIFIED, UNACKNOWLEDGED)}


def after(*steps, clear_s=2.0):
    """Return an alarm after a step each second: a sign, or None for an acknowledgement."""
    alarm = Alarm(Rule('jump', clear_s=clear_s))
    for at, step in enumerate(steps):
        alarm = (alarm.acknowledge(at * S_NS) if step is None else alarm.see(step, at * S_NS))
    return alarm


def test_an_alarm_is_raised_at_once():
    alarm = after(YES)
    assert (alarm.state, alarm.words, alarm.times, alarm.raised_ns) == (
        UNACKNOWLEDGED, 'TS - RS jumped', 1, 0)


def test_an_alarm_clears_after_its_time_only():
    """Gone at 1 s: at 2 s it is gone for 1 s, at 3 s for 2 s."""
    assert after(YES, NO, NO).state is UNACKNOWLEDGED
    assert after(YES, NO, NO, NO).state is RECTIFIED


def test_a_condition_that_comes_back_meanwhile_was_never_gone():
    alarm = after(YES, NO, NO, YES, NO, NO)
    assert (alarm.state, alarm.times) == (UNACKNOWLEDGED, 1)


def test_acknowledged_then_gone_is_normal_and_gone_then_acknowledged_too():
    assert after(YES, None).state is ACKNOWLEDGED
    assert after(YES, None, NO, NO, NO).state is NORMAL
    assert after(YES, NO, NO, NO, None).state is NORMAL


def test_a_rectified_alarm_that_comes_back_is_raised_again():
    alarm = after(YES, NO, NO, NO, YES)
    assert (alarm.state, alarm.times, alarm.raised_ns) == (UNACKNOWLEDGED, 2, 4 * S_NS)


def test_while_nobody_can_tell_the_alarm_stays_as_it_is():
    assert after(YES, *[UNKNOWN] * 20).state is UNACKNOWLEDGED
    assert after(*[UNKNOWN] * 20).state is NORMAL


def test_what_changes_in_the_condition_is_shown_without_a_new_alarm():
    alarm = after(YES, None, Sign(True, 'TS - RS jumped more', {'size_deg': 9.0}))
    assert (alarm.state, alarm.words, dict(alarm.values)) == (
        ACKNOWLEDGED, 'TS - RS jumped more', {'size_deg': 9.0})


@given(st.lists(st.sampled_from([YES, NO, UNKNOWN, None]), max_size=60),
       st.floats(0.0, 5.0))
def test_only_the_changes_of_the_resolution_happen(steps, clear_s):
    """An active state has a condition within its clearing time; a rectified one had one."""
    alarm, last_yes, since_no = Alarm(Rule('x', clear_s=clear_s)), None, None
    for at, step in enumerate(steps):
        before = alarm
        alarm = (alarm.acknowledge(at * S_NS) if step is None else alarm.see(step, at * S_NS))
        if alarm.state is not before.state:
            assert (before.state, alarm.state) in ALLOWED
            assert (step is YES) == (alarm.state is UNACKNOWLEDGED)
        if step is YES:
            last_yes, since_no = at, None
            assert alarm.state.active
        elif step is NO and since_no is None:
            since_no = at
        if since_no is not None and step is NO and at - since_no >= clear_s:
            assert not alarm.state.active
        assert alarm.state is NORMAL or last_yes is not None
        assert (alarm.times > 0) == (last_yes is not None)


@given(st.lists(st.sampled_from([YES, NO, UNKNOWN]), max_size=40))
def test_an_alarm_that_was_raised_is_not_forgotten_before_somebody_acknowledges(steps):
    alarm = after(*steps)
    assert (alarm.state is NORMAL) == (YES not in steps)
    acknowledged = alarm.acknowledge(100 * S_NS)
    assert acknowledged.state in (NORMAL, ACKNOWLEDGED)
    assert acknowledged.acknowledge(101 * S_NS) == acknowledged
