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

"""The alarm of a heading that contradicts the motion of the ship, while it happens."""

from __future__ import annotations

from pathlib import Path
import sys

import numpy as np
import pytest

from heading_intercompare.core.alarms.alarm import AlarmState, AlarmTable
from heading_intercompare.core.alarms.motion_watch import MOTION_RULES, MotionWatch
from heading_intercompare.core.records import Motion, Pairs
from heading_intercompare.core.settings import Settings

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / 'motion'))

from sailing import sail, START_NS  # noqa: E402

S = 10 ** 9
NORMS = {'norms.sigma_max_deg': 0.3, 'norms.sigma_ref_max_deg': 0.1}


def watch(stamp_ns, ts_deg, rs_deg, motion, *, late_s=0, **settings):
    """Look every five seconds, the motion late by some; return changes as (second, alarm)."""
    seen = MotionWatch(Settings.from_mapping({**NORMS, **settings}))
    table, changes = AlarmTable(MOTION_RULES), []
    moved = motion.in_order()
    zeros = np.zeros(stamp_ns.size)
    pairs = Pairs.of(stamp_ns, ts_deg % 360.0, rs_deg % 360.0, zeros.astype(int), zeros + 1.0)
    for second in range(5, int((stamp_ns[-1] - START_NS) / S) + 1, 5):
        now_ns = START_NS + second * S
        edges = now_ns - 5 * S, now_ns
        seen.take_motion(moved[slice(*np.searchsorted(moved.stamp_ns + late_s * S, edges))])
        seen.update(pairs[slice(*np.searchsorted(stamp_ns, edges))])
        changes += [(second, alarm) for alarm in table.update(seen.look(), now_ns)]
    return changes, table


@pytest.fixture(scope='module')
def voyage():
    return sail(3, duration_s=900.0)


@pytest.mark.parametrize('late_s', [0, 20])
def test_a_sensor_that_turns_round_is_named_within_three_minutes(voyage, rng, late_s):
    ts, rs = voyage.sensors(rng)
    wrong = (voyage.stamp_ns >= START_NS + 300 * S) & (voyage.stamp_ns < START_NS + 560 * S)
    ts = np.where(wrong, ts + 180.0, ts)
    changes, table = watch(voyage.stamp_ns, ts, rs, voyage.courses + voyage.rates, late_s=late_s)
    (raised_s, raised), (cleared_s, cleared) = changes
    assert 360 < raised_s <= 480 and 620 < cleared_s <= 800 + late_s
    assert raised.state is AlarmState.UNACKNOWLEDGED and raised.values['sensor'] == 'ts'
    assert raised.words.startswith('the TS points') and 'mounted backwards' in raised.words
    assert cleared.state is AlarmState.RECTIFIED
    assert table['motion'].times == 1


@pytest.mark.slow
@pytest.mark.parametrize('seed', [
    1, *(pytest.param(seed, marks=pytest.mark.endurance) for seed in (2, 4, 5))])
def test_sound_sensors_raise_nothing_in_turns_current_and_leeway(seed, rng):
    voyage = sail(seed, current_kn=2.5, leeway_deg=8.0)
    ts, rs = voyage.sensors(rng)
    for motion in (voyage.courses + voyage.rates, voyage.positions):
        assert watch(voyage.stamp_ns, ts, rs, motion)[0] == []


def test_both_sensors_wrong_together_are_seen(voyage, rng):
    """The difference of the two shows nothing."""
    ts, rs = voyage.sensors(rng)
    changes, _ = watch(voyage.stamp_ns, ts + 90.0, rs + 90.0, voyage.courses)
    assert changes[0][1].values['sensor'] == 'both' and changes[0][0] < 300


def test_without_motion_or_underway_nothing_is_said(voyage, rng):
    ts, rs = voyage.sensors(rng)
    slow = sail(3, speed_kn=1.0, current_kn=0.2, duration_s=600.0)
    assert watch(voyage.stamp_ns, ts + 180.0, rs, Motion.empty())[0] == []
    assert watch(slow.stamp_ns, slow.heading_deg + 180.0, slow.heading_deg, slow.courses)[0] == []


def test_the_installation_angle_is_removed(voyage, rng):
    ts, rs = voyage.sensors(rng)
    assert watch(voyage.stamp_ns, ts + 90.0, rs, voyage.courses,
                 installation_offset_deg=90.0)[0] == []


def test_months_take_no_memory():
    seen = MotionWatch(Settings.from_mapping(NORMS))
    for hour in range(48):
        stamps = START_NS + (3600 * hour + np.arange(3600)) * S
        seen.take_motion(Motion.of_rates(stamps, np.zeros(3600)))
    assert len(seen._record) <= 480 + 3600
