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

"""The appearance of a verdict: a table as text, for notebooks, and as a data frame."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
import sys
from types import ModuleType
from xml.etree import ElementTree

import numpy as np
import pytest
from trials import judge_turning_ship

from heading_intercompare import analyze, Headings, Settings
from heading_intercompare.core.runs.pairing_figures import RejectedReadings
from heading_intercompare.core.verdict.verdict_document import Input
from heading_intercompare.core.verdict.verdict_table import verdict_text

judge_ship = partial(judge_turning_ship, risk__min_duration_s=0.0)


def test_a_verdict_is_printed_as_a_table():
    verdict = judge_ship(1)
    run = verdict.runs[0]
    lines = str(verdict).splitlines()
    assert lines[:3] == [
        f'VERDICT: {verdict.headline}',
        'norms: sigma_max 0.3 deg, sigma_ref_max 0.1 deg; risks: consumer 0.05, producer 0.05', '']
    cells = dict(line.rsplit('  ', 1) for line in lines if '  ' in line.strip())
    cells = {name.strip(): cell for name, cell in cells.items()}
    assert cells['outcome'] == 'COMPLIANT'
    assert cells['first pair, UTC'] == '2023-11-14 22:13:20.000'
    assert cells['standard deviation [deg]'] == f'{run.std_deg:.4f}'
    assert cells['rejected'] == '0'
    reasons = lines[lines.index('', 3) + 1:]
    assert reasons[0] == 'run 1: the variance is within the acceptance limit, at the stated risk'
    assert all(line.startswith('  ') for line in reasons[1:])


GK_LINES = {'GK as printed', 'GK (5) variance', 'n+ / n++ / allowed', 'GK (6) counts'}


def test_a_verbose_table_has_the_criteria_of_gk_and_the_abbreviations():
    verdict = judge_ship(1)
    lines = verdict_text(verdict, verbose=True).splitlines()
    assert lines[:5] == [
        f'VERDICT: {verdict.headline}', 'GK as printed: COMPLIANT',
        'norms: sigma_max 0.3 deg, sigma_ref_max 0.1 deg, P 0.997; model NN, variant B; '
        'risks: consumer 0.05, producer 0.05',
        'TS: tested sensor; RS: reference sensor; GK: Granovskii and Kudryavtsev 2016; '
        'NN: errors of TS and RS normal; '
        'B: the mean of the TS is not known, and the same in all runs', '']
    assert GK_LINES <= {line.rpartition('  ')[0].strip() for line in lines}
    assert not {*str(verdict).splitlines()} - {*lines} - {str(verdict).splitlines()[1]}


def test_a_verbose_table_has_the_differences_by_heading_and_by_rate_of_turn():
    verdict = judge_ship(1)
    by_motion = verdict.runs[0].by_motion
    lines = verdict_text(verdict, verbose=True).splitlines()
    for block, title in ((by_motion.sectors, 'by heading, on steady headings'),
                         (by_motion.turns, 'by rate of turn, starboard positive')):
        at = lines.index(f'run 1, differences {title}:')
        rows = [line.split() for line in lines[at + 2:at + 2 + len(block.n)]]
        column = 1 if title.startswith('by heading') else 2
        assert [row[column] for row in rows] == [*map(str, block.n)]
        assert lines[at + 2 + len(block.n)] == ''
    assert not any(line.startswith('run 1, differences') for line in str(verdict).splitlines())


@pytest.mark.parametrize('stated, shown', [
    ({}, False), ({'norms__sigma_max_deg': 0.2, 'window_s': 60.0, 'norms__m_low': 0.5}, False),
    ({'norms__total_error_max_deg': 0.9}, True), ({'norms__probability': 0.95}, True),
    ({'norms__k_rule': 'three'}, True), ({'norms__k_total_rule': 'composition'}, True),
    ({'model': 'UN'}, True), ({'variant': 'A'}, True)])
def test_a_setting_in_the_terms_of_gk_shows_its_criteria(stated, shown):
    verdict = judge_ship(1, **stated)
    lines = {line.rpartition('  ')[0].strip() for line in str(verdict).splitlines()}
    assert (GK_LINES & lines == GK_LINES) is shown and bool(GK_LINES & lines) is shown
    assert ('GK as printed: ' in str(verdict)) is ('TS: tested sensor' in str(verdict)) is shown
    assert ('GK as printed: ' in verdict._repr_html_()) is shown


def test_runs_stand_side_by_side_five_in_a_table():
    heads = [line.split() for line in str(judge_ship(7)).splitlines() if line.startswith('   ')
             and 'run' in line]
    assert heads == [['run', '1', 'run', '2', 'run', '3', 'run', '4', 'run', '5'],
                     ['run', '6', 'run', '7']]


def test_what_is_absent_is_a_dash_and_what_is_rejected_has_its_reason():
    verdict = judge_ship(1)
    run = verdict.runs[0]
    other = replace(run, mean_deg=float('nan'), max_abs_deg=None, pairing=replace(
        run.pairing, rejected=RejectedReadings({'invalid': 2}, {'no_stamp': 1})))
    lines = [' '.join(line.split()) for line in str(replace(verdict, runs=[other])).splitlines()]
    assert {'mean difference [deg] -', 'largest |difference| [deg] -',
            'rejected 2 TS invalid, 1 RS no_stamp'} <= set(lines)


def test_without_runs_the_reason_stands_there():
    empty = judge_ship(0)
    assert str(empty).endswith(
        'No run: there are no pairs, or none in a run of sufficient length.')
    given = replace(empty, inputs=[Input('a.mcap', error='is cut')])
    assert str(given).endswith('not judged: a.mcap: is cut')


def test_who_only_names_a_verdict_sees_its_headline():
    verdict = judge_ship(2)
    assert repr(verdict) == f'<Verdict on 2 runs: {verdict.headline}>'
    assert repr(judge_ship(1)).startswith('<Verdict on 1 run: COMPLIANT')


def test_the_summary_is_a_line_and_one_a_run():
    verdict = judge_ship(2)
    headline, first, second = verdict.summary().splitlines()
    run = verdict.runs[0]
    assert headline == verdict.headline
    assert first.startswith(f'run 1: COMPLIANT, n = 600, mean {run.mean_deg:.4f} deg, ')
    assert first.endswith(f'limits {run.guarded.acceptance_limit_deg2:.6f} .. '
                          f'{run.guarded.rejection_limit_deg2:.6f}')
    assert second.startswith('run 2: ')


def test_a_notebook_shows_the_same_table():
    verdict = judge_ship(6)
    root = ElementTree.fromstring(verdict._repr_html_())
    rows = [[cell.text or '' for cell in row] for row in root.iter('tr')]
    words = {' '.join(' '.join(row).split()) for row in rows}
    printed = {' '.join(line.split()) for line in str(verdict).splitlines()}
    assert len(words) == 2 * 29 and words <= printed
    items = [item.text for item in root.iter('li')]
    assert {item.text for item in root.iter('p') if item.text} <= printed
    assert set(items) <= printed and len(items) >= 7


def test_a_hostile_name_is_shown_in_a_notebook_and_not_obeyed():
    name = '<script>alert(1)</script>&amp;\udcff'
    verdict = replace(judge_ship(1), headline=name, inputs=[Input(name, error=name)])
    page = verdict._repr_html_()
    page.encode('utf-8')
    assert '<script' not in page
    assert ElementTree.fromstring(page).find('p/strong').text == name.replace('\udcff', '?')


class Frame:
    """The part of pandas that `to_frame` needs."""

    def __init__(self, rows) -> None:
        self.rows, self.index = rows, None

    def set_index(self, name):
        self.index = name
        return self


def test_a_frame_has_a_row_a_run_and_dotted_names(monkeypatch):
    pandas = ModuleType('pandas')
    pandas.DataFrame = Frame
    monkeypatch.setitem(sys.modules, 'pandas', pandas)
    verdict = judge_ship(2)
    frame = verdict.to_frame()
    assert frame.index == 'run' and [row['run'] for row in frame.rows] == [1, 2]
    row, run = frame.rows[1], verdict.runs[1]
    assert (row['outcome'], row['n'], row['guarded.nu']) == ('compliant', 600, run.guarded.nu)
    assert row['pairing.ts_received'] == 600 and 'validity' not in row
    assert not any(isinstance(thing, (dict, list)) for thing in row.values())
    assert judge_ship(0).to_frame().rows == []


def test_without_pandas_one_line_says_so(monkeypatch):
    monkeypatch.setitem(sys.modules, 'pandas', None)
    with pytest.raises(ValueError, match=r'^to_frame needs pandas \(no module pandas\): install'):
        judge_ship(1).to_frame()


@pytest.mark.parametrize('model, variant, words', [
    ('NN', 'A', 'NN: errors of TS and RS normal; A: the mean of the TS is known to be 0'),
    ('UN', 'C', 'UN: errors of the TS uniform, of the RS normal; C: the mean of the TS is not')])
def test_the_letters_of_the_screen_are_explained_on_it(model, variant, words):
    settings = Settings.of(sigma_max_deg=0.3, sigma_ref_max_deg=0.1, model=model, variant=variant)
    stamps = np.arange(1_700_000_000, 1_700_000_600) * 10 ** 9
    headings = Headings.of(stamps, np.full(600, 1.0))
    verdict = analyze(headings, headings, settings)
    assert words in str(verdict).splitlines()[3] and words in verdict._repr_html_()
