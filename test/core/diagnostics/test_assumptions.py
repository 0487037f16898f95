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

"""The assumptions (a) to (j): each state by its figures, and the states not testable."""

from __future__ import annotations

from dataclasses import replace
import math

import numpy as np
import pytest

from heading_intercompare.core.conditions.common_glitches import CommonGlitches
from heading_intercompare.core.conditions.common_noise import CommonNoise, FollowedNoise
from heading_intercompare.core.conditions.one_source import OneSource, SameSource
from heading_intercompare.core.diagnostics import assumptions
from heading_intercompare.core.diagnostics.assumptions import (
    MET,
    model_kurtosis,
    NOT_TESTABLE,
    VIOLATED,
)
from heading_intercompare.core.diagnostics.deviation import HeadingDependence
from heading_intercompare.core.statistics.drift import Order, Slope
from heading_intercompare.core.statistics.normality import measure_shape
from heading_intercompare.core.statistics.stationarity import (
    examine_homogeneity,
    RunFigures,
    Stationarity,
)
from heading_intercompare.core.statistics.variance_uncertainty import Spread
from heading_intercompare.core.statistics.warm_up import WarmUp
from heading_intercompare.core.timing.time_skew import Skew

SKEWED = Skew(5000, rs_rate_std_deg_s=0.5, rate_std_deg_s=0.5, strength=400.0, skew_s=0.3,
              u_s=0.01, interval_s=(0.28, 0.32), well_determined=True, significant=True,
              std_deg=0.2, std_aligned_deg=0.13)
STEADY = Stationarity(20, 30.0, 0.3, 0.7, -0.2, 0.8, 0.1, 11, 0.6)
WARM = WarmUp(0.0, 1.0, 300.0, 0.02, 1173.6, True, 3600.0)
LINE = Slope(0.1, 0.0, 0.02, 0.05, (-0.02, 0.22), 4.0, 0.1)
NOT_ROUND = HeadingDependence(5000, 'headings_too_narrow', 300.0, 1e6)
TWO = OneSource(SameSource(False, 0.1, 0.03), CommonNoise(),
                CommonGlitches('not_testable'))


def state(assumption):
    assert assumption.statement == assumptions.STATEMENTS[assumption.id]
    assert assumption.evidence
    return assumption.id, assumption.state


@pytest.mark.parametrize('n, nu, resolved, expected', [
    (0, None, False, NOT_TESTABLE), (127, None, False, VIOLATED), (9991, 7.0, True, VIOLATED),
    (9991, 15.0, True, MET), (9991, 20.0, False, NOT_TESTABLE), (9991, 7.0, False, VIOLATED)])
def test_a_counts_independent_differences(n, nu, resolved, expected):
    assert state(assumptions.judge_large_n(n, nu, resolved)) == ('a', expected)


@pytest.mark.parametrize('low, middle, expected', [
    (0.0101, 0.0, False), (0.0099, 0.0, True), (0.02, 0.0099, False), (0.03, 0.016, True),
    (0.05, 0.01, False), (0.001, 0.0001, True), (0.0, 0.0, True)])
def test_slow_errors_are_told_from_a_change_unless_they_stand_out_and_weigh(low, middle,
                                                                            expected):
    """More than 2 of the middle, and 4 (low - middle) more than 0.05 of a variance of 0.8."""
    found = Spread(1000, 0, 0.8, 0.01, 0.1, 128.0, 60.0, 20.0, low, middle)
    assert assumptions.is_resolved(found) is expected
    assert assumptions.is_resolved(None) is False


def test_b_weighs_the_skew_by_what_it_adds():
    """(0.32 0.5)^2 = 0.0256 of 0.04 is 64 %; of a variance of 1 it is 2.6 %."""
    found = assumptions.judge_synchronous(SKEWED, 2.0)
    assert state(found) == ('b', VIOLATED)
    assert '64 %' in found.evidence
    assert state(assumptions.judge_synchronous(replace(SKEWED, std_deg=1.0), 2.0)) == ('b', MET)
    vague = replace(SKEWED, interval_s=(-0.1, 0.4), significant=False)
    assert state(assumptions.judge_synchronous(vague, 2.0)) == ('b', NOT_TESTABLE)


@pytest.mark.parametrize('kind', ['not_turned', 'no_fit', 'unclear'])
@pytest.mark.parametrize('rate_deg_s', [0.01, 0.1])
def test_b_is_not_met_where_no_skew_shows(kind, rate_deg_s):
    """With 0.01 deg/s two seconds add 0.0004 of 0.04, but nobody knows that it is two seconds."""
    still = Skew(5000, kind, rs_rate_std_deg_s=rate_deg_s, strength=1.0, well_determined=False,
                 std_deg=0.2, skew_s=0.1, u_s=0.9, searched_s=300.0)
    found = assumptions.judge_synchronous(still, 2.0)
    assert state(found) == ('b', NOT_TESTABLE)
    assert ('up to 300 s (alignment.clock_range_s)' in found.evidence) == (kind == 'no_fit')


def test_b_of_clocks_that_lie_apart():
    apart = Skew(5000, 'beyond', beyond_s=79.5, well_determined=False, also_s=-510.5)
    found = assumptions.judge_synchronous(apart, 2.0)
    assert state(found) == ('b', VIOLATED)
    assert 'about 79.5 s (or about -510.5 s)' in found.evidence


def test_b_of_too_little_data():
    still = Skew(5000, rs_rate_std_deg_s=0.01, strength=1.0, well_determined=False, std_deg=0.2)
    assert state(assumptions.judge_synchronous(Skew(0), 2.0)) == ('b', NOT_TESTABLE)
    assert state(assumptions.judge_synchronous(replace(still, std_deg=0.0),
                                               2.0)) == ('b', NOT_TESTABLE)


@pytest.mark.parametrize('warm_up, expected', [
    (None, NOT_TESTABLE), (WARM, VIOLATED), (replace(WARM, preferred=False), MET),
    (replace(WARM, settle_s=0.0), MET), (replace(WARM, settle_s=9999.0), VIOLATED)])
def test_c_looks_for_a_warm_up(warm_up, expected):
    assert state(assumptions.judge_stabilized(warm_up)) == ('c', expected)


@pytest.mark.parametrize('lower, upper, m_low, expected', [
    (None, None, 0.5, NOT_TESTABLE), (0.05, 0.04, 0.5, NOT_TESTABLE),
    (0.11, 0.04, 0.5, VIOLATED), (None, 0.0024, 0.5, VIOLATED), (None, 0.0026, 0.5, NOT_TESTABLE),
    (0.05, None, 0.5, NOT_TESTABLE)])
def test_d_compares_the_noise_of_the_rs_with_its_norm(lower, upper, m_low, expected):
    """Norm 0.1 deg, at least half of it: 0.0025 deg^2."""
    assert state(assumptions.judge_reference_norm(lower, 0.1, upper, m_low)) == ('d', expected)


@pytest.mark.parametrize('interval, variant, expected', [
    (None, 'B', NOT_TESTABLE), ((-0.05, 0.06), 'A', MET), ((0.01, 0.06), 'A', MET),
    ((0.1, 0.2), 'A', VIOLATED), ((0.1, 0.2), 'B', NOT_TESTABLE),
    ((-0.1, 0.2), 'A', NOT_TESTABLE)])
def test_e_takes_a_small_mean_for_a_small_offset(interval, variant, expected):
    """A third of 0.2 deg is small."""
    assert state(assumptions.judge_installation(interval, 0.2, variant)) == ('e', expected)


def test_f_needs_a_stationary_rest():
    order = Order(1, (0.0,) * 5, 100, False)
    changing = replace(STEADY, square_p=0.001)
    assert state(assumptions.judge_drift_and_stationary(order, STEADY, True)) == ('f', MET)
    assert state(assumptions.judge_drift_and_stationary(order, changing, True)) == ('f', VIOLATED)
    assert state(assumptions.judge_drift_and_stationary(order, changing,
                                                        False)) == ('f', NOT_TESTABLE)
    assert state(assumptions.judge_drift_and_stationary(None, STEADY, True)) == ('f', NOT_TESTABLE)


def test_g_needs_several_runs():
    alike = [RunFigures(0.0, 1.0, 1.0, 20.0), RunFigures(0.5, 1.0, 1.1, 20.0)]
    shifted = [alike[0], RunFigures(9.0, 1.0, 1.1, 20.0)]
    noisier = [alike[0], RunFigures(0.5, 1.0, 9.0, 20.0)]
    assert state(assumptions.judge_ergodic(None)) == ('g', NOT_TESTABLE)
    assert state(assumptions.judge_ergodic(examine_homogeneity(alike[:1]))) == ('g', NOT_TESTABLE)
    assert state(assumptions.judge_ergodic(examine_homogeneity(alike))) == ('g', MET)
    found = assumptions.judge_ergodic(examine_homogeneity(shifted))
    assert state(found) == ('g', VIOLATED)
    assert 'variant C' in found.evidence
    assert state(assumptions.judge_ergodic(examine_homogeneity(noisier))) == ('g', VIOLATED)


def test_h_sees_trends_and_the_heading():
    def judged(found, dependence=NOT_ROUND, resolved=True):
        return state(assumptions.judge_constant_moments(found, LINE, 1.0, dependence, resolved))
    round_trip = replace(NOT_ROUND, reason='', amplitude_deg=0.4, p=1e-5)
    assert judged(STEADY) == ('h', MET)
    assert judged(replace(STEADY, mean_p=0.003)) == ('h', VIOLATED)
    assert judged(replace(STEADY, kpss_p=0.003)) == ('h', VIOLATED)
    assert judged(replace(STEADY, mean_p=0.003), resolved=False) == ('h', NOT_TESTABLE)
    assert judged(STEADY, round_trip) == ('h', VIOLATED)
    assert judged(STEADY, replace(round_trip, p=0.02)) == ('h', MET)
    assert judged(Stationarity(blocks=0)) == ('h', NOT_TESTABLE)


def test_i_is_never_said_to_be_met():
    assert state(assumptions.judge_correlated_errors(0.04, 0.1, TWO)) == ('i', NOT_TESTABLE)
    assert state(assumptions.judge_correlated_errors(None, 0.1, TWO)) == ('i', NOT_TESTABLE)
    assert state(assumptions.judge_correlated_errors(0.009, 0.1, TWO)) == ('i', VIOLATED)
    rounding = replace(TWO, readings=SameSource(True, 0.03, 0.03))
    for one in (rounding, replace(TWO, noise=CommonNoise(of_rs=FollowedNoise('common'))),
                replace(TWO, glitches=CommonGlitches('common'))):
        assert state(assumptions.judge_correlated_errors(0.04, 0.1, one)) == ('i', VIOLATED)
    # A coarse TS that does not follow the noise of the RS is a sensor of its own.
    own = replace(rounding, noise=CommonNoise(of_rs=FollowedNoise('independent')))
    assert state(assumptions.judge_correlated_errors(0.04, 0.1, own)) == ('i', NOT_TESTABLE)


@pytest.mark.parametrize('model, share, kurtosis', [
    ('NN', 0.3, 0.0), ('UN', 0.0, -1.2), ('UN', 1.0, 0.0), ('NU', 0.0, 0.0), ('NU', 1.0, -1.2),
    ('UU', 0.5, -0.6), ('UU', 0.0, -1.2)])
def test_the_kurtosis_of_the_models_by_hand(model, share, kurtosis):
    assert model_kurtosis(model, share) == pytest.approx(kurtosis)


def test_the_kurtosis_of_a_model_agrees_with_simulation(rng):
    """A million differences, six standard errors sqrt(24/n)."""
    n = 1_000_000
    x = math.sqrt(3.0) * rng.uniform(-1.0, 1.0, n) + 0.7 * rng.standard_normal(n)
    found = measure_shape(x)
    assert found.excess_kurtosis == pytest.approx(
        model_kurtosis('UN', 0.49 / 1.49), abs=6.0 * math.sqrt(24.0 / n))


def test_j_holds_the_data_against_the_model(rng):
    n = 20_000
    uniform = 0.1 * math.sqrt(3.0) * rng.uniform(-1.0, 1.0, n) + 0.02 * rng.standard_normal(n)
    normal = 0.1 * rng.standard_normal(n)
    skewed = 0.1 * rng.exponential(1.0, n)

    def judged(x, model, nu=None, reference=(0.0, 0.03)):
        return state(assumptions.judge_laws(measure_shape(x, nu), model, reference))
    assert judged(uniform, 'UN') == ('j', MET)
    assert judged(uniform, 'NN') == ('j', VIOLATED)
    assert judged(normal, 'NN') == ('j', MET)
    assert judged(normal, 'UN') == ('j', VIOLATED)
    assert judged(skewed, 'NN') == ('j', VIOLATED)
    assert judged(skewed, 'NN', 10.0) == ('j', NOT_TESTABLE)
    assert judged(np.full(100, 0.2), 'NN') == ('j', NOT_TESTABLE)


def test_j_takes_any_kurtosis_between_the_bounds_of_the_rs(rng):
    """U + N: an RS from none to all of the variance gives from -1.2 to 0."""
    x = math.sqrt(3.0) * rng.uniform(-1.0, 1.0, 5000) + rng.standard_normal(5000)
    assert assumptions.judge_laws(measure_shape(x), 'UN', (0.0, 5.0)).state == MET
    assert assumptions.judge_laws(measure_shape(x), 'UN', (0.0, 0.1)).state == VIOLATED


def test_an_order_of_the_drift_that_changes_from_run_to_run_is_told():
    runs = [RunFigures(0.0, 1.0, 1.0, 20.0, order) for order in (0, 2)]
    assert assumptions.judge_ergodic(examine_homogeneity(runs)).evidence.endswith(
        'the order of their drift is not constant: 0, 2')
    same = [RunFigures(0.0, 1.0, 1.0, 20.0, 1)] * 2
    assert 'order' not in assumptions.judge_ergodic(examine_homogeneity(same)).evidence
