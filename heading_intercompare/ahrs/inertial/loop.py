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

"""
The control loop, step by step: motion of the platform, measurements, laws.

The functions read and write attributes of a platform `p`, a computer `c`, instruments `i` and a
thermostat `t`. These are the objects of this room, or records with the same fields, for which
`compiled_loop` compiles the functions. Both give the same bits: so squares are products here.
"""

from __future__ import annotations

import math
from typing import Sequence, TYPE_CHECKING

from heading_intercompare.ahrs.ship.earth import EARTH_RATE_RAD_S, gravity, radii
from heading_intercompare.ahrs.ship.seaway import GRID_S

from .control_laws import coarse_rate

if TYPE_CHECKING:
    from heading_intercompare.core.records import Reals

    from .computer import Computer
    from .instruments import Instruments, Thermostat
    from .platform import Platform


HOLD, FINE, GYROCOMPASS, SCHULER = range(4)
"""The laws that `run` knows."""

MOORED_M_S = 0.25
LOG_MEMORY_S = 60.0
PICK_OFF_RAD = 2.0 * math.pi / 2**20

Rates = tuple[float, float, float]


def run(law: int, p: 'Platform', c: 'Computer', i: 'Instruments', t: 'Thermostat',
        rows: Sequence[Sequence[float]] | Reals, first: int, stop: int,
        states: Sequence[list[float]] | Reals) -> None:
    """
    Run a law over some control steps.

    Parameters
    ----------
    law
        HOLD, FINE, GYROCOMPASS or SCHULER.
    p, c, i, t : Platform, Computer, Instruments, Thermostat
        The states, changed in place.
    rows : sequence of sequence of float, or ndarray
        Inputs of each step, see `platform.rows_of`.
    first, stop
        The steps to run.
    states : sequence of list of float, or ndarray
        After step k, item k + 1 holds the true and the assumed azimuth and the two tilts.

    """
    for k in range(first, stop):
        if law == GYROCOMPASS:
            ux, uy, uz = gyrocompass(c, p)
        elif law == FINE:
            ux, uy, uz = fine(c, p)
        elif law == HOLD:
            ux, uy, uz = hold(c)
        else:
            ux, uy, uz = schuler(c, p)
        step(p, i, t, rows[k], ux, uy, uz)
        take(c, p)
        state = states[k + 1]
        state[0], state[1] = p.azimuth_rad, c.azimuth_rad
        state[2], state[3] = p.alpha_rad, p.beta_rad


def step(p: 'Platform', i: 'Instruments', t: 'Thermostat', row: Sequence[float], ux: float,
         uy: float, uz: float) -> None:
    """
    Advance the platform by one control step at the commanded rates, and measure.

    Parameters
    ----------
    p, i, t : Platform, Instruments, Thermostat
        The states, changed in place.
    row
        Inputs of the step, see `platform.rows_of`.
    ux, uy, uz
        Commanded rates of the platform, rad/s.

    References
    ----------
    Equations of motion and accelerometers as in docs/ahrs.md, section Platform.

    """
    p.ux_rad_s, p.uy_rad_s, p.uz_rad_s = ux, uy, uz
    north, east, down = row[0], row[1], row[2]
    warm, soak = t.away_k, i.soak
    scale, bias, heat, still = i.torquer, i.gyro_bias, i.gyro_heat, i.gyro_soak
    px = ux + scale[0] * ux + row[11] + bias[0] + heat[0] * warm + still[0] * soak
    py = uy + scale[1] * uy + row[12] + bias[1] + heat[1] * warm + still[1] * soak
    slip_z = row[20]
    pz = uz + row[13] + bias[2] + heat[2] * warm + still[2] * soak + scale[2] * uz + slip_z
    alpha, beta, azimuth = p.alpha_rad, p.beta_rad, p.azimuth_rad
    turn = GRID_S * pz
    middle = azimuth if -1e-3 < turn < 1e-3 else azimuth + 0.5 * turn
    c, s = math.cos(middle), math.sin(middle)
    wx, wy = north * c + east * s, east * c - north * s
    # The gimbals drag the platform along, and its gyros see by how much.
    slip_x, slip_y = row[9] * c + row[10] * s, row[10] * c - row[9] * s
    px, py = px + slip_x, py + slip_y
    p.slip_x_rad_s, p.slip_y_rad_s, p.slip_z_rad_s = slip_x, slip_y, slip_z
    if middle == azimuth:
        new_alpha = alpha + GRID_S * (px - wx + beta * pz)
        new_beta = beta + GRID_S * (py - wy - alpha * pz)
    else:
        half_c, half_s = math.cos(0.5 * turn), math.sin(0.5 * turn)
        middle_alpha = alpha * half_c + beta * half_s + GRID_S * (px - wx)
        middle_beta = beta * half_c - alpha * half_s + GRID_S * (py - wy)
        new_alpha = middle_alpha * half_c + middle_beta * half_s
        new_beta = middle_beta * half_c - middle_alpha * half_s
    p.alpha_rad, p.beta_rad = new_alpha, new_beta
    p.azimuth_rad = azimuth + GRID_S * (pz - down + alpha * wy - beta * wx)

    fx = (row[3] * c + row[4] * s - 0.5 * (beta + new_beta) * row[5]
          + i.bias[0] + i.bias_heat[0] * warm + row[16])
    fy = (row[4] * c - row[3] * s + 0.5 * (alpha + new_alpha) * row[5]
          + i.bias[1] + i.bias_heat[1] * warm + row[17])
    quantum = p.quantum_m_s
    if quantum > 0.0:
        part_x, part_y = p.part_x_m_s + GRID_S * fx, p.part_y_m_s + GRID_S * fy
        counts_x = math.floor(part_x / quantum + 0.5)
        counts_y = math.floor(part_y / quantum + 0.5)
        p.part_x_m_s, p.part_y_m_s = part_x - counts_x * quantum, part_y - counts_y * quantum
        fx, fy = counts_x * quantum / GRID_S, counts_y * quantum / GRID_S
    if not p.stuck:
        p.force_x_m_s2, p.force_y_m_s2 = fx, fy

    mx = row[14] + (bias[3] + heat[3] * warm + still[3] * soak)
    my = row[15] + (bias[4] + heat[4] * warm + still[4] * soak)
    c, s = math.cos(p.angle_rad), math.sin(p.angle_rad)
    p.rate_x_rad_s = px * c + py * s + mx + i.spin_axis * p.angle_rate_rad_s
    p.rate_y_rad_s = py * c - px * s + my
    show(p, i, t, row)


def show(p: 'Platform', i: 'Instruments', t: 'Thermostat', row: Sequence[float]) -> None:
    """Update the measurements relative to the ship, and advance the instruments."""
    p.pick_off_rad = PICK_OFF_RAD * math.floor((row[6] - p.azimuth_rad) / PICK_OFF_RAD + 0.5)
    p.speed_m_s = row[7] * (1.0 + i.log_scale) + row[18]
    p.latitude_rad = row[8]
    p.satellite_rad = row[6] + row[19]
    i.soak *= i.soak_decay
    goal_k = t.cold_k if t.broken else 0.0
    t.away_k = goal_k + (t.away_k - goal_k) * t.decay


def take(c: 'Computer', p: 'Platform') -> None:
    """Read the instruments."""
    if not c.own:
        latitude = p.latitude_rad if math.isnan(c.manual_latitude_rad) else c.manual_latitude_rad
        if latitude != c.latitude_rad:
            set_latitude(c, latitude)
    c.ax = p.force_x_m_s2 - c.bias_x_m_s2
    c.ay = p.force_y_m_s2 - c.bias_y_m_s2
    known = not c.log_lost_s > LOG_MEMORY_S
    if c.speed_is_set:
        # Set by hand, or taken for nil.
        c.log_speed_m_s = c.set_speed_m_s
    elif c.log_ok:
        c.log_lost_s = 0.0
        # At berth the noise of the log would only shake the platform.
        c.log_speed_m_s = p.speed_m_s if abs(p.speed_m_s) > MOORED_M_S else 0.0
    else:
        # For a minute after its loss, keep the speed of the log.
        c.log_lost_s += GRID_S
        if c.log_lost_s > LOG_MEMORY_S:
            c.log_speed_m_s = 0.0
    psi = p.pick_off_rad
    c.old_vx, c.old_vy = c.vx, c.vy
    c.vx = c.log_speed_m_s * math.cos(psi)
    c.vy = c.log_speed_m_s * math.sin(psi)
    if known == (c.log_lost_s > LOG_MEMORY_S) or not c.started:
        # A change of the source of the velocity is not an acceleration.
        c.old_vx, c.old_vy = c.vx, c.vy
        c.started = True
    resolve(c, c.vx, c.vy)


def set_latitude(c: 'Computer', latitude_rad: float) -> None:
    """Set the latitude, and the Earth rates, radii and gravity there."""
    c.latitude_rad = latitude_rad
    c.cos, c.sin = math.cos(latitude_rad), math.sin(latitude_rad)
    c.earth_north, c.earth_up = EARTH_RATE_RAD_S * c.cos, EARTH_RATE_RAD_S * c.sin
    c.meridian_m, c.normal_m = radii(latitude_rad)
    c.gravity = gravity(latitude_rad)


def resolve(c: 'Computer', vx: float, vy: float) -> None:
    """Resolve a velocity in platform axes into north and east, and find its Coriolis rate."""
    cosine, sine = math.cos(c.azimuth_rad), math.sin(c.azimuth_rad)
    c.north_m_s, c.east_m_s = vx * cosine - vy * sine, vx * sine + vy * cosine
    c.transport_down = -c.east_m_s * c.sin / (c.cos * c.normal_m)
    c.coriolis = 2.0 * c.earth_up - c.transport_down


def coarse(c: 'Computer', tau_s: float) -> Rates:
    """Level fast and roughly: S (1)-(3)."""
    return (coarse_rate(c.ay, c.gravity, tau_s), coarse_rate(-c.ax, c.gravity, tau_s),
            -c.earth_up)


def hold(c: 'Computer') -> Rates:
    """Level without knowing the azimuth: S (7)."""
    integrate(c, c.hold_k1)
    c.ix += GRID_S * c.hold_ki * c.qy
    c.iy -= GRID_S * c.hold_ki * c.qx
    turn_x, turn_y = transport_without_azimuth(c)
    return (c.hold_k * c.qy + c.ix + turn_x, -c.hold_k * c.qx + c.iy + turn_y, -c.earth_up)


def transport_without_azimuth(c: 'Computer') -> tuple[float, float]:
    """Return the transport rates about x and y of the platform on a spherical Earth."""
    radius = math.sqrt(c.meridian_m * c.normal_m)
    return c.vy / radius, -c.vx / radius


def fine(c: 'Computer', p: 'Platform') -> Rates:
    """Level using all estimates, free in azimuth: S (12), (13)."""
    integrate(c, c.hold_k1)
    c.ix += GRID_S * c.hold_ki * c.qy
    c.iy -= GRID_S * c.hold_ki * c.qx
    ux, uy, uz = free(c, p)
    return ux + c.hold_k * c.qy, uy - c.hold_k * c.qx, uz


def free(c: 'Computer', p: 'Platform') -> Rates:
    """
    Hold the platform by the estimates and by what the gyros show, without accelerometers.

    References
    ----------
    The signals of the gyro vertical in S (12) and of the course gyro in S (20), as rates by their
    differences over a control step, S (21).

    """
    cosine, sine = math.cos(c.azimuth_rad), math.sin(c.azimuth_rad)
    north = c.earth_north + c.east_m_s / c.normal_m
    east = -c.north_m_s / c.meridian_m
    c.correction_rad_s = 0.0
    return (north * cosine + east * sine - c.drift_x_rad_s + c.ix - p.slip_x_rad_s,
            east * cosine - north * sine - c.drift_y_rad_s + c.iy - p.slip_y_rad_s,
            c.transport_down - c.earth_up - c.drift_z_rad_s - p.slip_z_rad_s)


def gyrocompass(c: 'Computer', p: 'Platform') -> Rates:
    """Level and seek the meridian: S (20)-(22)."""
    integrate(c, c.seek_k1)
    c.p += GRID_S * (c.qx - c.seek_k4 * c.p)
    ux, uy, uz = free(c, p)
    c.correction_rad_s = -c.seek_k3 / c.earth_north * c.p
    return ux + c.seek_k * c.qy, uy - c.seek_k * c.qx, uz + c.correction_rad_s


def schuler(c: 'Computer', p: 'Platform') -> Rates:
    """Level by the velocity integrated from the accelerometers alone."""
    # Commands the new velocity at once: with the old one the oscillation would grow.
    resolve(c, c.own_x, c.own_y)
    turning = c.coriolis
    x, y = c.own_x, c.own_y
    c.own_x = x + GRID_S * (c.ax - turning * y)
    c.own_y = y + GRID_S * (c.ay + turning * x)
    resolve(c, c.own_x, c.own_y)
    if c.own:
        set_latitude(c, c.latitude_rad + GRID_S * c.north_m_s / c.meridian_m)
    return free(c, p)


def integrate(c: 'Computer', damping_1_s: float) -> None:
    """Integrate the accelerometers against the velocity of the log."""
    turning = c.coriolis
    c.qx += (GRID_S * (c.ax - turning * c.vy - damping_1_s * c.qx) - (c.vx - c.old_vx))
    c.qy += (GRID_S * (c.ay + turning * c.vx - damping_1_s * c.qy) - (c.vy - c.old_vy))
