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

"""One synchronizer is followed at a time."""

from __future__ import annotations

from heading_intercompare.core.pairing.incarnations import IncarnationChoice


def run(steps):
    """Return the followed one after each step: heard, at a time, final."""
    choice, followed = IncarnationChoice(), []
    for heard, now_s, final in steps:
        if heard is not None:
            choice.hear(heard, now_s, final)
        followed.append(choice.look(now_s))
    return followed


def test_the_first_one_heard_is_followed_while_it_lives_whoever_else_speaks():
    steps = [(5, 0.0, False)]
    for tick in range(1, 40):
        steps += [(5, tick * 0.9, False), (3, tick * 0.9, False), (9, tick * 0.9, False)]
    assert set(run(steps)) == {5}


def test_one_that_was_killed_is_left_after_two_and_a_half_seconds():
    steps = [(1, 0.0, False)] + [(2, 0.5 * k, False) for k in range(1, 8)]
    assert run(steps) == [1] * 6 + [2, 2]


def test_one_that_ended_is_left_at_once_and_not_followed_again():
    assert run([(1, 0.0, True), (2, 0.1, False), (1, 0.2, False), (2, 0.3, True),
                (1, 9.0, False)]) == [1, 2, 2, 2, 2]


def test_several_restarts_are_followed_in_their_order():
    assert run([(1, 0.0, True), (2, 0.1, True), (3, 0.1, False), (None, 0.2, False)]) == [
        1, 2, 3, 3]


def test_a_node_that_was_held_up_does_not_take_the_others_for_dead():
    choice = IncarnationChoice()
    choice.hear(1, 0.0)
    choice.hear(2, 0.1)
    assert choice.look(0.2) == 1
    assert choice.look(10.0) == 1
    choice.hear(1, 10.1)
    assert choice.look(10.2) == 1


def test_memory_is_bounded():
    choice = IncarnationChoice()
    for one in range(10_000):
        choice.hear(one, one * 1e-4, final=one % 2 == 1)
    assert choice.look(1.0) == 0
    assert len(choice.list_others(1.0)) < 20
