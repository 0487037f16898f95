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

"""Sensors that point far apart for a while: by how much, from when to when, and who is wrong."""

from __future__ import annotations

import numpy as np
import pytest
from trials import find_finding

from heading_intercompare import analyze, Headings, Settings
from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.records import Motion
from heading_intercompare.core.validity.condition import DOUBTFUL, HOLDS, VOID

N = 18_000
STAMPS = 1_800_000_000 * 10 ** 9 + np.arange(1, N + 1) * 10 ** 8
T_S = np.arange(1, N + 1) / 10.0
SETTINGS = Settings.from_mapping({'norms': {'sigma_max_deg': 0.2, 'sigma_ref_max_deg': 0.1}})
APART = slice(6000, 8400)
WHEN = 'from 2027-01-15 08:10:00 to 08:14:00 UTC'


@pytest.fixture
def ship():
    """Return the heading of a ship on legs of five minutes that yaws, degrees."""
    legs = np.array([90.0, 60.0, 120.0, 80.0, 30.0, 100.0])
    return np.interp(T_S, np.arange(12) * 150.0 + np.tile([0.0, 120.0], 6),
                     np.repeat(legs, 2)) + np.sin(2.0 * np.pi * T_S / 8.3)


def sailing(ship):
    """Return the course over ground of a ship, once a second."""
    rows = slice(None, None, 10)
    return Motion.of_courses(STAMPS[rows], ship[rows] + 2.0, np.full(N // 10, 10.0))


def judge(ship, rng, sensor, off_deg, motion=None, ts_deg=0.05):
    """Judge two sensors of which one points off for four minutes."""
    streams = {'ts': ship + ts_deg * rng.standard_normal(N),
               'rs': ship + 0.05 * rng.standard_normal(N)}
    streams[sensor][APART] += off_deg
    return analyze(*(Headings.as_sent(STAMPS, streams[name] % 360.0) for name in ('ts', 'rs')),
                   SETTINGS, motion=motion)


def effect(verdict, condition):
    """Return the effect of the finding on a condition."""
    return find_finding(verdict.runs[0], condition).effect


@pytest.mark.parametrize('sensor', ['ts', 'rs'])
@pytest.mark.parametrize('off_deg', [5.0, 38.0, -170.0])
def test_the_headline_says_by_how_much_and_when(ship, rng, sensor, off_deg):
    verdict = judge(ship, rng, sensor, off_deg)
    assert verdict.outcome is Outcome.NON_COMPLIANT
    assert effect(verdict, 'parting') == DOUBTFUL and effect(verdict, 'mean_difference') == HOLDS
    assert f'the sensors part by {abs(off_deg):.1f} deg {WHEN}, without that compliant' in (
        verdict.headline)


@pytest.mark.parametrize('off_deg', [38.0, -170.0])
def test_an_rs_that_the_motion_proves_wrong_for_a_while_rejects_nothing(ship, rng, off_deg):
    verdict = judge(ship, rng, 'rs', off_deg, sailing(ship))
    assert verdict.runs[0].reason == 'void.motion'
    assert ', which the TS follows, from 2027-01-15 08:10:' in verdict.headline
    assert verdict.headline.endswith('without these legs compliant')


def test_a_ts_that_the_motion_proves_wrong_for_a_while_stays_rejected(ship, rng):
    verdict = judge(ship, rng, 'ts', 38.0, sailing(ship))
    assert verdict.outcome is Outcome.NON_COMPLIANT and effect(verdict, 'motion') == DOUBTFUL
    assert 'which of the two is wrong is not shown' not in verdict.headline


def test_a_bad_ts_stays_rejected_beside_a_wrong_rs(ship, rng):
    verdict = judge(ship, rng, 'rs', 38.0, sailing(ship), ts_deg=1.0)
    assert verdict.outcome is Outcome.NON_COMPLIANT and effect(verdict, 'motion') == DOUBTFUL
    assert 'without these legs also non-compliant' in verdict.headline


def test_sound_sensors_do_not_part(ship, rng):
    verdict = judge(ship, rng, 'ts', 0.0)
    assert verdict.outcome is Outcome.COMPLIANT and effect(verdict, 'parting') == HOLDS
    assert VOID not in {f.effect for f in verdict.runs[0].validity}
