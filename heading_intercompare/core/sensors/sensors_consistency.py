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

"""Whether a verdict on several sensors that was read follows from its own figures."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations
import math

from heading_intercompare.core.decision.guarded import variance_risk
from heading_intercompare.core.declared_settings import SettingsError
from heading_intercompare.core.sensor_table import find_reference, Sensor
from heading_intercompare.core.verdict.consistency import (
    check_consistency,
    compare_with,
    ContradictionError,
    explain_difference,
)

from .compared_sensors import pair_with_reference
from .judging import conclude_sensors, describe_sensors, say_that_it_complies
from .pair_figures import PairFigures
from .pair_settings import check_sensors, settings_of_pair
from .sensors_verdict import SensorsVerdict


def check_sensors_consistency(verdict: SensorsVerdict) -> None:
    """
    Check that a verdict on several sensors, and each on one of them, follows from its figures.

    Raises
    ------
    ContradictionError
        As `check_consistency`.

    """
    _check_names(verdict)
    for name, of_sensor in verdict.verdicts.items():
        try:
            check_consistency(of_sensor)
        except ContradictionError as error:
            raise ContradictionError(f'verdicts.{name}.{error}') from error
    derived = conclude_sensors(
        verdict.settings, verdict.verdicts,
        [_derive_pair(verdict, pair) for pair in verdict.pairs], verdict.inputs,
        lambda sensor, pair: _states_compliance(verdict, sensor, pair))
    compare_with(verdict, replace(derived, software=verdict.software,
                                          rule_version=verdict.rule_version))


def _check_names(verdict: SensorsVerdict) -> None:
    """Raise ContradictionError if the verdict lacks a sensor, or has one that is in no setting."""
    try:
        names = [sensor.name for sensor in check_sensors(verdict.settings)]
        settings_of = {ts.name: settings_of_pair(verdict.settings, ts, rs)
                       for ts, rs in pair_with_reference(verdict.settings)}
    except SettingsError as error:
        raise ContradictionError(f'settings: {error}') from error
    why = explain_difference(verdict)
    pairs = [pair.names for pair in verdict.pairs]
    if {*verdict.verdicts} != {*settings_of}:
        raise ContradictionError(f'verdicts are on {", ".join(verdict.verdicts) or "no sensor"}, '
                                 f'but its settings give {", ".join(settings_of) or "none"}: '
                                 f'{why}')
    of_reference = [(ts.name, rs.name) for ts, rs in pair_with_reference(verdict.settings)]
    expected = {*of_reference, *(two for two in combinations(names, 2)
                                 if not {two, two[::-1]} & {*of_reference})}
    if len({*pairs}) < len(pairs) or not {*of_reference} <= {*pairs} or not all(
            two in expected or two[::-1] in expected - {*of_reference} for two in pairs):
        raise ContradictionError(f'pairs are {"; ".join(" and ".join(two) for two in pairs)}, '
                                 f'but its settings give those of {", ".join(names)}: {why}')
    for name, of_sensor in verdict.verdicts.items():
        if of_sensor.settings != settings_of[name]:
            raise ContradictionError(f'verdicts.{name}.settings are not those that follow from '
                                     f'the settings of all sensors: {why}')


def _derive_pair(verdict: SensorsVerdict, pair: PairFigures) -> PairFigures:
    """Return the figures of a pair as its runs give them, or as its other figures do."""
    settings, sensors = verdict.settings, check_sensors(verdict.settings)
    reference = find_reference(sensors)
    risk = variance_risk(settings.risk) / len(verdict.pairs)
    if reference is not None and pair.second == reference.name:
        return describe_sensors(pair.names, verdict.verdicts[pair.first].runs, settings, sensors,
                                risk)
    limit_deg2 = describe_sensors(pair.names, (), settings, sensors, risk).limit_deg2
    differs = pair.differs
    if pair.runs == 1 and pair.lower_bound_deg2 is not None:
        differs = bool(pair.lower_bound_deg2 > limit_deg2 or pair.gross)
    std_deg = None if pair.variance_deg2 is None else math.sqrt(max(0.0, pair.variance_deg2))
    return replace(pair, limit_deg2=limit_deg2, std_deg=std_deg, of_reference=False,
                   differs=differs)


def _states_compliance(verdict: SensorsVerdict, sensor: Sensor, pair: PairFigures) -> bool:
    """Tell whether a verdict takes a pair for proof, and its variance is within the norm."""
    result = next((result for result in verdict.sensors if result.name == sensor.name), None)
    return (result is not None and pair.n > 0
            and result.headline.startswith(say_that_it_complies(sensor, pair))
            and pair.variance_deg2 is not None
            and pair.variance_deg2 <= result.sigma_max_deg ** 2)
