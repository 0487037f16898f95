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

"""Each figure of the JSON is in words in the protocol, or is left to the JSON for a reason."""

from __future__ import annotations

from dataclasses import fields, is_dataclass, replace
import re
from typing import get_args, get_type_hints

import pytest

from heading_intercompare.core.declared_figures import list_figures, list_keys
from heading_intercompare.core.statistics.normality import Shape
from heading_intercompare.core.statistics.stationarity import Homogeneity
from heading_intercompare.core.verdict.verdict_document import Campaign, RunVerdict, Verdict
from heading_intercompare.report.contents.findings import (
    describe_findings,
    FINDINGS,
    LEFT_TO_JSON,
    rows_of_block,
)

#: Shown by tables of their own; `test_html` finds every number of them in the page, and
#: `test_first_page`, `test_uncertainty_budget` and `test_html` the rest.
SHOWN = {'run', 'source', 'start_ns', 'end_ns', 'duration_s', 'pairing', 'n_input', 'n_invalid',
         'norm_tests',
         'n_stabilization', 'n', 'mean_deg', 'min_deg', 'max_deg', 'max_abs_deg',
         'mean_square_deg2', 'circular_mean_deg', 'resultant_length', 'drift_coefficients_deg',
         'variance_deg2', 'std_deg', 'variance_criterion', 'count_criterion', 'total_error',
         'outcome', 'reason', 'headline', 'validity', 'validity_effect', 'coverage', 'looks',
         'paper_outcome', 'guarded', 'assumptions', 'warnings', 'taken_out', 'limit_95',
         'clock_segment'}


def keys_of(kind, prefix=''):
    """Yield the dotted names of the figures of a dataclass, also within it."""
    for field in fields(kind):
        hint = get_type_hints(kind)[field.name]
        inner = next((one for one in (hint, *get_args(hint)) if is_dataclass(one)), None)
        # A look may hold the same look with nothing taken out.
        if inner in (None, kind):
            yield prefix + field.name
        else:
            yield from keys_of(inner, f'{prefix}{field.name}.')


def worded():
    """Return the names of the figures that the findings say in words."""
    figures = [item for finding in FINDINGS for keys in (finding.rows, finding.columns)
               for item in finding.pick(keys).items()]
    shapes = [f'{finding.block}.{shape}' for finding in FINDINGS
              for shape in finding.side_by_side.split()]
    return {key for name, figure in figures for key in (name, figure.u_key) if key} | {
        f'{shape}.{key}' for shape in shapes for key in list_figures(Shape)}


def test_every_figure_of_a_run_is_in_words_or_left_to_the_json():
    blocks = {field.name for field in list_keys(RunVerdict)} - SHOWN
    assert blocks == {finding.block.partition('.')[0] for finding in FINDINGS}
    hints = get_type_hints(RunVerdict)
    # A block that a run may lack is a union with None.
    kinds = {block: next(one for one in (hints[block], *get_args(hints[block]))
                         if is_dataclass(one)) for block in blocks}
    names = {name for block in blocks for name in keys_of(kinds[block], f'{block}.')}
    assert names == worded() | {*LEFT_TO_JSON}
    assert not worded() & {*LEFT_TO_JSON} and all(LEFT_TO_JSON.values())


def test_words_are_words_and_units_are_units():
    for figure in (*list_figures(RunVerdict).values(), *list_figures(Campaign).values()):
        assert not re.search(r'[^`]\b\w+_\w+\b[^`]', f' {figure.words} '), figure.words
        assert figure.unit in ('', '1', 'UTC', 'deg', 'deg²', 'deg/h', 'deg/s', 'kn', 's', 'h',
                               'readings')


@pytest.mark.parametrize('runs, n', [(0, 600), (1, 600), (1, 20), (3, 300)])
def test_each_section_has_a_title_a_meaning_and_tables(made, runs, n):
    verdict, _ = made(runs, n=n)
    found = describe_findings(verdict.runs)
    assert bool(found) == bool(runs)
    for one in found:
        assert one.title and one.meaning.endswith('.') and one.tables
        for _, table in one.tables:
            assert all(len(row) == len(table.head) for row in table.rows) and table.rows


def test_a_figure_stands_beside_its_uncertainty_with_two_digits(made):
    run = made(1)[0].runs[0]
    run = replace(run, skew=replace(run.skew, estimate=replace(
        run.skew.estimate, skew_s=1.19683, u_s=0.0412)))
    rows = {row[0]: row[2] for _, table in describe_findings([run])[0].tables
            for row in table.rows}
    assert rows['latency or clock offset'] == '1.197 ± 0.041'


def test_a_row_that_no_run_has_is_left_out():
    rows = rows_of_block(list_figures(Homogeneity), [
        (1, {'m': 2, 'q_p': None}), (2, {'m': 3, 'q_p': None})])
    assert [row for table in rows for row in table.rows] == [['runs compared', '1', '2', '3']]


@pytest.mark.slow
def test_no_name_of_the_json_is_in_the_protocol(made):
    """Names of settings stay, for they are what a user sets."""
    pytest.importorskip('jinja2')
    pytest.importorskip('matplotlib')
    from heading_intercompare.report import html
    verdict: Verdict = made(2)[0]
    page = html.render(verdict)
    text = re.sub(r'<style>.*?</style>|<[^>]+>', ' ', page[:page.index('Annex E. Settings</h2>')],
                  flags=re.DOTALL)
    names = {part for field in fields(RunVerdict) for part in (field.name,) if '_' in part}
    names |= {part for name in keys_of(RunVerdict) for part in name.split('.') if '_' in part}
    assert [name for name in names if re.search(rf'\b{name}\b', text)] == []
