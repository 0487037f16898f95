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

"""A verdict that was read follows from its own figures, or the first that does not is named."""

from __future__ import annotations

import copy
from functools import cache
import json
import re

from hypothesis import given, strategies as st
import numpy as np
import pytest
from ship_of_sensors import make_three, TABLE
from trials import (
    judge_headings,
    judge_turning_ship,
    make_settings,
    make_turning_ship,
    NORMS,
)

from heading_intercompare import analyze, analyze_sensors, Settings
from heading_intercompare.core.typed_reader import VerdictError
from heading_intercompare.core.version import RULE_VERSION, VERSION
from heading_intercompare.report.json import NOT_JUDGED, parse_any, render

STAMPS = (np.arange(1500) + 1_700_000_000) * 10 ** 9
SHIP_DEG = 100.0 + 50.0 * np.sin(np.arange(1500) / 40.0)


def _add_to_the_ship(error_deg):
    noise_deg = np.random.default_rng(1).normal(0.0, 0.1, 1500)
    return judge_headings(SHIP_DEG + error_deg + noise_deg, SHIP_DEG, STAMPS)


def _judge_three(table=TABLE, **errors):
    return analyze_sensors(make_three(**errors), Settings.of(sensors=table, slowest_error_s=60.0))


def _judge_one_run_twice():
    trials = [make_turning_ship(run, np.random.default_rng(run).normal(0.05, 0.2, 700))
              for run in (0, 1, 2, 0)]
    return analyze([ts for ts, _ in trials], [rs for _, rs in trials], make_settings())


def _judge_a_rejected_run():
    trials = [make_turning_ship(run, np.random.default_rng(run).normal(0.05, sd_deg, 700))
              for run, sd_deg in enumerate((0.2, 0.6))]
    return analyze([ts for ts, _ in trials], [rs for _, rs in trials], make_settings())


KINDS = {
    'one of two rejected': _judge_a_rejected_run,
    'one run twice': _judge_one_run_twice,
    'compliant': lambda: judge_turning_ship(1, 900),
    'rejected': lambda: judge_turning_ship(1, 900, sigma_deg=0.6),
    'open': lambda: judge_turning_ship(1, 900, sigma_deg=0.3),
    'too few': lambda: judge_turning_ship(1, 60),
    'one pair': lambda: judge_headings(SHIP_DEG[:1], SHIP_DEG[:1], STAMPS[:1]),
    'too short': lambda: judge_turning_ship(1, 300),
    'every run': lambda: judge_turning_ship(3, 700),
    'sensor': lambda: judge_turning_ship(6, 700, campaign__rule='sensor'),
    'variant A, stated': lambda: judge_turning_ship(
        5, 700, campaign__rule='sensor', variant='A', risk__slowest_error_s=20.0),
    'variant C': lambda: judge_turning_ship(3, 700, variant='C'),
    'stated': lambda: judge_turning_ship(1, 900, risk__slowest_error_s=20.0),
    'planned looks': lambda: judge_turning_ship(1, 2400, sequential__plan_s=2400.0,
                                                sequential__looks=3),
    'open looks': lambda: judge_turning_ship(1, 2000, sequential__plan_s='open',
                                             sequential__looks=3),
    'rejected at a look': lambda: judge_turning_ship(1, 2000, sigma_deg=0.8,
                                                     sequential__plan_s='open',
                                                     sequential__looks=3),
    'drift': lambda: judge_turning_ship(1, 900, drift_order=1),
    'drift as found': lambda: judge_turning_ship(1, 900, drift_order='auto'),
    'total error': lambda: judge_turning_ship(1, 900, norms={**NORMS, 'total_error_max_deg': 2.0}),
    'settled': lambda: judge_turning_ship(1, 900, runs__stabilization_s=200.0),
    'offset': lambda: judge_turning_ship(1, 900, installation_offset_u_deg=0.3),
    'uniform': lambda: judge_turning_ship(1, 900, model='UU'),
    'copy': lambda: judge_headings(SHIP_DEG, SHIP_DEG, STAMPS),
    'yaw': lambda: _add_to_the_ship(90.0),
    'slow': lambda: _add_to_the_ship(0.2 * np.sin(np.arange(1500) / 400.0)),
    'interpolated': lambda: judge_headings(
        SHIP_DEG + np.random.default_rng(2).normal(0.0, 0.1, 1500),
        np.interp(STAMPS[:-1] + 5 * 10 ** 8, STAMPS, SHIP_DEG), STAMPS, STAMPS[:-1] + 5 * 10 ** 8),
    'three': _judge_three, 'one of three': lambda: _judge_three(gyro2=0.9),
    'reference wrong': lambda: _judge_three(gnss=1.0),
    'no reference': lambda: _judge_three(TABLE.replace('  rs', '')),
}

#: What follows from other figures; the names of settings are kept by their hash.
DERIVED = re.compile(
    r'(verdicts\.\w+\.)?('
    r'outcome|headline|validity_effect|paper_outcome|ledger_complete|settings\b.*|settings_sha256|'
    r'campaign\.(rule|reason|m|worst_.*|a_low_deg|a_up_deg|low_worst_deg|up_worst_deg|'
    r'runs_by_outcome\..*|sensor\.(runs|n|span_s|nu|f|lower_bound_deg2|.*_limit_deg2))|'
    r'runs\[\d+\]\.(run|duration_s|n|n_input|n_invalid|n_stabilization|max_abs_deg|'
    r'mean_square_deg2|variance_deg2|std_deg|mean_deg|outcome|reason|headline|validity_effect|'
    r'paper_outcome|variance_criterion\..*|count_criterion\.(k|limit_deg|allowed|outcome)|'
    r'total_error\..*|coverage\.(span_s|longest_s|stated_s|least_duration_s|by_run_means|'
    r'scope\.(mean_is_judged|alpha_consumer))|'
    r'pairing\.(ts_received|rs_received|ts_paired|ts_unpaired|rs_used|rs_unused)|'
    r'guarded\.(d_hat_deg2|nu|upper_bound_deg2|lower_bound_deg2|acceptance_limit_deg2|'
    r'rejection_limit_deg2|sigma_ts_.*|duration_factor|hours_needed|bias_.*|rate_.*|'
    r'count_outcome|outcome|reason)))|'
    r'sensors\[\d+\]\.(name|role|topic|sigma_max_deg|outcome|headline|validity_effect)|'
    r'vote\.words|risk|pairs\[\d+\]\.(limit_deg2|of_reference)')


@cache
def _make(kind):
    return json.loads(render(KINDS[kind]()))


def _list_leaves(document, place=''):
    """Yield the places of a document that hold no mapping and no list but an empty one."""
    if isinstance(document, dict) and document:
        for key, inner in document.items():
            for at, leaf in _list_leaves(inner, f'{place}.{key}'.lstrip('.')):
                yield (key, *at), leaf
    elif isinstance(document, list) and document:
        for number, inner in enumerate(document):
            for at, leaf in _list_leaves(inner, f'{place}[{number}]'):
                yield (number, *at), leaf
    else:
        yield (), place


def _change(value, how):
    """Return a changed leaf, of its own type where it has one."""
    if how == 'null':
        return None
    if isinstance(value, bool):
        return not value
    if isinstance(value, (int, float)):
        return {'flip': -value - 1, 'scale': 2 * value + 1, 'zero': value * 0}[how]
    if isinstance(value, str):
        return {'flip': 'compliant' if value != 'compliant' else 'indeterminate',
                'scale': f'{value} x', 'zero': ''}[how]
    return {'flip': 1.5, 'scale': 'x', 'zero': 0}[how]


def _forge(document, at, how):
    forged = copy.deepcopy(document)
    part = forged
    for key in at[:-1]:
        part = part[key]
    if how == 'drop':
        del part[at[-1]]
    else:
        part[at[-1]] = _change(part[at[-1]], how)
    return forged


@pytest.mark.parametrize('kind', KINDS)
def test_what_the_program_writes_is_taken_with_its_label(kind):
    document = _make(kind)
    verdict = parse_any(json.dumps(document))
    assert verdict.provenance.startswith(f'{NOT_JUDGED}; verdict id ')
    assert str(verdict).splitlines()[1] == verdict.provenance
    assert verdict.to_dict() == document


@given(st.data())
def test_a_changed_leaf_is_refused_if_it_follows_from_others_and_labelled_otherwise(data):
    document = _make(data.draw(st.sampled_from(sorted(KINDS))))
    leaves = [*_list_leaves(document)]
    # Each figure is as likely as each of a long list.
    names = sorted({re.sub(r'\d+', '0', place) for _, place in leaves})
    name = data.draw(st.sampled_from(names))
    at, place = data.draw(st.sampled_from(
        [leaf for leaf in leaves if re.sub(r'\d+', '0', leaf[1]) == name]))
    how = data.draw(st.sampled_from(['flip', 'scale', 'zero', 'null', 'drop']))
    forged = _forge(document, at, how)
    try:
        verdict = parse_any(json.dumps(forged))
    except VerdictError as error:
        assert '\n' not in str(error)
        return
    assert verdict.provenance.startswith(NOT_JUDGED)
    assert verdict.to_dict() == document or not DERIVED.fullmatch(place), (place, how)


def test_both_outcomes_changed_name_the_run_and_what_its_figures_give():
    text = json.dumps(_make('rejected')).replace('"outcome": "non_compliant"',
                                                 '"outcome": "compliant"')
    with pytest.raises(VerdictError, match='^runs.0.*outcome is compliant, but its figures give '
                       'non_compliant: the file was changed$'):
        parse_any(text)


def test_emptied_findings_are_refused():
    document = _make('compliant')
    document = {**document, 'runs': [{**document['runs'][0], 'validity': []}]}
    with pytest.raises(VerdictError, match='runs.0..validity is '):
        parse_any(json.dumps(document))


@pytest.mark.parametrize('kind, effect', [
    ('rejected', 'holds'), ('rejected', 'doubtful'), ('one of two rejected', 'doubtful'),
    ('one of two rejected', 'holds'), ('sensor', 'doubtful')])
def test_a_forged_finding_that_runs_repeat_lets_no_sensor_comply(kind, effect):
    document = copy.deepcopy(_make(kind))
    campaign = document['campaign']
    campaign['validity'].insert(0, {
        'condition': 'repeated_readings', 'effect': effect, 'words': 'x', 'evidence': 'x'})
    document['outcome'] = 'compliant'
    campaign['reason'] = 'every_run_compliant'
    with pytest.raises(VerdictError, match='^outcome is compliant, but its figures give '):
        parse_any(json.dumps(document))


def test_another_version_is_named_in_the_line():
    document = _forge(_make('compliant'), ('outcome',), 'flip')
    document['software'] = {'name': 'heading_intercompare', 'version': '0.0.9'}
    with pytest.raises(VerdictError) as caught:
        parse_any(json.dumps(document))
    assert str(caught.value).endswith(
        f'the file was changed, or made by version 0.0.9 with rule {RULE_VERSION}, and this is '
        f'version {VERSION} with rule {RULE_VERSION}')
    document['outcome'] = 'compliant'
    assert parse_any(json.dumps(document)).software.version == '0.0.9'


@pytest.mark.parametrize('key, value', [('verdicts', {}), ('pairs', []), ('sensors', [])])
def test_a_verdict_on_several_sensors_that_lacks_one_is_refused(key, value):
    with pytest.raises(VerdictError, match=f'^{key} (are|is) .*, but its (settings|figures) give'):
        parse_any(json.dumps({**_make('three'), key: value}))
