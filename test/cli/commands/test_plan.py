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
    ([*GIVEN, '--json', '/'], '--json /: is a folder')])
def test_a_mistake_is_one_line(arguments, words, capsys):
    err = refusal(capsys, 'plan', *arguments)
    assert words in err
