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
    names = {f.name: f'<{f.name}>' for f in fields(Trial) if not f.name.startswith('latitude')}
    verdict = made(0, **{f'trial__{name}': text for name, text in names.items()})[0]
    shown = {thing for _, rows in identify(verdict) for _, thing in rows}
    assert {*names.values()} <= shown
    assert verdict.settings_sha256 in shown and verdict_id(verdict) in shown


def test_a_name_that_is_not_given_is_left_to_be_filled_in(made):
    rows = dict(row for _, rows in identify(made(0)[0]) for row in rows)
    for name in ('date of issue', 'temperature at the sensors [°C]', 'supply of the sensors',
                 'filled in by hand by: name, date',
                 'TS: last calibration or service, and its interval',
                 'RS: last calibration or service, and its interval'):
        assert rows[name] == ''
    assert rows['ship'] == rows['TS: serial number'] == rows['latitudes [deg]'] == ''


@pytest.mark.parametrize('given, words', [
    ({'latitude_min_deg': 53.5, 'latitude_max_deg': 54.0}, '53.5 to 54'),
    ({'latitude_max_deg': 54.0}, '54'), ({'latitude_min_deg': -1.0}, '-1'),
    ({'latitude_min_deg': 2.0, 'latitude_max_deg': 2.0}, '2')])
def test_the_latitudes_are_a_range(made, given, words):
    verdict = made(0, **{f'trial__{name}': value for name, value in given.items()})[0]
    assert dict(row for _, rows in identify(verdict) for row in rows)['latitudes [deg]'] == words


def test_the_running_head_names_number_ship_and_sensor():
    assert name_trial(named(protocol_number='7', ship='MV Example', ts_maker='Acme',
                            ts_type='Gyro', ts_serial='12')) == '7, MV Example, Acme Gyro no. 12'
    assert name_trial(named(ts_serial='12')) == 'no. 12'
    assert name_trial(Settings()) == ''


def test_the_id_changes_with_the_verdict_and_survives_its_json(made):
    verdict = made(1)[0]
    assert verdict_id(Verdict.from_dict(verdict.to_dict())) == verdict_id(verdict)
    assert verdict_id(replace(verdict, headline='x')) != verdict_id(verdict)
    assert len(verdict_id(verdict)) == 12
