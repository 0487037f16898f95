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

"""The pairs of several sensors in the rolling window, and the alarms of the vote."""

from __future__ import annotations

import pytest

from heading_intercompare.core.sensors.sensors_now import (
    describe_now,
    vote_now,
    vote_rules,
    vote_signs,
)

NAMES = 'a', 'b', 'c'


def pair(first, second, lower_deg2, mean_deg=0.0):
    """Return a pair with a lower bound, and 0.1 square degrees as the limit of both norms."""
    return describe_now((first, second), {
        'n': 500, 'newest_ns': 7, 'mean_deg': mean_deg, 'std_deg': 0.2,
        'lower_bound_deg2': lower_deg2, 'rejection_limit_deg2': 0.1}, 15.0)


def test_the_texts_of_a_message_give_the_same_as_the_numbers():
    figures = {'n': 500, 'newest_ns': 7, 'mean_deg': 0.1, 'std_deg': 0.2,
               'lower_bound_deg2': 0.03, 'rejection_limit_deg2': 0.04}
    found = describe_now(('a', 'b'), {key: str(value) for key, value in figures.items()}, 15.0)
    assert found == describe_now(('a', 'b'), figures, 15.0)
    assert (found.n, found.differs, found.share) == (500, False, pytest.approx(1.0))


def test_too_few_differences_and_figures_that_are_no_numbers_say_nothing():
    assert describe_now(('a', 'b'), {'n': 0}, 15.0).differs is None
    assert describe_now(('a', 'b'), {'lower_bound_deg2': 'nan'}, 15.0).differs is None
    assert describe_now(('a', 'b'), {}, 15.0).share is None


def test_a_mean_beyond_any_installation_differs_whatever_the_variance():
    assert pair('a', 'b', 0.01, mean_deg=-90.0).differs is True
    assert pair('a', 'b', 0.01, mean_deg=-14.0).differs is False


def test_the_sensor_whose_pairs_all_differ_is_named_and_raises_its_alarm_alone():
    pairs = [pair('a', 'b', 0.2), pair('a', 'c', 0.3), pair('b', 'c', 0.02)]
    vote = vote_now(NAMES, pairs)
    assert vote.wrong == ('a',)
    signs = vote_signs(NAMES, vote, pairs)
    assert [rule.name for rule in vote_rules(NAMES)] == [*signs]
    assert [sign.active for sign in signs.values()] == [True, False, False]
    assert signs['a_wrong'].words == 'a differs from b and c, which do not differ from each other'
    assert signs['a_wrong'].values['largest_share'] == pytest.approx(0.2 / 0.1 ** 0.5)


def test_a_sensor_that_is_only_suspected_neither_raises_nor_clears():
    """Four sensors: a differs from b; its pair with c was not testable."""
    names = 'a', 'b', 'c', 'd'
    pairs = [pair('a', 'b', 0.2), pair('a', 'd', 0.2), describe_now(('a', 'c'), {}, 15.0),
             *(pair(*both, 0.01) for both in (('b', 'c'), ('b', 'd'), ('c', 'd')))]
    vote = vote_now(names, pairs)
    assert vote.suspected == ('a',)
    assert vote_signs(names, vote, pairs)['a_wrong'].active is None


def test_a_sensor_whose_pairs_nobody_knows_keeps_its_alarm():
    pairs = [describe_now(('a', 'b'), {}, 15.0), describe_now(('a', 'c'), {}, 15.0),
             pair('b', 'c', 0.01)]
    signs = vote_signs(NAMES, vote_now(NAMES, pairs), pairs)
    assert [sign.active for sign in signs.values()] == [None, False, False]
