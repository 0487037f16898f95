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

"""The power-on self-test passes sound hardware in any sea, and finds every part that failed."""

from __future__ import annotations

import math

import pytest

from heading_intercompare.ahrs.gimballed.modes import Mode
from heading_intercompare.ahrs.gimballed.power_on import run_self_test
from heading_intercompare.ahrs.inertial.instruments import Instruments
from heading_intercompare.ahrs.inertial.platform import Platform, rows_of
from heading_intercompare.ahrs.sensor_presets import ERRORS
from heading_intercompare.ahrs.settings import Ahrs
from heading_intercompare.ahrs.ship.ship_motion import ShipTruth
from heading_intercompare.ahrs.ship.steering import Leg


def examine(seed=1, seaway='ss5', state='cold', broken=lambda platform, parts: None):
    """Return what the self-test finds on the worst instruments under way."""
    settings = Ahrs(initial_state=state)
    parts = Instruments(ERRORS['imo'], settings, seed, 'ts')
    platform = Platform(parts, 1e-3)
    platform.azimuth_rad, platform.alpha_rad, platform.beta_rad = 0.4 * seed, 0.03, -0.02
    ship = ShipTruth([Leg(0.0, 50.0 * seed, 12.0)], 55.0, 0.0, seaway, seed)
    rows = rows_of(ship.block(0), parts.take(600)).tolist()
    broken(platform, parts)
    test = run_self_test(platform, parts.thermostat)
    for k in range(601):
        try:
            excitation = next(test)
        except StopIteration as end:
            assert k == 100
            return end.value
        platform.excite(rows[k], *excitation)


@pytest.mark.parametrize('seaway', ['calm', 'ss5'])
def test_sound_hardware_passes(seaway):
    assert [examine(seed, seaway) for seed in range(20)] == [[]] * 20
    assert examine(state='warm') == []


def stop_spin(platform, parts):
    platform.spinning = False


def stick(platform, parts):
    platform.stuck = True


def jam(platform, parts):
    platform.jammed = True


def break_heater(platform, parts):
    parts.thermostat.broken = True


def lose_half_the_torque(platform, parts):
    parts.torquer[2] = -0.6


BROKEN = {'gyro': stop_spin, 'accelerometer': stick, 'servo': jam, 'thermostat': break_heater}


@pytest.mark.parametrize('part', BROKEN)
def test_each_failure_is_found_and_no_other(part):
    for seed in range(5):
        assert examine(seed, broken=BROKEN[part]) == [part]


def test_all_failures_are_named_together():
    def break_all(platform, parts):
        for fail in BROKEN.values():
            fail(platform, parts)
    assert examine(broken=break_all) == list(BROKEN)


def test_weak_gyro_is_found():
    """A course gyro that answers with 0.4 of what its torquer should do has failed."""
    assert examine(broken=lose_half_the_torque) == ['gyro']


def test_broken_heater_is_found_on_warm_instruments():
    """Without heat they lose 40 K (1 - exp(-10 / 200)) = 1.95 K, more than 0.5 K."""
    assert examine(state='warm', broken=break_heater) == ['thermostat']


def test_rotation_unit_is_back_when_the_calibration_begins(make_ahrs, run_for):
    ahrs = make_ahrs(initial_state='cold')
    run_for(ahrs, 10.0)
    assert 0.0 < abs(ahrs.platform.angle_rad) < math.radians(0.5)
    run_for(ahrs, 60.0)
    assert abs(ahrs.platform.angle_rad) < 1e-12


@pytest.mark.parametrize('part', BROKEN)
def test_ahrs_stops_with_the_reason_and_starts_after_a_repair(make_ahrs, run_for, part):
    ahrs = make_ahrs(initial_state='cold', noise=True, seaway='ss3',
                     events=f'0 fail_{part}; 15 reset; 30 repair; 31 reset')
    run = run_for(ahrs, 50.0)
    assert run.t_s[run.first(Mode.FAULT)] == pytest.approx(10.0, abs=0.11)
    faults = {round(status.t_s): status for status in run.statuses}
    assert faults[12].faults == faults[28].faults == (part,)
    assert dict(faults[12].tests)[part] == 'failed'
    assert dict(faults[12].tests)['post'] == 'pending'
    assert run.mode[-1] == Mode.THERMOSTAT_WAIT and run.statuses[-1].faults == ()
    assert dict(run.statuses[-1].tests)['servo'] == 'passed'


def test_servo_that_fails_later_is_noticed_by_the_calibration(make_ahrs, run_for):
    ahrs = make_ahrs(initial_state='warm', hold_s=10.0, events='135 fail_servo')
    run = run_for(ahrs, 150.0)
    assert run.mode[-1] == Mode.FAULT and run.statuses[-1].faults == ('servo',)
    assert any('the rotation unit does not follow' in s.message for s in run.statuses)
