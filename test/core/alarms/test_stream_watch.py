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

"""Whether both streams keep coming, and whether one clock steps."""

from __future__ import annotations

import pytest

from heading_intercompare.core.alarms.stream_watch import StreamWatch

S_NS = 10 ** 9


class Streams:
    """Two streams that report at a rate; the stamps of the TS may be off, its readings stop."""

    def __init__(self, rate_hz=10.0, speed=1.0, lag_s=0.0):
        self.watch, self.rate_hz, self.speed = StreamWatch(3.0, 5.0), rate_hz, speed
        self.now_s, self.received, self.heard = 100.0, [0, 0], [None, None]
        self.off_s, self.silent = lag_s, False

    def run(self, seconds):
        """Let time pass; return the signs of each second."""
        found = []
        for _ in range(seconds):
            self.now_s += 1.0
            stamp_s = 1000.0 + self.speed * (self.now_s - 100.0)
            for at, off_s in ((0, self.off_s), (1, 0.0)):
                if at or not self.silent:
                    self.received[at] += max(1, round(self.rate_hz * self.speed))
                    self.heard[at] = round((stamp_s + off_s) * S_NS)
            found.append(self.watch.look(self.received, self.heard, self.now_s))
        return found


def actives(found, name):
    """Return what the signs of a name say."""
    return [signs[name].active for signs in found]


@pytest.mark.parametrize('rate_hz, step_s', [(10.0, 1.0), (10.0, -0.8), (100.0, 3600.0),
                                             (1.0, -3.0)])
def test_a_step_of_a_clock_is_seen_within_two_looks_and_its_end_at_once(rate_hz, step_s):
    streams = Streams(rate_hz)
    assert not any(actives(streams.run(20), 'clock_step'))
    streams.off_s = step_s
    found = streams.run(60)
    assert actives(found, 'clock_step')[:3] == [None, True, True]
    assert actives(found, 'clock_step')[-1] is True
    assert f'stepped by {step_s:+.1f} s' in found[-1]['clock_step'].words
    assert not any(actives(found, 'overload'))
    streams.off_s = 0.0
    assert actives(streams.run(3), 'clock_step') == [False] * 3


def test_clocks_that_lie_apart_from_the_start_are_seen():
    found = Streams(lag_s=-3600.0).run(10)
    assert actives(found, 'clock_step')[-1] is True
    assert '3600.0 s apart' in found[-1]['clock_step'].words
    assert not any(actives(found, 'overload'))


@pytest.mark.parametrize('speed', [0.5, 10.0, 400.0])
def test_in_a_replay_pieces_that_come_unevenly_are_no_step(rng, speed):
    streams = Streams(speed=speed)
    for _ in range(200):
        streams.off_s = speed * rng.uniform(-0.4, 0.4)
        assert not any(actives(streams.run(1), 'clock_step'))


def test_a_silent_sensor_is_seen_after_its_time_and_is_not_a_step():
    streams = Streams()
    streams.run(20)
    streams.silent = True
    found = streams.run(10)
    assert actives(found, 'ts_silent') == [False] * 3 + [True] * 7
    assert not any(actives(found, 'rs_silent'))
    assert not any(actives(found, 'clock_step'))
    streams.silent = False
    found = streams.run(10)
    assert not any(actives(found, 'ts_silent')) and not any(actives(found, 'clock_step'))


@pytest.mark.parametrize('rate_hz, late_s', [(10.0, 3.0), (1.0, 6.0), (50.0, 2.5)])
@pytest.mark.parametrize('drops', [False, True])
def test_readings_that_come_late_are_no_step_of_a_clock(rate_hz, late_s, drops):
    """A driver has garbage to read: its readings wait, or a part of them is dropped."""
    watch, now_s, received, sent = StreamWatch(10.0, 5.0), 100.0, [0, 0], 0
    found = []
    for second in range(60):
        now_s += 1.0
        # From 20 s on the TS is late; it catches up from 35 s on.
        late = late_s if 20 <= second < 35 else max(0.0, late_s - 0.5 * (second - 34)) \
            if second >= 35 else 0.0
        upto = round(rate_hz * (now_s - 100.0 - late))
        n = max(0, upto - sent)
        lost = n // 2 if drops and 20 <= second < 35 else 0
        received = [received[0] + n - lost, received[1] + round(rate_hz)]
        sent = max(sent, upto)
        heard = [round((1000.0 + sent / rate_hz) * S_NS), round((900.0 + now_s) * S_NS)]
        found.append(watch.look(received, heard, now_s))
    assert not any(actives(found, 'clock_step'))


@pytest.mark.parametrize('pace', [0.0, 0.5, 0.99])
@pytest.mark.parametrize('late', [0, 1])
def test_a_sensor_that_lags_is_named_as_overload_and_not_as_a_step(late, pace):
    """One driver works at half its pace, or at 99 %, or hangs, until it is 12 s behind."""
    watch, received, lag_s, signs = StreamWatch(3.0, 5.0), [0, 0], 0.0, {}
    for second in range(1, 4000):
        if second > 20:
            lag_s = min(lag_s + 1.0 - pace, 12.0) if second < 2000 else max(lag_s - 1.0, 0.0)
        lags_s = [lag_s * (at == late) for at in range(2)]
        received = [round(10.0 * (second - behind_s)) for behind_s in lags_s]
        heard = [round((1000.0 + second - behind_s) * S_NS) for behind_s in lags_s]
        before, signs = signs, watch.look(received, heard, float(second))
        assert signs['clock_step'].active is not True
        if lag_s <= 5.0:
            assert not signs['overload'].active
        if before and lag_s == 12.0 and second in (1500, 1999):
            assert signs['overload'].active is True
            slow, other = ('TS', 'RS')[late], ('RS', 'TS')[late]
            assert signs['overload'].words.startswith(
                f'overload: the readings of the {slow} lag those of the {other} by 12.0 s')
    assert signs['overload'].active is False


def test_what_a_cut_connection_kept_comes_at_once_and_is_no_overload():
    watch = StreamWatch(3.0, 5.0)
    for second in range(1, 80):
        came = second if not 20 <= second < 55 else 19
        if second == 55:
            came = 40
        signs = watch.look([10 * second, 10 * came], [second * S_NS, came * S_NS], float(second))
        assert not signs['overload'].active and not signs['clock_step'].active


@pytest.mark.parametrize('speed', [20.0, 400.0])
def test_a_fast_replay_that_is_uneven_is_no_overload(rng, speed):
    streams = Streams(speed=speed)
    for _ in range(200):
        streams.off_s = speed * rng.uniform(-0.4, 0.4)
        assert not any(actives(streams.run(1), 'overload'))


def test_a_sensor_slower_than_the_limit_is_not_silent_between_its_readings():
    """One reading in 4 s."""
    watch = StreamWatch(3.0, 5.0)
    for at in range(200):
        n = 1 + at // 4
        found = watch.look([n, at], [n * 4 * S_NS, at * S_NS], float(at))
        assert found['ts_silent'].active is False
    later = [watch.look([n, at], [n * 4 * S_NS, at * S_NS], float(at)) for at in range(200, 220)]
    assert later[-1]['ts_silent'].active is True


def test_before_a_sensor_was_heard_it_is_not_silent():
    watch = StreamWatch(3.0, 5.0)
    for at in range(20):
        found = watch.look([0, 10 * at], [None, at * S_NS], float(at))
        assert found['ts_silent'].active is None and found['clock_step'].active is None


def test_the_silence_allowed_can_be_changed():
    watch = StreamWatch(3.0, 5.0)
    for at in range(100):
        watch.look([at, at], [at * S_NS, at * S_NS], float(at))
    assert watch.look([99, 99], [99 * S_NS, 99 * S_NS], 110.0)['ts_silent'].active is True
    watch.allow(60.0)
    assert watch.look([99, 99], [99 * S_NS, 99 * S_NS], 111.0)['ts_silent'].active is False
