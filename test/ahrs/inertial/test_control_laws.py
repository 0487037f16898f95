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

"""Gains and closed-form errors of the control laws."""

from __future__ import annotations

import math

import numpy as np
import pytest

from heading_intercompare.ahrs.gimballed.claims import gyrocompass_sigma, output_sigma
from heading_intercompare.ahrs.inertial.control_laws import (
    compute_gyrocompass_gains,
    compute_hold_gains,
    gyrocompass_azimuth,
    settled_rate,
    settled_speed_error,
    speed_error,
)
from heading_intercompare.ahrs.sensor_presets import ERRORS
from heading_intercompare.ahrs.ship.earth import EARTH_RATE_RAD_S, KNOT_M_S, RAD_PER_DEG_H

G = 9.806


def test_hold_loop_has_the_poles_asked_for():
    """Eigenvalues of tilt, velocity and integral as matrices give them."""
    gains = compute_hold_gains(0.02, 0.707, G)
    loop = np.array([[0.0, -gains.k_rad_m, 1.0], [G, -gains.k1_1_s, 0.0],
                     [0.0, -gains.ki_rad_m_s, 0.0]])
    imaginary = 0.02 * math.sqrt(1.0 - 0.707**2)
    assert np.sort_complex(np.linalg.eigvals(loop)) == pytest.approx(
        [-0.02, -0.01414 - 1j * imaginary, -0.01414 + 1j * imaginary], rel=1e-6)


def test_gyrocompass_loop_has_four_poles_in_pairs():
    """Azimuth, tilt, velocity, filter: all four at -sigma +- j sigma."""
    sigma, north = 2e-3, EARTH_RATE_RAD_S * math.cos(math.radians(60.0))
    gains = compute_gyrocompass_gains(sigma, G)
    loop = np.array([[0.0, 0.0, 0.0, -gains.k3_rad_m_s2 / north],
                     [north, 0.0, -gains.k_rad_m, 0.0],
                     [0.0, G, -gains.k1_1_s, 0.0],
                     [0.0, 0.0, 1.0, -gains.k4_1_s]])
    wanted = np.poly([-sigma * (1 + 1j), -sigma * (1 - 1j)] * 2).real
    assert np.poly(loop) == pytest.approx(wanted, rel=1e-9, abs=1e-20)


def test_settled_azimuth_by_hand():
    """0.01 deg/h east at 45 degrees: 0.01 / 10.6357 rad = 3.232'; 0.01 deg/h down: 0.167'."""
    drift, latitude = 0.01 * RAD_PER_DEG_H, math.radians(45.0)
    arcmin = math.degrees(1.0) * 60.0
    assert gyrocompass_azimuth(0.0, drift, 0.0, 0.0, 2e-3, latitude) * arcmin == pytest.approx(
        -3.232, abs=1e-3)
    assert gyrocompass_azimuth(0.0, 0.0, drift, 0.0, 2e-3, latitude) * arcmin == pytest.approx(
        0.1667, abs=1e-4)
    assert gyrocompass_azimuth(0.0, 0.0, 0.0, 50e-6 * 9.806198, 2e-3, latitude) == pytest.approx(
        -50e-6)


@pytest.mark.parametrize('speed_kn, latitude_deg, error_deg', [
    (20.0, 81.0, 8.1), (20.0, 83.0, 10.5), (50.0, 81.0, 20.7), (50.0, 83.0, 27.0)])
def test_speed_error_of_the_printed_table(speed_kn, latitude_deg, error_deg):
    """C. Plath's table for northerly courses, printed to 0.1 degrees, of the sine form."""
    found = speed_error(speed_kn * KNOT_M_S, 0.0, math.radians(latitude_deg))
    assert math.degrees(math.asin(math.tan(found))) == pytest.approx(error_deg, abs=0.15)


def test_no_speed_error_on_easterly_and_westerly_courses():
    for course_deg in (90.0, 270.0):
        assert speed_error(10.0, math.radians(course_deg), 0.8) == pytest.approx(0.0, abs=1e-15)


def test_settled_rate_grows_towards_the_pole_and_has_a_floor():
    assert settled_rate(0.0, 0.0, 2e-3, 0.8) == pytest.approx(0.05 * RAD_PER_DEG_H)
    rates = [settled_rate(1e-6, 0.0, 2e-3, math.radians(latitude)) for latitude in (0, 60, 80)]
    assert rates == sorted(rates)


def test_settled_speed_error_by_hand():
    """
    Eastbound, 60 degrees, 10 m/s: -2 v tan(phi) / (sigma R_N), and a quarter by the tilt.

    2.5 * 10 * 1.7321 / (2e-3 * 6.394e6) = 3.386e-3 rad; the gain is that of W cos(phi) + v / R_N,
    4 % more. Northbound the Coriolis force takes 2 W sin(phi) v tan(phi) / g = 2.23e-4 rad, the
    lag v / R_M e tan(phi) 2 / sigma = 1.17e-4 rad, off the angle of 0.0431 rad.
    """
    latitude = math.radians(60.0)
    assert settled_speed_error(10.0, math.pi / 2, latitude, 2e-3) == pytest.approx(
        -3.386e-3, rel=0.05)
    bare = speed_error(10.0, 0.0, latitude)
    assert settled_speed_error(10.0, 0.0, latitude, 2e-3) - bare == pytest.approx(
        -2.23e-4 - 1.17e-4, rel=0.05)
    assert settled_speed_error(0.0, 1.0, latitude, 2e-3) == 0.0


@pytest.mark.parametrize('model, sigma_deg, within', [
    ('dtg_precision', 0.033, 0.003), ('marine_0p1', 0.1, 0.001), ('imo', 0.22, 0.03)])
def test_class_has_the_accuracy_of_its_name(model, sigma_deg, within):
    """Claimed at the equator, where sec(phi) is 1, four hours after power-on."""
    errors = ERRORS[model]
    soak = math.exp(-14400.0 / errors.soak_tau_s)
    settled = gyrocompass_sigma(errors, errors.residual_xy_deg_h, 2e-3, soak, 0.0)
    assert math.degrees(math.hypot(settled, output_sigma(errors))) == pytest.approx(
        sigma_deg, abs=within)
