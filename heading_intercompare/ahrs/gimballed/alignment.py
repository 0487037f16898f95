# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""
The procedures of modes 1 to 6, from power-on to an aligned platform.

A procedure is a generator. It yields the rates to command over the next control step, or a law to
apply over several, or None while the platform is caged, and returns the mode that follows. When it
resumes after a yield, the computer has taken the measurements of those steps.
"""

from __future__ import annotations

from itertools import count
import math
from typing import Generator, NamedTuple, Protocol

from heading_intercompare.ahrs.inertial.computer import Computer
from heading_intercompare.ahrs.inertial.instruments import Instruments
from heading_intercompare.ahrs.inertial.loop import FINE, HOLD
from heading_intercompare.ahrs.inertial.platform import Platform
from heading_intercompare.ahrs.settings import Ahrs, Errors
from heading_intercompare.ahrs.ship.earth import RAD_PER_DEG_H, UG_M_S2
from heading_intercompare.ahrs.ship.seaway import GRID_S

from .calibration import (
    accelerometer_bias,
    azimuth_from_rates,
    course_drift,
    course_drift_sigma,
    fit_rotation,
    hann,
    WindowedMean,
)
from .claims import alignment_sigma, satellite_sigma
from .modes import Mode, Validity

__all__ = ['Machine', 'PROCEDURES', 'Procedure', 'slew', 'Steady', 'steps']


class Steady(NamedTuple):
    """A law of `loop`, and the number of control steps over which nothing else is to be done."""

    law: int
    steps: int


Procedure = Generator[tuple[float, float, float] | Steady | None, None, Mode]

POST_S, POST_LIMIT_S = 10.0, 30.0
THERMOSTAT_LIMIT_S = 1800.0
COARSE_S, COARSE_LIMIT_S = 120.0, 600.0
COARSE_TAU_S, COARSE_TAU_AT_SEA_S = 10.0, 30.0
TILT_RATE_RAD_S = math.radians(5.0 / 3600.0)
SECTORS, SECTOR_STEPS = 36, 50
METER_TURN_RAD_S = math.radians(2.0)
BIAS_LIMIT_RAD_S = 1.0 * RAD_PER_DEG_H
FIT_LIMIT_RAD_S = 1.0 * RAD_PER_DEG_H
EARTH_LIMIT_RAD_S = 0.1 * RAD_PER_DEG_H
SLEW_RAD_S = math.radians(10.0)
POSITION_S = 120.0
FORCE_LIMIT_M_S2 = 2000.0 * UG_M_S2
READINGS, READING_S, SATELLITE_READING_S = 6, 90.0, 450.0
FINE_LIMIT_S = 3600.0
STRAIGHT_RAD = math.radians(5.0 / 3600.0)


class Machine(Protocol):
    """The part of the AHRS that a procedure may read and change."""

    settings: Ahrs
    errors: Errors
    instruments: Instruments
    platform: Platform
    computer: Computer
    failures: set[str]
    forced: bool
    operation: Mode
    validity: Validity
    sigma_rad: float
    soak: float
    calibrated_deg_h: float
    course_deg_h: float
    calibrated_k: float

    @property
    def residual_deg_h(self) -> float:
        """Levelling gyro drift left by the calibration, and by the temperature since."""

    def say(self, message: str) -> None:
        """Report an event."""

    def flag(self, name: str) -> None:
        """Continue in a degraded state, for the reason named."""

    def fail(self, cause: str) -> Mode:
        """Report a fault and return the mode FAULT."""


def steps(span_s: float) -> int:
    """Return the number of control steps in a span, seconds."""
    return round(span_s / GRID_S)


def post(ahrs: Machine) -> Procedure:
    """Wait for the self-test."""
    for step in count(1):
        yield None
        if step >= steps(POST_S) and 'post' not in ahrs.failures:
            return Mode.THERMOSTAT_WAIT
        if step >= steps(POST_LIMIT_S):
            return ahrs.fail('post')


def thermostat_wait(ahrs: Machine) -> Procedure:
    """Wait until the instruments are warm."""
    for step in count(1):
        if ahrs.instruments.thermostat.ready:
            return Mode.COARSE_LEVELLING
        if ahrs.forced:
            ahrs.flag('FORCED_ON')
            return Mode.COARSE_LEVELLING
        yield None
        if step >= steps(THERMOSTAT_LIMIT_S):
            return ahrs.fail('thermostat')


def coarse_levelling(ahrs: Machine) -> Procedure:
    """Level fast, until the filtered tilt stops changing: S (1)-(3)."""
    computer = ahrs.computer
    tau_s = COARSE_TAU_S if computer.moored else COARSE_TAU_AT_SEA_S
    share = GRID_S / tau_s
    commands = []
    first_x = second_x = computer.ay / computer.gravity
    first_y = second_y = computer.ax / computer.gravity
    for step in count(1):
        rates = computer.coarse(tau_s)
        commands.append(rates)
        yield rates
        first_x += share * (computer.ay / computer.gravity - first_x)
        first_y += share * (computer.ax / computer.gravity - first_y)
        second_x += share * (first_x - second_x)
        second_y += share * (first_y - second_y)
        if step >= steps(COARSE_S) and max(abs(first_x - second_x), abs(
                first_y - second_y)) < TILT_RATE_RAD_S * tau_s:
            break
        if step >= steps(COARSE_LIMIT_S):
            return ahrs.fail('levelling')
    late = commands[slice(len(commands) // 2, None)]
    turn_x, turn_y = computer.transport_without_azimuth()
    computer.reset_loops()
    computer.ix = sum(rates[0] for rates in late) / len(late) - turn_x
    computer.iy = sum(rates[1] for rates in late) / len(late) - turn_y
    return Mode.GYRO_CALIBRATION


def gyro_calibration(ahrs: Machine) -> Procedure:
    """Level, then turn the course gyro both ways to find its biases as a meter: S (4)-(6)."""
    computer = ahrs.computer
    computer.enter_hold()
    yield Steady(HOLD, steps(ahrs.settings.hold_s))
    for _ in range(2):
        forth = yield from _revolution(ahrs, 1.0)
        back = yield from _revolution(ahrs, -1.0)
        bias_x = 0.5 * (forth.bias_x + back.bias_x)
        bias_y = 0.5 * (forth.bias_y + back.bias_y)
        residual = max(forth.residual, back.residual)
        if math.hypot(bias_x, bias_y) < BIAS_LIMIT_RAD_S and residual < FIT_LIMIT_RAD_S:
            computer.meter_x_rad_s, computer.meter_y_rad_s = bias_x, bias_y
            ahrs.soak, ahrs.calibrated_k = (
                ahrs.instruments.soak, ahrs.instruments.thermostat.away_k)
            ahrs.calibrated_deg_h = max(
                ahrs.errors.residual_xy_deg_h,
                0.5 * math.hypot(forth.bias_sigma, back.bias_sigma) / RAD_PER_DEG_H)
            ahrs.say('course gyro calibrated')
            return Mode.AZIMUTH_ALIGNMENT
        ahrs.say(f'calibration of the course gyro rejected: residual '
                 f'{residual / RAD_PER_DEG_H:.2g} deg/h')
    ahrs.flag('NOT_CALIBRATED')
    ahrs.calibrated_deg_h = math.hypot(ahrs.errors.residual_xy_deg_h, ahrs.errors.turn_on_deg_h)
    return Mode.AZIMUTH_ALIGNMENT


def _revolution(ahrs: Machine, sense: float):
    """
    Turn the meter once, and fit what it reads beyond the rates that the platform was commanded.

    The swell moves the platform by those commands alone, so it is not in the fit.
    """
    computer, platform = ahrs.computer, ahrs.platform
    columns = [[], [], [], []]
    angle_rad = 0.0 if sense > 0.0 else 2.0 * math.pi
    for _ in range(SECTORS):
        sums = [0.0, 0.0, 0.0, 0.0]
        for _ in range(SECTOR_STEPS):
            angle_rad += sense * METER_TURN_RAD_S * GRID_S
            platform.turn_meter(angle_rad, sense * METER_TURN_RAD_S)
            turn_x, turn_y, _ = rates = computer.hold()
            yield rates
            c, s = math.cos(platform.angle_rad), math.sin(platform.angle_rad)
            for i, value in enumerate((
                    c, s, platform.rate_x_rad_s - turn_x * c - turn_y * s,
                    platform.rate_y_rad_s + turn_x * s - turn_y * c)):
                sums[i] += value
        for column, total in zip(columns, sums):
            column.append(total / SECTOR_STEPS)
    return fit_rotation(*columns, weights=hann(SECTORS))


def azimuth_alignment(ahrs: Machine) -> Procedure:
    """Find the azimuth from the Earth rate, then slew to the meridian: S (7)-(11)."""
    computer, platform = ahrs.computer, ahrs.platform
    n = steps(ahrs.settings.alignment_s)
    for _ in range(2):
        window = WindowedMean(n, 10)
        path_x = path_y = 0.0
        for _ in range(n):
            platform.turn_meter(0.0, 0.0)
            rates = computer.hold()
            yield rates
            turn_x, turn_y = computer.transport_without_azimuth()
            window.add(platform.rate_x_rad_s, platform.rate_y_rad_s, turn_x, turn_y, rates[0],
                       rates[1], computer.ax - computer.coriolis * computer.vy,
                       computer.ay + computer.coriolis * computer.vx, path_x, path_y)
            path_x += GRID_S * computer.vx
            path_y += GRID_S * computer.vy
        rate_x, rate_y, turn_x, turn_y, ux, uy, ax, ay, mean_x, mean_y = window.mean()
        rate_x -= computer.meter_x_rad_s
        rate_y -= computer.meter_y_rad_s
        alpha, beta = -ay / computer.gravity, ax / computer.gravity
        earth_x = rate_x - turn_x - beta * computer.earth_up
        earth_y = rate_y - turn_y + alpha * computer.earth_up
        miss = math.hypot(earth_x, earth_y) - computer.earth_north
        if abs(miss) <= EARTH_LIMIT_RAD_S:
            break
        ahrs.say(f'alignment rejected: Earth rate off by {miss / RAD_PER_DEG_H:.2g} deg/h')
    else:
        return ahrs.fail('alignment')
    computer.drift_x_rad_s, computer.drift_y_rad_s = rate_x - ux, rate_y - uy
    middle_rad = azimuth_from_rates(earth_x, earth_y)
    # North turns under a ship that sails east: the platform has turned since the mean was true.
    east_m = ((path_x - mean_x) * math.sin(middle_rad) + (path_y - mean_y) * math.cos(middle_rad))
    computer.azimuth_rad = middle_rad + east_m * computer.sin / (computer.cos * computer.normal_m)
    computer.ix = computer.iy = 0.0
    yield from slew(ahrs, -computer.azimuth_rad)
    computer.azimuth_rad = 0.0
    return Mode.FINE_LEVELLING


def slew(ahrs: Machine, angle_rad: float) -> Generator[tuple[float, float, float], None, None]:
    """Turn the platform in azimuth by an angle: S (10), (11)."""
    computer = ahrs.computer
    sense, left = math.copysign(1.0, angle_rad), abs(angle_rad)
    while left > 0.0:
        part = sense * min(left, SLEW_RAD_S * GRID_S)
        computer.azimuth_rad += 0.5 * part
        ux, uy, uz = computer.free()
        computer.azimuth_rad += 0.5 * part
        computer.turn_axes(part)
        yield ux, uy, uz + part / GRID_S
        left = 0.0 if left <= SLEW_RAD_S * GRID_S else left - SLEW_RAD_S * GRID_S


def fine_levelling(ahrs: Machine) -> Procedure:
    """Level using all estimates, and make the calibrations that are possible: S (12)-(19)."""
    computer, settings = ahrs.computer, ahrs.settings
    computer.enter_hold()
    ahrs.validity = Validity.PROVISIONAL
    ahrs.sigma_rad = alignment_sigma(ahrs.residual_deg_h, computer.latitude_rad)
    left = steps(min(settings.fine_s, FINE_LIMIT_S))
    if settings.accelerometer_calibration == 'two_position' and computer.moored:
        left -= yield from _two_positions(ahrs)
    elif settings.accelerometer_calibration != 'off':
        left -= yield from _one_position(ahrs)
    if computer.moored or computer.gps_ok:
        left -= yield from _course_gyro_drift(ahrs)
    if left > 0:
        yield Steady(FINE, left)
    if settings.fine_s > FINE_LIMIT_S:
        ahrs.flag('FINE_LIMIT')
        ahrs.say(f'fine levelling ended at its limit of {FINE_LIMIT_S:g} s')
    return ahrs.operation


def _two_positions(ahrs: Machine) -> Generator[tuple[float, float, float], None, int]:
    """Find the accelerometer biases from two positions of the platform, half a turn apart."""
    computer = ahrs.computer
    start_rad, n, taken = computer.azimuth_rad, steps(POSITION_S), 0
    means = []
    for turn_rad in (math.pi, -math.pi):
        window = WindowedMean(n, 2)
        for _ in range(n):
            yield computer.free()
            window.add(computer.ax, computer.ay)
        means.append(window.mean())
        for rates in slew(ahrs, turn_rad):
            taken += 1
            yield rates
    computer.azimuth_rad = start_rad
    bias_x, bias_y = (0.5 * (one + other) for one, other in zip(*means))
    if math.hypot(bias_x, bias_y) < FORCE_LIMIT_M_S2:
        computer.bias_x_m_s2 += bias_x
        computer.bias_y_m_s2 += bias_y
        ahrs.say('accelerometers calibrated in two positions')
    else:
        ahrs.say('calibration of the accelerometers rejected')
    return 2 * n + taken


def _one_position(ahrs: Machine) -> Generator[tuple[float, float, float], None, int]:
    """Read the accelerometers on the levelled platform, which shows a change but no bias."""
    computer, n = ahrs.computer, steps(POSITION_S)
    read_x, read_y = [], []
    for _ in range(n):
        yield computer.fine()
        read_x.append(computer.ax)
        read_y.append(computer.ay)
    change_ug = math.hypot(accelerometer_bias(read_x, GRID_S),
                           accelerometer_bias(read_y, GRID_S)) / UG_M_S2
    ahrs.say(f'accelerometers read in one position: change {change_ug:.0f} ug')
    return n


def _course_gyro_drift(ahrs: Machine) -> Generator[tuple[float, float, float], None, int]:
    """Find the drift of the course gyro from readings of a known heading: S (15)."""
    computer, platform, moored = ahrs.computer, ahrs.platform, ahrs.computer.moored
    reading_s = READING_S if moored else SATELLITE_READING_S
    readings, taken = [], 0
    for _ in range(READINGS):
        window = WindowedMean(steps(reading_s), 1)
        for _ in range(steps(reading_s)):
            yield computer.fine()
            taken += 1
            if not (computer.moored if moored else computer.gps_ok):
                ahrs.say('drift of the course gyro kept: '
                         + ('the ship moves' if moored else 'satellite heading lost'))
                return taken
            window.add(platform.pick_off_rad - (0.0 if moored else platform.satellite_rad))
        readings += window.mean()
    method, known_rad = ahrs.settings.drift_fit, satellite_sigma(ahrs.errors, reading_s)
    drift, residual = course_drift(readings, reading_s, method)
    if residual > STRAIGHT_RAD + (0.0 if moored else 3.0 * known_rad):
        ahrs.say('drift of the course gyro kept: its readings are not on a straight line')
    elif moored:
        computer.drift_z_rad_s -= drift
        ahrs.course_deg_h = ahrs.errors.residual_z_deg_h
        ahrs.say('drift of the course gyro calibrated')
    else:
        # The satellite heading is noisy: it counts as far as it knows more than was known before.
        before = ahrs.course_deg_h * RAD_PER_DEG_H
        fit = course_drift_sigma(known_rad, reading_s, READINGS, method)
        share = before**2 / (before**2 + fit**2) if fit else 1.0
        computer.drift_z_rad_s -= share * drift
        ahrs.course_deg_h = max(ahrs.errors.residual_z_deg_h,
                                math.sqrt(1.0 - share) * ahrs.course_deg_h)
        ahrs.say('drift of the course gyro calibrated by satellite heading, to '
                 f'{ahrs.course_deg_h:.2g} deg/h')
    return taken


PROCEDURES = {
    Mode.POST: post,
    Mode.THERMOSTAT_WAIT: thermostat_wait,
    Mode.COARSE_LEVELLING: coarse_levelling,
    Mode.GYRO_CALIBRATION: gyro_calibration,
    Mode.AZIMUTH_ALIGNMENT: azimuth_alignment,
    Mode.FINE_LEVELLING: fine_levelling,
}
"""Modes 1 to 6 in the order of a cold start."""
