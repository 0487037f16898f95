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

"""One sensor as it reports."""

from __future__ import annotations

import math

import numpy as np
import pytest

from heading_intercompare.core.records import Headings
from heading_intercompare.web.figures.stream_watch import SensorView, StreamWatch

S = 10 ** 9
T0 = 1_700_000_000 * S


def play(watch, seconds, rate_hz=10.0, heading=lambda t: 90.0, start_s=100.0, late_s=0.0):
    """Let readings come one by one; return the steady time of the last one."""
    for i in range(round(seconds * rate_hz)):
        t = i / rate_hz
        stamp = T0 + round(t * S)
        watch.take(Headings.of([stamp], [heading(t) % 360.0]), stamp + round(late_s * S),
                   start_s + t)
    return start_s + t


def test_before_the_first_reading_nothing_is_known():
    watch = StreamWatch(3.0)
    watch.take(Headings.empty(), T0, 5.0)
    assert watch.view(5.0) == SensorView()
    assert watch.view(5.0).stale


def test_rate_age_and_offset_of_a_sensor():
    watch = StreamWatch(3.0)
    end_s = play(watch, 30.0, late_s=0.25)
    seen = watch.view(end_s + 0.4)
    assert seen.heading_deg == seen.last_deg == 90.0
    assert seen.rate_hz == pytest.approx(10.0)
    assert seen.age_s == pytest.approx(0.4)
    assert seen.offset_s == pytest.approx(-0.25)
    assert not seen.stale and not seen.flagged


def test_a_silent_sensor_shows_no_heading_but_says_which_was_the_last():
    watch = StreamWatch(3.0)
    end_s = play(watch, 5.0)
    seen = watch.view(end_s + 3.1)
    assert seen.stale
    assert (seen.heading_deg, seen.rate_hz, seen.turn_deg_min) == (None, None, None)
    assert (seen.last_deg, seen.age_s) == (90.0, pytest.approx(3.1))


def test_a_slow_sensor_is_given_the_time_of_three_readings():
    watch = StreamWatch(3.0)
    end_s = play(watch, 100.0, rate_hz=0.2)
    assert not watch.view(end_s + 14.0).stale
    assert watch.view(end_s + 16.0).stale


@pytest.mark.parametrize('rate_deg_s', [1.0, -2.0])
def test_the_rate_of_turn_is_positive_to_starboard_and_crosses_north(rate_deg_s):
    watch = StreamWatch(3.0)
    end_s = play(watch, 20.0, heading=lambda t: 358.0 + rate_deg_s * t)
    assert watch.view(end_s).turn_deg_min == pytest.approx(60.0 * rate_deg_s, abs=1e-6)


def test_a_flagged_reading_is_no_heading():
    watch = StreamWatch(3.0)
    watch.take(Headings.of([T0, T0 + S], [10.0, math.nan]), T0 + S, 1.0)
    seen = watch.view(1.0)
    assert seen.flagged and seen.heading_deg is None and seen.last_deg == 10.0
    watch.take(Headings.of([T0 + 2 * S], [11.0]), T0 + 2 * S, 2.0)
    assert watch.view(2.0).heading_deg == 11.0


def test_a_clock_set_back_ends_the_turn_seen_so_far():
    watch = StreamWatch(3.0)
    watch.take(Headings.of([T0 + 9 * S], [10.0]), T0, 1.0)
    watch.take(Headings.of([T0], [50.0]), T0, 2.0)
    assert watch.view(2.0).turn_deg_min is None
    watch.take(Headings.of([T0 + S], [51.0]), T0, 3.0)
    assert watch.view(3.0).turn_deg_min == pytest.approx(60.0)


def test_memory_is_bounded_at_a_thousand_hertz():
    watch = StreamWatch(3.0)
    stamps = T0 + np.arange(30_000) * (S // 1000)
    for at in range(0, 30_000, 3):
        watch.take(Headings.of(stamps[at:at + 3], [5.0] * 3), T0, at / 1000.0)
    assert watch.view(30.0).rate_hz == pytest.approx(1000.0, rel=0.01)
    assert len(watch._arrivals) <= 2000 and len(watch._turn) <= 500
