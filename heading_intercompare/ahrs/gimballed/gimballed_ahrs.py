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

"""The gimballed AHRS of S: platform, computer and mode machine, run in blocks of ten seconds."""

from __future__ import annotations

from bisect import insort
from dataclasses import dataclass
from functools import cache
import math
from typing import Sequence

import numpy as np

from heading_intercompare.ahrs.inertial import loop
from heading_intercompare.ahrs.inertial.compiled_loop import compile_for
from heading_intercompare.ahrs.inertial.computer import Computer
from heading_intercompare.ahrs.inertial.control_laws import (
    compute_gyrocompass_gains,
    gyrocompass_azimuth,
    torque,
)
from heading_intercompare.ahrs.inertial.instruments import Instruments, Thermostat
from heading_intercompare.ahrs.inertial.platform import Platform, rows_of
from heading_intercompare.ahrs.plans import Event, parse_events
from heading_intercompare.ahrs.random_noise import open_stream
from heading_intercompare.ahrs.sensor_presets import ModelErrors
from heading_intercompare.ahrs.settings import Ahrs
from heading_intercompare.ahrs.ship.earth import RAD_PER_DEG_H, UG_M_S2
from heading_intercompare.ahrs.ship.seaway import BLOCK_STEPS, GRID_S
from heading_intercompare.ahrs.ship.ship_motion import ShipBlock, ShipTruth
from heading_intercompare.core.records import Reals

from .claims import alignment_sigma, FreeAzimuth
from .condition import progress, self_tests
from .fixes import Fixes
from .machine import FAILURES, find_obstacle_to_failure, Procedure, Steady
from .modes import AhrsStatus, Mode, Validity
from .operation import POLE_RAD, PROCEDURES, TOO_NEAR_THE_POLE
from .power_on import Excitation

TRACK_STEPS = 100
UNWATCHED = {'post', 'thermostat', 'servo'}
THERMOSTAT_K = 2.0
RIVALS = ({'gyrocompass', 'gyro_azimuth'}, {'log_lost', 'log_found'}, {'gps_lost', 'gps_found'})
AVAILABLE = {'log_lost': ('log', False), 'log_found': ('log', True),
             'gps_lost': ('satellite heading', False), 'gps_found': ('satellite heading', True)}


@dataclass(frozen=True, slots=True)
class Track:
    """
    The states of the AHRS over one block.

    Attributes
    ----------
    start_s
        Start of the block, seconds.
    azimuth_rad, error_rad, alpha_rad, beta_rad : ndarray, shape (101,)
        True azimuth of the platform, assumed minus true azimuth in (-pi, pi], and tilts, on the
        grid of the control loop, both ends included.
    flexure_rad, sigma_rad : ndarray, shape (100,)
        Error of the mounting, and claimed standard deviation of the heading, in each step.
    mode, validity : ndarray of int8, shape (100,)
        Mode and validity in each step.
    statuses
        Status reports of the block.

    """

    start_s: float
    azimuth_rad: Reals
    error_rad: Reals
    alpha_rad: Reals
    beta_rad: Reals
    flexure_rad: Reals
    sigma_rad: Reals
    mode: np.ndarray
    validity: np.ndarray
    statuses: tuple[AhrsStatus, ...]


class GimballedAhrs:
    """
    The AHRS, simulated block by block.

    Parameters
    ----------
    settings
        Set-up of the AHRS.
    errors
        Errors of its instruments; see `sensor_presets.errors_of`.
    ship
        The ship that carries it.
    seed
        Seed of the simulation.
    role
        'ts' or 'rs'; names the random numbers.
    fast
        Compile the control loop if numba is installed; it gives the same bits.

    """

    def __init__(self, settings: Ahrs, errors: ModelErrors, ship: ShipTruth, seed: int,
                 role: str, fast: bool = False) -> None:
        self.settings, self.errors = settings, errors
        self._ship = ship
        self.instruments = Instruments(errors, settings, seed, role)
        self.platform = Platform(self.instruments, errors.accelerometer_step_m_s
                                 if settings.noise else 0.0)
        self.computer = Computer(settings, self.platform)
        self.failures: set[str] = set()
        self.forced = False
        self.operation = Mode[settings.operation.upper()]
        self.validity = Validity.NONE
        self.sigma_rad = math.nan
        self.soak = self.instruments.soak
        self.calibrated_deg_h = errors.residual_xy_deg_h
        self.course_deg_h = (errors.residual_z_deg_h if settings.initial_state == 'aligned'
                             else errors.turn_on_deg_h)
        self.calibrated_k = self.course_k = self.course_soak = self.turned_rad = 0.0
        self.azimuth_found = False
        self.fixes: Fixes | None = None
        self._last_m_s = 0.0
        self._flags: set[str] = set()
        self._faults: list[str] = []
        self._messages: list[str] = []
        self._events = list(parse_events(settings.events))
        self._place = open_stream(seed, f'{role}.ahrs.start')
        self._step = self._entered = 0
        # Inputs and mounting errors of the minute.
        self._rows = self._flexure_rad = np.empty(0)
        self._steady = Steady(loop.HOLD, 0)
        self.computer.prepare(float(ship.block(0).latitude_rad[0]))
        self._compiled = compile_for(self.platform, self.computer) if fast else None
        self._set_up()

    def _set_up(self) -> None:
        """Put the platform into its initial state."""
        state = self.settings.initial_state
        if state == 'aligned':
            self._align()
            self._enter(self.operation)
            return
        self._tumble(self.settings.azimuth_deg)
        self._enter(Mode.POST if state == 'cold' else Mode.COARSE_LEVELLING)

    def _tumble(self, azimuth_deg: float | None) -> None:
        """Tilt the platform in a random direction and turn it, unless the azimuth is given."""
        direction, azimuth = (2.0 * math.pi * self._place.random() for _ in range(2))
        if not self.settings.noise:
            direction, azimuth = 0.0, 0.0
        tilt = math.radians(self.settings.tilt_deg)
        self.platform.alpha_rad = tilt * math.cos(direction)
        self.platform.beta_rad = tilt * math.sin(direction)
        self.platform.azimuth_rad = (_wrap(azimuth) if azimuth_deg is None
                                     else math.radians(azimuth_deg))

    def _align(self) -> None:
        """Start as a gyrocompass that has settled, with the drifts that a calibration leaves."""
        parts, computer, platform = self.instruments, self.computer, self.platform
        drift_x, drift_y, drift_z = (bias + soak * parts.soak for bias, soak in zip(
            parts.gyro_bias[:3], parts.gyro_soak[:3]))
        sigma_1_s = self.settings.sigma_1_s
        if self.settings.azimuth_deg is None:
            gains = compute_gyrocompass_gains(sigma_1_s, computer.gravity)
            platform.azimuth_rad = gyrocompass_azimuth(
                drift_x, drift_y, drift_z, parts.bias[1], sigma_1_s, computer.latitude_rad)
            computer.p = drift_z * computer.earth_north / gains.k3_rad_m_s2
            computer.qx = gains.k4_1_s * computer.p
            computer.qy = -drift_x / gains.k_rad_m
            platform.alpha_rad = (parts.bias[1] - gains.k1_1_s * computer.qy) / computer.gravity
            platform.beta_rad = (gains.k1_1_s * computer.qx - parts.bias[0]) / computer.gravity
            self.validity = Validity.VALID
        else:
            platform.azimuth_rad = math.radians(self.settings.azimuth_deg)
            platform.alpha_rad = parts.bias[1] / computer.gravity
            platform.beta_rad = -parts.bias[0] / computer.gravity
        self.sigma_rad = math.hypot(alignment_sigma(self.residual_deg_h, computer.latitude_rad),
                                    math.radians(self.settings.azimuth_deg or 0.0))

    @property
    def residual_deg_h(self) -> float:
        """Levelling gyro drift left by the calibration, and by the temperature since."""
        change_k = abs(self.instruments.thermostat.away_k - self.calibrated_k)
        return math.hypot(self.calibrated_deg_h, self.errors.temperature_deg_h_k * max(
            0.0, change_k - Thermostat.READY_K))

    def command(self, kind: str, t_s: float) -> float:
        """
        Make an event happen at a time, or at the next block if that is past; return when.

        Raises
        ------
        ValueError
            If the event is due within the next block, and nothing would happen: the reason.

        """
        event = Event(max(t_s, self.now_s), kind)
        if event.t_s < self.now_s + TRACK_STEPS * GRID_S and (why := self._obstacle(
                kind, [queued.kind for queued in self._events if queued.t_s <= event.t_s])):
            raise ValueError(f'{kind} refused: {why}')
        insort(self._events, event, key=lambda queued: queued.t_s)
        return event.t_s

    @property
    def unknown_m_s(self) -> float:
        """Speed that a lost log showed last; 0 with a log."""
        return self._last_m_s if self.computer.no_speed else 0.0

    def claim(self, free: FreeAzimuth, span_s: float, *, own_velocity: bool = False) -> None:
        """
        Claim what is left of the azimuth after a span in which nothing corrected it.

        North turns under a ship that sails east. Without a log that is not known, and with
        `own_velocity` only as far as the levels are.
        """
        parts, computer = self.instruments, self.computer
        unknown_rad_s = (self.residual_deg_h * RAD_PER_DEG_H if own_velocity
                         else self.unknown_m_s / computer.normal_m)
        self.sigma_rad = free.add(
            span_s, self.course_deg_h, parts.thermostat.away_k - self.course_k,
            parts.soak - self.course_soak, unknown_rad_s * computer.sin / computer.cos)

    def calibrate_course(self, left_deg_h: float) -> None:
        """Note that the course gyro is calibrated here and now, and what that leaves."""
        parts = self.instruments
        self.course_deg_h = left_deg_h
        self.course_k, self.course_soak = parts.thermostat.away_k, parts.soak

    def say(self, message: str) -> None:
        """Report an event."""
        self._messages.append(message)

    def flag(self, name: str) -> None:
        """Continue in a degraded state, for the reason named."""
        self._flags.add(name)

    def fail(self, cause: str) -> Mode:
        """Report a fault and return the mode FAULT."""
        self._faults.append(cause)
        self.say(f'fault: {cause}')
        return Mode.FAULT

    @property
    def now_s(self) -> float:
        """Seconds since the start."""
        return self._step * GRID_S

    def block(self) -> Track:
        """Run for the next ten seconds and return the states."""
        minute, first = divmod(self._step, BLOCK_STEPS)
        if not first:
            ship, random = self._ship.block(minute), self.instruments.take(BLOCK_STEPS)
            self._rows, self._flexure_rad = rows_of(ship, random), random['flexure']
            if not minute:
                self._look(ship)
        steps = slice(first, first + TRACK_STEPS)
        rows = self._rows[steps]
        start_s, platform, computer = self.now_s, self.platform, self.computer
        grid = np.empty((TRACK_STEPS + 1, 4))
        states = grid.tolist() if self._compiled is None else grid
        inputs = rows.tolist() if self._compiled is None else rows
        states[0][:] = self._state()
        statuses: list[AhrsStatus] = []
        spells: list[tuple[int, Mode, Validity, float]] = []
        k = 0
        if self._compiled:
            self._compiled.begin()
        while k < TRACK_STEPS:
            if self._events and self._events[0].t_s <= self.now_s:
                self._happen(self._events.pop(0).kind)
            rates = None if self._steady.steps else self._next()
            if isinstance(rates, Steady):
                self._steady = rates
            if self._messages or self._step % 10 == 0:
                statuses.append(self._status())
            n = 1
            if self._steady.steps:
                n = self._count_steady(TRACK_STEPS - k)
                if self._compiled:
                    self._compiled.run(self._steady.law, rows, k, k + n, grid)
                else:
                    loop.run(self._steady.law, platform, computer, self.instruments,
                             self.instruments.thermostat, inputs, k, k + n, states)
                self._steady = Steady(self._steady.law, self._steady.steps - n)
            else:
                if rates is None:
                    platform.rest(rows[k].tolist())
                elif isinstance(rates, Excitation):
                    platform.excite(rows[k].tolist(), *rates)
                else:
                    platform.step(rows[k].tolist(), *rates)
                    computer.take()
                states[k + 1][:] = self._state()
            spells.append((n, self.mode, self.validity, self.sigma_rad))
            k += n
            self._step += n
            if self._step % 10 == 0:
                self._watch()
        azimuth, assumed, alpha, beta = np.array(states).T
        error = np.arctan2(np.sin(assumed - azimuth), np.cos(assumed - azimuth))
        lasted, mode, validity, sigma = zip(*spells)
        return Track(
            start_s=start_s, azimuth_rad=azimuth, error_rad=error, alpha_rad=alpha, beta_rad=beta,
            flexure_rad=self._flexure_rad[steps], sigma_rad=np.repeat(sigma, lasted),
            mode=np.repeat(np.array(mode, np.int8), lasted),
            validity=np.repeat(np.array(validity, np.int8), lasted), statuses=tuple(statuses))

    def _state(self) -> tuple[float, float, float, float]:
        """Return the true and the assumed azimuth, and the two tilts."""
        platform = self.platform
        return (platform.azimuth_rad, self.computer.azimuth_rad, platform.alpha_rad,
                platform.beta_rad)

    def _count_steady(self, most: int) -> int:
        """Return for how many steps a law can run before something else is to be done."""
        n = min(self._steady.steps, most, 10 - self._step % 10)
        if self._events:
            while n > 1 and self._events[0].t_s <= (self._step + n - 1) * GRID_S:
                n -= 1
        return n

    def _look(self, ship: ShipBlock) -> None:
        """Measure once before the first step."""
        platform, computer = self.platform, self.computer
        platform.latitude_rad = float(ship.latitude_rad[0])
        platform.pick_off_rad = float(ship.heading_rad[0]) - platform.azimuth_rad
        platform.speed_m_s = float(ship.speed_m_s[0])
        computer.take()

    def _next(self) -> tuple[float, float, float] | Steady | Excitation | None:
        """Return the rates to command, after all changes of mode that are due."""
        while True:
            try:
                return next(self._procedure)
            except StopIteration as end:
                self._enter(end.value)

    def _enter(self, mode: Mode) -> None:
        """Begin a mode."""
        self.mode, self._entered = mode, self._step
        self._steady = Steady(loop.HOLD, 0)
        if mode is not Mode.FAULT:
            self._reached = mode
        if mode is Mode.POST or mode is Mode.FAULT:
            self.validity, self.sigma_rad = Validity.NONE, math.nan
        self._procedure: Procedure = PROCEDURES[mode](self)
        self.say(f'mode {mode.name}')

    def _obstacle(self, kind: str, waiting: Sequence[str] = ()) -> str:
        """Return why an event would change nothing after the waiting events; empty if it would."""
        if kind in FAILURES or kind == 'repair':
            return find_obstacle_to_failure(kind, self.failures, waiting)
        before = [event for event in waiting if event in next(
            (rivals for rivals in RIVALS if kind in rivals), {kind})]
        if before:
            return 'it is about to happen' if before[-1] == kind else ''
        if kind in ('gyrocompass', 'gyro_azimuth'):
            return self._obstacle_to_operation(kind, waiting)
        if kind == 'reset' and self.mode is not Mode.FAULT:
            return f'there is no fault; the mode is {self.mode.name}'
        if kind == 'force_on' and self.mode is not Mode.THERMOSTAT_WAIT:
            return f'only THERMOSTAT_WAIT can be cut short; the mode is {self.mode.name}'
        return self._obstacle_to_change(*AVAILABLE[kind]) if kind in AVAILABLE else ''

    def _obstacle_to_operation(self, kind: str, waiting: Sequence[str]) -> str:
        """Return why a mode of operation cannot be chosen; empty if it can."""
        mode = self.mode
        if mode is Mode.FAULT and not {'reset', 'power_dip'} & set(waiting):
            return 'the mode is FAULT; reset first'
        operates = mode in (Mode.GYROCOMPASS, Mode.GYRO_AZIMUTH)
        if kind.upper() == (mode if operates else self.operation).name:
            return f'it is the mode {"already" if operates else "that follows"}'
        if kind == 'gyrocompass' and abs(self.computer.latitude_rad) > POLE_RAD:
            return TOO_NEAR_THE_POLE
        return ''

    def _obstacle_to_change(self, instrument: str, available: bool) -> str:
        """Return why an instrument cannot be lost or come back; empty if it can."""
        if instrument == 'log' and self.computer.speed_is_set:
            return 'the log is not used'
        if available == (self.computer.log_ok if instrument == 'log' else self.computer.gps_ok):
            return f'the {instrument} is {"there" if available else "lost"} already'
        return ''

    def _happen(self, kind: str) -> None:
        """Carry out an event, or say why it changes nothing."""
        computer = self.computer
        if why := self._obstacle(kind):
            self.say(f'{kind} refused: {why}')
            return
        if kind in ('gyrocompass', 'gyro_azimuth'):
            self.operation = Mode[kind.upper()]
            if self.mode in (Mode.GYROCOMPASS, Mode.GYRO_AZIMUTH):
                self._switch()
        elif kind == 'reset':
            self._restart()
        elif kind == 'force_on':
            self.forced = True
        elif kind in ('log_lost', 'log_found'):
            computer.log_ok = kind == 'log_found'
        elif kind in ('gps_lost', 'gps_found'):
            computer.gps_ok = kind == 'gps_found'
        elif kind == 'power_dip':
            self.instruments.power_on()
            if self._compiled:
                self._compiled.begin()
            # The estimate in force is that of the drift before.
            self.course_deg_h = math.hypot(self.errors.turn_on_deg_h, self.course_deg_h)
            self._restart()
        elif kind == 'repair':
            self.failures.clear()
            self.instruments.thermostat.broken = False
            self.platform.stuck = self.platform.jammed = False
            self.platform.spinning = True
        else:
            self.failures.add(FAILURES[kind])
            self.instruments.thermostat.broken |= kind == 'fail_thermostat'
            self.platform.stuck |= kind == 'fail_accelerometer'
            self.platform.jammed |= kind == 'fail_servo'
            self.platform.spinning &= kind != 'fail_gyro'

    def _switch(self) -> None:
        """Switch the mode of operation; keep azimuth and drift estimates."""
        computer = self.computer
        if self.mode is Mode.GYRO_AZIMUTH and self.settings.vertical == 'schuler':
            computer.leave_schuler()
        if self.operation is Mode.GYROCOMPASS:
            self.validity = Validity.SETTLING
        self._enter(self.operation)

    def _restart(self) -> None:
        """Start again with the self-test; keep the calibrations."""
        self._faults.clear()
        self._flags.clear()
        self.forced = False
        self.computer.reset_loops()
        self.computer.leave_schuler()
        self.computer.azimuth_rad = 0.0
        self.azimuth_found, self.fixes = False, None
        self.platform.angle_rad = self.platform.angle_rate_rad_s = 0.0
        self._tumble(None)
        self._enter(Mode.POST)

    def _watch(self) -> None:
        """Check once a second for failures that stop the AHRS, and for the loss of the log."""
        lost = 'NO_SPEED' in self._flags
        if not self.computer.no_speed:
            self._last_m_s = abs(self.computer.log_speed_m_s)
        if self.computer.no_speed and not lost:
            self.flag('NO_SPEED')
            self.say('no speed')
        elif lost and self.computer.log_ok:
            self._flags.remove('NO_SPEED')
            self.say('speed again')
        if self.mode in (Mode.POST, Mode.THERMOSTAT_WAIT, Mode.FAULT):
            return
        # Once the instruments have become warm, a cold start that was forced is over.
        self.forced = self.forced and not self.instruments.thermostat.ready
        seen = self.failures - UNWATCHED
        if self.failures & {'thermostat'} and not self.forced and (
                abs(self.instruments.thermostat.away_k) > THERMOSTAT_K):
            seen.add('thermostat')
        if seen:
            self._enter(self.fail(min(seen)))

    def _status(self) -> AhrsStatus:
        """Return the status report of this step."""
        computer = self.computer
        message, self._messages = '; '.join(self._messages), []
        mode_s = round((self._step - self._entered) * GRID_S, 3)
        platform = self.platform
        return AhrsStatus(
            t_s=self.now_s, mode=self.mode.name, mode_s=mode_s, progress=progress(
                self.mode, mode_s, self.validity, self.instruments.thermostat.away_k,
                self.settings),
            validity=self.validity.name,
            tests=_results(self._reached, tuple(self._faults)), message=message,
            flags=('DEGRADED', *sorted(self._flags)) if self._flags else (),
            faults=tuple(self._faults), sigma_deg=math.degrees(self.sigma_rad),
            temperature_c=self.instruments.thermostat.SET_C + self.instruments.thermostat.away_k,
            drifts_deg_h=(
                computer.drift_x_rad_s / RAD_PER_DEG_H, computer.drift_y_rad_s / RAD_PER_DEG_H,
                computer.drift_z_rad_s / RAD_PER_DEG_H, computer.meter_x_rad_s / RAD_PER_DEG_H,
                computer.meter_y_rad_s / RAD_PER_DEG_H),
            biases_ug=(computer.bias_x_m_s2 / UG_M_S2, computer.bias_y_m_s2 / UG_M_S2,
                       computer.bias_z_m_s2 / UG_M_S2),
            currents_a=(torque(platform.ux_rad_s)[1], torque(platform.uy_rad_s)[1],
                        torque(platform.uz_rad_s)[1]))


@cache
def _results(reached: Mode, faults: tuple[str, ...]) -> tuple[tuple[str, str], ...]:
    """Return the results of the built-in tests, which seldom change."""
    return tuple(self_tests(reached, faults).items())


def _wrap(angle_rad: float) -> float:
    return math.atan2(math.sin(angle_rad), math.cos(angle_rad))
