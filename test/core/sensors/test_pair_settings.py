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

"""The settings of a pair: norms, angles, risks and names of both."""

from __future__ import annotations

import pytest

from heading_intercompare.core.declared_settings import SettingsError
from heading_intercompare.core.sensor_table import read_sensors
from heading_intercompare.core.sensors.pair_settings import check_sensors, settings_of_pair
from heading_intercompare.core.settings import Settings

TABLE = """
gyro1 topic=g1/imu sigma_max_deg=0.5 sensor_class=gyrocompass installation_offset_deg=1.5
gyro2 installation_offset_u_deg=0.3 serial="A 12" convention=ned \
slowest_error_s=400 calibration_months=12
gnss  sigma_max_deg=0.1 rs evidence=5/26 calibration_date=2026-03-01 \
installation_offset_deg=0.5 installation_offset_u_deg=0.4
"""


def of(first, second, **given):
    settings = Settings.of(sensors=TABLE, **{'sigma_max_deg': 0.3, **given})
    by_name = {one.name: one for one in read_sensors(TABLE)}
    return settings_of_pair(settings, by_name[first], by_name[second])


def test_a_pair_with_the_reference():
    found = of('gyro1', 'gnss', m_low=0.5, sigma_ref_deg=0.08)
    assert found.sensors is None
    assert (found.norms.sigma_max_deg, found.norms.sigma_ref_max_deg) == (0.5, 0.1)
    assert (found.norms.m_low, found.norms.sigma_ref_deg) == (0.5, 0.08)
    assert (found.ts_topic, found.rs_topic) == ('g1/imu', 'gnss/heading')
    assert found.installation_offset_deg == 1.0
    assert found.risk.sensor_class == 'gyrocompass'
    found = of('gyro2', 'gnss')
    assert (found.norms.sigma_max_deg, found.ts_convention) == (0.3, 'ned')
    assert found.installation_offset_u_deg == pytest.approx(0.5)
    assert (found.risk.slowest_error_s, found.trial.ts_serial) == (400.0, 'A 12')
    assert (found.trial.ts_calibration_months, found.trial.ts_calibration_date) == (12, None)
    assert (found.trial.rs_evidence, found.trial.rs_calibration_date) == ('5/26', '2026-03-01')


def test_what_is_known_of_the_reference_does_not_hold_for_another_partner():
    found = of('gyro1', 'gyro2', m_low=0.5, sigma_ref_deg=0.08, sigma_ref_max_deg=0.1)
    assert (found.norms.sigma_ref_max_deg, found.norms.m_low, found.norms.m_up,
            found.norms.sigma_ref_deg) == (0.3, 0.0, 1.0, None)


def test_a_preset_is_the_norm_of_a_sensor_without_one():
    settings = {'sigma_max_deg': None, 'preset': 'imo_a821', 'latitude_deg': 60.0}
    assert of('gyro1', 'gnss', **settings).norms.preset is None
    assert of('gyro2', 'gnss', **settings).norms.preset == 'imo_a821'
    assert of('gyro1', 'gyro2', **settings).norms.sigma_ref_max_deg > 0.3


def test_a_sensor_without_a_norm_is_named():
    with pytest.raises(SettingsError, match='^sensors, a and b: .*give sigma_max_deg'):
        check_sensors(Settings.of(sensors='a; b'))
    with pytest.raises(SettingsError, match='sensors: none'):
        check_sensors(Settings.of(sigma_max_deg=1.0))
