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

"""All diagnostics of a run: faults are found, any n, the memory."""

from __future__ import annotations

import json
import math
import tracemalloc

import numpy as np
import pytest

from heading_intercompare.core.angles import wrap180
from heading_intercompare.core.decision.criteria import Limits
from heading_intercompare.core.decision.guarded import decide, gather_evidence
from heading_intercompare.core.diagnostics.assumptions import (
    MET,
    NOT_TESTABLE,
    VIOLATED,
)
from heading_intercompare.core.diagnostics.run_columns import RunColumns
from heading_intercompare.core.diagnostics.run_diagnostics import diagnose, with_runs
from heading_intercompare.core.diagnostics.run_findings import (
    describe_drift,
    left_in_deg2,
)
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.statistics.cells import Cells
from heading_intercompare.core.statistics.drift import remove_polynomial
from heading_intercompare.core.statistics.stationarity import (
    examine_homogeneity,
    RunFigures,
)
from heading_intercompare.core.timing.time_skew import Skew
from heading_intercompare.core.typed_reader import make_plain

SETTINGS = Settings.from_mapping(
    {'norms': {'sigma_max_deg': 0.2, 'sigma_ref_max_deg': 0.1, 'm_low': 0.5}})


def judged(x, stamps, span_s, limits, settings=SETTINGS):
    evidence = gather_evidence(Cells.of(x, stamps), n_plus=0, n_plus_plus=0, span_s=span_s,
                               mean_deg=float(x.mean()) if x.size else None)
    return decide(evidence, limits, settings.risk)


def run(x, rs, step_s=0.1, settings=SETTINGS, **columns):
    stamps = 10 ** 18 + np.arange(x.size) * round(step_s * 1e9)
    limits = Limits.of(settings.norms, settings.model)
    span_s = (x.size - 1) * step_s if x.size else 0.0
    guarded = judged(x, stamps, span_s, limits, settings)
    drift, rest = describe_drift(stamps, x, 0.1 * limits.sigma_max_deg)
    columns = RunColumns(stamps, x, np.asarray(rs), settings, limits, **columns)
    return diagnose(columns, guarded, drift=drift, rest=rest)


def states(found):
    return {a.id: a.state for a in found.assumptions}


@pytest.fixture
def good(ar1, yaw, rng):
    """Return differences and RS headings of a good hour at 10 Hz."""
    n = 36_000
    return 0.08 * ar1(n, 20.0) + 0.05 * rng.standard_normal(n), yaw(np.arange(n) / 10.0)


def test_a_good_run_bears_its_assumptions_out(good):
    found = run(*good)
    assert ''.join(a.id for a in found.assumptions) == 'abcdefghij'
    assert states(found) == {**dict.fromkeys('abcefhj', MET), **dict.fromkeys('dgi', NOT_TESTABLE)}
    assert found.warnings == ()
    assert found.skew.outcome_as_paired.value == 'compliant'
    assert found.correlation.closed


@pytest.mark.slow
def test_turning_the_ship_changes_no_finding(good):
    x, rs = good
    a, b = run(x, rs), run(x, (rs + 255.0) % 360.0)
    assert states(a) == states(b)
    assert b.skew.estimate.skew_s == pytest.approx(a.skew.estimate.skew_s, abs=1e-7)
    assert b.stationarity == a.stationarity
    assert b.correlation == a.correlation


def test_a_skew_is_shown_with_the_verdict_without_it(yaw, rng):
    n, t = 20_000, np.arange(20_000) / 10.0
    found = run(yaw(t - 0.4) - yaw(t) + 0.1 * rng.standard_normal(n), yaw(t))
    assert found.skew.estimate.skew_s == pytest.approx(0.4, abs=0.02)
    assert found.skew.outcome_as_paired.value == 'non_compliant'
    assert found.skew.outcome_aligned.value == 'compliant'
    assert found.skew.variance_aligned_deg2 == pytest.approx(0.01, rel=0.1)
    assert states(found)['b'] == VIOLATED
    assert any(w.startswith('timing: the TS data are 0.4') and 'older' in w
               for w in found.warnings)


def test_the_palmer_turns_from_non_compliant_to_compliant(real):
    """Norms 0.2 and 0.1 deg: sd 0.299 as logged, 0.143 aligned."""
    pairs, x = real('gyr1-s330')
    limits = Limits.of(SETTINGS.norms)
    guarded = judged(x, pairs.stamp_ns, 600.0, limits)
    drift, rest = describe_drift(pairs.stamp_ns, x, 0.1 * limits.sigma_max_deg)
    found = diagnose(RunColumns(pairs.stamp_ns, x, pairs.rs_deg, SETTINGS, limits), guarded,
                     drift=drift, rest=rest)
    assert found.skew.outcome_as_paired.value == 'non_compliant'
    assert found.skew.outcome_aligned.value == 'compliant'
    assert math.sqrt(found.skew.variance_aligned_deg2) == pytest.approx(0.143, abs=0.002)
    assert found.heading_dependence.reason == 'headings_too_narrow'


def test_a_skew_that_is_not_asked_for_is_not_estimated(good):
    settings = Settings.from_mapping({**SETTINGS.to_mapping(), 'alignment.skew': 'off'})
    found = run(*good, settings=settings)
    assert found.skew.estimate == Skew(0)
    assert states(found)['b'] == NOT_TESTABLE
    assert found.allan.reference_noise.sigma_ref_lower_deg in (None, 0.0)


def test_a_drift_is_a_drift_until_it_is_removed(good):
    x, rs = good
    x = x + np.linspace(0.0, 0.5, x.size)
    found = run(x, rs)
    assert (found.drift.order.order, states(found)['h'], states(found)['f']) == (1, VIOLATED, MET)
    assert found.drift.line.slope_deg_per_h == pytest.approx(0.5, abs=0.05)
    residual = remove_polynomial(np.arange(x.size), x, 1).residual_deg
    assert states(run(x, rs, residual_deg=residual))['h'] == MET


def test_a_warm_up_is_warned_of(good):
    x, rs = good
    found = run(x + np.exp(-np.arange(x.size) / 5000.0), rs)
    assert found.drift.warm_up.stabilization_s == pytest.approx(500.0 * math.log(50.0), rel=0.1)
    assert states(found)['c'] == VIOLATED
    assert any(w.startswith('warm_up: ') for w in found.warnings)


def test_a_coarse_sensor_is_warned_of(good):
    x, rs = good
    coarse = run(wrap180(np.round(rs + 0.01 * x, 1) - rs), rs % 360.0)
    assert any(w.startswith('resolution: ') for w in coarse.warnings)


def test_silences_are_warned_of(good):
    x, rs = good
    stamps = np.arange(x.size) * 10 ** 8
    stamps[x.size // 2:] += 30 * 10 ** 9
    limits = Limits.of(SETTINGS.norms)
    guarded = judged(x, stamps, 3600.0, limits)
    drift, rest = describe_drift(stamps, x, 0.1 * limits.sigma_max_deg)
    found = diagnose(RunColumns(stamps, x, rs, SETTINGS, limits), guarded, drift=drift, rest=rest)
    assert found.correlation.stamps.silences == 1
    assert any(w.startswith('silence: the pairs fall silent once, for up to 30.1 s')
               for w in found.warnings)


def test_ergodicity_is_filled_in_from_all_runs(good):
    found = run(*good)
    runs = examine_homogeneity([RunFigures(0.0, 1.0, 1.0, 20.0), RunFigures(0.1, 1.0, 1.0, 20.0)])
    changed = with_runs(found.assumptions, runs)
    assert [a.id for a in changed] == list('abcdefghij')
    assert changed[6].state == MET
    assert changed[:6] + changed[7:] == found.assumptions[:6] + found.assumptions[7:]


@pytest.mark.filterwarnings('error')
@pytest.mark.parametrize('n', [0, 1, 2, 3, 7, 8, 10, 16, 20, 31, 32, 63, 64, 65, 100, 127,
                               128, 129])
def test_any_number_of_pairs_gives_figures_or_none(n, rng):
    """Not a number in the JSON, and no warning of numpy; frozen, turning, noisy."""
    with np.errstate(divide='raise', over='raise', invalid='raise'):
        for x in (np.zeros(n), np.full(n, 0.1), np.full(n, -180.0), rng.standard_normal(n)):
            for rs in (np.full(n, 10.0), np.arange(n) * 3.3 % 360.0):
                found = run(x, rs)
                json.dumps(make_plain(found), allow_nan=False)
                assert len(found.assumptions) == 10
                assert n >= 64 or not any(a.state == MET for a in found.assumptions
                                          if a.id != 'j')


@pytest.mark.slow
def test_a_long_run_takes_little_memory(ar1, yaw):
    """Ten numbers a pair besides the columns; six, 220 MB, for 12 h at 100 Hz."""
    n = 1_000_000
    x, rs = 0.1 * ar1(n, 1000.0), yaw(np.arange(n) / 100.0)
    tracemalloc.start()
    run(x, rs, 0.01)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 80 * n


def test_the_drift_left_in_is_that_of_the_block(rng):
    stamps = np.arange(4000) * 10 ** 8
    for slope in (0.0, 2e-4):
        x = slope * np.arange(4000) + rng.standard_normal(4000)
        assert left_in_deg2(stamps, x) == describe_drift(stamps, x, 0.1)[0].left_deg2
    assert left_in_deg2(stamps[:0], x[:0]) == 0.0
