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

"""Every setting of the simulated trial: ship, sea, sensors, the gimballed AHRS."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Mapping

from heading_intercompare.ahrs.ship.course import Current
from heading_intercompare.ahrs.ship.seaway import SEAWAYS
from heading_intercompare.ahrs.ship.steering import USUAL_TURN_DEG_S
from heading_intercompare.ahrs.ship.wave_sea import Hull, Waves
from heading_intercompare.core.declared_settings import (
    Checked,
    from_mapping,
    read_rows,
    setting,
    SettingsError,
    to_mapping,
)

from .faults import FAULTS
from .plans import (
    EVENTS,
    FIXED,
    parse_deviation,
    parse_events,
    parse_faults,
    parse_fixed,
    parse_legs,
    parse_starts,
    parse_utc,
)

AHRS_MODELS = ('dtg_precision', 'marine_0p1', 'imo')
_STREAMS = ('ts', 'rs', 'truth')
MODELS = ('ideal', 'gnss_compass', 'gnss_0p5m', 'gnss_5m', 'gnss_harbour', 'fog_strapdown',
          'rlg_strapdown', *AHRS_MODELS)


def _declare(help: str, hi: float | None = None) -> Any:
    """Declare an error of the AHRS, whose default is that of the model."""
    return setting(None, help + '; none: as in the model', 0.0, hi)


@dataclass(frozen=True, slots=True)
class Errors(Checked):
    """Errors of the instruments of the AHRS; random errors are given by standard deviation."""

    turn_on_deg_h: float | None = _declare('gyro drift, new at each turn-on [deg/h]')
    markov_deg_h: float | None = _declare('coloured gyro drift [deg/h]')
    markov_tau_s: float | None = _declare('its correlation time [s]')
    random_walk_deg_sqrt_h: float | None = _declare('angle random walk of a gyro [deg/sqrt(h)]')
    temperature_deg_h_k: float | None = _declare('gyro drift with temperature [deg/h/K]')
    soak_deg_h: float | None = _declare('gyro drift at power-on, decaying [deg/h]')
    soak_tau_s: float | None = _declare('its time constant [s]')
    torquer_ppm: float | None = _declare('scale error of the gyro torquers [1e-6]')
    spin_axis_arcsec: float | None = _declare(
        'angle between spin and rotation axis of the meter [arcsec]')
    residual_xy_deg_h: float | None = _declare('levelling gyro drift left by calibration [deg/h]')
    residual_z_deg_h: float | None = _declare('course gyro drift left by calibration [deg/h]')
    accelerometer_bias_ug: float | None = _declare('accelerometer bias [ug]')
    accelerometer_markov_ug: float | None = _declare('its coloured part [ug]')
    accelerometer_markov_tau_s: float | None = _declare('its correlation time [s]')
    accelerometer_white_ug: float | None = _declare('accelerometer white noise [ug/sqrt(Hz)]')
    accelerometer_temperature_ug_k: float | None = _declare('bias with temperature [ug/K]')
    accelerometer_step_m_s: float | None = _declare('velocity step of the accelerometers [m/s]')
    log_scale: float | None = _declare('scale error of the log')
    log_markov_m_s: float | None = _declare('coloured error of the log [m/s]')
    log_markov_tau_s: float | None = _declare('its correlation time [s]')
    gps_deg: float | None = _declare('coloured error of the satellite heading [deg]')
    gps_tau_s: float | None = _declare('its correlation time [s]')
    follow_up_s: float | None = _declare('lag of the azimuth follow-up [s]')
    harmonic_arcsec: float | None = _declare('pick-off error, once a turn [arcsec]')
    harmonic2_arcsec: float | None = _declare('pick-off error, twice a turn [arcsec]')
    coupling: float | None = _declare('heading error per roll or pitch angle')
    flexure_deg: float | None = _declare('coloured error of the mounting [deg]')
    flexure_tau_s: float | None = _declare('its correlation time [s]')
    output_deg: float | None = _declare('white noise of the output [deg]')


@dataclass(frozen=True, slots=True)
class Ahrs(Checked):
    """The gimballed AHRS; used if the model of the sensor is an AHRS."""

    initial_state: str = setting(
        'cold', "'cold': power-on at 0; 'warm': begins with coarse levelling; 'aligned': begins "
        'in operation with the drifts that a calibration leaves',
        choices=('cold', 'warm', 'aligned'))
    operation: str = setting('gyrocompass', 'mode of operation until another is commanded',
                             choices=('gyrocompass', 'gyro_azimuth'))
    powered_s: float = setting(
        14400.0, 'time since power-on at the start, unless cold [s]', 0.0)
    tilt_deg: float = setting(2.0, 'tilt of the platform before levelling [deg]', 0.0, 10.0)
    azimuth_deg: float | None = setting(
        None, 'azimuth of the platform at the start; if aligned, its error [deg]; none: random',
        -180.0, 180.0)
    sigma_1_s: float = setting(2e-3, 'tuning of the gyrocompass [1/s]', 1e-4, 1e-2)
    start: str = setting(
        'successive', "calibration of the course gyro and alignment in azimuth: 'successive', or "
        "'mutual' in one turning of the course gyro", choices=('successive', 'mutual'))
    hold_s: float = setting(600.0, 'levelling before the course gyro is calibrated [s]', 10.0)
    alignment_s: float = setting(
        600.0, 'time over which the rates are averaged for the alignment [s]', 10.0)
    fine_s: float = setting(900.0, 'least time of fine levelling [s]', 10.0)
    vertical: str = setting('aided', "levelling in gyro azimuth: with the log, 'aided', or by the "
                            "AHRS's own velocity, 'schuler'", choices=('aided', 'schuler'))
    own_latitude: bool = setting(False, "with 'schuler', integrate the latitude too")
    speed_compensation: str = setting(
        'full', "speed used: 'full' that of the log, 'none' zero, 'manual' manual_speed_kn",
        choices=('full', 'none', 'manual'))
    manual_speed_kn: float = setting(
        0.0, "speed set by hand, for 'manual' [kn]", -100.0, 100.0)
    manual_latitude_deg: float | None = setting(
        None, "latitude set by hand [deg]; none: the ship's latitude", -89.0, 89.0)
    gps: bool = setting(False, 'whether a satellite heading is available to correct drifts')
    gps_correction: str = setting('rls', "'pair': half of the drift of each pair of fixes; 'rls': "
                                  'line through all fixes', choices=('pair', 'rls'))
    drift_fit: str = setting('lsq', "course gyro drift by a straight line, 'lsq', or by the mean "
                             "of pairs, 'pairs'", choices=('lsq', 'pairs'))
    accelerometer_calibration: str = setting(
        'two_position', 'calibration of the accelerometers; two positions only when moored',
        choices=('two_position', 'single', 'off'))
    publish: str = setting(
        'valid', 'lowest state of a heading that is not flagged as invalid',
        choices=('valid', 'settling', 'provisional'))
    noise: bool = setting(True, 'false: no random errors at all')
    fixed: str = setting('', "errors fixed instead of drawn, 'name value; ...' with the names "
                         + ', '.join(FIXED) + ' [deg/h, ug]')
    events: str = setting('', "'t_s kind; ...' with the kinds " + ', '.join(EVENTS))
    errors: Errors = field(default_factory=Errors)

    def __post_init__(self) -> None:
        """Check ranges, events and fixed errors."""
        Checked.__post_init__(self)
        parse_events(self.events)
        parse_fixed(self.fixed)


@dataclass(frozen=True, slots=True)
class Sensor(Checked):
    """One simulated heading sensor: its model, errors, stamps and faults."""

    model: str = setting(
        'ideal', "model to which the error terms below are added: 'ideal' the true heading, "
        "'gnss_...' a satellite compass, '..._strapdown' a strapdown gyrocompass, the others a "
        'gimballed AHRS', choices=MODELS)
    rate_hz: float = setting(10.0, 'readings per second [Hz]', 0.001, 1000.0)
    phase_s: float = setting(0.0, 'time of the first reading [s]', 0.0, 3600.0)
    offset_deg: float = setting(0.0, 'constant error, or mounting angle [deg]', -360.0, 360.0)
    deviation: str = setting('', "dependence on the true heading, 'B C D E': B sin + C cos + "
                             'D sin of twice + E cos of twice the heading [deg]')
    drift_deg_h: float = setting(0.0, 'steady drift [deg/h]', -3600.0, 3600.0)
    settling_deg: float = setting(0.0, 'decaying error at each start [deg]', -360.0, 360.0)
    settling_tau_s: float = setting(1800.0, 'its time constant [s]', 1.0)
    starts: str = setting('', "further starts, each with its settle-point error, 't_s error_deg; "
                          "...': the settling error begins with each")
    tone_deg: float = setting(0.0, 'amplitude of a periodic error [deg]', 0.0, 180.0)
    tone_period_s: float = setting(5064.0, 'its period; 84.4 min is Schuler [s]', 0.1)
    white_deg: float = setting(0.0, 'standard deviation of white noise [deg]', 0.0, 180.0)
    white_shape: str = setting('normal', 'its distribution', choices=('normal', 'uniform'))
    markov_deg: float = setting(0.0, 'standard deviation of coloured noise [deg]', 0.0, 180.0)
    markov_tau_s: float = setting(120.0, 'its correlation time [s]', 0.001)
    resolution_deg: float = setting(0.0, 'step of the readings; 0: none [deg]', 0.0, 10.0)
    claimed_sigma_deg: float | None = setting(
        None, 'standard deviation that the sensor claims [deg]; none: that of its random errors',
        0.0, 180.0)
    latency_s: float = setting(
        0.0, 'delay from the instant of a reading to its delivery [s]', 0.0, 60.0)
    stamp_offset_s: float = setting(
        0.0, 'stamp minus the instant of the reading [s]; what the skew estimate finds',
        -3600.0, 3600.0)
    stamp_jitter_s: float = setting(
        0.0, 'largest random error of a stamp, uniform [s]', 0.0, 10.0)
    clock_drift_ppm: float = setting(0.0, 'rate error of the clock of the stamps [1e-6]',
                                     -1000.0, 1000.0)
    dropout: float = setting(0.0, 'probability that a reading is missing', 0.0, 1.0)
    outage_every_s: float = setting(
        0.0, 'mean time from an outage to the next, random; 0: none [s]', 0.0)
    outage_s: float = setting(10.0, 'mean length of an outage, random [s]', 0.001)
    faults: str = setting('', "'t_s kind [value [duration_s]]; ...' with the kinds "
                          + ', '.join(FAULTS))
    ahrs: Ahrs = field(default_factory=Ahrs)

    def __post_init__(self) -> None:
        """Check ranges and faults, and that jitter cannot swap two stamps."""
        Checked.__post_init__(self)
        parse_faults(self.faults)
        parse_deviation(self.deviation)
        parse_starts(self.starts)
        if self.stamp_jitter_s * self.rate_hz >= 0.5:
            raise SettingsError(
                f'stamp_jitter_s = {self.stamp_jitter_s!r}: must be less than half the interval '
                f'of the readings, {0.5 / self.rate_hz:g}')


@dataclass(frozen=True, slots=True)
class SeaSettings(Checked):
    """Waves that the ship meets, and how it answers them."""

    height_m: float = setting(
        0.0, 'significant wave height; 0: the motion that seaway names, whatever the course [m]',
        0.0, 20.0)
    peak_period_s: float = setting(9.0, 'period of the peak of the spectrum [s]', 2.0, 30.0)
    from_deg: float = setting(0.0, 'where the waves come from [deg]', -360.0, 360.0)
    peak_factor: float = setting(
        3.3, 'peak factor of JONSWAP; 1: Pierson and Moskowitz', 1.0, 10.0)
    spreading: float | None = setting(
        10.0, 'exponent s of the spreading cos^2s of half the angle; none: one direction',
        0.0, 1000.0)
    length_m: float = setting(80.0, 'length of the ship at the waterline [m]', 1.0, 500.0)
    breadth_m: float = setting(14.0, 'its breadth [m]', 0.5, 100.0)
    draught_m: float = setting(4.5, 'its draught [m]', 0.1, 40.0)
    roll_period_s: float = setting(11.0, 'natural period of roll [s]', 1.0, 60.0)
    roll_damping: float = setting(
        0.1, 'damping of roll as a share of the critical one', 0.01, 1.0)

    def waves(self) -> Waves | None:
        """Return the waves; None without."""
        return None if self.height_m == 0.0 else Waves(
            self.height_m, self.peak_period_s, self.from_deg, self.peak_factor, self.spreading)

    def hull(self) -> Hull:
        """Return the ship."""
        return Hull(self.length_m, self.breadth_m, self.draught_m, self.roll_period_s,
                    self.roll_damping)


@dataclass(frozen=True, slots=True)
class CurrentSettings(Checked):
    """A steady current, which the log of the ship does not see."""

    set_deg: float = setting(0.0, 'where the water goes [deg]', -360.0, 360.0)
    drift_kn: float = setting(0.0, 'how fast it goes [kn]', 0.0, 20.0)

    def current(self) -> Current:
        """Return the current."""
        return Current(self.set_deg, self.drift_kn)


@dataclass(frozen=True, slots=True)
class TrackSettings(Checked):
    """A recorded voyage that the ship repeats in place of its legs; the command simulate only."""

    file: str = setting(
        '', 'bag, log of NMEA sentences or csv with the headings; empty: the ship sails its legs')
    heading: str = setting(
        '', 'topic, sentence or column of the headings; empty: truth/heading of a simulated bag, '
        'otherwise the only one')
    motion_file: str = setting(
        '', 'file with the motion of the ship; empty: that of the headings')
    begin_s: float = setting(0.0, 'time of the record at which the trial begins [s]', 0.0)
    heading_smooth_s: float = setting(
        3.0, 'oscillations of heading, roll and pitch with this period are halved, faster ones '
        'removed; at least four samples [s]', 0.1, 3600.0)
    speed_smooth_s: float = setting(
        60.0, 'the same for the velocity over ground [s]', 1.0, 3600.0)
    speed_kn: float = setting(
        0.0, 'speed if the record has neither velocity nor positions [kn]', 0.0, 60.0)
    longest_gap_s: float = setting(
        60.0, 'longest gap that is bridged; a longer one is an error [s]', 0.0, 86400.0)


@dataclass(frozen=True, slots=True)
class Scenario(Checked):
    """A trial to simulate: ship, sea, TS and RS."""

    title: str = setting('', 'title of the trial')
    duration_s: float = setting(1200.0, 'length of the trial [s]', 1.0, 2.6e6)
    start_utc: str = setting('2026-01-01T00:00:00Z', 'instant of the start, ISO 8601, UTC')
    seed: int = setting(1, 'seed of all random numbers', 0, 2**63 - 1)
    latitude_deg: float = setting(45.0, 'latitude of the start [deg]', -89.0, 89.0)
    longitude_deg: float = setting(0.0, 'longitude of the start [deg]', -180.0, 180.0)
    seaway: str = setting('calm', 'state of the sea', choices=tuple(SEAWAYS))
    legs: str = setting('0 0 0', "course plan 't_s course_deg speed_kn; ...'")
    turn_deg_s: float = setting(
        USUAL_TURN_DEG_S, 'greatest rate of turn in a change of course; a ship that turns faster '
        f'than {USUAL_TURN_DEG_S:g} deg/s answers faster in proportion [deg/s]', 0.01, 20.0)
    sea: SeaSettings = field(default_factory=SeaSettings)
    current: CurrentSettings = field(default_factory=CurrentSettings)
    track: TrackSettings = field(default_factory=TrackSettings)
    motion_hz: float = setting(
        1.0, 'rate at which the ship tells position, velocity and rate of turn; 0: not at all '
        '[Hz]', 0.0, 100.0)
    ts: Sensor = field(default_factory=Sensor)
    rs: Sensor = field(default_factory=Sensor)
    others: str = setting(
        '', "further sensors of the ship, 'name setting=value ...; ...' with the settings of a "
        'sensor; topic name/heading')

    def __post_init__(self) -> None:
        """Check ranges, the course plan, the start and the further sensors."""
        Checked.__post_init__(self)
        parse_legs(self.legs)
        parse_utc(self.start_utc)
        try:
            names = [name for name, _ in read_rows(self.others, Sensor)]
        except ValueError as error:
            raise SettingsError(f'others, {error}') from error
        if reserved_names := [name for name in names if name.lower() in _STREAMS]:
            raise SettingsError(f'others: {reserved_names[0]} is the name of another stream')

    @property
    def topics(self) -> dict[str, str]:
        """Return the usual topic of each simulated sensor."""
        return {name: f'{name}/heading' for name in self.sensors}

    @property
    def sensors(self) -> dict[str, Sensor]:
        """All simulated sensors: 'ts', 'rs', and the others by name."""
        return {'ts': self.ts, 'rs': self.rs, **dict(read_rows(self.others, Sensor))}

    @classmethod
    def from_mapping(cls, mapping: Mapping[str, Any]) -> 'Scenario':
        """
        Return a scenario from nested or dotted names, as in a YAML file.

        Raises
        ------
        SettingsError
            For an unknown name or a value that is not allowed: name, value, what is allowed.

        """
        scenario: Scenario = from_mapping(cls, mapping)
        return scenario

    def to_mapping(self) -> dict[str, Any]:
        """Return dotted names and values, in the order of their declaration."""
        return to_mapping(self)
