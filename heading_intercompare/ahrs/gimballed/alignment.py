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

"""The procedures of modes 1 to 6, from power-on to an aligned platform; see `machine`."""

from __future__ import annotations

from itertools import count
import math
from typing import Generator, Sequence

from heading_intercompare.ahrs.inertial.computer import Computer
from heading_intercompare.ahrs.inertial.loop import FINE, HOLD, Rates
from heading_intercompare.ahrs.inertial.platform import Platform
from heading_intercompare.ahrs.settings import Ahrs
from heading_intercompare.ahrs.ship.earth import RAD_PER_DEG_H, UG_M_S2
from heading_intercompare.ahrs.ship.seaway import GRID_S

from .calibration import (
    accelerometer_bias,
    azimuth_from_rates,
    course_drift,
    course_drift_sigma,
    fit_rotation,
    hann,
    RotationFit,
    WindowedMean,
)
from .claims import alignment_sigma, FreeAzimuth, satellite_sigma, slew_sigma
from .fixes import Fixes
from .machine import Machine, Procedure, SECOND, Steady, steps
from .modes import Mode, Validity
from .power_on import run_self_test, TEST_S
from .slew import slew

POST_LIMIT_S = 30.0
THERMOSTAT_LIMIT_S = 1800.0
COARSE_S, COARSE_LIMIT_S = 120.0, 600.0
COARSE_TAU_S, COARSE_TAU_AT_SEA_S = 10.0, 30.0
TILT_RATE_RAD_S = math.radians(5.0 / 3600.0)
SECTORS, SECTOR_STEPS = 36, 50
METER_TURN_RAD_S = math.radians(2.0)
BIAS_LIMIT_RAD_S = 1.0 * RAD_PER_DEG_H
FIT_LIMIT_RAD_S = 1.0 * RAD_PER_DEG_H
EARTH_LIMIT_RAD_S = 0.1 * RAD_PER_DEG_H
SERVO_RAD = math.radians(1.0)
POSITION_S = 120.0
FORCE_LIMIT_M_S2 = 2000.0 * UG_M_S2
READINGS, READING_S, SATELLITE_READING_S = 6, 90.0, 450.0
FINE_LIMIT_S = 3600.0
STRAIGHT_RAD = math.radians(5.0 / 3600.0)


def post(ahrs: Machine) -> Procedure:
    """Test the hardware, and wait for the test of the computer."""
    failed = yield from run_self_test(ahrs.platform, ahrs.instruments.thermostat)
    for part in failed:
        ahrs.fail(part)
    if failed:
        return Mode.FAULT
    for _ in range(steps(TEST_S), steps(POST_LIMIT_S)):
        if 'post' not in ahrs.failures:
            break
        yield None
    return ahrs.fail('post') if 'post' in ahrs.failures else Mode.THERMOSTAT_WAIT


def thermostat_wait(ahrs: Machine) -> Procedure:
    """Wait until the instruments are warm."""
    for _ in range(steps(THERMOSTAT_LIMIT_S)):
        if ahrs.instruments.thermostat.ready:
            return Mode.COARSE_LEVELLING
        if ahrs.forced:
            ahrs.flag('FORCED_ON')
            return Mode.COARSE_LEVELLING
        ahrs.platform.turn_meter(0.0, 0.0)
        yield None
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
        ahrs.platform.turn_meter(0.0, 0.0)
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
    pairs = count_pairs(ahrs.settings)
    for _ in range(2):
        window = _Window(computer, 2 * pairs * SECTORS * SECTOR_STEPS)
        fits = []
        for sense in (1.0, -1.0) * pairs:
            fit = yield from _revolution(ahrs, sense, window)
            if fit is None:
                ahrs.say('the rotation unit does not follow')
                return ahrs.fail('servo')
            fits.append(fit)
        bias_x, bias_y, rate_x, rate_y = (
            math.fsum(values) / len(fits) for values in list(zip(*fits))[:4])
        residual = max(fit.residual for fit in fits)
        if math.hypot(bias_x, bias_y) < BIAS_LIMIT_RAD_S and residual < FIT_LIMIT_RAD_S:
            computer.meter_x_rad_s, computer.meter_y_rad_s = bias_x, bias_y
            ahrs.soak, ahrs.calibrated_k = (
                ahrs.instruments.soak, ahrs.instruments.thermostat.away_k)
            ahrs.calibrated_deg_h = max(
                ahrs.errors.residual_xy_deg_h,
                math.hypot(*(fit.bias_sigma for fit in fits)) / len(fits) / RAD_PER_DEG_H)
            ahrs.say('course gyro calibrated')
            if ahrs.settings.start == 'mutual':
                # What the meter reads beyond the known motion is the drift of the gyro vertical.
                ahrs.azimuth_found = window.find_azimuth(ahrs, rate_x, rate_y)
            return Mode.AZIMUTH_ALIGNMENT
        ahrs.say(f'calibration of the course gyro rejected: residual '
                 f'{residual / RAD_PER_DEG_H:.2g} deg/h')
    ahrs.flag('NOT_CALIBRATED')
    ahrs.calibrated_deg_h = math.hypot(ahrs.errors.residual_xy_deg_h, ahrs.errors.turn_on_deg_h)
    return Mode.AZIMUTH_ALIGNMENT


def count_pairs(settings: Ahrs) -> int:
    """Return how often the meter turns forth and back: once, or for as long as it aligns."""
    if settings.start != 'mutual':
        return 1
    return max(1, round(settings.alignment_s * METER_TURN_RAD_S / (4.0 * math.pi)))


def _revolution(ahrs: Machine, sense: float,
                window: '_Window') -> Generator[Rates, None, RotationFit | None]:
    """
    Turn the meter once, and fit what it reads beyond the known motion of the platform.

    The swell is in that motion alone, so it is not in the fit. Returns None if the rotation unit
    does not follow.
    """
    computer, platform = ahrs.computer, ahrs.platform
    columns: tuple[list[float], ...] = ([], [], [], [])
    angle_rad = 0.0 if sense > 0.0 else 2.0 * math.pi
    for _ in range(SECTORS):
        sums = [0.0, 0.0, 0.0, 0.0]
        for _ in range(SECTOR_STEPS):
            angle_rad += sense * METER_TURN_RAD_S * GRID_S
            platform.turn_meter(angle_rad, sense * METER_TURN_RAD_S)
            rates = computer.hold()
            yield rates
            turn_x, turn_y = _motion(rates, platform)
            window.add(turn_x, turn_y)
            c, s = math.cos(platform.angle_rad), math.sin(platform.angle_rad)
            for i, value in enumerate((
                    c, s, platform.rate_x_rad_s - turn_x * c - turn_y * s,
                    platform.rate_y_rad_s + turn_x * s - turn_y * c)):
                sums[i] += value
        if abs(platform.angle_rad - angle_rad) > SERVO_RAD:
            return None
        for column, total in zip(columns, sums):
            column.append(total / SECTOR_STEPS)
    cosine, sine, rate_x, rate_y = columns
    return fit_rotation(cosine, sine, rate_x, rate_y, hann(SECTORS))


def _motion(rates: Rates, platform: Platform) -> tuple[float, float]:
    """Return the rates commanded, and those by which the platform has left the gyro vertical."""
    return rates[0] + platform.slip_x_rad_s, rates[1] + platform.slip_y_rad_s


class _Window:
    """The means over some control steps from which the azimuth follows: S (8), (9)."""

    def __init__(self, computer: Computer, n: int) -> None:
        self._computer = computer
        self._means = WindowedMean(n, 8)
        self._path_x = self._path_y = 0.0

    def add(self, rate_x: float, rate_y: float) -> None:
        """Add the known rates of the platform over the last step."""
        computer = self._computer
        turn_x, turn_y = computer.transport_without_azimuth()
        self._means.add(rate_x, rate_y, turn_x, turn_y,
                        computer.ax - computer.coriolis * computer.vy,
                        computer.ay + computer.coriolis * computer.vx, self._path_x, self._path_y)
        self._path_x += GRID_S * computer.vx
        self._path_y += GRID_S * computer.vy

    def mean(self) -> tuple[float, float]:
        """Return the means of the known rates."""
        rate_x, rate_y = self._means.mean()[:2]
        return rate_x, rate_y

    def find_azimuth(self, ahrs: Machine, more_x: float, more_y: float) -> bool:
        """
        Set the azimuth by the mean Earth rate, and the drifts of the gyro vertical.

        Parameters
        ----------
        ahrs
            The device.
        more_x, more_y
            Rates to add to the known ones: the drifts of the gyro vertical.

        Returns
        -------
        bool
            Whether the Earth rate has the right size; otherwise the azimuth stays unknown.

        """
        computer = self._computer
        rate_x, rate_y, turn_x, turn_y, ax, ay, mean_x, mean_y = self._means.mean()
        alpha, beta = -ay / computer.gravity, ax / computer.gravity
        earth_x = rate_x + more_x - turn_x - beta * computer.earth_up
        earth_y = rate_y + more_y - turn_y + alpha * computer.earth_up
        miss = math.hypot(earth_x, earth_y) - computer.earth_north
        if abs(miss) > EARTH_LIMIT_RAD_S:
            ahrs.say(f'alignment rejected: Earth rate off by {miss / RAD_PER_DEG_H:.2g} deg/h')
            return False
        computer.drift_x_rad_s, computer.drift_y_rad_s = more_x, more_y
        middle_rad = azimuth_from_rates(earth_x, earth_y)
        # North turns under a ship that sails east: the platform has turned since the mean.
        east_m = ((self._path_x - mean_x) * math.sin(middle_rad)
                  + (self._path_y - mean_y) * math.cos(middle_rad))
        computer.azimuth_rad = (middle_rad
                                + east_m * computer.sin / (computer.cos * computer.normal_m))
        return True


def azimuth_alignment(ahrs: Machine) -> Procedure:
    """Find the azimuth from the Earth rate, then slew to the meridian: S (7)-(11)."""
    computer, platform = ahrs.computer, ahrs.platform
    n = steps(ahrs.settings.alignment_s)
    for _ in range(2):
        if ahrs.azimuth_found:
            break
        window, meter = _Window(computer, n), WindowedMean(n, 2)
        for _ in range(n):
            platform.turn_meter(0.0, 0.0)
            rates = computer.hold()
            yield rates
            window.add(*_motion(rates, platform))
            meter.add(platform.rate_x_rad_s, platform.rate_y_rad_s)
        (mean_x, mean_y), (rate_x, rate_y) = window.mean(), meter.mean()
        ahrs.azimuth_found = window.find_azimuth(
            ahrs, rate_x - computer.meter_x_rad_s - mean_x,
            rate_y - computer.meter_y_rad_s - mean_y)
    if not ahrs.azimuth_found:
        return ahrs.fail('alignment')
    ahrs.azimuth_found = False
    computer.ix = computer.iy = 0.0
    ahrs.turned_rad = -computer.azimuth_rad
    if not (yield from slew(computer, platform, ahrs.turned_rad)):
        ahrs.say('the platform does not turn as asked')
        return ahrs.fail('servo')
    computer.azimuth_rad = 0.0
    return Mode.FINE_LEVELLING


def fine_levelling(ahrs: Machine) -> Procedure:
    """Level using all estimates, and make the calibrations that are possible: S (12)-(19)."""
    computer = ahrs.computer
    computer.enter_hold()
    ahrs.validity = Validity.PROVISIONAL
    ahrs.sigma_rad = math.hypot(alignment_sigma(ahrs.residual_deg_h, computer.latitude_rad),
                                slew_sigma(ahrs.errors, ahrs.turned_rad))
    free = FreeAzimuth(ahrs.errors, ahrs.sigma_rad)
    ahrs.fixes = fixes = Fixes(computer, ahrs.platform, ahrs.say)
    calibrations, n_steps = _calibrate(ahrs), 0
    while True:
        try:
            rates = next(calibrations)
        except StopIteration as end:
            arrived = end.value
            break
        yield rates
        fixes.step()
        ahrs.claim(free, GRID_S)
        n_steps += 1
    if not arrived:
        ahrs.say('the platform does not turn as asked')
        return ahrs.fail('servo')
    left = steps(min(ahrs.settings.fine_s, FINE_LIMIT_S)) - n_steps
    while left > 0:
        n = min(left, SECOND)
        yield from hold_azimuth(ahrs, FINE, n, fixes)
        ahrs.claim(free, n * GRID_S)
        left -= n
    if ahrs.settings.fine_s > FINE_LIMIT_S:
        ahrs.flag('FINE_LIMIT')
        ahrs.say(f'fine levelling ended at its limit of {FINE_LIMIT_S:g} s')
    return ahrs.operation


def hold_azimuth(ahrs: Machine, law: int, n: int,
                 fixes: Fixes) -> Generator[Steady, None, None]:
    """Apply a law that leaves the azimuth free, with satellite fixes if there are any."""
    if not ahrs.computer.gps_ok:
        yield Steady(law, n)
        fixes.miss(n)
        return
    for _ in range(n):
        yield Steady(law, 1)
        fixes.step()


def _calibrate(ahrs: Machine) -> Generator[Rates, None, bool]:
    """Make the calibrations that are possible; return whether every slew has arrived."""
    computer, settings = ahrs.computer, ahrs.settings
    if settings.accelerometer_calibration == 'two_position' and computer.moored:
        if not (yield from _two_positions(ahrs)):
            return False
    elif settings.accelerometer_calibration != 'off':
        yield from _one_position(ahrs)
    if computer.moored or computer.gps_ok:
        yield from _course_gyro_drift(ahrs)
    return True


def _two_positions(ahrs: Machine) -> Generator[Rates, None, bool]:
    """
    Find the accelerometer biases: the horizontal biases from two positions, half a turn apart.

    Gravity is known, so one position shows the bias of the vertical one: S (16)-(19). A ship that
    moves ends it. Returns whether the slews have arrived.
    """
    computer, platform = ahrs.computer, ahrs.platform
    start_rad, n, still = computer.azimuth_rad, steps(POSITION_S), True
    means: list[Sequence[float]] = []
    read_z: list[float] = []
    for turn_rad in (math.pi, -math.pi):
        window = WindowedMean(n, 2)
        for _ in range(n):
            yield computer.free()
            still = still and computer.moored
            if not still:
                break
            window.add(computer.ax, computer.ay)
            read_z.append(platform.force_z_m_s2 + computer.gravity)
        if not still and not means:
            break
        means.append(window.mean() if still else (0.0, 0.0))
        if not (yield from slew(computer, platform, turn_rad)):
            return False
    computer.azimuth_rad = start_rad
    if not still:
        ahrs.say(f'calibration of the accelerometers dropped: {_why_not_moored(computer)}')
        return True
    bias_x, bias_y = (0.5 * (start_mean + turned_mean) for start_mean, turned_mean in zip(*means))
    bias_z = 0.5 * (accelerometer_bias(read_z[:n], GRID_S)
                    + accelerometer_bias(read_z[n:], GRID_S))
    if math.hypot(bias_x, bias_y) < FORCE_LIMIT_M_S2 and abs(bias_z) < FORCE_LIMIT_M_S2:
        computer.bias_x_m_s2 += bias_x
        computer.bias_y_m_s2 += bias_y
        computer.bias_z_m_s2 = bias_z
        ahrs.say('accelerometers calibrated in two positions')
    else:
        ahrs.say('calibration of the accelerometers rejected')
    return True


def _one_position(ahrs: Machine) -> Generator[Rates, None, None]:
    """
    Read the accelerometers on the levelled platform: S (16)-(19).

    The horizontal ones show a change but no bias. The vertical one shows its bias, which alongside
    is taken over.
    """
    computer, read = ahrs.computer, []
    still = computer.moored
    for _ in range(steps(POSITION_S)):
        yield computer.fine()
        still = still and computer.moored
        read.append((computer.ax, computer.ay, ahrs.platform.force_z_m_s2 + computer.gravity))
    change_x, change_y, bias_z = (accelerometer_bias(column, GRID_S) for column in zip(*read))
    ahrs.say('accelerometers read in one position: change '
             f'{math.hypot(change_x, change_y) / UG_M_S2:.0f} ug')
    if still and abs(bias_z) < FORCE_LIMIT_M_S2:
        computer.bias_z_m_s2 = bias_z


def _why_not_moored(computer: Computer) -> str:
    return 'no speed' if computer.no_speed else 'the ship moves'


def _course_gyro_drift(ahrs: Machine) -> Generator[Rates, None, None]:
    """Find the drift of the course gyro from readings of a known heading: S (15)."""
    computer, platform, moored = ahrs.computer, ahrs.platform, ahrs.computer.moored
    reading_s = READING_S if moored else SATELLITE_READING_S
    readings: list[float] = []
    for _ in range(READINGS):
        window = WindowedMean(steps(reading_s), 1)
        for _ in range(steps(reading_s)):
            yield computer.fine()
            if not (computer.moored if moored else computer.gps_ok):
                ahrs.say('drift of the course gyro kept: '
                         + (_why_not_moored(computer) if moored else 'satellite heading lost'))
                return
            window.add(platform.pick_off_rad - (0.0 if moored else platform.satellite_rad))
        readings += window.mean()
    method, known_rad = ahrs.settings.drift_fit, satellite_sigma(ahrs.errors, reading_s)
    drift, residual = course_drift(readings, reading_s, method)
    if residual > STRAIGHT_RAD + (0.0 if moored else 3.0 * known_rad):
        ahrs.say('drift of the course gyro kept: its readings are not on a straight line')
    elif moored:
        computer.drift_z_rad_s -= drift
        ahrs.calibrate_course(ahrs.errors.residual_z_deg_h)
        ahrs.say('drift of the course gyro calibrated')
    else:
        # The satellite heading is noisy: it counts as far as it knows more than was known before.
        before = ahrs.course_deg_h * RAD_PER_DEG_H
        fit = course_drift_sigma(known_rad, reading_s, READINGS, method)
        share = before**2 / (before**2 + fit**2) if fit else 1.0
        computer.drift_z_rad_s -= share * drift
        ahrs.calibrate_course(max(ahrs.errors.residual_z_deg_h,
                                  math.sqrt(1.0 - share) * ahrs.course_deg_h))
        ahrs.say('drift of the course gyro calibrated by satellite heading, to '
                 f'{ahrs.course_deg_h:.2g} deg/h')


PROCEDURES = {
    Mode.POST: post,
    Mode.THERMOSTAT_WAIT: thermostat_wait,
    Mode.COARSE_LEVELLING: coarse_levelling,
    Mode.GYRO_CALIBRATION: gyro_calibration,
    Mode.AZIMUTH_ALIGNMENT: azimuth_alignment,
    Mode.FINE_LEVELLING: fine_levelling,
}
"""Modes 1 to 6 in the order of a cold start."""
