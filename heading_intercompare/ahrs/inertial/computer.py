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

"""The computer of the AHRS: its estimates, and the rates that its control laws command."""

from __future__ import annotations

import math

from heading_intercompare.ahrs.settings import Ahrs
from heading_intercompare.ahrs.ship.earth import KNOT_M_S

from . import loop
from .control_laws import compute_gyrocompass_gains, compute_hold_gains
from .loop import LOG_MEMORY_S, MOORED_M_S, Rates
from .platform import Platform

HOLD_1_S = 0.02
HOLD_ZETA = 0.707


class Computer:
    """
    All knowledge of the AHRS, and its control laws, which are functions of `loop`.

    `take` reads the instruments after each control step. A law then returns the rates to command
    over the next step, about x, y, z of the platform, rad/s.

    Attributes
    ----------
    drift_x_rad_s, drift_y_rad_s, drift_z_rad_s : float
        Estimated drifts of the controlling gyros.
    meter_x_rad_s, meter_y_rad_s : float
        Estimated biases of the course gyro as a meter.
    bias_x_m_s2, bias_y_m_s2, bias_z_m_s2 : float
        Estimated biases of the accelerometers.
    azimuth_rad : float
        Assumed azimuth of the platform; 0 after the slew to the meridian.
    qx, qy : float
        Integrated accelerometers minus the velocity of the log, m/s.
    ix, iy : float
        Integral rate corrections, rad/s.
    p : float
        Azimuth filter of the gyrocompass, m.
    ax, ay : float
        Accelerometers less their biases, m/s^2.
    vx, vy, old_vx, old_vy : float
        Velocity of the log in platform axes, now and a step before, m/s.
    latitude_rad, cos, sin
        Latitude in use, from `prepare` on, with its cosine and sine.
    earth_north, earth_up
        Earth rate there, rad/s.
    meridian_m, normal_m
        Radii of curvature there.
    gravity
        Gravity there, m/s^2.

    """

    # `loop.set_latitude` sets them.
    latitude_rad: float
    cos: float
    sin: float
    earth_north: float
    earth_up: float
    meridian_m: float
    normal_m: float
    gravity: float

    def __init__(self, settings: Ahrs, platform: Platform) -> None:
        self.settings = settings
        self.platform = platform
        self.drift_x_rad_s = self.drift_y_rad_s = self.drift_z_rad_s = 0.0
        self.meter_x_rad_s = self.meter_y_rad_s = 0.0
        self.bias_x_m_s2 = self.bias_y_m_s2 = self.bias_z_m_s2 = 0.0
        self.azimuth_rad = 0.0
        self.log_ok = True
        self.gps_ok = settings.gps
        self.started = False
        self.log_lost_s = self.log_speed_m_s = 0.0
        self.speed_is_set = settings.speed_compensation != 'full'
        self.set_speed_m_s = (settings.manual_speed_kn * KNOT_M_S
                              if settings.speed_compensation == 'manual' else 0.0)
        self.manual_latitude_rad = (math.nan if settings.manual_latitude_deg is None
                                    else math.radians(settings.manual_latitude_deg))
        self.correction_rad_s = 0.0
        self.reset_loops()
        self.own = False
        self.own_x = self.own_y = 0.0
        self.vx = self.vy = self.old_vx = self.old_vy = 0.0
        self.ax = self.ay = 0.0
        self.north_m_s = self.east_m_s = self.transport_down = self.coriolis = 0.0
        self.hold_k1 = self.hold_k = self.hold_ki = 0.0
        self.seek_k1 = self.seek_k = self.seek_k4 = self.seek_k3 = 0.0

    def reset_loops(self) -> None:
        """Empty the integrators."""
        self.qx = self.qy = self.ix = self.iy = self.p = 0.0

    @property
    def moored(self) -> bool:
        """Whether the log shows a ship at rest."""
        return (self.settings.speed_compensation != 'none' and not self.no_speed
                and abs(self.log_speed_m_s) <= MOORED_M_S)

    @property
    def no_speed(self) -> bool:
        """Whether the log has been lost for so long that its last speed no longer counts."""
        return self.log_lost_s > LOG_MEMORY_S

    def prepare(self, latitude_rad: float) -> None:
        """Prepare for a latitude, before the first measurement."""
        loop.set_latitude(self, latitude_rad if math.isnan(self.manual_latitude_rad)
                          else self.manual_latitude_rad)

    def take(self) -> None:
        """Read the instruments."""
        loop.take(self, self.platform)

    def coarse(self, tau_s: float) -> Rates:
        """Level fast and roughly: S (1)-(3)."""
        return loop.coarse(self, tau_s)

    def enter_hold(self) -> None:
        """Set the gains of levelling with integral action for this latitude."""
        gains = compute_hold_gains(HOLD_1_S, HOLD_ZETA, self.gravity)
        self.hold_k1, self.hold_k, self.hold_ki = gains.k1_1_s, gains.k_rad_m, gains.ki_rad_m_s

    def hold(self) -> Rates:
        """Level without knowing the azimuth: S (7)."""
        return loop.hold(self)

    def transport_without_azimuth(self) -> tuple[float, float]:
        """Return the transport rates about x and y of the platform on a spherical Earth."""
        return loop.transport_without_azimuth(self)

    def fine(self) -> Rates:
        """Level using all estimates, free in azimuth: S (12), (13)."""
        return loop.fine(self, self.platform)

    def free(self) -> Rates:
        """Hold the platform by the estimates and the gyros, without accelerometers."""
        return loop.free(self, self.platform)

    def enter_gyrocompass(self) -> None:
        """Set the gains of the gyrocompass, S (20)-(22), and empty the integral corrections."""
        gains = compute_gyrocompass_gains(self.settings.sigma_1_s, self.gravity)
        self.seek_k1, self.seek_k = gains.k1_1_s, gains.k_rad_m
        self.seek_k4, self.seek_k3 = gains.k4_1_s, gains.k3_rad_m_s2
        self.ix = self.iy = 0.0

    def enter_schuler(self) -> None:
        """Start the AHRS's own velocity from that of the log."""
        self.own = self.settings.own_latitude
        self.own_x, self.own_y = self.vx, self.vy
        self.ix = self.iy = 0.0

    def leave_schuler(self) -> None:
        """Return to the external position."""
        self.own = False

    def turn_axes(self, angle_rad: float) -> None:
        """Express the velocity differences in axes turned clockwise by an angle."""
        c, s = math.cos(angle_rad), math.sin(angle_rad)
        self.qx, self.qy = self.qx * c + self.qy * s, self.qy * c - self.qx * s
