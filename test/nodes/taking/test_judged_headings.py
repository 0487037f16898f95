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

"""Headings are kept back until it is known whether anybody judges them."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from heading_intercompare.bags.rosbag2.publisher_starts import PublisherStart
from heading_intercompare.nodes.taking import judged_headings
from heading_intercompare.nodes.taking.judged_headings import JudgedHeadings

TOPIC, LEDGER = 'ts/heading', 'pairs/ledger'


@pytest.fixture
def found(monkeypatch):
    """Return what is known of a synchronizer; all of it can be set."""
    monkeypatch.setattr(judged_headings, 'is_alone', lambda: False)
    return SimpleNamespace(publishers=0, first=None)


def made(found):
    """Return what keeps the headings of one sensor."""
    class Heading(SimpleNamespace):
        spans, is_heading, is_ledger, last_judged = (1,), True, False, None
        first_judged = property(lambda self: found.first)
    ledger = SimpleNamespace(spans=(), is_heading=False, is_ledger=True, intake=found)
    intake = SimpleNamespace(full_name=f'/{TOPIC}', publishers=1, counted=True,
                             read_stamps=lambda messages: [0] * len(messages),
                             numbers=SimpleNamespace(spans=(), last_publisher=''))
    return JudgedHeadings({TOPIC: Heading(intake=intake), LEDGER: ledger})


def some(lo, hi):
    """Return messages with these numbers."""
    return [(b'', {'publication_sequence_number': n}) for n in range(lo, hi)]


def test_a_synchronizer_that_is_found_3_s_late_says_where_the_bag_begins(found):
    """The bag began 3 s before the verdict, whose figures it then did not give."""
    judged = made(found)
    for second in range(4):
        messages = some(1 + 50 * second, 51 + 50 * second)
        assert judged.take(TOPIC, messages, 10.0 + second, False) == []
    found.publishers = 1
    assert judged.take(TOPIC, some(201, 251), 14.0, False) == []
    found.first = 163
    assert judged.take(TOPIC, some(251, 252), 15.0, False) == some(163, 252)
    assert [n for n, _ in judged.counts.values()] == [251 - 162]


def test_without_a_synchronizer_all_headings_are_kept_after_a_while(found):
    judged, now_s, kept = made(found), 10.0, []
    while not kept and now_s < 30.0:
        n = int(now_s)
        kept += judged.take(TOPIC, some(n, n + 1), now_s, False)
        now_s += 1.0
    assert (kept, now_s) == (some(10, 16), 16.0)


def test_nodes_of_one_process_need_not_wait_for_long(found, monkeypatch):
    monkeypatch.setattr(judged_headings, 'is_alone', lambda: True)
    judged = made(found)
    assert judged.take(TOPIC, some(1, 2), 10.0, False) == []
    assert judged.take(TOPIC, some(2, 3), 11.0, False) == some(1, 3)


def test_what_the_last_publisher_in_a_bag_before_sends_goes_on_with_it(found):
    """Another one began again with the graph, which says when it was heard."""
    for publisher, kept in (('aa', some(41, 60)), ('bb', [])):
        judged = made(found)
        judged._resumed = {TOPIC: 'aa'}
        judged._topics[TOPIC].intake.numbers.last_publisher = publisher
        assert judged.take(TOPIC, some(41, 60), 10.0, False) == kept
    found.first = 58
    assert judged.take(TOPIC, some(60, 62), 10.2, False) == some(58, 62)


def test_what_is_missing_among_headings_that_nobody_judged_is_no_loss_of_the_bag(found):
    """5 to 8 before the synchronizer came, 61 to 63 after; a publisher restarts in between."""
    judged = made(found)
    judged.take(TOPIC, some(1, 5) + some(9, 60), 10.0, False)
    found.first = 40
    judged.note_starts(TOPIC, [PublisherStart('bb', 70, 0)])
    judged.take(TOPIC, some(60, 61) + some(64, 66) + some(70, 73), 10.2, False)
    (n, numbering), = judged.counts.values()
    assert n == 20 + 1 + 2 + 3
    # The 69 of the second publisher were not heard.
    assert numbering.missing == 3 + 69
    assert numbering.spans == (('', 40, 65), ('bb', 70, 72))
