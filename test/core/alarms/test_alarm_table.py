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

"""The alarms of one node."""

from __future__ import annotations

from heading_intercompare.core.alarms.alarm import AlarmState, AlarmTable, Rule, Sign


def table():
    """Return a table in which both alarms were raised at 0."""
    made = AlarmTable([Rule('jump', clear_s=0.0), Rule('frozen', clear_s=0.0)])
    made.update({'jump': Sign(True, 'a'), 'frozen': Sign(True, 'b')}, 0)
    return made


def test_only_changes_of_state_are_returned():
    made = table()
    assert made.update({'jump': Sign(True, 'again')}, 1) == []
    changed, = made.update({'jump': Sign(False), 'frozen': Sign(None)}, 2)
    assert (changed.rule.name, changed.state) == ('jump', AlarmState.RECTIFIED)
    assert made['frozen'].state is AlarmState.UNACKNOWLEDGED


def test_one_alarm_is_acknowledged_by_its_name_and_all_without():
    made = table()
    assert [a.rule.name for a in made.acknowledge('frozen', 1)] == ['frozen']
    assert made.acknowledge('no such alarm', 1) == []
    assert [a.rule.name for a in made.acknowledge(None, 1)] == ['jump']
    assert {a.state for a in made.alarms} == {AlarmState.ACKNOWLEDGED}
    assert len(made) == 2
