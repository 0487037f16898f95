# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Verdicts to mappings and back: nothing changes, and what is no verdict is named in a line."""

from __future__ import annotations

import copy
import json
import math
from typing import Any, Iterator

import numpy as np
import pytest

from heading_intercompare import analyze, Headings, join, Outcome, Settings, Verdict
from heading_intercompare.core.pipeline import Intercomparison
from heading_intercompare.core.verdict.verdict_document import (
    Input,
    OperatorNote,
    Software,
    VerdictError,
)

S = 1_000_000_000
NORMS = {'norms.sigma_max_deg': 0.3, 'norms.sigma_ref_max_deg': 0.1, 'risk.min_duration_s': 0.0}
GIVEN = Settings.from_mapping(NORMS).to_mapping()
WITHOUT_NORMS = {**GIVEN, 'norms.sigma_ref_max_deg': None}


def judged(runs: int = 1, n: int = 600, **settings: Any) -> Verdict:
    """Return a verdict on runs of a turning ship, TS 0.2° sd."""
    rng = np.random.default_rng(n)
    ts, rs = [], []
    for run in range(runs):
        stamps = (np.arange(n) + 10_000 * run + 1_700_000_000) * S
        true = 180.0 + 170.0 * np.sin(np.arange(n) / 40.0)
        ts.append(Headings.of(stamps, true + 0.05 + rng.normal(0.0, 0.2, n)))
        rs.append(Headings.of(stamps, true))
    return analyze(ts, rs, Settings.from_mapping(
        {**NORMS, **{k.replace('__', '.'): v for k, v in settings.items()}}))


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
    mapping = judged(runs, n, **settings).to_dict()
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
    mapping = judged().to_dict()
    mapping['software']['version'] = '0.0.1'
    again = Verdict.from_dict(mapping)
    assert again.software == Software('heading_intercompare', '0.0.1')
    assert again.to_dict() == mapping


def test_an_absent_figure_is_nan_where_there_is_always_one():
    mapping = judged().to_dict()
    mapping['runs'][0]['total_error']['low_deg'] = None
    mapping['runs'][0]['duration_s'] = None
    again = Verdict.from_dict(mapping)
    assert again.runs[0].total_error.low_deg is None
    assert math.isnan(again.runs[0].duration_s)
    assert again.to_dict() == mapping


def test_unknown_keys_are_passed_over():
    mapping = judged().to_dict()
    newer = copy.deepcopy(mapping)
    newer['runs'][0]['guarded']['later'] = newer['later'] = {'x': 1}
    assert Verdict.from_dict(newer).to_dict() == mapping


def keys(block: Any, path: tuple = ()) -> Iterator[tuple]:
    """Yield the way to every key of a nested block, the first element of lists for all."""
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
    """Return a way as errors name it."""
    return ''.join(f'[{key}]' if isinstance(key, int) else f'.{key}' for key in path).lstrip('.')


def test_whatever_key_is_missing_is_named():
    mapping = judged(2).to_dict()
    free = {('campaign', 'runs_by_outcome'), ('runs', 0, 'pairing', 'rejected')}
    ways = [path for path in keys(mapping) if path[:-1] not in free]
    assert len(ways) > 250
    for path in ways:
        less = copy.deepcopy(mapping)
        del reached(less, path[:-1])[path[-1]]
        with pytest.raises(VerdictError) as told:
            Verdict.from_dict(less)
        assert str(told.value) in (f'{name_of(path)} is missing',
                                   "schema = None: must be 'heading_intercompare/verdict/2'")


def test_whatever_value_is_of_a_wrong_type_is_named():
    mapping = judged(2).to_dict()
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
    ({}, "schema = None: must be 'heading_intercompare/verdict/2'"),
    ({'schema': 'heading_intercompare/verdict/1'}, "schema = 'heading_intercompare/verdict/1'"),
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
    ({'settings': WITHOUT_NORMS}, 'settings: norms.sigma_ref_max_deg'),
    ({'settings': {**GIVEN, 'norms.sigma': 1.0}}, "settings: unknown setting 'norms.sigma'"),
    ({'settings': {**GIVEN, 'window_s': 0.0}}, 'settings: window_s = 0.0: must be a number')])
def test_what_is_no_verdict_is_told_in_one_line(wrong, words):
    if isinstance(wrong, dict) and wrong and 'schema' not in wrong:
        wrong = {**judged().to_dict(), **wrong}
    with pytest.raises(VerdictError, match=words):
        Verdict.from_dict(wrong)
