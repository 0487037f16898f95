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

"""The command `plan`: a table, the same plan as JSON, and mistakes in one line."""

from __future__ import annotations

import json

from command_line import refusal
import pytest

from heading_intercompare.cli import main

NORMS = ['--set', 'norms.sigma_max_deg=0.2', '--set', 'norms.sigma_ref_max_deg=0.01']
GIVEN = [*NORMS, '--set', 'risk.slowest_error_s=30', '--slow-share', '0.2', '--rate', '0.5',
         '--trials', '60', '--quiet']


def test_the_table_says_how_long_to_measure(capsys, tmp_path):
    assert main(['plan', *GIVEN, '--json', str(tmp_path / 'p.json')]) == 0
    out = capsys.readouterr().out
    plan = json.loads((tmp_path / 'p.json').read_text())
    assert out.startswith('a run must last 10 min to comply; the slowest error stated is 30 s\n')
    assert '\none run of 10 min ' in out and out.index('5 runs of 5 min ') < out.index('one run')
    assert 'to certify with probability 0.8 a TS at\n  0.5 of its norm: 5 runs of 5 min (25 min ' \
        'in all); or one run of 10 min\n' in out
    assert 'set campaign.rule=sensor, and wait at least 30 s between runs' in out
    assert plan['least_s'] == 600.0 and plan['levels'] == [0.5, 0.7, 0.85]
    assert len(out.splitlines()) == 13 + len(plan['chances']) // 3 + len(plan['remedies'])
    assert plan['total_s'] == 600.0 and 'a TS at 0.7 of its norm (10 min measured in all)' in out
    assert main(['plan', *GIVEN, '--json', '-']) == 0
    assert json.loads(capsys.readouterr().out) == plan


@pytest.mark.parametrize('arguments, words', [
    (NORMS, 'risk.slowest_error_s is missing'),
    (['--set', 'risk.sensor_class=ins'], 'norms.sigma_max_deg is missing'),
    ([*GIVEN, '--rate', '-1'], 'rate_hz = -1.0: must be greater than 0'),
    ([*GIVEN, '--seed', '-1'], '--seed -1: must be at least 0'),
    ([*GIVEN, '--trials', '0'], '--trials 0: must be at least 1'),
    ([*GIVEN, '--json', '/'], '--json /: is a folder'),
    ([*GIVEN, '--plot', 'a.gif'], 'a.gif: a picture must end in .png or .pdf or .svg'),
    ([*GIVEN, '--page', 'a.png'], '--page a.png: must end with .html'),
    ([*GIVEN, '--hours', '5'], '--hours 5: is for --scenario; leave it out'),
    ([*GIVEN, '--jobs', '2'], '--jobs 2: is for --scenario; leave it out'),
    ([*NORMS, '--scenario', 'demo', '--rate', '2'], '--rate 2: the scenario says it'),
    ([*NORMS, '--scenario', 'demo', '--slow-share', '0.2'],
     '--slow-share 0.2: the scenario says it; leave it out'),
    ([*NORMS, '--scenario', 'demo', '--hours', '-1'], '--hours -1: must be greater than 0'),
    ([*NORMS, '--scenario', 'no_such'], '--scenario no_such: is neither a file nor one of'),
    (['--scenario', 'demo'], 'norms.sigma_max_deg is missing'),
    ([*NORMS, '--scenario', 'demo', '--hours', '1e9'], 'duration_s = ')])
def test_a_mistake_is_one_line(arguments, words, capsys):
    err = refusal(capsys, 'plan', *arguments)
    assert words in err


@pytest.mark.slow
def test_a_scenario_is_planned_for_by_its_verdicts(capsys, tmp_path):
    """Errors of 0.1 degrees against a norm of 0.2: six minutes are enough, one is not."""
    pytest.importorskip('matplotlib')
    trial = tmp_path / 'trial.yaml'
    trial.write_text('title: Many & few\nduration_s: 120\nseed: 5\nlegs: 0 20 8; 60 90 8\n'
                     'ts: {white_deg: 0.1, rate_hz: 4}\nrs: {white_deg: 0.004, rate_hz: 4}\n')
    words = ['plan', *NORMS, '--set', 'risk.slowest_error_s=5', '--scenario', str(trial),
             '--hours', '0.1', '--trials', '3', '--quiet']
    plot, page = tmp_path / 'p.svg', tmp_path / 'p.html'
    assert main([*words, '--json', str(tmp_path / 'p.json'), '--plot', str(plot), '--page',
                 str(page)]) == 0
    out = capsys.readouterr().out
    plan = json.loads((tmp_path / 'p.json').read_text())
    assert out.startswith('trial.yaml: 360 s, seeds 5 to 7: Many & few\nTS: true standard ')
    assert f'{plan["ts"]["std_deg"]:.4f} deg' in out and '0.50 of its norm of 0.2 deg' in out
    rows = [' '.join(line.split()) for line in out.splitlines()]
    assert '45 s 0 (0 to 71) 0 (0 to 71) 100 (29 to 100)' in rows
    assert '6 min 100 (29 to 100) 0 (0 to 71) 0 (0 to 71)' in rows
    assert 'to certify this TS with probability 0.8: one run of 2 min' in rows
    assert 'outcomes of 6 min: 3 compliant: upper_bound_within_acceptance_limit' in rows
    assert plan['scenario'] == 'trial.yaml' and plan['seeds'] == [5, 6, 7]
    assert [chance['compliant'] for chance in plan['chances']][::5] == [0.0, 1.0]
    assert '<svg' in plot.read_text() and page.read_text().count('<svg') == 1
    assert '<h1>Many &amp; few</h1>' in page.read_text()
    assert main([*words, '--json', '-']) == 0
    assert json.loads(capsys.readouterr().out) == plan


@pytest.mark.parametrize('option', ['--json', '--plot', '--page'])
def test_the_scenario_is_not_overwritten(option, tmp_path, capsys):
    trial = tmp_path / 'trial.yaml'
    trial.write_text('duration_s: 120\n')
    err = refusal(capsys, 'plan', *NORMS, '--scenario', trial, option, trial)
    assert f'{option} {trial}: that is an INPUT; name another file' in err


def test_the_figure_of_a_plan_by_norms_shows_the_levels(tmp_path, capsys):
    pytest.importorskip('matplotlib')
    assert main(['plan', *GIVEN, '--trials', '2', '--plot', str(tmp_path / 'p.svg')]) == 0
    text = (tmp_path / 'p.svg').read_text()
    assert all(f'TS at {level} of its norm' in text for level in (0.5, 0.7, 0.85))


def test_a_plan_by_a_named_norm_says_what_to_sail_for_each_of_its_tests(capsys):
    words = ['plan', '--set', 'norms.preset=imo_msc116', '--set', 'norms.sigma_ref_max_deg=0.2',
             '--set', 'risk.slowest_error_s=30', '--trials', '2', '--quiet']
    assert main(words) == 0
    out = capsys.readouterr().out
    assert ('  follow-up error up to 10 deg/s (limit 0.5 deg): a zigzag or full circles, to port '
            'and to starboard, as fast as the ship turns, 1 deg/s or more\n') in out
    assert ('  amplitude of the dynamic error of periods below 30 s (limit 0.5 deg): not decided: '
            'needs an RS of 0.18 deg') in out
    assert main([*words, '--json', '-']) == 0
    tests = json.loads(capsys.readouterr().out)['tests']
    assert len(tests) == 6 and sum(bool(test['obstacle']) for test in tests) == 1


@pytest.mark.slow
def test_a_plan_by_a_scenario_counts_the_tests_of_its_trials(capsys, tmp_path):
    trial = tmp_path / 'trial.yaml'
    legs = '; '.join(f'{60 * k} {60 if k % 2 else 300} 8' for k in range(15))
    trial.write_text(f'duration_s: 900\nturn_deg_s: 2\nlegs: {legs}\n'
                     'ts: {model: ideal, white_deg: 0.05, stamp_offset_s: 0.4}\n'
                     'rs: {model: ideal, white_deg: 0.02}\n')
    words = ['plan', *NORMS, '--set', 'norms.tests=follow_up 0.05 0-2; static_error 0.5',
             '--scenario', str(trial), '--trials', '2', '--quiet']
    assert main(words) == 0
    out = capsys.readouterr().out
    assert 'tests of the norm in 15 min, of 2 trials:\n' in out
    assert '  follow-up error up to 2 deg/s: 2 not met\n  static error: 2 not sailed\n' in out
