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

"""Headings grouped by minute: all of them, in order, whatever the log times."""

from __future__ import annotations

import numpy as np
import pytest

from heading_intercompare.bags.parallel.by_minute import Window
from heading_intercompare.bags.parallel.decoding import Found
from heading_intercompare.core.records import Headings

S = 10**9
MINUTE = 60 * S


def found(log_time_ns, place=None) -> Found:
    """Return headings stamped with their number."""
    log = np.asarray(log_time_ns, np.int64)
    place = np.zeros(len(log), np.int16) if place is None else np.asarray(place, np.int16)
    return Found(log, place, np.zeros(len(log), np.uint32),
                 Headings.as_sent(np.arange(len(log)), np.zeros(len(log))))


def numbers(minutes) -> list[list[list[int]]]:
    """Return the numbers of the headings by minute and topic."""
    return [[headings.stamp_ns.tolist() for headings in minute] for minute in minutes]


def taken(count: int, *blocks) -> list[list[list[int]]]:
    """Return the same of blocks, each of one or several kinds."""
    window = Window(count)
    return numbers([minute for block in blocks for minute in window.add(block)]
                   + list(window.rest()))


@pytest.mark.parametrize('rising', [True, False])
def test_a_block_is_divided_at_minutes_from_its_first_log_time(rng, rising):
    log = 7 * S + rng.integers(0, 10 * MINUTE, 500)
    log[:2] = 7 * S
    log = np.sort(log) if rising else log
    place = rng.integers(0, 2, 500)
    topics = [np.flatnonzero(place == topic) for topic in (0, 1)]
    # A reading after a later log time takes that time; otherwise it would lose its place.
    minutes = [(np.maximum.accumulate(log[mine]) - 7 * S) // MINUTE for mine in topics]
    expected = [[mine[of == minute].tolist() for mine, of in zip(topics, minutes)]
                for minute in np.unique(np.concatenate(minutes))]
    assert taken(2, [found(log, place)]) == expected


def test_topics_one_behind_the_other_are_divided_at_the_same_times():
    log = [*np.arange(0, 180, 10) * S, *np.arange(5, 185, 10) * S]
    assert taken(2, [found(log, [0] * 18 + [1] * 18)]) == [
        [list(range(6 * i, 6 * i + 6)), list(range(18 + 6 * i, 24 + 6 * i))] for i in range(3)]


def test_kinds_are_divided_at_the_same_times():
    ts, rs = found(np.arange(0, 200, 10) * S, [0] * 20), found([65 * S, 70 * S, 190 * S], [1] * 3)
    assert taken(2, [ts, rs]) == [
        [list(range(6)), []], [list(range(6, 12)), [0, 1]], [list(range(12, 18)), []],
        [[18, 19], [2]]]


def test_small_blocks_are_joined_until_they_span_a_minute():
    assert taken(1, [found([0, 30 * S])], [found([60 * S])], [found([])], [found([61 * S])]) == [
        [[0, 1, 0]], [[0]]]


@pytest.mark.parametrize('log, count', [([0, 1, 2**62, 2**62 + 1], 2), ([-2**62, 5, 2**62], 3),
                                        ([2**62, 2**62 + 1, 0, 1], 1)])
def test_log_times_far_apart_take_no_time(log, count):
    minutes = taken(1, [found(log)])
    assert [i for minute in minutes for i in minute[0]] == list(range(len(log)))
    assert len(minutes) == count
