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

"""Messages replayed at their log times, on a clock that the tests set."""

from __future__ import annotations

from fractions import Fraction
import math

import numpy as np
import pytest

from heading_intercompare.bags.errors import BagError
from heading_intercompare.bags.recording.bag_writer import BagWriter
from heading_intercompare.bags.rosbag2.bag_reader import BagReader
from heading_intercompare.bags.rosbag2.paced_replay import Pace, Replay
from heading_intercompare.core.declared_settings import SettingsError

S = 1_000_000_000
T0 = 1_700_000_000 * S


class Clock:
    """A steady clock that stands still until it is set."""

    def __init__(self) -> None:
        self.ns = 77 * S

    def __call__(self) -> int:
        return self.ns


def bag_of(path, log_ns):
    """Write a bag with a message for every log time, alternating between /a and /b."""
    with BagWriter(path) as bag:
        for topic in '/a', '/b':
            bag.add_topic(topic, 'std_msgs/msg/String')
        for i, ns in enumerate(log_ns):
            bag.write(('/a', '/b')[i % 2], bytes([i % 251]) * 12, int(ns), int(ns), i)
    return BagReader(path)


@pytest.fixture(scope='module')
def log_ns():
    """Return 200 log times at odd distances, some of them equal."""
    steps = np.random.default_rng(3).integers(0, 90_000_001, 199)
    steps[::7] = 0
    return [T0, *(T0 + np.cumsum(steps)).tolist()]


@pytest.fixture(scope='module')
def reader(tmp_path_factory, log_ns):
    """Return a bag of these times."""
    return bag_of(tmp_path_factory.mktemp('replay') / 'bag', log_ns)


def begun(reader, **options):
    """Return a replay of both topics that has begun, and its clock."""
    clock = Clock()
    replay = Replay(reader, ['/a', '/b'], clock_ns=clock, **options)
    replay.begin()
    return replay, clock


def taken(replay):
    """Return the numbers of the messages that are due."""
    return [message.sequence for message in iter(replay.take, None)]


def due_ns(log_ns, rate):
    """Return when a log time is due, in clock nanoseconds, by exact arithmetic."""
    # Log time is rounded to nanoseconds, halves to even; at most one of the clock is unsure.
    return math.ceil(Fraction(2 * (log_ns - T0) - 1, 2) / Fraction(rate))


@pytest.mark.parametrize('rate', [1.0, 0.7, 20.0, 3.3])
def test_every_message_is_due_at_its_distance_from_the_start_over_the_rate(
        reader, log_ns, rate):
    replay, clock = begun(reader, rate=rate)
    start_ns, found = clock.ns, []
    for number, ns in enumerate(log_ns):
        if number and ns == log_ns[number - 1]:
            continue
        due = due_ns(ns, rate)
        clock.ns = start_ns + due - 2
        assert taken(replay) == []
        clock.ns = start_ns + due + 1
        found += taken(replay)
        assert found[-1] == max(n for n, other in enumerate(log_ns) if other == ns)
    assert found == list(range(200)) and replay.over


def test_pauses_shift_what_follows_by_their_length_to_the_nanosecond(reader, log_ns, rng):
    replay, clock = begun(reader)
    start_ns, shift_ns, found = clock.ns, 0, []
    for ns in sorted(set(log_ns))[1:]:
        clock.ns = start_ns + shift_ns + (ns - T0) - 1
        found += taken(replay)
        assert found == list(range(log_ns.index(ns)))
        replay.pause(True)
        length_ns = int(rng.integers(1, 10 * S))
        clock.ns += length_ns
        assert replay.take() is None and replay.shown_ns == ns - 1
        replay.pause(False)
        shift_ns += length_ns
        assert replay.take() is None
        clock.ns += 1
        found += taken(replay)
        assert found == list(range(log_ns.index(ns) + log_ns.count(ns)))
    assert replay.over


def test_rounds_follow_each_other_without_drift(reader, log_ns):
    """Message k of round r is due at (r times the length of a round, plus its place) / rate."""
    rate, length_ns = 0.7, log_ns[-1] - T0
    replay, clock = begun(reader, rate=rate, loop=True)
    start_ns = clock.ns
    for number in range(40):
        for k in (5, 100, 199):
            assert log_ns[k - 1] < log_ns[k]
            due = due_ns(log_ns[k] + number * length_ns, rate)
            clock.ns = start_ns + due - 2
            before = taken(replay)
            assert k - 1 in before and k not in before
            clock.ns = start_ns + due + 1
            assert k in taken(replay)
    assert (replay.round, replay.over) == (41, False)


def test_a_new_round_begins_with_the_last_message_of_the_one_before(reader, log_ns):
    replay, clock = begun(reader, loop=True)
    clock.ns += log_ns[-1] - T0
    assert taken(replay) == [*range(200), *(n for n, ns in enumerate(log_ns) if ns == T0)]
    assert (replay.shown_ns, replay.round) == (T0, 2)
    assert replay.place.endswith(', round 2')


def test_whatever_is_pressed_no_message_is_lost_or_doubled(reader, log_ns, rng):
    for _ in range(20):
        rate = rng.choice([0.0, 0.5, 1.0, 40.0])
        replay, clock = begun(reader, rate=rate, paused=bool(rng.integers(2)))
        found, shown = [], [replay.shown_ns]
        while not replay.over:
            clock.ns += int(rng.integers(0, 3 * S))
            if rng.random() < 0.4:
                replay.pause([True, False, None][rng.integers(3)])
            for _ in range(rng.integers(20)):
                message = replay.take()
                assert message is None or not replay.paused
                found += [] if message is None else [message.sequence]
                shown.append(replay.shown_ns)
                following = log_ns[len(found)] if len(found) < 200 else math.inf
                assert log_ns[max(0, len(found) - 1)] <= shown[-1] <= following
        assert found == list(range(200))
        assert shown == sorted(shown)


def test_at_a_rate_beyond_every_number_all_is_due_at_the_first_look(reader):
    replay, clock = begun(reader, rate=1e308)
    assert taken(replay) == [0, 1]
    clock.ns += 10
    assert taken(replay) == list(range(2, 200))


def test_without_waiting_everything_is_due_and_a_pause_still_holds_it(reader):
    replay, _ = begun(reader, rate=0.0)
    assert [replay.take().sequence for _ in range(5)] == list(range(5))
    replay.pause(True)
    assert taken(replay) == []
    replay.pause(False)
    assert taken(replay) == list(range(5, 200))


def test_a_pause_before_the_begin_stands_at_the_start(reader, log_ns):
    clock = Clock()
    replay = Replay(reader, ['/a', '/b'], paused=True, clock_ns=clock)
    clock.ns += 5 * S
    replay.begin()
    clock.ns += 5 * S
    assert taken(replay) == [] and replay.shown_ns == T0
    replay.pause(False)
    assert set(taken(replay)) == {n for n, ns in enumerate(log_ns) if ns == T0}


def test_a_pause_says_what_it_did_and_where(reader, log_ns):
    replay, clock = begun(reader)
    clock.ns += 1_234_000_000
    taken(replay)
    place = f'1.234 s of {(log_ns[-1] - T0) / S:.3f} s'
    assert replay.place == place
    assert replay.pause(False) == f'not paused, at {place}'
    assert replay.pause() == f'paused at {place}'
    assert replay.pause(True) == f'already paused at {place}'
    assert replay.pause() == f'resumed at {place}'


def test_only_the_topics_asked_for_are_replayed(reader):
    replay = Replay(reader, ['/b'], rate=0.0)
    replay.begin()
    assert taken(replay) == list(range(1, 200, 2))
    with pytest.raises(BagError, match="no topic 'c'"):
        Replay(reader, ['c'])


@pytest.mark.parametrize('start_s, duration_s, numbers', [
    (0.0, None, [0, 1, 2, 3]), (1.0, None, [1, 2, 3]), (1.000000001, None, [2, 3]),
    (0.0, 2.0, [0, 1]), (1.0, 1.0, [1]), (1.0, 1.000000001, [1, 2]), (3.0, None, [3]),
    (2.5, 1e300, [3]), (0.0, 0.0, []), (2.1, 0.5, [])])
def test_the_part_begins_with_its_start_and_ends_before_its_end(
        tmp_path, start_s, duration_s, numbers):
    reader = bag_of(tmp_path / 'bag', [T0 + n * S for n in range(4)])
    replay, clock = begun(reader, start_s=start_s, duration_s=duration_s)
    assert replay.over == (not numbers)
    if numbers:
        clock.ns += numbers[0] * S - round(start_s * S) - 1
        assert taken(replay) == []
        clock.ns += 4 * S
    assert taken(replay) == numbers
    assert replay.over


@pytest.mark.parametrize('start_s', [3.000000001, 3.5, 1e300])
def test_a_start_behind_the_end_is_refused_with_the_length(tmp_path, start_s):
    reader = bag_of(tmp_path / 'bag', [T0, T0 + 3 * S])
    with pytest.raises(SettingsError, match=r'start_s = [\de+.]+: .*bag is 3.000 s long'):
        Replay(reader, ['/a'], start_s=start_s)


@pytest.mark.parametrize('loop', [False, True])
def test_where_there_is_nothing_it_is_over_at_once(tmp_path, loop):
    replay = Replay(bag_of(tmp_path / 'empty', []), ['/a'], start_s=7.0, loop=loop)
    assert replay.over and replay.take() is None
    gap = Replay(bag_of(tmp_path / 'gap', [T0, T0 + 9 * S]), ['/a'], start_s=1.0, duration_s=8.0,
                 loop=loop)
    assert gap.over and gap.take() is None
    assert gap.part == f'{tmp_path / "gap"} from 1 s to before 9 s'


def test_a_log_time_that_steps_back_holds_nothing_up(tmp_path):
    log_ns = [T0, T0 + 3 * S, T0 + S, T0 + 4 * S]
    replay, clock = begun(bag_of(tmp_path / 'bag', log_ns))
    clock.ns += 3 * S
    assert taken(replay) == [0, 1, 2]
    assert replay.shown_ns == T0 + 3 * S


def test_a_day_at_an_odd_rate_is_right_to_the_nanosecond():
    clock = Clock()
    pace = Pace(T0, 1 / 3, clock_ns=clock)
    pace.begin()
    clock.ns += 86_400 * S
    assert pace.look_ns() == T0 + 28_800 * S
