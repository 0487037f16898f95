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

"""Common situations, simulated and as csv: outcome, reason, words and exit code."""

from __future__ import annotations

import json

from command_line import NORMS
import numpy as np
import pytest

from heading_intercompare.cli import main

SHIP = """\
title: A ship that turns
duration_s: 1200
start_utc: '2026-03-01T09:00:00Z'
seed: 7
latitude_deg: 54.3
longitude_deg: 10.2
seaway: ss3
motion_hz: {motion_hz}
legs: 0 45 12; 180 90 12; 420 180 10; 720 300 10; 960 20 12
ts: {{model: ideal, rate_hz: 10, white_deg: 0.1{ts}}}
rs: {{model: ideal, rate_hz: 10, white_deg: 0.05, phase_s: 0.03{rs}}}
"""

SIMULATED = {
    'sound': ('', '', 0, 'compliant', 'upper_bound_within_acceptance_limit', 'COMPLIANT for'),
    'quarter turn': (', faults: 0 rotated 90', '', 3, 'indeterminate', 'void.convention',
                     'VOID: TS - RS is near'),
    'half turn': (', faults: 0 jump 180', '', 3, 'indeterminate', 'void.convention',
                  'VOID: TS - RS is near'),
    'ENU for NED': (', faults: 0 mirrored 90', '', 3, 'indeterminate', 'void.convention',
                    'VOID: TS turns against RS'),
    'thirty degrees': (', offset_deg: 30', '', 3, 'indeterminate', 'void.mean_difference',
                       'VOID: the mean difference is'),
    'five degrees': (', offset_deg: 5', '', 4, 'compliant',
                     'upper_bound_within_acceptance_limit', 'DOUBTFUL: the mean difference is'),
    'freezes in a turn': (', faults: 410 freeze 0 60', '', 3, 'indeterminate', 'void.frozen',
                          'VOID: the TS froze'),
    'reference freezes': ('', ', faults: 410 freeze 0 60', 3, 'indeterminate', 'void.frozen',
                          'VOID: the RS froze'),
    'most readings lost': (', dropout: 0.6', '', 3, 'indeterminate', 'void.losses',
                           '% lost'),
    'some readings lost': (', dropout: 0.3', '', 4, 'compliant',
                           'upper_bound_within_acceptance_limit', 'DOUBTFUL: 30 % lost'),
    'a clock that is late': (', faults: 0 clock_step 1.5', '', 4, 'non_compliant',
                            'lower_bound_above_rejection_limit', 'DOUBTFUL: a latency or '
                            'clock offset of'),
    'too noisy': (', markov_deg: 0.6, markov_tau_s: 5', '', 1, 'non_compliant',
                  'lower_bound_above_rejection_limit', 'NON-COMPLIANT'),
}


def verdict_of(arguments, capsys):
    """Return exit code, JSON and the first line of the screen."""
    code = main(['analyze', *map(str, arguments), *NORMS, '--check', '--quiet'])
    screen = capsys.readouterr().out
    assert main(['analyze', *map(str, arguments), *NORMS, '--json', '-', '--quiet']) == 0
    return code, json.loads(capsys.readouterr().out), screen.splitlines()[0]


def sail(tmp_path, capsys, ts, rs, motion_hz):
    """Simulate the ship; return what `verdict_of` does."""
    scenario = tmp_path / 'ship.yaml'
    scenario.write_text(SHIP.format(ts=ts, rs=rs, motion_hz=motion_hz), encoding='utf-8')
    assert main(['simulate', '--scenario', str(scenario), '-o', str(tmp_path / 'bag'),
                 '--quiet']) == 0
    capsys.readouterr()
    return verdict_of([tmp_path / 'bag'], capsys)


@pytest.mark.slow
@pytest.mark.parametrize('name', SIMULATED)
def test_a_simulated_trial_gets_outcome_reason_and_words(name, tmp_path, capsys):
    ts, rs, expected_code, outcome, reason, words = SIMULATED[name]
    # The motion would name most of these errors first.
    code, verdict, line = sail(tmp_path, capsys, ts, rs, motion_hz=0)
    (run,) = verdict['runs']
    assert (verdict['outcome'], run['reason']) == (outcome, reason)
    assert words in line and line == f'VERDICT: {verdict["headline"]}'
    assert code == expected_code


@pytest.mark.slow
@pytest.mark.parametrize('ts, rs, words', [
    (', faults: 0 jump 180', '', 'the TS points 180 deg off the course over ground'),
    (', offset_deg: 45', ', offset_deg: 45', 'off the course over ground'),
    ('', ', offset_deg: 120', 'the RS points 120 deg off the course over ground')])
def test_the_motion_of_the_simulated_ship_names_the_sensor_that_is_wrong(
        ts, rs, words, tmp_path, capsys):
    code, verdict, line = sail(tmp_path, capsys, ts, rs, motion_hz=1)
    assert (code, verdict['runs'][0]['reason']) == (3, 'void.motion')
    assert words in line


def columns(rng):
    """Return stamps (s), TS and RS headings of a ship that turns and yaws."""
    t = np.arange(1, 9001) * 0.1
    ship = 90.0 + 40.0 * np.sin(2.0 * np.pi * t / 600.0) + np.sin(2.0 * np.pi * t / 8.0)
    return (t, ship + 0.1 * rng.standard_normal(t.size),
            np.round(ship + 0.05 * rng.standard_normal(t.size), 3))


def delayed(t, heading, by_s):
    return np.interp(t - by_s, t, heading)


def filtered(t, heading, tau_s):
    out = np.empty_like(heading)
    out[0] = heading[0]
    a = 0.1 / tau_s
    for k in range(1, heading.size):
        out[k] = out[k - 1] + a * (heading[k] - out[k - 1])
    return out


CSV = {
    'the reference twice': lambda t, ts, rs, rng: rs,
    'the reference late': lambda t, ts, rs, rng: np.roll(rs, 3),
    'the reference rounded': lambda t, ts, rs, rng: np.round(rs, 2),
    'the reference with noise': lambda t, ts, rs, rng: rs + 0.02 * rng.standard_normal(t.size),
    'the reference filtered': lambda t, ts, rs, rng: filtered(t, rs, 1.0),
}


@pytest.mark.slow
@pytest.mark.parametrize('name', CSV)
def test_one_source_in_a_csv_of_pairs_is_void(name, tmp_path, capsys, rng):
    t, ts, rs = columns(rng)
    ts = CSV[name](t, ts, rs, rng)
    code, verdict, line = verdict_of([written(tmp_path, t, ts, rs)], capsys)
    assert (code, verdict['runs'][0]['reason']) == (3, 'void.same_source')
    assert 'VOID: TS and RS look like one sensor' in line


def test_one_bad_reading_in_a_csv_is_named(tmp_path, capsys, rng):
    t, ts, rs = columns(rng)
    ts[4500] += 60.0
    code, verdict, line = verdict_of([written(tmp_path, t, ts, rs)], capsys)
    assert (code, verdict['runs'][0]['reason']) == (3, 'outliers_decide')
    assert 'DOUBTFUL: 1 isolated outlier decides' in line


def written(folder, t, ts, rs):
    """Write pairs as csv."""
    path = folder / 'pairs.csv'
    rows = [f'{1700000000 + s:.1f},{a % 360.0:.4f},{b % 360.0:.4f}'
            for s, a, b in zip(t.tolist(), ts.tolist(), rs.tolist())]
    path.write_text('\n'.join(['stamp_s,ts_deg,rs_deg', *rows, '']), encoding='utf-8')
    return path
