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

"""The command observe: what it prints, writes and refuses."""

from __future__ import annotations

from importlib.util import find_spec
import json

from command_line import refusal
import pytest

from heading_intercompare.cli import main
from heading_intercompare.core.norm_tests.judged_test import STATES

NORM = ('--set', 'norms.systematic_max_deg=0.75')
START = 1_773_136_800


@pytest.fixture(autouse=True)
def place(tmp_path, monkeypatch):
    """Work in a folder with ten minutes of a TS that shows 73.6, and a table of a quay."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / 'gyro.csv').write_text('t_ns,heading_deg\n' + ''.join(
        f'{START + t}000000000,73.6\n' for t in range(600)))
    (tmp_path / 'quay.csv').write_text(
        'stamp_utc;fore_m;aft_m;base_m;side;note;weather\n' + ''.join(
            f'2026-03-10 10:{m:02d}:00;1,5{m % 3};1,50;80;port;no {m};calm\n'
            for m in range(1, 9)) + '2026-03-10 12:00:00;1,5;1,5;80;port;late;calm\n')
    return tmp_path


def test_it_prints_each_correction_the_budget_and_the_decision(capsys):
    code = main(['observe', 'gyro.csv', 'quay.csv', '--bearing', '73,42', '--common-u-deg', '0.05',
                 *NORM, '--check'])
    out, err = capsys.readouterr()
    assert code == 0 and err == 'note: quay.csv: column weather is not read\n'
    assert '2026-03-10 10:01:00.000        73.427    73.600     -0.173' in out
    assert 'not used: 1 outside_the_log' in out and 'too much' in out
    for words in ('scatter of 8 observations, 7 degrees of freedom', 'TS in steps of 0.1 deg',
                  'expanded, 95 %', 'VERDICT: COMPLIANT: ',
                  'cannot decide: the standard deviation', 'It covers the hours'):
        assert words in out


@pytest.mark.parametrize('norm, code', [('0.75', 0), ('0.02', 1), ('0.2', 3)])
def test_the_exit_code_is_the_outcome(norm, code):
    assert main(['observe', 'gyro.csv', 'quay.csv', '--bearing', '73.42', '--common-u-deg',
                 '0.05', '--set', f'norms.systematic_max_deg={norm}', '--check']) == code


@pytest.mark.parametrize('limit,state', [(0.75, 'met'), (0.02, 'not_met'), (0.2, 'open')])
def test_the_settle_point_is_a_test_of_the_norm(limit, state, capsys):
    arguments = ['observe', 'gyro.csv', 'quay.csv', '--bearing', '73.42', '--common-u-deg', '0.05',
                 '--set', f'norms.tests=settle_point {limit:g}']
    assert main(arguments) == 0
    assert (f'limit {limit:g} deg (norms.tests): {STATES[state]}\n') in capsys.readouterr().out
    assert main([*arguments, '--json', '-']) == 0
    [test] = json.loads(capsys.readouterr().out)['norm_tests']
    assert (test['kind'], test['state'], test['record']) == (
        'settle_point', state, '8 observations')


def test_the_json_has_every_figure_of_the_text(capsys, place):
    arguments = ['observe', 'gyro.csv', 'quay.csv', '--bearing', '73.42', '--common-u-deg', '0.05',
                 *NORM, '--json']
    assert main([*arguments, '-']) == 0
    found = json.loads(capsys.readouterr().out)
    assert found['schema'] == 'heading_intercompare/observations/1'
    assert (found['outcome'], found['n'], len(found['observations'])) == ('compliant', 8, 8)
    assert found['observations'][0]['note'] == 'no 1'
    assert found['not_used'] == {'outside_the_log': 1}
    assert found['settings']['norms.systematic_max_deg'] == 0.75
    assert [c['name'] for c in found['components']][:2] == ['observations', 'common']
    assert main([*arguments, 'out.json', '--quiet']) == 0
    assert json.loads((place / 'out.json').read_text())['correction_deg'] == (
        found['correction_deg'])


def test_a_table_with_the_readings_needs_no_recording(capsys, place):
    (place / 'sun.csv').write_text('time,ts_bearing_deg\n2026-03-10 08:00:00,120.4\n'
                                   '2026-03-10 08:05:00,121.6\n')
    if find_spec('ephem') is None:
        assert 'install heading_intercompare[sun]' in refusal(
            capsys, 'observe', 'sun.csv', '--sun', '--position', '54.3 10.2',
            '--common-u-deg', '0.3')
        return
    assert main(['observe', 'sun.csv', '--sun', '--position', '54.3 10.2', '--common-u-deg', '0.3',
                 *NORM]) == 0
    assert 'deg above the horizon' in capsys.readouterr().out


def test_a_recording_without_the_time_of_any_observation_is_no_crash(capsys, place):
    (place / 'late.csv').write_text('time,true_heading_deg\n2027-03-10 08:00:00,73.5\n')
    assert main(['observe', 'gyro.csv', 'late.csv', '--common-u-deg', '0', *NORM]) == 0
    assert 'INDETERMINATE: no observation with a TS reading' in capsys.readouterr().out


@pytest.mark.parametrize('arguments, says', [
    (('gyro.csv', 'quay.csv', '--bearing', '73'), 'give --common-u-deg'),
    (('gyro.csv', 'quay.csv', '--common-u-deg', '0'), 'line 2: has no true bearing'),
    (('gyro.csv', 'quay.csv', '--bearing', 'N'), '--bearing N: must be a number'),
    (('gyro.csv', 'quay.csv', '--bearing', '7', '--sun'), 'not allowed with'),
    (('gyro.csv', 'quay.csv', '--line', '54 10 54 10', '--common-u-deg', '0'),
     'give --point-u-m'),
    (('gyro.csv', 'quay.csv', '--line', '54 10 54 10', '--point-u-m', '1', '--common-u-deg',
      '0'), 'one point'),
    (('gyro.csv', 'quay.csv', '--bearing', '7', '--point-u-m', '1', '--common-u-deg', '0'),
     'is for --line and --mark'),
    (('gyro.csv', 'quay.csv', '--position', '99 9', '--common-u-deg', '0'),
     "--position '99 9': must be"),
    (('gyro.csv', 'quay.csv', '--common-u-deg', '-1'), "'-1' must be a number of at least 0"),
    (('none.csv', 'quay.csv', '--bearing', '7', '--common-u-deg', '0'), 'none.csv: '),
    (('gyro.csv', 'none.csv', '--common-u-deg', '0'), 'none.csv: No such file'),
    (('gyro.csv', 'quay.csv', '--bearing', '7', '--common-u-deg', '0', '--json', 'quay.csv'),
     'is an INPUT'),
])
def test_what_is_wrong_is_said_in_one_line(capsys, arguments, says):
    assert says in refusal(capsys, 'observe', *arguments)
