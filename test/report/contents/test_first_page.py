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

"""The first page says the verdict in words, and what it rests on, covers and needs."""

from __future__ import annotations

from dataclasses import replace

import pytest

from heading_intercompare import Outcome
from heading_intercompare.report.contents.first_page import compose_first_page

LONG = {'risk__min_duration_s': 60.0}


def facts(verdict):
    return dict(compose_first_page(verdict).facts)


def test_a_certificate_says_what_it_covers(made):
    page = compose_first_page(made(1, **LONG)[0])
    assert (page.kind, page.word, page.sign) == ('compliant', 'COMPLIANT', '✓')
    assert page.means == 'The tested sensor meets its norm.' and page.runs == []
    told = dict(page.facts)
    assert told['covers'].startswith('it holds for errors that change within 30 s')
    assert told['validity'] == 'no condition of the comparison is violated'
    assert told['rests on'].startswith('1 run of 10 min analysed, 600 differences')
    assert ' ± ' in told['measured'] and 'to be at most 0.09 deg²' in told['measured']


def test_it_names_the_norms_and_when_it_was_issued(made):
    assert facts(made(0, trial__issue_date='2026-03-05')[0])['date of issue'] == '2026-03-05'
    shown = facts(made(0, norms__sigma_max_deg=0.25)[0])
    assert shown['date of issue'] == ''
    assert shown['norms'] == ('standard deviation of the TS at most 0.25 deg, of the RS at most '
                              '0.1 deg')


def test_a_rejection_and_an_open_verdict_differ_in_sign_kind_and_words(made):
    bad, short = (compose_first_page(made(1, **more)[0]) for more in (
        {'noise_deg': 0.6}, {}))
    assert (bad.kind, bad.sign) == ('non-compliant', '✗') and 'does not meet' in bad.means
    assert (short.kind, short.sign) == ('indeterminate', '?') and 'open' in short.means
    assert dict(short.facts)['why'].endswith('measure 10 min (0.17 h) in all')
    assert dict(short.facts)['covers'] == 'nothing, because the verdict is open'
    assert 'to be at most' not in dict(short.facts)['measured']


def test_a_void_comparison_gives_no_outcome_of_the_paper(made):
    verdict = made(1)[0]
    run = replace(verdict.runs[0], validity_effect='void', reason='void.convention')
    page = compose_first_page(replace(verdict, validity_effect='void', runs=[run]))
    assert (page.kind, page.word) == ('void', 'INDETERMINATE, VOID')
    assert 'says nothing' in page.means and 'GK as printed' not in dict(page.facts)
    assert 'measure again' in dict(page.facts)['why']


def test_a_doubt_stands_in_the_word(made):
    verdict = made(1, **LONG)[0]
    one = replace(verdict.runs[0].validity[0], effect='doubtful', words='it creaks')
    run = replace(verdict.runs[0], validity_effect='doubtful', validity=(one,))
    page = compose_first_page(replace(verdict, validity_effect='doubtful', runs=[run]))
    assert page.word == 'COMPLIANT, DOUBTFUL'
    assert dict(page.facts)['validity'] == 'DOUBTFUL: it creaks'
    runs = [replace(run, run=number) for number in (1, 2, 3)]
    told = facts(replace(verdict, validity_effect='doubtful', runs=runs))['validity']
    assert told == 'DOUBTFUL: it creaks (run 1 and 2 more)'


@pytest.mark.parametrize('runs, lines', [(2, 3), (8, 9), (9, 10)])
def test_several_runs_have_a_line_each_the_worst_first_and_many_are_cut(made, runs, lines):
    verdict = made(runs, n=200)[0]
    worst = max(verdict.runs, key=lambda run: run.std_deg)
    page = compose_first_page(verdict)
    assert len(page.runs) == lines and page.runs[0] == f'0 of {runs} runs comply'
    assert page.runs[1].startswith(f'run {worst.run} alone: ')
    assert ('1 more' in page.runs[-1]) == (runs == 9)


def test_runs_judged_as_one_sensor_need_a_total_length(made):
    told = facts(made(3, n=150, campaign__rule='sensor')[0])
    assert told['why'].endswith('measure 10 min (0.17 h) in all')
    good = made(5, n=400, campaign__rule='sensor')[0]
    assert good.outcome is Outcome.COMPLIANT
    assert 'from run to run' in facts(good)['covers']


def test_without_a_run_there_is_nothing(made):
    told = facts(made(0)[0])
    assert told['rests on'].startswith('No run') and told['covers'] == 'nothing'
    assert told['validity'] == 'not examined'


def test_of_several_open_runs_the_one_that_needs_longest_is_named(made):
    verdict = made(3, n=200)[0]
    runs = [replace(run, guarded=replace(run.guarded, hours_needed=hours))
            for run, hours in zip(verdict.runs, (0.5, 7.0, 2.0))]
    assert '(run 2: ' in facts(replace(verdict, runs=runs))['why']


def test_runs_judged_as_one_sensor_are_listed_without_what_each_alone_would_need(made):
    page = compose_first_page(made(3, n=200, campaign__rule='sensor')[0])
    assert len(page.runs) == 3 and not any('measure' in line for line in page.runs)
