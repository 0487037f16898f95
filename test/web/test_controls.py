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

"""The action that waits for a minute; its clock is the test's."""

from __future__ import annotations

import pytest

from heading_intercompare.web.controls import Delay, DELAY_S


@pytest.fixture
def now_s():
    """Return the time, a list of one number."""
    return [1000.0]


@pytest.fixture
def delay(now_s):
    return Delay(lambda: now_s[0])


@pytest.mark.parametrize('what', ['start', 'stop'])
@pytest.mark.parametrize('after_s, left_s', [
    (0.0, DELAY_S), (17.5, DELAY_S - 17.5), (DELAY_S, 0.0), (5.0 * DELAY_S, 0.0)])
def test_an_action_is_due_when_the_minute_is_over(delay, now_s, what, after_s, left_s):
    assert delay.begin(what, 'J. Smith').startswith(f'{what} run waits until ')
    waiting = delay.waiting
    now_s[0] += after_s
    assert delay.left_s(waiting) == left_s
    assert delay.take_due() == (None if left_s else waiting)
    assert delay.waiting == (waiting if left_s else None)
    assert (waiting.what, waiting.operator) == (what, 'J. Smith')


@pytest.mark.parametrize('first', ['start', 'stop'])
@pytest.mark.parametrize('second', ['start', 'stop'])
def test_a_second_action_replaces_nothing(delay, now_s, first, second):
    delay.begin(first, 'J. Smith')
    waiting = delay.waiting
    now_s[0] += 30.0
    assert delay.begin(second, 'Mate').startswith(f'{first} run waits already: ')
    assert delay.waiting is waiting and delay.left_s(waiting) == DELAY_S - 30.0


def test_an_action_is_taken_once_and_only_by_its_name(delay):
    delay.begin('start', '')
    waiting = delay.waiting
    assert delay.take('stop') is None and delay.waiting is waiting
    assert delay.take('start') is waiting
    assert delay.take('start') is None and delay.take_due() is None
    assert delay.begin('stop', '').startswith('stop run waits until ')
