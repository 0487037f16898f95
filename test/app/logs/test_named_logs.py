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

"""Logs by the names of their sensors, and what a bag says was lost."""

from __future__ import annotations

import pytest
from ship_of_sensors import make_three, TABLE, write_bag, write_log

from heading_intercompare import judge_logs
from heading_intercompare.app.inputs import judge_input
from heading_intercompare.app.logs.trial_logs import name_logs
from heading_intercompare.core.settings import Settings
from heading_intercompare.drivers.settings import DriverSettings

SETTINGS = Settings.of(sensors=TABLE)


def test_inputs_name_their_sensors():
    assert name_logs(['gnss=c.log', 'gyro1=a=b.log', 'gyro2=b.log'], SETTINGS) == {
        'gnss': 'c.log', 'gyro1': 'a=b.log', 'gyro2': 'b.log'}
    # A file may have = in its name.
    assert name_logs(['bag', 'x=1/bag'], SETTINGS) is None


@pytest.mark.parametrize('inputs, said', [
    (['gyro1=a', 'bag'], 'bag: must be NAME=LOG with a sensor of the settings: gyro1, gyro2, '
     'gnss'),
    (['gyro1=a', 'gyro3=b'], 'gyro3=b: must be NAME=LOG'),
    (['gyro1=a', 'gyro1=b'], 'gyro1=b: gyro1 has the log a already'),
    (['gyro1=a', 'gyro2=b'], 'gnss: has no log; give gnss=LOG'),
])
def test_a_wrong_name_is_refused_in_one_line(inputs, said):
    with pytest.raises(ValueError) as error:
        name_logs(inputs, SETTINGS)
    assert said in str(error.value)


def test_one_log_of_several_talkers(tmp_path):
    headings = make_three()
    lines = []
    for name, talker in (('gyro1', 'HE'), ('gyro2', 'II'), ('gnss', 'GP')):
        file = write_log(tmp_path / f'{name}.log', headings[name], talker)
        lines += file.read_text().splitlines()
    ship = tmp_path / 'ship.log'
    ship.write_text('\n'.join(sorted(lines)) + '\n')
    rows = 'gyro1 talker=HE\ngyro2 talker=II\ngnss talker=GP rs'
    settings = Settings.of(sensors=rows, sigma_max_deg=0.3, sigma_ref_max_deg=0.1)
    judged = judge_logs(dict.fromkeys(headings, str(ship)), settings)
    assert [entry.ts_topic for entry in judged.sensors.inputs] == ['HEHDT', 'IIHDT', 'GPHDT']
    assert [(entry.ts_topic, entry.rs_topic) for entry in judged.verdicts['gyro2'].inputs] == [
        ('IIHDT', None), (None, 'GPHDT')]
    for verdict in judged.verdicts.values():
        assert verdict.runs[0].std_deg < 0.3


def test_notes_of_a_bag_name_it(tmp_path):
    path = str(write_bag(tmp_path / 'trial', make_three()))
    judged = judge_input(path, SETTINGS, name='night')
    assert judged.entries[0].path == 'night' and judged.entries[0].sha256
    assert judged.notes == [] and {*judged.earlier} == {'gyro1', 'gyro2'}


def test_the_driver_of_ts_does_not_read_the_log_of_rs(tmp_path):
    headings = make_three()
    logs = {'ts': str(write_log(tmp_path / 'ts.log', headings['gyro1'], 'HE')),
            'rs': str(write_log(tmp_path / 'rs.log', headings['gnss'], 'GP'))}
    settings = Settings.of(sigma_max_deg=0.3, sigma_ref_max_deg=0.1)
    judged = judge_logs(logs, settings, {'ts': DriverSettings(talker='HE')})
    assert [(entry.ts_topic, entry.rs_topic) for entry in judged.verdict.inputs] == [
        ('HEHDT', None), (None, 'GPHDT')]
