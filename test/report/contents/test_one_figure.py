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

"""A figure that stands on several pages of the protocol is the same one on all of them."""

from __future__ import annotations

from dataclasses import replace
import re

import numpy as np
import pytest
from trials import judge_turning_ship, make_settings, make_turning_ship

from heading_intercompare import analyze, Settings
from heading_intercompare.core.verdict.verdict_document import Input
from heading_intercompare.report.contents.decision_rule import describe_uncertainty
from heading_intercompare.report.contents.defaults import mark_default
from heading_intercompare.report.contents.file_names import name_files
from heading_intercompare.report.contents.first_page import compose_first_page
from heading_intercompare.report.contents.tables import GUARDED, RESULTS, rows_of, SUMMARY
from heading_intercompare.report.contents.uncertainty_budget import budget_of
from heading_intercompare.report.formatting import ABSENT

pytest.importorskip('jinja2')

from heading_intercompare.report import html  # noqa: E402

#: The figures of the first page that an annex has with all its digits: pattern, row of the annex.
IN_ANNEX = (
    (r'mean difference (\S+)', 'mean difference', RESULTS),
    (r'standard deviation of the differences (\S+) deg', 'standard deviation', RESULTS),
    (r'variance, at the stated risks, (\S+) to', "lower bound L of the variance, at the "
     "producer's risk", GUARDED),
    (r'variance, at the stated risks, \S+ to (\S+)', "upper bound U of the variance, at the "
     "consumer's risk", GUARDED),
    (r'to be at most (\S+)', 'acceptance limit A', GUARDED),
    (r'worth (\S+) independent', 'effective degrees of freedom of the variance', GUARDED))


def walk(n, rng):
    """Return errors that go on wandering."""
    slow = np.cumsum(rng.standard_normal(n))
    return 0.1 * rng.standard_normal(n) + 0.3 * (slow - slow.mean()) / slow.std()


def slow_wave(n):
    """Return errors with one long wave."""
    return 0.1 * np.sin(np.arange(n) * 2.0 * np.pi / n) + 0.2 * np.sin(np.arange(n) / 2.0)


def judged(case, rng):
    """Return the verdict of a case."""
    if case in ('walking', 'wave'):
        error_deg = walk(2000, rng) if case == 'walking' else slow_wave(3000)
        ts, rs = make_turning_ship(0, error_deg, 0.02 * rng.standard_normal(len(error_deg)))
        return analyze(ts, rs, make_settings())
    return judge_turning_ship(**{
        'good': {'n': 1500, 'risk__min_duration_s': 60.0}, 'bad': {'sigma_deg': 0.6},
        'short': {'n': 150}, 'single': {'n': 1}, 'equal': {'sigma_deg': 0.0},
        'turned': {'mean_deg': 90.0}, 'offset': {'installation_offset_deg': 0.05,
                                                 'installation_offset_u_deg': 0.01},
        'variant A': {'variant': 'A', 'mean_deg': 0.0}, 'drift': {'drift_order': 2},
        'none': {'runs': 0}, 'three': {'runs': 3, 'n': 300},
        'sensor': {'runs': 3, 'n': 400, 'campaign__rule': 'sensor'}}[case])


CASES = ('good', 'bad', 'short', 'single', 'equal', 'turned', 'offset', 'variant A', 'drift',
         'walking', 'wave', 'none', 'three', 'sensor')


def is_rounding(shown, exact):
    """Tell whether a figure is another one, rounded to its last digit."""
    digits = len(shown.partition('.')[2]) if '.' in shown else -1
    step = 10.0 ** -digits if '.' in shown else 10.0 ** (len(shown) - len(shown.rstrip('0')))
    return abs(float(shown) - float(exact)) <= 0.501 * step


@pytest.mark.parametrize('case', CASES)
def test_the_first_page_says_the_figures_of_the_annexes_rounded(case, rng):
    verdict = judged(case, rng)
    facts = dict(compose_first_page(verdict).facts)
    worst = next((run for run in verdict.runs
                  if run.run == verdict.campaign.worst_variance_run), None)
    assert (worst is None) == (facts['measured'] == 'nothing: too few differences')
    text = facts['measured'] + (facts['rests on'] if len(verdict.runs) == 1 else '')
    for pattern, name, table in IN_ANNEX if worst is not None else ():
        match = re.search(pattern, text)
        cell = next(row[2] for row in rows_of(table, worst) if row[0] == name)
        assert match is None or is_rounding(match[1], cell), name


@pytest.mark.parametrize('case', CASES)
def test_all_pages_say_one_number_of_independent_differences(case, rng):
    verdict = judged(case, rng)
    first = dict(compose_first_page(verdict).facts)['rests on']
    unknown = 0
    for run in verdict.runs:
        result = next(row[2] for row in rows_of(SUMMARY, run) if row[0].startswith('independent'))
        budget = budget_of(run, verdict.settings).rows[0][1]
        evidence = next(a.evidence for a in run.assumptions if a.id == 'a')
        if result == ABSENT:
            unknown += 1
            assert 'an unknown number of' in budget and 'are worth' not in evidence.replace(
                'are worth is unknown', '')
            continue
        assert f'worth {result} independent' in budget
        number = re.search(r'worth (\S+) independent', evidence)
        assert number is not None and is_rounding(result, number[1])
        if len(verdict.runs) == 1:
            assert f'worth {result} independent' in first
    assert ('unknown' in first) == bool(unknown)


def test_a_number_that_slow_errors_hide_is_unknown_on_all_pages(rng):
    """The decision counts some degrees of freedom of the visible errors; nobody knows the rest."""
    verdict = judged('wave', rng)
    run = verdict.runs[0]
    hidden = replace(run, assumptions=tuple(
        replace(a, state='not_testable') if a.id == 'a' else a for a in run.assumptions))
    assert run.guarded.nu is not None
    text = dict(compose_first_page(replace(verdict, runs=[hidden])).facts)['rests on']
    assert text.endswith('how many independent ones they are worth is unknown')


@pytest.mark.parametrize('case', CASES)
def test_no_unit_stands_beside_a_missing_figure(case, rng):
    text = re.sub(r'<style>.*?</style>|<[^>]+>', ' ', html.render(judged(case, rng)),
                  flags=re.DOTALL)
    assert re.findall(r'(?:of|is|with|deviation|turn|difference) - (?:deg|s|h|%)\S*', text) == []


@pytest.mark.parametrize('name, stated, default', [
    ('norms.probability', 0.95, 0.997), ('risk.alpha_consumer', 0.1, 0.05),
    ('installation_offset_deg', 1.5, 0.0), ('model', 'UU', 'NN'), ('variant', 'A', 'B'),
    ('pairing.kernel', 'line', 'band_limited'), ('alignment.skew_s', 0.2, 0.0)])
def test_the_word_default_stands_beside_what_nobody_stated(name, stated, default):
    for value, word in ((stated, 'x'), (default, 'x, default')):
        assert mark_default('x', Settings.from_mapping({name: value}), name) == word


@pytest.mark.parametrize('name, value, pattern', [
    ('installation_offset_deg', 1.5, r'as set</th><td>(1\.5|0, default)</td>'),
    ('installation_offset_u_deg', 0.1, r'uncertainty \[deg\], as set</th><td>(0\.1|0, default)<'),
    ('risk.alpha_consumer', 0.02, r'<td>(0\.02|0\.05, default), nominal: the largest'),
    ('norms.probability', 0.95, r'probability P \[1\]</th><td>(0\.95|0\.997, default)</td>'),
    ('window_s', 300.0, r'window_s</th><td>(300\.0</td><td>|600\.0</td><td>default)</td>'),
    ('installation_offset_deg', 1.5, r'<td>(1\.5 deg|0 deg, default)</td><td>B</td>')])
def test_the_protocol_says_of_a_setting_whether_anybody_stated_it(name, value, pattern):
    shown = [re.search(pattern, html.render(judge_turning_ship(n=200, **settings)))[1]
             for settings in ({}, {name.replace('.', '__'): value})]
    assert ['default' in text for text in shown] == [True, False]


def test_no_latency_is_said_to_be_known_unless_it_is_stated():
    assert 'no latency of the TS was stated' in describe_uncertainty(Settings())[1]
    stated = Settings.from_mapping({'alignment.skew_s': 0.2})
    assert 'a known latency of the TS of 0.2 s was removed' in describe_uncertainty(stated)[1]


def test_the_protocol_has_names_of_files_and_no_paths():
    verdict = judge_turning_ship(n=200)
    bag, other, pairs = '/vol/day1/trial', '/vol/day2/trial', 'data/pairs.csv'
    inputs = [Input(bag, '1', 'a', 'b', ledger_problems=(f'{bag}/trial_0.mcap ends early',)),
              Input(other, '2', 'a', 'b', same_as=bag),
              Input(pairs, '3', 'csv', 'csv', made_from={'/stick/raw.mcap': 'c'}),
              Input('/vol/gone', error='/vol/gone: no such file')]
    page = html.render(replace(verdict, runs=[replace(verdict.runs[0], source=bag)],
                               inputs=inputs, ledger_problems=(f'{bag}: a gap',)))
    assert not re.search('/vol|/stick|data/|day[12]', page)
    for words in ('trial: a gap', 'trial (2) was not judged: it has the data of trial',
                  'were made from raw.mcap', 'gone was not judged: gone: no such file'):
        assert words in page


def test_the_id_is_that_of_the_verdict_with_its_paths():
    """The JSON beside the protocol has the paths, and the same id."""
    verdict = replace(judge_turning_ship(n=200), inputs=[Input('/vol/trial', '1', 'a', 'b')])
    assert f'verdict {html.verdict_id(verdict)}' in html.render(verdict)


@pytest.mark.parametrize('paths, names', [
    (['trial'], ['trial']), (['a/trial/'], ['trial']),
    (['a/t', 'b/t', 'c/t'], ['t', 't (2)', 't (3)']),
    (['a/x.log and b/y.log', 'a/x.log, b/y.log'], ['x.log and y.log', 'x.log, y.log']),
    (['.', '/'], ['.', '/']), ([''], [''])])
def test_files_of_one_name_are_numbered(paths, names):
    assert [*name_files([Input(path) for path in paths[:-1]], paths[-1:]).values()] == names
