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

"""Differences that leave their usual spread."""

from __future__ import annotations

from pathlib import Path
import sys

import numpy as np
import pytest

from heading_intercompare.core.alarms.alarm import AlarmState

sys.path.insert(0, str(Path(__file__).resolve().parents[3] / 'benchmarks'))

from made_up_ships import raised, voyage, watch  # noqa: E402


def times_of(changes, name):
    """Return when an alarm was raised, and when it cleared."""
    return ([t for t, a in changes if a.rule.name == name and a.state.active],
            [t for t, a in changes if a.rule.name == name and not a.state.active])


@pytest.mark.slow
@pytest.mark.parametrize('motion', ['alongside', 'swell', 'turning'])
@pytest.mark.parametrize('rate_hz', [10.0, 100.0])
def test_a_jump_is_raised_within_3_s_and_clears_when_the_sensor_comes_back(rng, motion, rate_hz):
    t, ts, rs = voyage(rng, motion=motion, rate_hz=rate_hz, span_s=150.0)
    ts[(t >= 60.4) & (t < 110.0)] += 6.0
    changes, _ = watch(t, ts % 360.0, rs)
    (began,), (ended,) = times_of(changes, 'jump')
    assert 60.4 < began <= 63.4 and 110.0 < ended <= 116.0
    assert raised(changes) == ['jump']
    assert '+6' in changes[0][1].words or '+5.9' in changes[0][1].words


@pytest.mark.slow
def test_a_jump_that_stays_is_an_alarm_for_as_long(rng):
    """Twenty minutes: the window holds nothing of the time before any more."""
    t, ts, rs = voyage(rng, span_s=1300.0, rate_hz=4.0)
    ts[t >= 60.0] += 6.0
    changes, table = watch(t, ts % 360.0, rs)
    assert raised(changes) == ['jump'] and table['jump'].state is AlarmState.UNACKNOWLEDGED


@pytest.mark.slow
@pytest.mark.parametrize('late_s', [-1.0, 0.5, 1.5])
@pytest.mark.parametrize('rate_hz', [1.0, 4.0])
def test_turns_of_a_late_sensor_raise_nothing(rng, late_s, rate_hz):
    """At 3 deg/s, 1.5 s make 4.5 deg, forty standard deviations of the errors."""
    changes, _ = watch(*voyage(rng, motion='turning', late_s=late_s, rate_hz=rate_hz,
                               span_s=600.0))
    assert raised(changes) == []


def test_a_single_outlier_is_raised_and_clears(rng):
    t, ts, rs = voyage(rng, span_s=120.0)
    ts[500] += 25.0
    changes, _ = watch(t, ts % 360.0, rs)
    (began,), (ended,) = times_of(changes, 'outliers')
    assert raised(changes) == ['outliers'] and 50.0 < began <= 53.0 and ended <= 67.0


@pytest.mark.slow
def test_a_flood_of_outliers_is_one_alarm_until_it_ends(rng):
    """One reading in ten for two minutes: the usual spread must not grow with them."""
    t, ts, rs = voyage(rng, span_s=300.0)
    bad = (t >= 100.0) & (t < 220.0) & (np.arange(t.size) % 10 == 3)
    ts[bad] += rng.choice((-15.0, 15.0), int(bad.sum()))
    changes, _ = watch(t, ts % 360.0, rs)
    (began,), (ended,) = times_of(changes, 'outliers')
    assert raised(changes) == ['outliers']
    assert 100.0 < began <= 103.0 and 220.0 < ended <= 235.0


def test_a_drift_is_no_jump(rng):
    t, ts, rs = voyage(rng, span_s=400.0)
    changes, _ = watch(t, (ts + 0.02 * np.maximum(0.0, t - 60.0)) % 360.0, rs)
    assert raised(changes) == []
