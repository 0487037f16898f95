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

"""Gains, closed-form errors and torques of the control laws; pure functions of S (2)-(22)."""

from __future__ import annotations

from dataclasses import dataclass
import math

from heading_intercompare.ahrs.ship.earth import earth_rate, gravity, radii

GYRO_MOMENTUM_N_M_S = 0.04
TORQUE_MOTOR_N_M_A = 0.02


@dataclass(frozen=True, slots=True)
class HoldGains:
    """Gains of the levelling with integral action: damping, velocity, integral."""

    k1_1_s: float
    k_rad_m: float
    ki_rad_m_s: float


@dataclass(frozen=True, slots=True)
class GyrocompassGains:
    """Gains of the gyrocompass: damping, velocity, damping of the azimuth filter, azimuth."""

    k1_1_s: float
    k_rad_m: float
    k4_1_s: float
    k3_rad_m_s2: float


def torque(rate_rad_s: float) -> tuple[float, float]:
    """
    Return the control moment, and the current of the torque motor, that turn the platform.

    Parameters
    ----------
    rate_rad_s
        Commanded rate about one axis, rad/s.

    Returns
    -------
    moment_n_m, current_a : float
        M = H u, newton metres, and I = M / k, amperes.

    References
    ----------
    S (3), with an angular momentum of 0.04 N m s and 0.02 N m/A.

    Examples
    --------
    >>> moment, current = torque(1e-4)
    >>> round(moment, 9), round(current, 9)
    (4e-06, 0.0002)

    """
    moment = GYRO_MOMENTUM_N_M_S * rate_rad_s
    return moment, moment / TORQUE_MOTOR_N_M_A


def coarse_rate(force_m_s2: float, gravity_m_s2: float, tau_s: float) -> float:
    """
    Return the rate of coarse levelling about one axis.

    Parameters
    ----------
    force_m_s2
        Corrected accelerometer of the other axis, with sign: +A_y for the rate about x, -A_x for
        the rate about y.
    gravity_m_s2
        Gravity.
    tau_s
        Time constant, seconds.

    Returns
    -------
    float
        Rate, rad/s. A tilt decays as exp(-t / tau).

    References
    ----------
    S (1), S (2). What the feed-forward of the friction leaves moves the platform in `loop.step`.

    """
    return force_m_s2 / (gravity_m_s2 * tau_s)


def compute_hold_gains(omega_1_s: float, zeta: float, gravity_m_s2: float) -> HoldGains:
    """
    Return the gains that place the poles of the levelling loop.

    Parameters
    ----------
    omega_1_s
        Natural frequency, rad/s; the third pole is at -omega.
    zeta
        Damping of the pair.
    gravity_m_s2
        Gravity.

    References
    ----------
    S (7), S (12): s^3 + k1 s^2 + g K s + g Ki = (s + w)(s^2 + 2 zeta w s + w^2).

    Examples
    --------
    >>> gains = compute_hold_gains(0.02, 0.5, 10.0)
    >>> round(gains.k1_1_s, 9), round(gains.k_rad_m, 9), round(gains.ki_rad_m_s, 12)
    (0.04, 8e-05, 8e-07)

    """
    both = 1.0 + 2.0 * zeta
    return HoldGains(both * omega_1_s, both * omega_1_s**2 / gravity_m_s2,
                     omega_1_s**3 / gravity_m_s2)


def compute_gyrocompass_gains(sigma_1_s: float, gravity_m_s2: float) -> GyrocompassGains:
    """
    Return the gains of the gyrocompass from its one tuning parameter.

    Parameters
    ----------
    sigma_1_s
        Magnitude of the real and the imaginary parts of the four poles, 1/s.
    gravity_m_s2
        Gravity.

    References
    ----------
    S (20)-(22): s (s + k4)(s^2 + k1 s + g K) + g k3 = ((s + sigma)^2 + sigma^2)^2.

    Examples
    --------
    >>> gains = compute_gyrocompass_gains(0.5, 10.0)
    >>> gains.k1_1_s, gains.k_rad_m, gains.k4_1_s, gains.k3_rad_m_s2
    (1.0, 0.1, 1.0, 0.025)

    """
    return GyrocompassGains(2.0 * sigma_1_s, 4.0 * sigma_1_s**2 / gravity_m_s2,
                            2.0 * sigma_1_s, 4.0 * sigma_1_s**4 / gravity_m_s2)


def gyrocompass_azimuth(drift_x_rad_s: float, drift_y_rad_s: float, drift_z_rad_s: float,
                        bias_y_m_s2: float, sigma_1_s: float, latitude_rad: float) -> float:
    """
    Return the azimuth at which the gyrocompass settles; the heading error is minus this.

    Parameters
    ----------
    drift_x_rad_s, drift_y_rad_s, drift_z_rad_s
        Uncompensated drifts about the north, the east and the down axis, rad/s.
    bias_y_m_s2
        Uncompensated bias of the east accelerometer, m/s^2.
    sigma_1_s
        Tuning, 1/s.
    latitude_rad
        Latitude, radians.

    References
    ----------
    S (22): A = -e_y / (W cos phi) + 2 e_z / sigma - (b_y / g + e_x / (2 sigma)) tan(phi). The last
    bracket is the tilt about north at which accelerometer and damping balance.

    """
    tilt = bias_y_m_s2 / gravity(latitude_rad) + 0.5 * drift_x_rad_s / sigma_1_s
    return (-drift_y_rad_s / earth_rate(latitude_rad)[0] + 2.0 * drift_z_rad_s / sigma_1_s
            - tilt * math.tan(latitude_rad))


def speed_error(speed_m_s: float, course_rad: float, latitude_rad: float) -> float:
    """
    Return the heading error of a gyrocompass without speed compensation.

    Parameters
    ----------
    speed_m_s
        Speed over ground, m/s.
    course_rad
        Course, radians.
    latitude_rad
        Latitude, radians.

    Returns
    -------
    float
        Indicated minus true heading, radians.

    References
    ----------
    e = atan2(v cos C, R W cos phi + v sin C), with R_M for the northward and R_N for the
    eastward part: the direction of the horizontal rate of the level frame. `settled_speed_error`
    adds what the loop makes of the other effects of the speed.

    """
    meridian, normal = radii(latitude_rad)
    return math.atan2(
        speed_m_s * math.cos(course_rad) / meridian,
        earth_rate(latitude_rad)[0] + speed_m_s * math.sin(course_rad) / normal)


def settled_speed_error(speed_m_s: float, course_rad: float, latitude_rad: float,
                        sigma_1_s: float) -> float:
    """
    Return the heading error to which a gyrocompass settles that takes the speed for nil.

    Parameters
    ----------
    speed_m_s
        Speed over ground, m/s.
    course_rad
        Course, radians.
    latitude_rad
        Latitude now, radians.
    sigma_1_s
        Tuning, 1/s.

    Returns
    -------
    float
        Indicated minus true heading, radians.

    Notes
    -----
    To the direction of the horizontal rate, `speed_error`, come the Coriolis force
    (2 W sin(phi) + v_E tan(phi) / R_N) v, which the level takes for a tilt; the turn of north
    under a ship that sails east, v_E tan(phi) / R_N, which acts like a drift of the course gyro;
    and the lag of the loop, 2 / sigma times the rate at which all this changes with the latitude.

    References
    ----------
    S (20)-(22) and the equations of motion of docs/ahrs.md at rest in the tilts and in azimuth.

    """
    meridian = radii(latitude_rad)[0]
    north_m_s, step = speed_m_s * math.cos(course_rad), 1e-4
    now, before, after = (_settle(speed_m_s, course_rad, latitude_rad + away, sigma_1_s)
                          for away in (0.0, -step, step))
    changing = (after - before) / (2.0 * step) * north_m_s / meridian
    return now - 2.0 / sigma_1_s * changing


def _settle(speed_m_s: float, course_rad: float, latitude_rad: float, sigma_1_s: float) -> float:
    """Solve for the resting platform by iteration; each round adds two digits or more."""
    earth_north, earth_up = earth_rate(latitude_rad)
    meridian, normal = radii(latitude_rad)
    g, tangent = gravity(latitude_rad), math.tan(latitude_rad)
    gains = compute_gyrocompass_gains(sigma_1_s, g)
    north_m_s, east_m_s = speed_m_s * math.cos(course_rad), speed_m_s * math.sin(course_rad)
    north, east = earth_north + east_m_s / normal, -north_m_s / meridian
    turning = 2.0 * earth_up + east_m_s * tangent / normal
    force_north, force_east = turning * east_m_s, -turning * north_m_s
    azimuth = math.atan2(east, north)
    alpha = beta = 0.0
    for _ in range(12):
        c, s = math.cos(azimuth), math.sin(azimuth)
        rate_x, rate_y = north * c + east * s, east * c - north * s
        rate_z = (-earth_up - east_m_s * tangent / normal) - alpha * rate_y + beta * rate_x
        qx = -gains.k4_1_s * (rate_z + earth_up) * earth_north / gains.k3_rad_m_s2
        beta = (gains.k1_1_s * qx - force_north * c - force_east * s) / g
        qy = (rate_x - earth_north - beta * rate_z) / gains.k_rad_m
        alpha = (force_east * c - force_north * s - gains.k1_1_s * qy) / g
        missing = gains.k_rad_m * qx + alpha * rate_z
        azimuth = math.atan2(east, north) + math.asin(missing / math.hypot(north, east))
    return -azimuth


def settled_rate(walk_rad_sqrt_s: float, residual_rad_s: float, sigma_1_s: float,
                 latitude_rad: float) -> float:
    """
    Return the azimuth correction rate below which a gyrocompass counts as settled, rad/s.

    Parameters
    ----------
    walk_rad_sqrt_s
        Angle random walk of the gyros, rad/sqrt(s).
    residual_rad_s
        Drift of the course gyro that a calibration leaves, rad/s.
    sigma_1_s
        Tuning, 1/s.
    latitude_rad
        Latitude, radians.

    Notes
    -----
    The first term is the stationary noise of the correction, which grows with the secant of the
    latitude. A floor of 0.05 deg/h keeps the result above zero without noise.

    """
    noise = 0.5 * walk_rad_sqrt_s * sigma_1_s**1.5 / earth_rate(latitude_rad)[0]
    return 2.0 * math.hypot(noise, residual_rad_s) + math.radians(0.05) / 3600.0
