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

"""No figure of a protocol speaks against its headline, whatever the outcome of the run."""

from __future__ import annotations

from dataclasses import replace
import re

import numpy as np
import pytest
from trials import make_settings, make_turning_ship

from heading_intercompare import analyze, Outcome
from heading_intercompare.core.verdict.conclusion import explain
from heading_intercompare.report.contents.tables import GUARDED, RESULTS, rows_of

NORMS = {'norms.sigma_max_deg': 0.3, 'norms.sigma_ref_max_deg': 0.1}

#: Shares of a second, a minute, an hour, a day: how an open verdict says how long to measure.
LENGTH = r'measure (?:\d+ (?:s|min) \(\d+\.\d\d h\)|\d+\.\d h|[\d.]+ years) in all'


def errors(kind, n, rng):
    """Return n errors of the TS of a kind, degrees."""
    t = np.linspace(-1.0, 1.0, n)
    noise = rng.standard_normal(n)
    slow = np.cumsum(rng.standard_normal(n))
    return {
        'good': 0.1 * noise, 'bad': 0.9 * noise, 'edge': 0.285 * noise, 'gap': 0.307 * noise,
        'drifting': 0.1 * noise + 0.38 * t,
        'swinging': 0.1 * noise + 0.33 * np.sin(2.2 * np.pi * t + 0.4),
        'walking': 0.1 * noise + 0.3 * (slow - slow.mean()) / slow.std(),
        'turned': 0.1 * noise + 90.0, 'shifted': 0.1 * noise + 5.0,
        'wild': 0.1 * noise + np.where(np.arange(n) == n // 2, 60.0, 0.0),
        'tails': 0.12 * noise + (np.arange(n) % 50 == 7) * np.sign(noise)}[kind]


def judged(kind, n, rng, runs=1, **settings):
    """Return the verdict on runs of one reading a second."""
    trials = [make_turning_ship(run, errors(kind, n, rng), 0.02 * rng.standard_normal(n))
              for run in range(runs)]
    return analyze([ts for ts, _ in trials], [rs for _, rs in trials], make_settings(**settings))


FAMILY = [
    ('good', 3000, 1, {}), ('bad', 3000, 1, {}), ('bad', 200, 1, {}),
    ('good', 200, 1, {}), ('good', 599, 1, {}), ('good', 20, 1, {}), ('good', 3000, 1, {
        'risk__slowest_error_s': 2300.0}),
    ('edge', 900, 1, {}), ('edge', 300, 1, {}), ('gap', 6000, 1, {}), ('gap', 40_000, 1, {}),
    ('drifting', 3000, 1, {}), ('drifting', 300, 1, {}), ('swinging', 3000, 1, {}),
    ('walking', 3000, 1, {}), ('turned', 3000, 1, {}), ('turned', 100, 1, {}),
    ('shifted', 3000, 1, {}), ('wild', 3000, 1, {}), ('tails', 3000, 1, {}),
    ('good', 3000, 1, {'norms__total_error_max_deg': 0.05}),
    ('good', 3000, 1, {'sequential__plan_s': 6000.0}),
    ('good', 3000, 3, {}), ('good', 200, 3, {}), ('bad', 900, 3, {}), ('edge', 900, 4, {}),
    ('edge', 900, 4, {'campaign__rule': 'sensor'}), ('good', 130, 4, {'campaign__rule': 'sensor'}),
    ('walking', 900, 6, {'campaign__rule': 'sensor'}),
]


def cells(run):
    """Return the cells of the tables of a run by their names."""
    return {name: cell for rows in (RESULTS, GUARDED) for name, _, cell in rows_of(rows, run)}


def number(cell):
    """Return the number of a cell; None for a dash."""
    return None if cell == '-' else float(cell)


@pytest.mark.slow
@pytest.mark.parametrize('kind, n, runs, settings', FAMILY)
def test_no_figure_speaks_against_the_headline(kind, n, runs, settings, rng):
    verdict = judged(kind, n, rng, runs, **settings)
    risk = verdict.settings.risk
    for run in verdict.runs:
        shown = cells(run)
        sure = number(shown['confidence that the variance is at most A'])
        broken = number(shown['confidence that the variance is above R'])
        meets = number(shown['conformance probability'])
        if run.outcome is not Outcome.COMPLIANT:
            assert sure is None or sure < 1.0 - risk.alpha_consumer
            assert meets is None or meets < 1.0 - risk.alpha_consumer
        if run.outcome is not Outcome.NON_COMPLIANT:
            assert broken is None or broken < 1.0 - 0.9 * risk.alpha_producer
        upper = number(shown["upper bound U of the variance, at the consumer's risk"])
        if run.outcome is Outcome.INDETERMINATE and run.reason == run.guarded.reason:
            assert upper is None or upper > run.guarded.acceptance_limit_deg2
        factor = number(shown['length with which the run alone decides, times this one'])
        hours = number(shown['length with which the run alone decides'])
        if run.outcome is not Outcome.INDETERMINATE:
            assert factor is hours is None
        else:
            assert factor is None or factor > 1.0
            assert hours is None or hours * 3600.0 > run.coverage.span_s
            assert 'measure' in explain(run) or 'no length' in explain(run) or \
                'no longer record' in explain(run) or 'find their cause' in explain(run)
        if run.validity_effect == 'void':
            assert not {'COMPLIANT', 'NON-COMPLIANT'} & {*shown.values()}


@pytest.mark.slow
@pytest.mark.parametrize('kind, n, runs, settings', FAMILY)
def test_an_open_verdict_says_how_long_to_measure(kind, n, runs, settings, rng):
    verdict = judged(kind, n, rng, runs, **settings)
    for line in (verdict.headline, *map(explain, verdict.runs)):
        assert 'measure longer' not in line
        assert line.count('measure ') == len(re.findall(
            LENGTH + '|measure at least 128|measure again', line))


def test_the_family_has_every_kind_of_outcome(rng):
    """Otherwise the tests above prove little."""
    found = {(run.outcome, run.reason) for kind, n, runs, settings in FAMILY
             for run in judged(kind, n, rng, runs, **settings).runs}
    assert {outcome for outcome, _ in found} == {*Outcome}
    assert {reason for _, reason in found} >= {
        'insufficient_data', 'insufficient_duration', 'data_limited', 'slow_errors_not_resolved',
        'reference_limited', 'total_error_not_within_norm', 'void.convention',
        'outliers_decide', 'upper_bound_within_acceptance_limit',
        'lower_bound_above_rejection_limit', 'count_lower_bound_above_allowed'}


def test_a_short_sound_record_is_not_called_certain(rng):
    """It used to show a confidence of 0.999999 beside `shorter than a run must be`."""
    run = judged('good', 300, rng).runs[0]
    assert run.reason == 'insufficient_duration' and run.guarded.confidence_compliant > 0.9999
    shown = cells(run)
    assert shown['confidence that the variance is at most A'] == '-'
    assert shown['conformance probability'] == '-'
    hours = float(shown['length with which the run alone decides'])
    assert hours == pytest.approx(600.0 / 3600.0, rel=1e-5)


def test_a_length_of_an_earlier_version_that_is_shorter_than_the_run_is_not_shown(rng):
    """Version 0.1.0 said that 0.054 of the duration would do, and to measure longer."""
    run = judged('good', 300, rng).runs[0]
    run = replace(run, guarded=replace(run.guarded, duration_factor=0.054, hours_needed=0.0045))
    shown = cells(run)
    assert shown['length with which the run alone decides'] == '-'
    assert shown['length with which the run alone decides, times this one'] == '-'
    assert explain(run).endswith('measure 10 min (0.17 h) in all')
