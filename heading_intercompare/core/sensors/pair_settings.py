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

"""The settings of one pair of sensors, as for a comparison of these two alone."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations

from heading_intercompare.core.decision.coverage import least_duration_s, slowest_error_s
from heading_intercompare.core.decision.criteria import require_norms
from heading_intercompare.core.decision.norm_presets import sigma_max_deg
from heading_intercompare.core.declared_settings import SettingsError
from heading_intercompare.core.sensor_table import find_tested, read_sensors, Sensor
from heading_intercompare.core.settings import Risk, Settings

from .compared_sensors import list_sensors
from .pair_names import Names

#: What the row of a sensor says for the protocol.
_OF_TRIAL = ('maker', 'type', 'serial', 'evidence', 'calibration_date', 'calibration_months')


def settings_of_pair(settings: Settings, ts: Sensor, rs: Sensor) -> Settings:
    """
    Return the settings of a pair.

    Parameters
    ----------
    settings
        Of the whole comparison.
    ts, rs
        The tested one and its partner. What is known of the RS (`norms.sigma_ref_deg`, `m_low`,
        `m_up`) holds only for the reference; any other partner is between perfect and its norm.

    Returns
    -------
    Settings
        With these a comparison of the two streams alone gives the same verdict; unchanged without
        the setting `sensors`.

    Raises
    ------
    SettingsError
        If one of them has no norm.

    """
    if settings.sensors is None:
        return settings
    norms, trial = settings.norms, settings.trial
    if ts.sigma_max_deg is not None:
        norms = replace(norms, sigma_max_deg=ts.sigma_max_deg, preset=None)
    if rs.is_reference:
        if rs.sigma_max_deg is not None:
            norms = replace(norms, sigma_ref_max_deg=rs.sigma_max_deg)
    else:
        partner = rs.sigma_max_deg
        if partner is None:
            partner = sigma_max_deg(settings.norms, settings.model)
        norms = replace(norms, sigma_ref_max_deg=partner, sigma_ref_deg=None, m_low=0.0, m_up=1.0)
    of_pair = replace(
        settings, sensors=None, norms=norms, risk=_risk_of_pair(ts, rs, settings.risk),
        installation_offset_deg=ts.installation_offset_deg - rs.installation_offset_deg,
        installation_offset_u_deg=(ts.installation_offset_u_deg ** 2
                                   + rs.installation_offset_u_deg ** 2) ** 0.5,
        ts_topic=ts.heading_topic, rs_topic=rs.heading_topic,
        ts_convention=ts.convention, rs_convention=rs.convention,
        trial=replace(trial, **{f'{role}_{name}': getattr(sensor, name)
                                for role, sensor in (('ts', ts), ('rs', rs))
                                for name in _OF_TRIAL if getattr(sensor, name)}))
    try:
        require_norms(of_pair.norms, of_pair.model)
    except SettingsError as error:
        raise SettingsError(f'sensors, {ts.name} and {rs.name}: {error}; give sigma_max_deg in '
                            'the rows of both') from error
    return of_pair


def risk_of(sensor: Sensor, risk: Risk) -> Risk:
    """Return the risks of a judgement on a sensor, with its own slowest error."""
    if sensor.slowest_error_s is not None:
        risk = replace(risk, slowest_error_s=sensor.slowest_error_s)
    if sensor.sensor_class is not None:
        risk = replace(risk, sensor_class=sensor.sensor_class)
        if sensor.slowest_error_s is None:
            risk = replace(risk, slowest_error_s=None)
    return risk


def _risk_of_pair(ts: Sensor, rs: Sensor, risk: Risk) -> Risk:
    """
    Return the risks of a judgement on a pair.

    A statement must hold for all errors in the differences. Where the partner has slower errors,
    or none stated, the statement on the TS only says how long a run must be.
    """
    of_ts = risk_of(ts, risk)
    slowest = slowest_error_s(of_ts)
    is_silent = rs.slowest_error_s is None and rs.sensor_class is None
    if slowest is None or (rs.is_reference and is_silent):
        return of_ts
    of_partner = slowest_error_s(risk_of(rs, risk))
    if of_partner is not None and of_partner <= slowest:
        return of_ts
    return replace(of_ts, slowest_error_s=None, sensor_class=None,
                   min_duration_s=least_duration_s(of_ts))


def check_sensors(settings: Settings) -> tuple[Sensor, ...]:
    """Return the sensors; SettingsError if there is none, or if one has no norm."""
    sensors = read_sensors(settings.sensors)
    if not sensors:
        raise SettingsError('sensors: none; give a row per sensor')
    for sensor in sensors[1:]:
        settings_of_pair(settings, sensors[0], sensor)
    return sensors


def check_norms(settings: Settings) -> None:
    """Raise SettingsError if two sensors, or one of several, have no norm."""
    if settings.sensors is None:
        require_norms(settings.norms, settings.model)
    else:
        check_sensors(settings)


def settings_of_others(settings: Settings) -> dict[Names, Settings]:
    """Return the settings of each pair without the reference, by the names of its sensors."""
    free = [sensor for sensor in list_sensors(settings) if not sensor.is_reference]
    return {(first.name, second.name): settings_of_pair(settings, first, second)
            for first, second in combinations(free, 2)}


def settings_of_tested(settings: Settings, name: str | None) -> Settings:
    """
    Return the settings of one sensor and the reference; as given for None.

    Raises
    ------
    SettingsError
        If the sensor is not among the tested ones, or a sensor has no norm.

    """
    if name is None:
        return settings
    sensors = check_sensors(settings)
    return settings_of_pair(settings, *find_tested(sensors, name))
