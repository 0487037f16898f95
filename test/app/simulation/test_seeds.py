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

"""A trial with many seeds."""

from __future__ import annotations

import math

import numpy as np
import pytest

from heading_intercompare.ahrs.settings import Scenario
from heading_intercompare.app.simulation.seeds import repeat_trial, Repeated, SeedResult
from heading_intercompare.cli import main
from heading_intercompare.core.settings import Settings

NORMS = Settings.from_mapping({'norms.sigma_max_deg': 0.3, 'norms.sigma_ref_max_deg': 0.1,
                               'risk.slowest_error_s': 5.0, 'motion.compare': False})
TRIAL = {'duration_s': 300.0, 'ts.offset_deg': 0.2, 'ts.white_deg': 0.15, 'ts.rate_hz': 4.0,
         'rs.white_deg': 0.05, 'rs.rate_hz': 4.0, 'legs': '0 20 8; 100 80 8'}


def made(seed, mean, low, high, covered=0.95):
    """Return the result of a seed."""
    return SeedResult(seed, 'compliant', mean, 0.1, (low, high), mean, 0.1, covered)


def test_the_seeds_of_a_trial_with_known_errors():
    """
    White errors of 0.15 and 0.05 degrees about 0.2: 1200 pairs.

    The mean error spreads by 0.15 / sqrt(1200) = 0.0043, the difference by 0.0046 degrees. With
    16 seeds a spread is known to 18 %; four times that is allowed.
    """
    repeated = repeat_trial(Scenario.from_mapping(TRIAL), range(3, 19), NORMS)
    assert [result.seed for result in repeated.results] == list(range(3, 19))
    for name, mean, spread in (('true_mean_deg', 0.2, 0.0043), ('mean_deg', 0.2, 0.0046)):
        values = repeated.values(name)
        assert values.mean() == pytest.approx(mean, abs=4.0 * spread / 4.0)
        assert values.std(ddof=1) == pytest.approx(spread, rel=0.72)
    assert repeated.values('true_std_deg') == pytest.approx(np.full(16, 0.15), rel=0.12)
    # Of normal errors, 95.4 % lie within twice the standard deviation that the sensor claims:
    # its offset of 0.2 is not in the claim, so fewer do.
    share = 0.5 * (math.erf((0.3 - 0.2) / 0.15 / math.sqrt(2.0))
                   + math.erf((0.3 + 0.2) / 0.15 / math.sqrt(2.0)))
    assert repeated.values('covered').mean() == pytest.approx(share, abs=0.02)
    within, judged = repeated.coverage
    assert judged == 16 and within >= 12
    assert next(repeated.words) == 'outcomes of 16 seeds: compliant 16'


def test_coverage_by_hand():
    """Four means of 0 and one of 1 with intervals of +-0.2: the fifth misses the others."""
    near = [made(k, 0.01 * k, 0.01 * k - 0.2, 0.01 * k + 0.2) for k in range(4)]
    assert Repeated(tuple(near)).coverage == (4, 4)
    far = made(4, 1.0, 0.8, 1.2)
    within, judged = Repeated((*near, far)).coverage
    assert judged == 5 and within == 4
    assert '4 of 5 seeds: 80% (28% to 99%)' in ' '.join(Repeated((*near, far)).words)


def test_seeds_without_a_run_are_not_counted():
    nothing = SeedResult(9, 'indeterminate', math.nan, math.nan, (math.nan, math.nan), math.nan,
                         math.nan, math.nan)
    repeated = Repeated((nothing, nothing))
    assert repeated.coverage == (0, 0)
    assert list(repeated.words) == ['outcomes of 2 seeds: indeterminate 2']


def test_the_same_seeds_give_the_same_figures():
    scenario = Scenario.from_mapping({**TRIAL, 'duration_s': 60.0})
    assert repeat_trial(scenario, (1, 2), NORMS) == repeat_trial(scenario, (1, 2), NORMS)


def test_the_command_says_and_draws_them(tmp_path, capsys):
    pytest.importorskip('matplotlib')
    trial = tmp_path / 'trial.yaml'
    trial.write_text('title: Many & few\nduration_s: 120\nseed: 5\nts: {white_deg: 0.1}\n'
                     'rs: {white_deg: 0.05}\n', encoding='utf-8')
    assert main(['simulate', '--scenario', str(trial), '--seeds', '4', '--page',
                 str(tmp_path / 'page.html'), '--set', 'norms.sigma_max_deg=0.3', '--set',
                 'norms.sigma_ref_max_deg=0.1']) == 0
    out = capsys.readouterr().out
    assert 'trial.yaml: 120 s, seeds 5 to 8: Many & few' in out
    assert 'outcomes of 4 seeds: ' in out and 'mean error of the TS: mean ' in out
    page = (tmp_path / 'page.html').read_text(encoding='utf-8')
    assert '<h1>Many &amp; few</h1>' in page and page.count('<svg') == 1


@pytest.mark.parametrize('words, told', [
    ([], '-o BAG: must be given, unless the trial is repeated with --seeds N'),
    (['--seeds', '3', '-o', 'bag'], '-o bag: no bag is written with --seeds; leave one out'),
    (['-o', 'bag', '--jobs', '2'], '--jobs 2: is for --seeds N; leave it out'),
    (['--seeds', '1'], '--seeds 1: must be between 2 and 10000'),
    (['-o', 'bag', '--page', 'a.png'], '--page a.png: must end with .html')])
def test_a_mistake_is_one_line(tmp_path, capsys, monkeypatch, words, told):
    monkeypatch.chdir(tmp_path)
    assert main(['simulate', '--scenario', 'demo', *words]) == 2
    error = capsys.readouterr().err
    assert told in error and len(error.strip().splitlines()) == 1
    assert not list(tmp_path.iterdir())
