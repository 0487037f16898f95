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

"""Verdicts to mappings and back: nothing changes, and anything else gives one clear line."""

from __future__ import annotations

import copy
import json
import math
from pathlib import Path
import subprocess
import sys
from typing import Any, Iterator

import pytest
from trials import judge_turning_ship

from heading_intercompare import join, Outcome, Settings, Verdict
from heading_intercompare.core.declared_settings import settings_sha256
from heading_intercompare.core.pipeline import Intercomparison
from heading_intercompare.core.typed_reader import VerdictError
from heading_intercompare.core.verdict.verdict_document import (
    Input,
    OperatorNote,
    SCHEMA,
    SCHEMA_VERSION,
    Software,
)
from heading_intercompare.core.version import RULE_VERSION

ROOT = Path(__file__).resolve().parents[3]
S = 1_000_000_000
NORMS = {'norms.sigma_max_deg': 0.3, 'norms.sigma_ref_max_deg': 0.1, 'risk.min_duration_s': 0.0}
GIVEN = Settings.from_mapping(NORMS).to_mapping()
WITHOUT_NORMS = {**GIVEN, 'norms.sigma_ref_max_deg': None}


def exact(mapping: dict[str, Any]) -> str:
    """Return a mapping as text that shows every bit and the order of the keys."""
    return json.dumps(mapping, allow_nan=False)


@pytest.mark.parametrize('runs, n, settings', [
    (0, 1, {}), (1, 1, {}), (1, 2, {}), (1, 50, {}), (1, 3000, {}), (6, 300, {}),
    (6, 300, {'campaign__rule': 'sensor'}),
    (1, 2000, {'drift_order': 'auto', 'runs__stabilization_s': 'auto'}),
    (1, 2000, {'sequential__plan_s': 2000.0, 'alignment__skew': 'apply'}),
    (2, 500, {'variant': 'A', 'model': 'UN', 'norms__k_rule': 2.5}),
    (1, 500, {'norms__preset': 'imo_a424', 'norms__latitude_deg': 60.0,
              'norms__sigma_max_deg': None, 'norms__total_error_max_deg': 1.0})])
def test_a_verdict_comes_back_as_it_was(runs, n, settings):
    mapping = judge_turning_ship(runs, n, **settings).to_dict()
    again = Verdict.from_dict(json.loads(exact(mapping)))
    assert exact(again.to_dict()) == exact(mapping)
    assert exact(Verdict.from_dict(mapping).to_dict()) == exact(mapping)
    assert again.outcome in Outcome and isinstance(again.settings, Settings)


def test_what_is_known_of_the_inputs_comes_back():
    comparison = Intercomparison(Settings.from_mapping(NORMS))
    inputs = [Input('a.mcap', 'ab', 'ts', 'rs', (OperatorNote(5, 'turn'),)),
              Input('b.csv', 'cd', no_run='no pair was made'), Input('c', None, error='gone'),
              Input('d', 'ab', same_as='a.mcap')]
    mapping = join(comparison.results(), comparison.compliance.settings, inputs,
                   incomplete=True).to_dict()
    assert mapping['inputs'][0] == {'path': 'a.mcap', 'sha256': 'ab', 'ts_topic': 'ts',
                                    'rs_topic': 'rs', 'notes': [{'stamp_ns': 5, 'text': 'turn'}]}
    assert [*mapping['inputs'][1]] == ['path', 'sha256', 'ts_topic', 'rs_topic', 'no_run']
    again = Verdict.from_dict(mapping)
    assert list(again.inputs) == inputs and again.to_dict() == mapping
    assert [given.why_no_run for given in again.inputs] == [
        None, 'no pair was made', 'gone', 'it has the data of a.mcap']


def test_who_judged_is_told_as_it_was():
    mapping = judge_turning_ship().to_dict()
    mapping['software']['version'] = '0.0.1'
    again = Verdict.from_dict(mapping)
    assert again.software == Software('heading_intercompare', '0.0.1')
    assert again.to_dict() == mapping


def test_an_absent_figure_is_nan_where_there_is_always_one():
    mapping = judge_turning_ship().to_dict()
    mapping['runs'][0]['total_error']['low_deg'] = None
    mapping['runs'][0]['duration_s'] = None
    again = Verdict.from_dict(mapping)
    assert again.runs[0].total_error.low_deg is None
    assert math.isnan(again.runs[0].duration_s)
    assert again.to_dict() == mapping


def test_unknown_keys_are_passed_over():
    mapping = judge_turning_ship().to_dict()
    newer = copy.deepcopy(mapping)
    newer['runs'][0]['guarded']['later'] = newer['later'] = {'x': 1}
    assert Verdict.from_dict(newer).to_dict() == mapping


def keys(block: Any, path: tuple = ()) -> Iterator[tuple]:
    """Yield the path to every key of a nested block; of a list, only its first element."""
    if isinstance(block, dict):
        for key, thing in block.items():
            yield (*path, key)
            yield from keys(thing, (*path, key))
    elif isinstance(block, list) and block:
        yield from keys(block[0], (*path, 0))


def reached(mapping: dict, path: tuple) -> Any:
    for key in path:
        mapping = mapping[key]
    return mapping


def name_of(path: tuple) -> str:
    """Return a path as errors name it."""
    return ''.join(f'[{key}]' if isinstance(key, int) else f'.{key}' for key in path).lstrip('.')


@pytest.mark.slow
def test_whatever_key_is_missing_is_named():
    mapping = judge_turning_ship(2).to_dict()
    free = {('campaign', 'runs_by_outcome'), ('runs', 0, 'pairing', 'rejected'),
            ('runs', 0, 'pairing', 'rejected', 'ts'), ('runs', 0, 'pairing', 'rejected', 'rs'),
            ('runs', 0, 'pairing', 'lost', 'ts'), ('runs', 0, 'pairing', 'lost', 'rs')}
    ways = [path for path in keys(mapping) if path[:-1] not in free]
    # Keys that a verdict without the figure leaves out.
    absent = ('searched_s', 'scope', 'stated_times', 'm_low_needed', 'scatter_upper_bound_deg2',
              'limit_95', 'by_motion', 'drift_orders')
    ways = [path for path in ways if not {*absent} & {*path}]
    assert len(ways) > 250
    for path in ways:
        less = copy.deepcopy(mapping)
        del reached(less, path[:-1])[path[-1]]
        with pytest.raises(VerdictError) as told:
            Verdict.from_dict(less)
        assert str(told.value) in (f'{name_of(path)} is missing',
                                   "schema = None: must be 'heading_intercompare/verdict/1'",
                                   "schema_version = None: must be text such as '1.0'")


def test_a_verdict_names_its_rule_and_the_hash_of_its_settings():
    verdict = judge_turning_ship()
    mapping = verdict.to_dict()
    assert mapping['schema_version'] == SCHEMA_VERSION
    assert SCHEMA == f'heading_intercompare/verdict/{SCHEMA_VERSION.partition(".")[0]}'
    assert mapping['rule_version'] == RULE_VERSION
    assert mapping['settings_sha256'] == settings_sha256(mapping['settings'])
    assert mapping['settings_sha256'] != judge_turning_ship(model='UN').settings_sha256


def test_the_hash_of_the_settings_is_found_as_the_page_says(tmp_path):
    """The page gives a command; it is run on a verdict."""
    page = (ROOT / 'docs' / 'verdict_json.md').read_text('utf-8')
    program = page.split("python3 -c '")[1].split("' < verdict.json")[0]
    mapping = judge_turning_ship(ts_topic='grad/°').to_dict()
    done = subprocess.run([sys.executable, '-c', program], input=json.dumps(mapping), text=True,
                          check=True, capture_output=True)
    assert done.stdout.strip() == mapping['settings_sha256']


def test_settings_changed_by_another_hand_are_seen():
    mapping = judge_turning_ship().to_dict()
    mapping['settings']['norms.sigma_max_deg'] = 0.4
    with pytest.raises(VerdictError, match='so they were changed afterwards'):
        Verdict.from_dict(mapping)


def test_a_later_minor_version_is_read_and_a_later_major_one_is_not():
    mapping = judge_turning_ship().to_dict()
    later = {**mapping, 'schema_version': '1.34', 'later': 1}
    assert Verdict.from_dict(later).to_dict() == mapping
    for newer in ({'schema_version': '2.0'}, {'schema': 'heading_intercompare/verdict/2'},
                  {'schema': 'heading_intercompare/verdict/2', 'schema_version': '2.1'}):
        with pytest.raises(VerdictError, match="/1'; a newer version of heading_intercompare "
                           'wrote it: install that version to read it$'):
            Verdict.from_dict({**mapping, **newer})


@pytest.mark.slow
def test_whatever_value_is_of_a_wrong_type_is_named():
    mapping = judge_turning_ship(2).to_dict()
    for path in keys(mapping):
        if reached(mapping, path) == {}:
            continue
        for wrong in ({'surely': 'wrong'}, [[{}]]):
            other = copy.deepcopy(mapping)
            reached(other, path[:-1])[path[-1]] = wrong
            with pytest.raises(VerdictError) as told:
                Verdict.from_dict(other)
            assert (name_of(path) if path[0] != 'settings' else path[-1]) in str(told.value)
            assert '\n' not in str(told.value)


@pytest.mark.parametrize('wrong, words', [
    (None, 'a verdict must be an object, not NoneType'),
    ([], 'a verdict must be an object, not list'),
    ({}, "schema = None: must be 'heading_intercompare/verdict/1'"),
    ({'schema': 'heading_intercompare/verdict/0'}, "verdict/0': must be '[a-z_/]*/1'$"),
    ({'schema': 'heading_intercompare/sensors/1'}, "sensors/1': must be '[a-z_/]*/1'$"),
    ({'schema_version': 2}, "schema_version = 2: must be text such as '1.0'"),
    ({'schema_version': '2'}, "schema_version = '2': must be text"),
    ({'settings_sha256': None}, 'settings_sha256 = None: the settings have '),
    ({'rule_version': '2'}, "rule_version = '2': must be "),
    ({'schema': []}, r'schema = \[\]: must be'),
    ({'outcome': 'good'}, "outcome = 'good': must be 'compliant' or 'indeterminate' or "),
    ({'outcome': None}, 'outcome = None: must be'),
    ({'headline': 3}, 'headline = 3: must be text'),
    ({'runs': {}}, 'runs = {}: must be a list'),
    ({'runs': 'x' * 100}, "runs = 'xxx.*xx...: must be a list"),
    ({'runs': [3]}, r'runs\[0\] = 3: must be an object'),
    ({'inputs': [{}]}, r'inputs\[0\].path is missing'),
    ({'settings': []}, r'settings = \[\]: must be an object'),
    ({'settings': {}}, 'settings.norms.sigma_max_deg is missing'),
    ({'settings': WITHOUT_NORMS, 'settings_sha256': settings_sha256(WITHOUT_NORMS)},
     'settings: norms.sigma_ref_max_deg'),
    ({'settings': {**GIVEN, 'norms.sigma': 1.0}}, "settings: unknown setting 'norms.sigma'"),
    ({'settings': {**GIVEN, 'window_s': 0.0}}, 'settings: window_s = 0.0: must be a number')])
def test_what_is_no_verdict_is_told_in_one_line(wrong, words):
    if isinstance(wrong, dict) and wrong and 'schema' not in wrong:
        wrong = {**judge_turning_ship().to_dict(), **wrong}
    with pytest.raises(VerdictError, match=words):
        Verdict.from_dict(wrong)
