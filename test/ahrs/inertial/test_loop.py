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

"""What the laws make of a bias, a drift, the Earth rate and the friction of the gimbals."""

from __future__ import annotations

import math

import numpy as np
import pytest

from heading_intercompare.ahrs.inertial import loop
from heading_intercompare.ahrs.inertial.computer import Computer
from heading_intercompare.ahrs.inertial.control_laws import torque
from heading_intercompare.ahrs.inertial.instruments import Instruments
from heading_intercompare.ahrs.inertial.platform import Platform, rows_of
from heading_intercompare.ahrs.sensor_presets import ERRORS
from heading_intercompare.ahrs.settings import Ahrs
from heading_intercompare.ahrs.ship.earth import EARTH_RATE_RAD_S, KNOT_M_S, radii, UG_M_S2
from heading_intercompare.ahrs.ship.ship_motion import ShipTruth
from heading_intercompare.ahrs.ship.steering import Leg

LATITUDE = math.radians(45.0)
NORTH = UP = EARTH_RATE_RAD_S * math.sqrt(0.5)
ARCSEC = math.radians(1.0 / 3600.0)
KAPPA = 5e-5


def bench(fixed='', speed_kn=0.0, course_deg=0.0):
    """Return platform, computer and rows of a ship at 45 degrees; the platform stands north."""
    settings = Ahrs(noise=False, initial_state='warm', fixed=fixed)
    parts = Instruments(ERRORS['imo'], settings, 1, 'ts')
    ship = ShipTruth([Leg(0.0, course_deg, speed_kn)], 45.0)
    platform = Platform(parts, 0.0)
    computer = Computer(settings, platform)
    block = ship.block(0)
    computer.prepare(float(block.latitude_rad[0]))
    platform.latitude_rad = float(block.latitude_rad[0])
    platform.speed_m_s = float(block.speed_m_s[0])
    platform.pick_off_rad = float(block.heading_rad[0])
    platform.force_z_m_s2 = -computer.gravity
    computer.take()
    return platform, computer, rows_of(block, parts.take(600))


def run(law, platform, computer, rows):
    """Return true azimuth, assumed azimuth and tilts after each step, shape (n + 1, 4)."""
    states = np.zeros((len(rows) + 1, 4)).tolist()
    computer.enter_hold()
    if law == loop.HOLD:
        computer.ix = NORTH
    elif law == loop.GYROCOMPASS:
        computer.enter_gyrocompass()
    loop.run(law, platform, computer, platform.instruments, platform.instruments.thermostat,
             rows.tolist(), 0, len(rows), states)
    return np.array(states)


def step_by(platform, computer, rows, rates):
    """Command what a function returns at every step."""
    for row in rows.tolist():
        platform.step(row, *rates())
        computer.take()


@pytest.mark.parametrize('known_ug', [0.0, 80.0])
def test_known_bias_leaves_no_tilt(known_ug):
    """S (1): of 80 ug the unknown part tilts the platform by b / g; 60 s are six tau."""
    platform, computer, rows = bench('bias_x 80')
    computer.bias_x_m_s2 = known_ug * UG_M_S2
    step_by(platform, computer, rows, lambda: computer.coarse(10.0))
    tilt = -(80.0 - known_ug) * UG_M_S2 / computer.gravity
    assert platform.beta_rad == pytest.approx(tilt, abs=0.005 * 80e-6)


def test_coarse_tilt_decays_with_its_time_constant():
    """S (2): after one tau 1/e of it is left, and W cos(phi) tau (1 - 1/e) of the Earth rate."""
    platform, computer, rows = bench()
    platform.alpha_rad = platform.beta_rad = 1e-2
    step_by(platform, computer, rows[:100], lambda: computer.coarse(10.0))
    left = math.exp(-1.0)
    assert platform.beta_rad == pytest.approx(1e-2 * left, rel=0.02)
    assert platform.alpha_rad == pytest.approx(1e-2 * left - NORTH * 10.0 * (1.0 - left),
                                               rel=0.02)


def test_currents_turn_the_platform_by_their_moments():
    """S (3): M / H over a minute is the angle; 0.02 N m/A by 0.04 N m s is 0.5 rad/s per A."""
    platform, computer, rows = bench()
    current = torque(1e-3)[1]
    step_by(platform, computer, rows[:60], lambda: (0.0, 0.0, 1e-3 - UP))
    assert platform.azimuth_rad == pytest.approx(0.5 * current * 6.0, rel=1e-3)


def test_hold_leaves_no_tilt_of_a_drift_and_the_earth_rate():
    """S (7): where (2) leaves drift times tau, the integrators leave nothing after 25 / omega."""
    platform, computer, rows = bench('drift_x 5; drift_y -3')
    computer.enter_hold()
    tilts = []
    for _ in range(20):
        step_by(platform, computer, rows, computer.hold)
        tilts.append(math.hypot(platform.alpha_rad, platform.beta_rad))
    assert max(tilts) > 60.0 * ARCSEC
    assert tilts[-1] < 0.1 * ARCSEC


def disturbance_gain(gains, w):
    """Return |tilt / rate| of s (s + k1) / (s^3 + k1 s^2 + g K s + g Ki) at j w."""
    k1, gk, gki = gains
    s = 1j * w
    return abs(s * (s + k1) / (s**3 + k1 * s**2 + gk * s + gki))


@pytest.mark.parametrize('law', [loop.HOLD, loop.FINE], ids=['hold', 'fine'])
@pytest.mark.parametrize('heading_deg', [0.0, 90.0])
def test_signals_of_the_gyro_vertical_take_the_friction_out(law, heading_deg):
    """
    S (12): rolling by 5 degrees in 10 s drags the platform by 5e-5 of it, about the ship's axis.

    S (7) leaves that tilt. In S (12) the gyros' signal is a step late: 2 sin(w dt / 2) is left.
    """
    platform, computer, rows = bench()
    w, amplitude = 2.0 * math.pi / 10.0, math.radians(5.0)
    rate = amplitude * w * np.cos(w * 0.1 * (np.arange(600) + 0.5))
    rows[:, 9 if heading_deg == 0.0 else 10] = KAPPA * rate
    states = run(law, platform, computer, rows)[-200:]
    tilt, other = states[:, 2:].T if heading_deg == 0.0 else states[:, :1:-1].T
    wanted = KAPPA * amplitude * w * disturbance_gain(
        (computer.hold_k1, computer.gravity * computer.hold_k,
         computer.gravity * computer.hold_ki), w)
    if law == loop.FINE:
        wanted *= 2.0 * math.sin(0.5 * w * 0.1)
    assert 0.5 * np.ptp(tilt) == pytest.approx(wanted, rel=0.05)
    assert np.abs(other).max() < 0.2 * wanted + 1e-9


@pytest.mark.parametrize('law, left', [(loop.HOLD, 1.0), (loop.FINE, 0.0),
                                       (loop.GYROCOMPASS, 0.0)], ids=['hold', 'fine', 'compass'])
def test_rate_of_the_course_gyro_keeps_the_azimuth_while_the_ship_turns(law, left):
    """S (21): a turn by 90 degrees drags the azimuth by 5e-5 of it, 16.2", unless it is seen."""
    platform, computer, rows = bench()
    rows[50:500, 20] = KAPPA * math.radians(2.0)
    states = run(law, platform, computer, rows)
    assert (states[-1, 0] - states[0, 0]) / ARCSEC == pytest.approx(16.2 * left, abs=0.1)


@pytest.mark.parametrize('part', ['all', 'earth', 'speed', 'drift'])
def test_four_rates_together_hold_the_platform(part):
    """
    S (13): with Earth rate, transport rate and drift known, a minute leaves it within 0.05".

    Each one left out tilts the platform at its own rate. The fourth, the integral correction, is
    in the test of S (7).
    """
    platform, computer, rows = bench('drift_x 2', 20.0, 90.0)
    speed_m_s, east = 20.0 * KNOT_M_S, radii(LATITUDE)[1]
    computer.drift_x_rad_s = 2.0 * ARCSEC
    missing = {'all': 0.0, 'earth': NORTH, 'speed': speed_m_s / east,
               'drift': -2.0 * ARCSEC}[part]
    if part == 'drift':
        computer.drift_x_rad_s = 0.0

    def rates():
        if part == 'earth':
            computer.earth_north = 0.0
        elif part == 'speed':
            computer.normal_m = math.inf
        return computer.free()

    for row in rows.tolist():
        platform.step(row, *rates())
        computer.take()
    assert platform.alpha_rad / ARCSEC == pytest.approx(-60.0 * missing / ARCSEC, abs=0.05)


def test_accelerometers_and_velocity_pull_towards_the_meridian():
    """
    S (20): a platform 1 degree off north tips at W cos(phi) sin(1 deg); S (22) turns it back.

    dA/dt = -k3 p / W cos(phi), dp/dt = q, dq/dt = -g beta, d beta/dt = W cos(phi) A: the azimuth
    begins with -4 sigma^4 A t^4 / 24, of which the damping takes a tenth. The tilt turns it too,
    by -(W cos(phi))^2 A t^2 / 2.
    """
    platform, computer, rows = bench()
    platform.azimuth_rad = math.radians(1.0)
    states = run(loop.GYROCOMPASS, platform, computer, rows)
    tip = NORTH * math.sin(math.radians(1.0)) * 60.0
    assert states[-1, 3] == pytest.approx(tip, rel=0.05)
    fourth = -4.0 * 2e-3**4 * math.radians(1.0) * 60.0**4 / 24.0
    second = -NORTH**2 * math.radians(1.0) * 60.0**2 / 2.0
    assert states[-1, 0] - math.radians(1.0) == pytest.approx(0.9 * fourth + second, rel=0.03)
