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
Every setting of the analysis: name, default, unit, meaning, range. Declared here and only here.

These classes give the ROS parameters, the YAML file, `--set` and the tables of the documentation.
The outer rooms declare their own settings with the same `setting`.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, ClassVar, Mapping, Sequence

from .declared_settings import (
    Checked,
    from_mapping,
    Moved,
    name_keywords,
    setting,
    SettingsError,
    to_mapping,
)
from .required_tests import read_required_tests
from .sensor_table import read_sensors, SENSOR_CLASS_NAMES
from .time_rules.clock_cuts import ClockCuts
from .time_rules.exclusions import read_exclusions
from .units.full_turns import ANGLE_UNITS


@dataclass(frozen=True, slots=True)
class Norms(Checked):
    """The norms of the TS, and what is known about the RS."""

    sigma_max_deg: float | None = setting(
        None, 'norm of the TS standard deviation [deg]; required, or given by a preset', 0.0)
    limiting_error_max_deg: float | None = setting(
        None, 'norm of the limiting error of the TS, in place of sigma_max_deg, which is this / '
        'sqrt 3 for a uniform law and this / K(P) for a normal one [deg]', 0.0)
    sigma_ref_max_deg: float | None = setting(
        None, 'norm of the RS standard deviation [deg]; required', 0.0)
    sigma_ref_deg: float | None = setting(
        None, 'actual RS standard deviation if known (service log) [deg]; sets m_low and m_up '
        'to sigma_ref_deg / sigma_ref_max_deg', 0.0)
    m_low: float = setting(0.0, 'lower bound of M = sigma_ref / sigma_ref_max', 0.0, 1.0)
    m_up: float = setting(1.0, 'upper bound of M = sigma_ref / sigma_ref_max', 0.0, 1.0)
    probability: float = setting(0.997, 'confidence probability P', 0.5, 0.999999)
    k_rule: float | str = setting(
        'exact', "coverage factor K(P) of the guarded counts: 'exact' two-sided quantile of the "
        "model, 'three' for 3 in Gaussian models, or a number; GK as printed has 3 for P = "
        '0.997', 0.1, 20.0, choices=('exact', 'three'))
    k_total_rule: str = setting(
        'ts', "K of GK (7): 'ts' distribution of the TS error alone, or 'composition'",
        choices=('ts', 'composition'))
    total_error_max_deg: float | None = setting(
        None, 'norm of the total TS error at P [deg]', 0.0)
    systematic_max_deg: float | None = setting(
        None, 'norm of the systematic TS error, for observations (the command observe) [deg]; a '
        'preset with a norm of its own replaces it', 0.0)
    preset: str | None = setting(
        None, 'a named norm (see the command norms); replaces sigma_max_deg')
    latitude_deg: float | None = setting(
        None, 'latitude for the secant factor of a preset [deg]', -70.0, 70.0)
    tests: str | None = setting(
        None, "tests of a norm of one's own, in place of the same tests of the preset: rows of a "
        "test and its limit, such as 'static_error 1.0' or 'follow_up 0.5 0-10', separated by "
        'line ends or a semicolon; see docs/verdict.md')

    def __post_init__(self) -> None:
        """Check ranges, the order of the bounds of M, and the tests."""
        Checked.__post_init__(self)
        try:
            read_required_tests(self.tests)
        except ValueError as error:
            raise SettingsError(f'norms.tests, {error}') from error
        if self.sigma_max_deg is not None and self.sigma_max_deg <= 0.0:
            raise SettingsError(
                f'norms.sigma_max_deg = {self.sigma_max_deg!r}: must be greater than 0')
        if self.limiting_error_max_deg is not None:
            if self.limiting_error_max_deg <= 0.0:
                raise SettingsError(f'norms.limiting_error_max_deg = '
                                    f'{self.limiting_error_max_deg!r}: must be greater than 0')
            if self.sigma_max_deg is not None:
                raise SettingsError('norms.limiting_error_max_deg: must not be given with '
                                    'norms.sigma_max_deg, which follows from it')
        if self.m_low > self.m_up:
            raise SettingsError(f'norms.m_low = {self.m_low!r}: must not exceed '
                                f'norms.m_up = {self.m_up!r}')
        if (self.sigma_ref_deg is not None and self.sigma_ref_max_deg is not None
                and self.sigma_ref_deg > self.sigma_ref_max_deg):
            raise SettingsError(
                f'norms.sigma_ref_deg = {self.sigma_ref_deg!r}: the RS is out of its norm '
                f'norms.sigma_ref_max_deg = {self.sigma_ref_max_deg!r}; no verdict is possible')


SILENCE_STEPS = 10.0
"""A step of the stamps longer than this multiple of the usual one is a silence."""

LONGEST_GAP_S = 3.0
"""Readings further apart do not show the motion between them, unless the settings say so."""


@dataclass(frozen=True, slots=True)
class Pairing(Checked):
    """How TS and RS readings are paired."""

    method: str = setting(
        'auto', "'interpolate': RS interpolated to the TS stamps; 'interpolate_ts': TS to the RS "
        "stamps; 'auto': 'interpolate_ts' if the RS is slow, otherwise 'interpolate'; 'nearest': "
        'mutual nearest stamps, ties to the earlier',
        choices=('auto', 'interpolate', 'interpolate_ts', 'nearest'))
    auto_s: float = setting(
        60.0, "start of a run on which 'auto' bases its choice [s]", 1.0, 600.0)
    kernel: str = setting(
        'band_limited', "'band_limited': interpolated by up to eight readings, which keeps the "
        "motion; 'line': by the straight line between two, without a certificate where it lacks "
        'motion', choices=('band_limited', 'line'))
    max_gap_s: float | str = setting(
        'auto', "longest bracket interpolated, inclusive [s]; 'auto': 1.5 usual steps of the "
        'sensor, which also bounds a number', 0.0, 3600.0, choices=('auto',))
    tolerance_s: float = setting(0.05, "largest lag of a pair, method 'nearest' [s]", 0.0, 60.0)
    max_wait_s: float = setting(
        5.0, 'live only: a sensor that lags the other by more, or is silent for longer, is late; '
        'an alarm names a lag [s]', 0.0, 600.0)
    silent_wait_s: float = setting(
        60.0, 'live only: how long a reading waits for a sensor that is late, at least '
        'max_wait_s: what that one has sent may still come [s]', 0.0, 3600.0)
    jump_s: float = setting(10.0, 'a longer step of the stamps is a jump [s]', 0.1, 86400.0)

    @property
    def longest_wait_s(self) -> float:
        """Return how long a reading waits for its partner at most, live, seconds."""
        return max(self.max_wait_s, self.silent_wait_s)

    @property
    def longest_gap_s(self) -> float:
        """Return how far readings may lie apart to show the motion between them, seconds."""
        return self.max_gap_s if isinstance(self.max_gap_s, float) else LONGEST_GAP_S


@dataclass(frozen=True, slots=True)
class RunCutting(Checked):
    """Where a run starts and ends, and which part is analysed."""

    stabilization_s: float | str = setting(
        0.0, "start of a run that is not analysed [s], or 'auto'", 0.0, choices=('auto',))
    gap_s: float = setting(60.0, 'a silence of the pairs longer than this cuts a run [s]', 0.0)
    min_duration_s: float = setting(0.0, 'a piece shorter than this is not a run [s]', 0.0)
    every_h: float | None = setting(
        None, 'a run is also cut at every multiple of this time since 1970-01-01 00:00 UTC: 24 '
        'cuts at midnight, 4 at the change of watch [h]', 0.01, 8784.0)
    cut_at_utc: str | None = setting(
        None, "a run is also cut at these times of every day, UTC: '00:00' or "
        "'00:00,08:00,16:00'")
    keep: int = setting(
        31, 'with every_h or cut_at_utc: a verdict covers the runs since this many cuts; a '
        'logbook keeps all runs', 1, 100000)

    def __post_init__(self) -> None:
        """Check ranges and the times of the day."""
        Checked.__post_init__(self)
        try:
            self.clock_cuts()
        except ValueError as error:
            raise SettingsError(f'runs.cut_at_utc = {self.cut_at_utc!r}: {error}') from error

    def clock_cuts(self) -> ClockCuts:
        """Return the cuts by the clock."""
        return ClockCuts(self.every_h, self.cut_at_utc)

    def horizon_ns(self, newest_ns: int | None, spans: int = 1) -> int | None:
        """
        Return the cut before which runs are not part of a verdict.

        Parameters
        ----------
        newest_ns
            Stamp of the newest pair.
        spans
            Step back this multiple of `keep`.

        Returns
        -------
        int or None
            None if all runs are part of it.

        """
        cuts = self.clock_cuts()
        if newest_ns is None or not cuts:
            return None
        return cuts.before(newest_ns, spans * self.keep)


LARGEST_SKEW_S = 3600.0
"""Largest skew that settings may search for, in either direction, seconds."""
_LARGEST_SHIFT_S = 2.0 ** 31


@dataclass(frozen=True, slots=True)
class Alignment(Checked):
    """Time skew between the sensors."""

    skew_s: float = setting(
        0.0, 'known TS latency, or shift of the TS clock, subtracted from the TS stamps before '
        'pairing [s]', -_LARGEST_SHIFT_S, _LARGEST_SHIFT_S)
    skew: str = setting(
        'report', "'off'; 'report': estimate the skew and show the verdict with and without it; "
        "'apply': pair again with the skew removed", choices=('off', 'report', 'apply'))
    skew_range_s: float = setting(
        2.0, 'largest skew to search for, in either direction [s]', 0.01, 60.0)
    clock_range_s: float = setting(
        600.0, 'largest offset of the clocks to search for beyond a minute, in either direction; '
        '0: none [s]', 0.0, LARGEST_SKEW_S)


@dataclass(frozen=True, slots=True)
class Sequential(Checked):
    """Early verdicts at doubling looks."""

    plan_s: float | str | None = setting(
        None, "planned length of a run [s]; 'open': its end is not planned, and the looks begin "
        'at the least length of a run; none: no early verdict. Not stated: open for the command '
        'live and the launch files, and for a recording what it was judged by live', 0.0,
        choices=('open',))
    looks: int = setting(7, 'number of doubling looks, the end of the run among them', 2, 20)


@dataclass(frozen=True, slots=True)
class Risk(Checked):
    """Risks of the guarded decision."""

    alpha_consumer: float = setting(0.05, 'risk of certifying a TS at its norm', 1e-9, 0.5)
    alpha_producer: float = setting(0.05, 'risk of rejecting a TS at its norm', 1e-9, 0.5)
    count_share: float = setting(
        0.1, "share of the producer's risk for the counts; the rest is for the variance", 0.001,
        0.999)
    slowest_error_s: float | None = setting(
        None, 'slowest error of the TS: the time in which its correlation falls to 1/e, never a '
        'period [s]; a run shorter than 20 times this is not certified', 0.0)
    sensor_class: str | None = setting(
        None, 'class of the TS; gives the slowest error if slowest_error_s does not (see the '
        'command norms)', choices=SENSOR_CLASS_NAMES)
    min_duration_s: float | None = setting(
        None, 'shortest run that may comply, if longer than the slowest error requires [s]; '
        'none: 600 s if no slowest error is stated', 0.0)


@dataclass(frozen=True, slots=True)
class CampaignRule(Checked):
    """How several runs are judged together; to be chosen before the data are seen."""

    rule: str = setting(
        'every_run', "'every_run': each run must comply; 'sensor': the common variance of all "
        'runs must comply', choices=('every_run', 'sensor'))


@dataclass(frozen=True, slots=True)
class Detectors(Checked):
    """Thresholds of the detectors and of their findings."""

    convention_tolerance_deg: float = setting(
        10.0, 'a mean difference within this of 90, -90 or 180 means a wrong convention [deg]',
        0.0, 45.0)
    mean_max_deg: float = setting(
        15.0, 'a larger mean difference, after the stated installation angle is removed, makes a '
        'run void unless 3 standard uncertainties of that angle cover it [deg]', 0.0, 180.0)


@dataclass(frozen=True, slots=True)
class MotionRule(Checked):
    """The motion of the ship, against which both headings are checked."""

    compare: bool = setting(
        True, 'compare the headings with the motion: one that contradicts it makes a run '
        'doubtful or void')
    least_speed_kn: float = setting(
        3.0, 'slowest speed over ground at which the course says anything [kn]', 0.5, 60.0)
    current_max_kn: float = setting(
        3.0, 'strongest current across the course [kn]', 0.0, 20.0)
    leeway_max_deg: float = setting(
        10.0, 'largest leeway and mounting angle between heading and course through the water '
        '[deg]', 0.0, 90.0)
    fix_topic: str = setting('ship/fix', 'topic of the positions (NavSatFix)')
    velocity_topic: str = setting(
        'ship/velocity', 'topic of the velocity over ground, east and north (TwistStamped)')
    rate_topic: str = setting(
        'ship/rate_of_turn', 'topic of the rate of turn, about the vertical (TwistStamped or Imu)')


@dataclass(frozen=True, slots=True)
class Antennas(Checked):
    """Two antennas whose positions give the headings of the RS."""

    fore_topic: str | None = setting(
        None, 'topic of the positions of the fore antenna (NavSatFix); with aft_topic the RS is '
        'the baseline between both')
    aft_topic: str | None = setting(
        None, 'topic of the positions of the aft antenna (NavSatFix)')
    baseline_m: float | None = setting(
        None, 'distance of the antennas, level; none: the median of the record [m]', 0.01, 1000.0)
    baseline_angle_deg: float = setting(
        0.0, 'angle from the direction aft to fore antenna to the bow, clockwise; 90 if the fore '
        'antenna is to port of the other [deg]', -360.0, 360.0)
    tolerance_m: float | None = setting(
        None, 'a reading whose baseline is off by more is rejected; none: five times the scatter '
        'of the baseline [m]', 0.0, 100.0)
    position_sigma_m: float | None = setting(
        None, 'standard deviation of a position in each direction; none: from the scatter of the '
        'baseline [m]', 0.0, 100.0)

    def __post_init__(self) -> None:
        """Check ranges, and that both topics are given or none."""
        Checked.__post_init__(self)
        if (self.fore_topic is None) is not (self.aft_topic is None):
            stated, lacking = (('aft', 'fore') if self.fore_topic is None else ('fore', 'aft'))
            raise SettingsError(f'antennas.{lacking}_topic: must be given with '
                                f'antennas.{stated}_topic')


@dataclass(frozen=True, slots=True)
class Trial(Checked):
    """Whose trial it is: names for the protocol, empty if unknown; they change no figure."""

    protocol_number: str = setting('', 'number of the protocol or of the order')
    issue_date: str | None = setting(None, 'date of issue of the protocol', is_date=True)
    customer: str = setting('', 'who asked for the trial')
    purpose: str = setting('', 'purpose of the trial, such as type approval or service')
    ship: str = setting('', 'name of the ship, with its IMO number')
    place: str = setting('', 'sea area or port of the trial')
    latitude_min_deg: float | None = setting(
        None, 'southernmost latitude of the trial, north positive [deg]', -90.0, 90.0)
    latitude_max_deg: float | None = setting(
        None, 'northernmost latitude of the trial, north positive [deg]', -90.0, 90.0)
    sea_state: int | str = setting(
        '', 'sea state by the code of the WMO, or in words, such as 3 to 4', 0, 9)
    conditions: str = setting('', 'weather and manoeuvres of the trial')
    temperature_c: float | str = setting(
        '', 'temperature at the sensors, also in words, such as 18 to 22 [deg C]', -90.0, 90.0)
    supply: str = setting('', 'supply of the sensors: voltage, frequency, emergency supply')
    laboratory: str = setting('', 'who measures and evaluates: laboratory, address')
    operator: str = setting('', 'who operated the sensors and the recording')
    ts_maker: str = setting('', 'maker of the TS')
    ts_type: str = setting('', 'type of the TS')
    ts_serial: str = setting('', 'serial number of the TS')
    ts_evidence: str = setting('', 'certificate or service log of the last calibration of the TS')
    ts_calibration_date: str | None = setting(
        None, 'date of the last calibration or service of the TS', is_date=True)
    ts_calibration_months: int | None = setting(
        None, 'interval of calibration of the TS [months]', 1, 600)
    rs_maker: str = setting('', 'maker of the RS')
    rs_type: str = setting('', 'type of the RS')
    rs_serial: str = setting('', 'serial number of the RS')
    rs_evidence: str = setting(
        '', 'proof that the RS meets its norm: certificate or service log of its calibration')
    rs_calibration_date: str | None = setting(None, 'the same date of the RS', is_date=True)
    rs_calibration_months: int | None = setting(None, 'the same interval of the RS', 1, 600)
    deviations: str = setting('', 'deviations from the method, and why; none if there are none')
    filled_in_by: str = setting('', 'who stated these names: name, date')

    def __post_init__(self) -> None:
        """Check the ranges and the order of the latitudes."""
        Checked.__post_init__(self)
        low, high = self.latitude_min_deg, self.latitude_max_deg
        if low is not None and high is not None and low > high:
            raise SettingsError(f'trial.latitude_min_deg = {low!r}: must not exceed '
                                f'trial.latitude_max_deg = {high!r}')


class Secrets:
    """What the section `dashboard` may not state: every bag holds a copy of the parameter file."""

    REMOVED: ClassVar[Mapping[str, Any]] = {'token': Moved(
        'each bag would hold it; put the token into the environment variable '
        'HEADING_INTERCOMPARE_TOKEN, or into a file of mode 0600 that token_file names')}


@dataclass(frozen=True, slots=True)
class Settings(Checked):
    """All settings of the analysis, the same for nodes, command line and scripts."""

    REMOVED: ClassVar[Mapping[str, Any]] = {
        'pairing.slow_rs_s': 0.25, 'detectors.frozen_s': 5.0, 'detectors.frozen_moved_deg': 0.0,
        'detectors.same_source_share': 0.001, 'detectors.lost_doubtful': 0.1,
        'detectors.lost_void': 0.5, 'detectors.silence_steps': 10.0}
    """Names that were settings, with the value that holds always; see `drop_removed`."""
    NEEDED: ClassVar[Sequence[str]] = (
        'norms.sigma_max_deg', 'norms.sigma_ref_max_deg', 'norms.sigma_ref_deg', 'norms.preset',
        'norms.latitude_deg', 'risk.sensor_class', 'installation_offset_deg', 'alignment.skew',
        'ts_topic', 'rs_topic')
    """The settings that a user needs; the others have defaults that fit most trials."""

    norms: Norms = field(default_factory=Norms)
    model: str = setting('NN', 'TS and RS error distributions, N normal or U uniform',
                         choices=('NN', 'UN', 'NU', 'UU'))
    variant: str = setting('B', 'a priori knowledge of the TS mean: GK Table I',
                           choices=('A', 'B', 'C'))
    installation_offset_deg: float = setting(
        0.0, 'known angle TS - RS as mounted [deg]', -360.0, 360.0)
    installation_offset_u_deg: float = setting(
        0.0, 'standard uncertainty of the installation offset [deg]', 0.0, 180.0)
    wrap_center_deg: float = setting(
        0.0, 'differences are reduced to [c - 180, c + 180) [deg]', -360.0, 360.0)
    runs: RunCutting = field(default_factory=RunCutting)
    drift_order: int | str = setting(
        0, "order of the polynomial removed before GK (4), or 'auto'", 0, 3, choices=('auto',))
    pairing: Pairing = field(default_factory=Pairing)
    alignment: Alignment = field(default_factory=Alignment)
    sequential: Sequential = field(default_factory=Sequential)
    ts_topic: str = setting(
        'ts/heading', 'topic of the TS; of messages with NMEA sentences TOPIC.HEHDT chooses one, '
        'and TOPIC.FIELD or TOPIC.FIELD@rad@enu takes an angle or a quaternion in messages of any '
        'type')
    rs_topic: str = setting('rs/heading', 'the same of the RS')
    bag_namespace: str | None = setting(
        None, 'namespace in a bag of the topics without a leading slash, such as /ship1; none: '
        'that of the recorder of this package, or the root')
    ts_convention: str = setting('enu', 'world axes of the TS orientation',
                                 choices=('enu', 'ned'))
    rs_convention: str = setting('enu', 'world axes of the RS orientation',
                                 choices=('enu', 'ned'))
    ts_unit: str = setting(
        'auto', "unit of the headings of the TS in files of numbers and in fields of messages; "
        "'auto': that of the name of the column or field, of the form of the file, or degrees",
        choices=('auto', *ANGLE_UNITS))
    rs_unit: str = setting('auto', 'the same of the RS', choices=('auto', *ANGLE_UNITS))
    risk: Risk = field(default_factory=Risk)
    campaign: CampaignRule = field(default_factory=CampaignRule)
    window_s: float = setting(600.0, 'length of the rolling window [s]', 1.0)
    detectors: Detectors = field(default_factory=Detectors)
    exclusions: str | None = setting(
        None, 'stretches taken out by hand, each with its reason: rows start, end, reason in UTC, '
        'separated by line ends or a semicolon')
    sensors: str | None = setting(
        None, 'three or more sensors of the ship, or two without a reference: a row per sensor, '
        "separated by line ends or a semicolon, with its name, setting=value, and 'rs' for the "
        'reference of all others; see docs/howto/many_sensors.md')
    motion: MotionRule = field(default_factory=MotionRule)
    antennas: Antennas = field(default_factory=Antennas)
    trial: Trial = field(default_factory=Trial)

    def __post_init__(self) -> None:
        """Check single settings, and combinations that exclude each other."""
        Checked.__post_init__(self)
        if self.variant == 'A' and self.drift_order != 0:
            raise SettingsError(f'drift_order = {self.drift_order!r}: must be 0 in variant A, '
                                'whose TS has no systematic error that could drift')
        try:
            read_exclusions(self.exclusions)
        except ValueError as error:
            raise SettingsError(f'exclusions, {error}') from error
        try:
            rows = read_sensors(self.sensors)
        except ValueError as error:
            raise SettingsError(f'sensors, {error}') from error
        if not rows:  # A table without rows compares TS and RS.
            object.__setattr__(self, 'sensors', None)

    @classmethod
    def from_mapping(cls, mapping: Mapping[str, Any]) -> 'Settings':
        """Return settings from nested or dotted names; see `from_mapping`."""
        settings: Settings = from_mapping(cls, mapping)
        return settings

    @classmethod
    def of(cls, **keywords: Any) -> 'Settings':
        """
        Return settings from keywords.

        Parameters
        ----------
        keywords
            Settings by the last part of their name (``sigma_max_deg=0.5``), or by the whole name
            with ``_`` for the dot (``risk_min_duration_s=1200.0``). A group takes its class, or
            a mapping (``norms={'m_low': 0.9}``).

        Raises
        ------
        SettingsError
            For a name that is unknown or that two groups have, a setting given twice, a wrong
            type or a value outside its range; one line with the nearest name or what is allowed.

        Examples
        --------
        >>> settings = Settings.of(sigma_max_deg=0.2, sigma_ref_max_deg=0.1, ts_topic='/gyro/imu')
        >>> settings.norms.sigma_max_deg, settings.ts_topic
        (0.2, '/gyro/imu')

        """
        return cls.from_mapping(name_keywords(cls, keywords))

    def unit_of(self, stream: str) -> str:
        """Return the unit that is stated for the headings of a topic or stream; 'auto' if none."""
        stated = {sensor.heading_topic: sensor.unit for sensor in read_sensors(self.sensors)} or {
            self.ts_topic: self.ts_unit, self.rs_topic: self.rs_unit}
        return {name.lstrip('/'): unit for name, unit in stated.items()}.get(
            stream.lstrip('/'), 'auto')

    def to_mapping(self) -> dict[str, Any]:
        """
        Return dotted names and values, in the order of their declaration.

        The removed names follow with their values: so a verdict says all that it rests on, and
        its hash is that of an earlier version with the same settings.
        """
        return {**to_mapping(self), **self.REMOVED}
