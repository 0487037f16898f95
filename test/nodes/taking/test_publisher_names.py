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

"""A publisher that comes to the list of the graph owns a number that follows no other."""

from __future__ import annotations

from types import SimpleNamespace

from heading_intercompare.nodes.taking.publisher_names import PublisherNames

S = 1_000_000_000


def make_names(*listed):
    """Return names of the publishers in a list, which can be changed, and the list."""
    graph = SimpleNamespace(gids=[*listed])
    names = PublisherNames(lambda: graph.gids)
    names.look(graph.gids, 10 * S)
    return names, graph


def begin(names, received_s):
    """Begin a batch; the last one was received at a time."""
    names.begin(None if received_s is None else round(received_s * S))


def test_the_only_publisher_owns_the_first_message():
    names, _ = make_names('a')
    begin(names, None)
    assert names.find_new(7, 70) == 'a' and names.starts == [('a', 7, 70)]


def test_of_several_nobody_knows_who_owns_the_first_message_and_no_later_hole_is_theirs():
    """One of the two is dead and disappears; then the other one is known if it publishes."""
    names, graph = make_names('a', 'b')
    begin(names, None)
    assert names.find_new(7, 70) == ''
    begin(names, 10.1)
    assert names.find_new(9, 90) is None
    names.look(['b'], 30 * S)
    assert names.find_alone(True) == ''
    names.look(['b'], 31 * S)
    assert names.find_alone(False) == ''
    assert names.find_alone(True) == 'b' and names.find_alone(True) == ''
    assert names.starts == [('', 7, 70), ('b', 0, 0)]


def test_a_publisher_that_comes_after_the_last_message_of_another_owns_the_next_start():
    names, graph = make_names('a')
    begin(names, None)
    names.find_new(1, 1)
    graph.gids = ['a', 'b']
    names.look(graph.gids, 20 * S)
    begin(names, 19.5)
    assert names.find_new(40, 50) == 'b'
    begin(names, 25.0)
    assert names.find_new(43, 60) is None


def test_a_publisher_that_is_listed_for_long_and_silent_owns_no_hole_of_another():
    names, graph = make_names('a')
    begin(names, None)
    names.find_new(1, 1)
    names.look(['a', 'silent'], 20 * S)
    graph.gids = ['a', 'silent']
    begin(names, 22.5)
    assert names.find_new(40, 50) is None


def test_a_publisher_that_an_earlier_process_heard_is_not_new():
    names, graph = make_names('a')
    names.go_on('a')
    begin(names, None)
    assert names.find_new(1041, 50) is None
    graph.gids = ['a', 'b']
    begin(names, 5.0)
    assert names.find_new(3, 70) == 'b'


def test_where_only_a_new_publisher_is_left_a_number_that_follows_is_its_first():
    names, graph = make_names('a')
    begin(names, None)
    names.find_new(1, 1)
    begin(names, 19.5)
    assert not names.are_all_new()
    graph.gids = ['a', 'b']
    assert not names.are_all_new()
    graph.gids = ['b']
    assert names.are_all_new() and names.find_new(2, 50) == 'b'
    assert not names.are_all_new()


def test_where_nobody_knows_who_was_heard_nobody_is_new():
    names, graph = make_names('a', 'b')
    begin(names, None)
    names.find_new(7, 70)
    graph.gids = ['c']
    begin(names, 19.5)
    assert not names.are_all_new()
