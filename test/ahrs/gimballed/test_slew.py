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

"""The slew: its servo, its stop and its check by the pick-off, S (10), (11)."""

from __future__ import annotations

import math

import pytest

from heading_intercompare.ahrs.gimballed.slew import slew
from heading_intercompare.ahrs.inertial.computer import Computer
from heading_intercompare.ahrs.inertial.instruments import Instruments
from heading_intercompare.ahrs.inertial.platform import Platform, rows_of
from heading_intercompare.ahrs.sensor_presets import ERRORS
from heading_intercompare.ahrs.settings import Ahrs
from heading_intercompare.ahrs.ship.ship_motion import ShipTruth
from heading_intercompare.ahrs.ship.steering import Leg

ARCSEC = math.radians(1.0 / 3600.0)


class Bench:
    """A platform on a ship whose heading is a function of time."""

    def __init__(self, heading_deg=lambda t_s: 0.0, speed_m_s=0.0):
        settings = Ahrs(noise=False, initial_state='warm')
        parts = Instruments(ERRORS['imo'], settings, 1, 'ts')
        self.heading_deg, self.speed_m_s = heading_deg, speed_m_s
        self.row = rows_of(ShipTruth([Leg(0.0, 0.0, 0.0)], 45.0).block(0), parts.take(1))[0]
        self.platform = Platform(parts, 0.0)
        self.computer = Computer(settings, self.platform)
        self.computer.prepare(math.radians(45.0))
        self.rates_deg_s = []
        self.step(0.0, 0.0, self.computer.free()[2])

    def step(self, ux, uy, uz):
        """Advance by one control step."""
        t_s = 0.1 * len(self.rates_deg_s)
        row = self.row.copy()
        row[6], row[7] = math.radians(self.heading_deg(t_s + 0.1)), self.speed_m_s
        row[20] = 5e-5 * (row[6] - math.radians(self.heading_deg(t_s))) / 0.1
        before = self.platform.azimuth_rad
        self.platform.step(row, ux, uy, uz)
        self.computer.take()
        self.rates_deg_s.append(math.degrees(self.platform.azimuth_rad - before) / 0.1)

    def slew(self, angle_deg):
        """Return whether the slew was confirmed, the angle really turned, and the seconds."""
        start_rad = self.platform.azimuth_rad
        self.rates_deg_s.clear()
        motion = slew(self.computer, self.platform, math.radians(angle_deg))
        while True:
            try:
                rates = next(motion)
            except StopIteration as end:
                return (end.value, self.platform.azimuth_rad - start_rad,
                        0.1 * len(self.rates_deg_s))
            self.step(*rates)


@pytest.mark.parametrize('angle_deg', [-170.0, -30.0, -0.2, 0.0, 2.0, 90.0, 180.0])
def test_platform_arrives(angle_deg):
    """At 10 deg/s, then 2 s to coast and a few steps to trim; exact to an arc second."""
    bench = Bench()
    confirmed, turned_rad, span_s = bench.slew(angle_deg)
    assert confirmed
    assert turned_rad == pytest.approx(math.radians(angle_deg), abs=ARCSEC)
    assert span_s == pytest.approx(abs(angle_deg) / 10.0 + 2.4, abs=0.4)
    assert bench.computer.azimuth_rad == math.radians(angle_deg)


def test_servo_takes_its_time():
    """S (10): with the gain k = 2.5 1/s the rate is 10 deg/s (1 - (1 - k dt)^n) after n steps."""
    bench = Bench()
    bench.slew(90.0)
    for n in (1, 2, 4, 10, 60):
        assert bench.rates_deg_s[n - 1] == pytest.approx(10.0 * (1.0 - 0.75**n), abs=2e-3)
    assert max(bench.rates_deg_s) < 10.01


def test_rate_is_relative_to_the_ship_and_the_angle_is_not():
    """S (10): on a ship that turns by 2 deg/s the platform turns by 12 deg/s: 120 deg in 10 s."""
    bench = Bench(lambda t_s: 2.0 * t_s, 5.0)
    confirmed, turned_rad, span_s = bench.slew(120.0)
    assert confirmed
    # The friction drags it by 5e-5 of what the ship turns, which the next step takes out.
    assert turned_rad == pytest.approx(math.radians(120.0), abs=2.0 * ARCSEC)
    assert bench.rates_deg_s[80] == pytest.approx(12.0, abs=0.01)
    assert span_s == pytest.approx(10.0 + 2.0 + 2.0, abs=0.8)


def test_yaw_does_not_mislead_the_slew():
    """A pick-off alone would be wrong by the yaw, some tenths of a degree."""
    bench = Bench(lambda t_s: 0.9 * math.sin(2.0 * math.pi * t_s / 12.0), 5.0)
    confirmed, turned_rad, _ = bench.slew(77.0)
    assert confirmed
    assert turned_rad == pytest.approx(math.radians(77.0), abs=2.0 * ARCSEC)


def test_scale_error_of_the_torquer_stays():
    """200 ppm of 150 degrees are 108"."""
    bench = Bench()
    bench.platform.instruments.torquer[2] = 200e-6
    confirmed, turned_rad, _ = bench.slew(150.0)
    assert confirmed
    assert turned_rad - math.radians(150.0) == pytest.approx(108.0 * ARCSEC, abs=2.0 * ARCSEC)


def test_motor_that_stands_still_is_noticed():
    """S (11): the angle is not reached within 10 s more than it takes; nothing has turned."""
    bench = Bench()
    bench.platform.jammed = True
    confirmed, turned_rad, span_s = bench.slew(50.0)
    assert not confirmed and abs(turned_rad) < ARCSEC
    assert span_s == pytest.approx(15.0, abs=0.2)


@pytest.mark.parametrize('speed_m_s, confirmed', [(0.0, False), (5.0, True)])
def test_pick_off_must_confirm_the_angle(speed_m_s, confirmed):
    """Three degrees of difference are too much at berth; at sea the ship may have turned."""
    bench = Bench(lambda t_s: min(0.6 * t_s, 3.0), speed_m_s)
    assert bench.slew(60.0)[0] is confirmed


@pytest.mark.parametrize('late_s, mode', [(560.0, 'AZIMUTH_ALIGNMENT'),
                                          (640.0, 'FINE_LEVELLING')])
def test_ahrs_stops_if_the_motor_stands_still(make_ahrs, run_for, late_s, mode):
    """It fails after the calibration of the meter, or after the slew to the meridian."""
    ahrs = make_ahrs(initial_state='warm', hold_s=60.0, alignment_s=60.0, azimuth_deg=40.0,
                     events=f'{late_s} fail_servo')
    run = run_for(ahrs, 800.0)
    assert run.statuses[-1].mode == 'FAULT' and run.statuses[-1].faults == ('servo',)
    (said,) = (status for status in run.statuses if 'fault: servo' in status.message)
    assert 'the platform does not turn as asked' in said.message
    last = next(status for status in reversed(run.statuses) if status.mode != 'FAULT')
    assert last.mode == mode
