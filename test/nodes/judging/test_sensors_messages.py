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

"""The comparison of several sensors as messages."""

from __future__ import annotations

from heading_intercompare.core.sensors.sensors_now import describe_now
from heading_intercompare.core.sensors.vote import find_wrong
from heading_intercompare.messages.status_messages import decode_statuses, ERROR, OK, WARN
from heading_intercompare.nodes.judging.sensors_messages import encode_sensors_figures, encode_vote


def test_figures_have_a_status_per_sensor_and_per_pair():
    pair = describe_now(('a', 'b'), {'n': 3, 'std_deg': 0.25}, 15.0)
    ns, (a, both) = decode_statuses(encode_sensors_figures({'a': {'rate_hz': 10.0}}, [pair], 5))
    assert (ns, a.name, dict(a.values)) == (5, 'a', {'rate_hz': '10.0'})
    assert both.name == 'a - b' and dict(both.values) == {'n': '3', 'std_deg': '0.25'}
    assert 'not a verdict' in a.message and both.level == OK


def test_the_vote_on_the_window_is_apart_from_that_on_judged_runs():
    wrong = find_wrong('abc', {('a', 'b'): True, ('a', 'c'): True, ('b', 'c'): False})
    none = find_wrong('abc', {('a', 'b'): False, ('a', 'c'): False, ('b', 'c'): False})
    _, (now,) = decode_statuses(encode_vote(wrong, None, 1))
    assert (now.name, now.level, now.values['wrong']) == ('now', ERROR, 'a')
    _, both = decode_statuses(encode_vote(none, wrong, 1))
    assert [(one.name, one.level) for one in both] == [('now', OK), ('judged', ERROR)]


def test_a_suspicion_is_a_warning():
    vote = find_wrong('abcd', {('a', 'b'): True, ('a', 'c'): True, ('a', 'd'): None,
                               ('b', 'c'): False, ('b', 'd'): False, ('c', 'd'): False})
    _, (now,) = decode_statuses(encode_vote(vote, None, 1))
    assert (now.level, now.values['suspected']) == (WARN, 'a')
