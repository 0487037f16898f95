# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The computer of the AHRS: its estimates, and the rates that its control laws command."""

from __future__ import annotations

import math

from heading_intercompare.ahrs.settings import Ahrs
from heading_intercompare.ahrs.ship.earth import EARTH_RATE_RAD_S, gravity, KNOT_M_S, radii
from heading_intercompare.ahrs.ship.seaway import GRID_S

from .control_laws import coarse_rate, compute_gyrocompass_gains, compute_hold_gains
from .platform import Platform

__all__ = ['Computer']

MOORED_M_S = 0.25
HOLD_1_S = 0.02
HOLD_ZETA = 0.707
FRICTION = 5e-5
LOG_MEMORY_S = 60.0

Rates = tuple[float, float, float]


class Computer:
    """
    All knowledge of the AHRS, and its control laws.

    `take` reads the instruments after each control step. A law then returns the rates to command
    over the next step, about x, y, z of the platform, rad/s.

    Attributes
    ----------
    drift_x_rad_s, drift_y_rad_s, drift_z_rad_s : float
        Estimated drifts of the controlling gyros.
    meter_x_rad_s, meter_y_rad_s : float
        Estimated biases of the course gyro as a meter.
    bias_x_m_s2, bias_y_m_s2 : float
        Estimated biases of the accelerometers.
    azimuth_rad : float
        Assumed azimuth of the platform; 0 after the slew to the meridian.
    qx, qy : float
        Integrated accelerometers minus the velocity of the log, m/s.
    ix, iy : float
        Integral rate corrections, rad/s.
    p : float
        Azimuth filter of the gyrocompass, m.

    """

    def __init__(self, settings: Ahrs, platform: Platform) -> None:
        self.settings = settings
        self.platform = platform
        self.drift_x_rad_s = self.drift_y_rad_s = self.drift_z_rad_s = 0.0
        self.meter_x_rad_s = self.meter_y_rad_s = 0.0
        self.bias_x_m_s2 = self.bias_y_m_s2 = 0.0
        self.azimuth_rad = 0.0
        self.log_ok = True
        self.gps_ok = settings.gps
        self._started = False
        self._log_lost_s = 0.0
        self._speed_m_s = 0.0
        self.correction_rad_s = 0.0
        self.reset_loops()
        self._latitude_rad = (None if settings.manual_latitude_deg is None
                              else math.radians(settings.manual_latitude_deg))
        self.own = False
        self.own_x = self.own_y = 0.0
        self.vx = self.vy = 0.0

    def reset_loops(self) -> None:
        """Empty the integrators."""
        self.qx = self.qy = self.ix = self.iy = self.p = 0.0

    @property
    def moored(self) -> bool:
        """Whether the log shows a ship at rest."""
        return (self.settings.speed_compensation != 'none' and not self.no_speed
                and abs(self._speed_m_s) <= MOORED_M_S)

    def prepare(self, latitude_rad: float) -> None:
        """Prepare for a latitude, before the first measurement."""
        self._set_latitude(latitude_rad if self._latitude_rad is None else self._latitude_rad)
        self.north_m_s = self.east_m_s = 0.0

    def take(self) -> None:
        """Read the instruments."""
        platform = self.platform
        if not self.own:
            latitude = (platform.latitude_rad if self._latitude_rad is None
                        else self._latitude_rad)
            if latitude != self.latitude_rad:
                self._set_latitude(latitude)
        self.ax = platform.force_x_m_s2 - self.bias_x_m_s2
        self.ay = platform.force_y_m_s2 - self.bias_y_m_s2
        known = not self.no_speed
        self._take_speed()
        psi = platform.pick_off_rad
        self.old_vx, self.old_vy = self.vx, self.vy
        self.vx = self._speed_m_s * math.cos(psi)
        self.vy = self._speed_m_s * math.sin(psi)
        if known == self.no_speed or not self._started:
            # A change of the source of the velocity is not an acceleration.
            self.old_vx, self.old_vy = self.vx, self.vy
            self._started = True
        self._resolve(self.vx, self.vy)

    def _take_speed(self) -> None:
        """Find the speed for the laws; for a minute after its loss, keep that of the log."""
        if self.settings.speed_compensation == 'manual':
            self._speed_m_s = self.settings.manual_speed_kn * KNOT_M_S
        elif self.settings.speed_compensation == 'none':
            self._speed_m_s = 0.0
        elif self.log_ok:
            self._log_lost_s = 0.0
            speed = self.platform.speed_m_s
            # At berth the noise of the log would only shake the platform.
            self._speed_m_s = speed if abs(speed) > MOORED_M_S else 0.0
        else:
            self._log_lost_s += GRID_S
            if self.no_speed:
                self._speed_m_s = 0.0

    @property
    def no_speed(self) -> bool:
        """Whether the log has been lost for so long that its last speed no longer counts."""
        return self._log_lost_s > LOG_MEMORY_S

    def _set_latitude(self, latitude_rad: float) -> None:
        """Set the latitude, and the Earth rates, radii and gravity there."""
        self.latitude_rad = latitude_rad
        self.cos, self.sin = math.cos(latitude_rad), math.sin(latitude_rad)
        self.earth_north, self.earth_up = EARTH_RATE_RAD_S * self.cos, EARTH_RATE_RAD_S * self.sin
        self.meridian_m, self.normal_m = radii(latitude_rad)
        self.gravity = gravity(latitude_rad)

    def _resolve(self, vx: float, vy: float) -> None:
        """Resolve a velocity in platform axes into north and east, and find its Coriolis rate."""
        c, s = math.cos(self.azimuth_rad), math.sin(self.azimuth_rad)
        self.north_m_s, self.east_m_s = vx * c - vy * s, vx * s + vy * c
        self.transport_down = -self.east_m_s * self.sin / (self.cos * self.normal_m)
        self.coriolis = 2.0 * self.earth_up - self.transport_down

    def coarse(self, tau_s: float) -> Rates:
        """Level fast and roughly: S (1)-(3)."""
        platform = self.platform
        return (coarse_rate(self.ay, self.gravity, tau_s, FRICTION, platform.roll_rate_rad_s),
                coarse_rate(-self.ax, self.gravity, tau_s, FRICTION, platform.pitch_rate_rad_s),
                -self.earth_up)

    def enter_hold(self) -> None:
        """Set the gains of levelling with integral action for this latitude."""
        self._hold = compute_hold_gains(HOLD_1_S, HOLD_ZETA, self.gravity)

    def hold(self) -> Rates:
        """Level without knowing the azimuth: S (7)."""
        self._integrate(self._hold.k1_1_s)
        gains = self._hold
        self.ix += GRID_S * gains.ki_rad_m_s * self.qy
        self.iy -= GRID_S * gains.ki_rad_m_s * self.qx
        turn_x, turn_y = self.transport_without_azimuth()
        platform = self.platform
        return (gains.k_rad_m * self.qy + self.ix + turn_x + FRICTION * platform.roll_rate_rad_s,
                -gains.k_rad_m * self.qx + self.iy + turn_y
                + FRICTION * platform.pitch_rate_rad_s,
                -self.earth_up)

    def transport_without_azimuth(self) -> tuple[float, float]:
        """Return the transport rates about x and y of the platform on a spherical Earth."""
        radius = math.sqrt(self.meridian_m * self.normal_m)
        return self.vy / radius, -self.vx / radius

    def fine(self) -> Rates:
        """Level using all estimates, free in azimuth: S (12), (13)."""
        self._integrate(self._hold.k1_1_s)
        gains = self._hold
        self.ix += GRID_S * gains.ki_rad_m_s * self.qy
        self.iy -= GRID_S * gains.ki_rad_m_s * self.qx
        ux, uy, uz = self.free()
        platform = self.platform
        return (ux + gains.k_rad_m * self.qy + FRICTION * platform.roll_rate_rad_s,
                uy - gains.k_rad_m * self.qx + FRICTION * platform.pitch_rate_rad_s, uz)

    def free(self) -> Rates:
        """Hold the platform by the estimates alone, without accelerometers."""
        c, s = math.cos(self.azimuth_rad), math.sin(self.azimuth_rad)
        north = self.earth_north + self.east_m_s / self.normal_m
        east = -self.north_m_s / self.meridian_m
        self.correction_rad_s = 0.0
        return (north * c + east * s - self.drift_x_rad_s + self.ix,
                east * c - north * s - self.drift_y_rad_s + self.iy,
                self.transport_down - self.earth_up - self.drift_z_rad_s)

    def enter_gyrocompass(self) -> None:
        """Set the gains of the gyrocompass and empty the integral corrections."""
        self._seek = compute_gyrocompass_gains(self.settings.sigma_1_s, self.gravity)
        self.ix = self.iy = 0.0

    def gyrocompass(self) -> Rates:
        """Level and seek the meridian: S (20)-(22)."""
        gains = self._seek
        self._integrate(gains.k1_1_s)
        self.p += GRID_S * (self.qx - gains.k4_1_s * self.p)
        ux, uy, uz = self.free()
        self.correction_rad_s = -gains.k3_rad_m_s2 / self.earth_north * self.p
        return ux + gains.k_rad_m * self.qy, uy - gains.k_rad_m * self.qx, uz + (
            self.correction_rad_s)

    def enter_schuler(self) -> None:
        """Start the AHRS's own velocity from that of the log."""
        self.own = self.settings.own_latitude
        self.own_x, self.own_y = self.vx, self.vy
        self.ix = self.iy = 0.0

    def schuler(self) -> Rates:
        """Level by the velocity integrated from the accelerometers alone."""
        # Commands the new velocity at once: with the old one the oscillation would grow.
        self._resolve(self.own_x, self.own_y)
        turning = self.coriolis
        x, y = self.own_x, self.own_y
        self.own_x = x + GRID_S * (self.ax - turning * y)
        self.own_y = y + GRID_S * (self.ay + turning * x)
        self._resolve(self.own_x, self.own_y)
        if self.own:
            self._set_latitude(self.latitude_rad + GRID_S * self.north_m_s / self.meridian_m)
        return self.free()

    def leave_schuler(self) -> None:
        """Return to the external position."""
        self.own = False

    def _integrate(self, damping_1_s: float) -> None:
        """Integrate the accelerometers against the velocity of the log."""
        turning = self.coriolis
        self.qx += (GRID_S * (self.ax - turning * self.vy - damping_1_s * self.qx)
                    - (self.vx - self.old_vx))
        self.qy += (GRID_S * (self.ay + turning * self.vx - damping_1_s * self.qy)
                    - (self.vy - self.old_vy))

    def turn_axes(self, angle_rad: float) -> None:
        """Express the velocity differences in axes turned clockwise by an angle."""
        c, s = math.cos(angle_rad), math.sin(angle_rad)
        self.qx, self.qy = self.qx * c + self.qy * s, self.qy * c - self.qx * s
