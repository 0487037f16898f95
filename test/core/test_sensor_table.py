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

"""The table of sensors: names, topics, one reference or none."""

from __future__ import annotations

import pytest

from heading_intercompare.core.decision.coverage import SENSOR_CLASSES
from heading_intercompare.core.declared_settings import SettingsError
from heading_intercompare.core.sensor_table import (
    describe_driver,
    find_reference,
    read_sensors,
    SENSOR_CLASS_NAMES,
)
from heading_intercompare.core.settings import Settings


def test_sensors_with_a_reference():
    sensors = read_sensors('gyro topic=/gyro/imu sigma_max_deg=0.5 sensor_class=gyrocompass\n'
                           'gnss sigma_max_deg=0.1 rs installation_offset_deg=-1.5')
    gyro, gnss = sensors
    assert (gyro.name, gyro.heading_topic, gyro.sigma_max_deg) == ('gyro', '/gyro/imu', 0.5)
    assert (gnss.heading_topic, gnss.installation_offset_deg) == ('gnss/heading', -1.5)
    assert find_reference(sensors) is gnss and not gyro.is_reference
    assert find_reference(sensors[:1]) is None
    assert read_sensors(None) == read_sensors('') == ()


def test_a_row_says_how_its_sentences_are_read():
    gyro, gnss = read_sensors('gyro talker=HE own_sentence="PXYZ,ATT heading=3 unit=rad"; gnss rs')
    assert describe_driver(gyro) == {'talker': 'HE', 'own_sentence': 'PXYZ,ATT heading=3 unit=rad'}
    assert describe_driver(gnss) == {}


@pytest.mark.parametrize('text, said', [
    ('gyro', 'has one sensor, gyro'),
    ('gyro rs; gnss rs', 'gyro and gnss are both the reference'),
    ('gyro topic=a/b; gnss topic=/a/b', 'gnss has the topic /a/b of gyro'),
    ('gyro sigma_max_deg=0; gnss', 'sigma_max_deg = 0.0: must be greater than 0'),
    ('gyro sensor_class=magnet; gnss', "sensor_class = 'magnet': must be"),
    ('gyro name=other; gnss', 'the first word of the row is the name'),
])
def test_a_mistake_is_a_mistake_of_the_settings(text, said):
    with pytest.raises(SettingsError, match='^sensors, ') as error:
        Settings.of(sensors=text)
    assert said in str(error.value)


def test_the_classes_are_those_with_a_slowest_error():
    assert {*SENSOR_CLASS_NAMES} == {*SENSOR_CLASSES}


@pytest.mark.parametrize('table', ['', '  \n', '# none', ';'])
def test_a_table_without_rows_compares_ts_and_rs(table):
    assert Settings.of(sensors=table).sensors is None
