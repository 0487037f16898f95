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

"""The JSON Schema accepts every verdict; the reader rejects whatever the schema rejects."""

from __future__ import annotations

import copy
import json
from pathlib import Path
import runpy

import jsonschema
import pytest
from trials import judge_turning_ship

from heading_intercompare import join, Settings
from heading_intercompare.core.verdict.verdict_document import Input, OperatorNote
from heading_intercompare.report.json_schema import make_schema

ROOT = Path(__file__).resolve().parents[2]
S = 1_000_000_000
NORMS = {'norms.sigma_max_deg': 0.3, 'norms.sigma_ref_max_deg': 0.1}
CHECK = jsonschema.Draft202012Validator(make_schema())


def faults(mapping):
    """Return the places where a verdict in JSON breaks the schema."""
    return [error.json_path for error in CHECK.iter_errors(json.loads(json.dumps(mapping)))]


@pytest.mark.slow
def test_the_schema_is_a_schema():
    jsonschema.Draft202012Validator.check_schema(make_schema())


GENERATED = runpy.run_path(str(ROOT / 'docs' / 'generate.py'))


def test_the_file_is_what_the_classes_declare():
    assert GENERATED['SCHEMA'].read_text('utf-8') == GENERATED['schema'](), 'run: make docs'


def test_the_pages_of_json_and_csv_are_what_the_classes_declare():
    page = GENERATED['KEYS'].read_text('utf-8')
    assert page == GENERATED['keys'](page), 'run: make docs'
    page = GENERATED['RUNS'].read_text('utf-8')
    assert page == GENERATED['columns'](page), 'run: make docs'


@pytest.mark.slow
@pytest.mark.parametrize('runs, n, settings', [
    (0, 1, {}), (1, 1, {}), (1, 50, {}), (1, 3000, {}), (6, 300, {'campaign__rule': 'sensor'}),
    (1, 2000, {'drift_order': 'auto', 'runs__stabilization_s': 'auto', 'norms__k_rule': 2.5}),
    (1, 2000, {'sequential__plan_s': 2000.0, 'alignment__skew': 'apply'})])
def test_a_verdict_meets_the_schema(runs, n, settings):
    assert faults(judge_turning_ship(runs, n, **settings).to_dict()) == []


def test_what_is_known_of_the_inputs_meets_the_schema():
    inputs = [Input('a.mcap', 'ab', 'ts', 'rs', (OperatorNote(5, 'turn'),)),
              Input('c', None, error='gone'), Input('d', 'ab', same_as='a.mcap')]
    assert faults(join([], Settings.from_mapping(NORMS), inputs, incomplete=True).to_dict()) == []


def test_keys_of_later_versions_are_allowed():
    mapping = judge_turning_ship().to_dict()
    mapping['later'] = mapping['runs'][0]['guarded']['later'] = {'x': 1}
    assert faults({**mapping, 'schema_version': '1.34'}) == []


@pytest.mark.parametrize('where, wrong', [
    ('schema', 'heading_intercompare/verdict/2'), ('schema_version', '2.0'),
    ('outcome', 'good'), ('rule_version', '2'), ('settings_sha256', 'ab'), ('runs', {}),
    ('settings.model', 'XX'), ('settings.norms.probability', 2.0), ('settings.window_s', None),
    ('runs.0.n', 1.5), ('runs.0.guarded.nu', 'many'), ('campaign.runs_by_outcome.compliant', 'x')])
def test_what_is_no_verdict_breaks_the_schema_where_it_is_wrong(where, wrong):
    mapping = judge_turning_ship().to_dict()
    first, _, rest = where.partition('.')
    *path, last = [first] + ([rest] if first == 'settings' else rest.split('.')) * bool(rest)
    block = mapping
    for key in path:
        block = block[int(key) if key.isdigit() else key]
    block[last] = wrong
    assert len(faults(mapping)) == 1


@pytest.mark.slow
def test_a_key_that_is_missing_breaks_the_schema():
    mapping = judge_turning_ship().to_dict()
    for block in (mapping, mapping['runs'][0], mapping['settings'], mapping['campaign']):
        for key in {*block} - {'limit_95', 'by_motion'}:
            kept = copy.copy(block)
            del block[key]
            assert faults(mapping) != [], key
            block.clear()
            block.update(kept)
