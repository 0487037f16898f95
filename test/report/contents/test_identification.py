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

"""A protocol names its trial, its sensors and its verdict."""

from __future__ import annotations

from dataclasses import fields, replace

import pytest

from heading_intercompare import Settings, Trial, Verdict
from heading_intercompare.report.contents.identification import (
    identify,
    name_trial,
    verdict_id,
)


def named(**trial):
    return Settings.from_mapping({'trial': trial})


def test_every_name_of_the_settings_is_in_the_identification(made):
    words = {f.name: f'<{f.name}>' for f in fields(Trial)
             if f.default == '' and f.name != 'deviations'}
    figures = {'sea_state': 0, 'temperature_c': -2.5, 'ts_calibration_date': '2026-02-10',
               'rs_calibration_months': 24}
    verdict = made(0, **{f'trial__{name}': thing for name, thing in {**words, **figures}.items()})
    verdict = verdict[0]
    shown = {thing for _, rows in identify(verdict) for _, thing in rows}
    assert {*({**words, **figures, 'temperature_c': '-2.5'}).values()} - {0, 24} <= shown
    assert {'0', '24'} <= shown
    assert verdict.settings_sha256 in shown and verdict_id(verdict) in shown


def test_a_name_that_is_not_given_is_left_to_be_filled_in(made):
    rows = dict(row for _, rows in identify(made(0)[0]) for row in rows)
    for name in ('temperature at the sensors [°C]', 'supply of the sensors',
                 'sea state', 'these names stated by: name, date',
                 'filled in by hand by: name, date', 'TS: certificate or service log',
                 *(f'{sensor}: {what}' for sensor in ('TS', 'RS') for what in (
                     'date of the last calibration or service',
                     'interval of calibration [months]'))):
        assert rows[name] == ''
    assert rows['ship'] == rows['TS: serial number'] == rows['latitudes [deg]'] == ''


@pytest.mark.parametrize('given, words', [
    ({'latitude_min_deg': 53.5, 'latitude_max_deg': 54.0}, '53.5 to 54'),
    ({'latitude_max_deg': 54.0}, '54'), ({'latitude_min_deg': -1.0}, '-1'),
    ({'latitude_min_deg': 2.0, 'latitude_max_deg': 2.0}, '2')])
def test_the_latitudes_are_a_range(made, given, words):
    verdict = made(0, **{f'trial__{name}': value for name, value in given.items()})[0]
    assert dict(row for _, rows in identify(verdict) for row in rows)['latitudes [deg]'] == words


@pytest.mark.parametrize('day, months, date_cell, interval_cell', [
    ('2023-01-31', 12, '2023-01-31', '12, due on 2024-01-31'),
    ('2023-01-31', 13, '2023-01-31', '13, due on 2024-02-29'),
    ('2023-02-13', 9, '2023-02-13', '9, due on 2023-11-13, before the trial ended'),
    ('2023-02-14', 9, '2023-02-14', '9, due on 2023-11-14'),
    ('2023-11-15', None, '2023-11-15, after the trial', ''),
    ('2023-11-14', None, '2023-11-14', ''), (None, 12, '', '12')])
def test_a_calibration_says_when_the_next_is_due_and_whether_it_holds_the_trial(
        made, day, months, date_cell, interval_cell):
    """The run ends on 2023-11-14."""
    verdict = made(1, n=100, trial__ts_calibration_date=day, trial__ts_calibration_months=months)
    rows = dict(row for _, rows in identify(verdict[0]) for row in rows)
    assert rows['TS: date of the last calibration or service'] == date_cell
    assert rows['TS: interval of calibration [months]'] == interval_cell


def test_the_running_head_names_number_ship_and_sensor():
    assert name_trial(named(protocol_number='7', ship='MV Example', ts_maker='Acme',
                            ts_type='Gyro', ts_serial='12')) == '7, MV Example, Acme Gyro no. 12'
    assert name_trial(named(ts_serial='12')) == 'no. 12'
    assert name_trial(Settings()) == ''


def test_the_id_changes_with_the_verdict_and_survives_its_json(made):
    verdict = made(1)[0]
    assert verdict_id(Verdict.from_dict(verdict.to_dict())) == verdict_id(verdict)
    assert verdict_id(replace(verdict, headline='x')) != verdict_id(verdict)
    assert len(verdict_id(verdict)) == 32
