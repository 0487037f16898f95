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

"""The sensors that are compared: those of the setting `sensors`, or two."""

from __future__ import annotations

from heading_intercompare.core.sensor_table import (
    find_reference,
    list_tested,
    read_sensors,
    Sensor,
)
from heading_intercompare.core.settings import Settings


def list_sensors(settings: Settings) -> tuple[Sensor, ...]:
    """Return the sensors of `sensors`; without that setting the TS `ts` and the RS `rs`."""
    if settings.sensors is not None:
        return read_sensors(settings.sensors)
    return (Sensor('ts', topic=settings.ts_topic, convention=settings.ts_convention,
                   unit=settings.ts_unit),
            Sensor('rs', 'rs', topic=settings.rs_topic, convention=settings.rs_convention,
                   unit=settings.rs_unit))


def pair_with_reference(settings: Settings) -> tuple[tuple[Sensor, Sensor], ...]:
    """Return each tested sensor with the reference; empty if no sensor is the reference."""
    sensors = list_sensors(settings)
    reference = find_reference(sensors)
    return () if reference is None else tuple(
        (sensor, reference) for sensor in list_tested(sensors))
