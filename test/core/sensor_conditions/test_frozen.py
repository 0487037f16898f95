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

"""A headline names the cause before its consequences: a clock far off, a frozen sensor."""

from __future__ import annotations

import numpy as np
import pytest
from trials import find_finding

from heading_intercompare import analyze, Headings, Settings
from heading_intercompare.core.records import Motion

N = 18_000
STAMPS = 10 ** 18 + np.arange(1, N + 1) * 10 ** 8
T_S = np.arange(1, N + 1) / 10.0
SETTINGS = Settings.from_mapping({'norms': {'sigma_max_deg': 0.2, 'sigma_ref_max_deg': 0.1}})


@pytest.fixture
def ship():
    """Return the heading of a ship that yaws and alters course every four minutes, degrees."""
    courses = np.array([90.0, 40.0, 100.0, 160.0, 95.0, 20.0, 80.0, 150.0])
    steps = np.repeat(courses, 2)
    times = np.sort(np.concatenate((np.arange(8) * 240.0, np.arange(8) * 240.0 + 180.0)))
    return np.interp(T_S, times, steps) + np.sin(2.0 * np.pi * T_S / 8.3)


@pytest.fixture
def motion(ship):
    """Return the course over ground and the rate of turn, once a second."""
    rows = slice(None, None, 10)
    rate_deg_s = np.gradient(ship, T_S)[rows]
    return (Motion.of_courses(STAMPS[rows], ship[rows] + 2.0, np.full(N // 10, 10.0))
            + Motion.of_rates(STAMPS[rows], rate_deg_s))


def headings(deg, late_s=0.0):
    """Return readings in hundredths of a degree, of a clock that lags by `late_s`."""
    return Headings.as_sent(STAMPS - round(late_s * 1e9), np.round(deg, 2) % 360.0)


@pytest.mark.slow
@pytest.mark.parametrize('with_motion', [False, True])
@pytest.mark.parametrize('late_s', [90.0, 300.0])
def test_a_clock_far_off_is_named_before_what_it_makes_of_the_headings(
        ship, motion, rng, late_s, with_motion):
    ts, rs = (ship + 0.05 * rng.standard_normal(N) for _ in range(2))
    verdict = analyze(headings(ts), headings(rs, late_s), SETTINGS,
                      motion=motion if with_motion else None)
    assert verdict.runs[0].reason == 'void.clocks'
    assert f'the clock of the RS lags by about {late_s:.1f} s' in verdict.headline


@pytest.mark.slow
@pytest.mark.parametrize('sensor', ['TS', 'RS'])
@pytest.mark.parametrize('span_s', [30, 300, 800])
def test_a_frozen_sensor_is_named_before_its_quarrel_with_the_motion(
        ship, motion, rng, sensor, span_s):
    streams = {name: ship + 0.05 * rng.standard_normal(N) for name in ('TS', 'RS')}
    streams[sensor][4500:4500 + 10 * span_s] = streams[sensor][4500]
    verdict = analyze(headings(streams['TS']), headings(streams['RS']), SETTINGS, motion=motion)
    assert verdict.runs[0].reason == 'void.frozen'
    assert f'the {sensor} froze' in verdict.headline


def moored(rng, sticks, range_deg, hold_s, holds):
    """Return TS and RS of a ship that swings in 28 s, one of which sticks at times."""
    t_s = np.arange(0.0, 3600.0, 1.0)
    swing = 180.0 + 0.5 * range_deg * np.sin(2.0 * np.pi * t_s / 28.0)
    sensors = {name: np.round(swing + 0.01 * rng.standard_normal(t_s.size), 2)
               for name in ('TS', 'RS')}
    for begin in (np.arange(holds) + 0.3) * 3600.0 / holds:
        at = slice(int(begin), int(begin + hold_s))
        sensors[sticks][at] = sensors[sticks][at.start]
    stamps = 10 ** 18 + (t_s * 1e9).astype(np.int64)
    return (Headings.of(stamps, sensors['TS']), Headings.of(stamps, sensors['RS']))


def frozen(verdict):
    return find_finding(verdict.runs[0], 'frozen')


@pytest.mark.parametrize('sensor', ['TS', 'RS'])
def test_a_sound_gyro_of_a_moored_ship_that_sticks_for_14_s_is_not_frozen(rng, sensor):
    found = frozen(analyze(*moored(rng, sensor, 0.3, 14.0, 6), SETTINGS))
    assert found.effect == 'holds' and f'the {sensor} repeated its value' in found.evidence


@pytest.mark.parametrize('sensor', ['TS', 'RS'])
def test_a_gyro_that_misses_more_than_twice_the_norm_is_frozen(rng, sensor):
    found = frozen(analyze(*moored(rng, sensor, 0.8, 30.0, 6), SETTINGS))
    assert found.effect == 'void' and found.words == f'the {sensor} froze'


def test_a_gyro_that_sticks_most_of_the_time_is_doubtful(rng):
    """0.32 deg of motion missed for 83 % of the hour: 0.007 deg2, above 5 % of 0.04 deg2."""
    found = frozen(analyze(*moored(rng, 'TS', 0.32, 500.0, 6), SETTINGS))
    assert found.effect == 'doubtful' and found.words == 'the TS sticks'
