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

"""The guarded decision: each row of its table, degenerate data, measured risks."""

from __future__ import annotations

from dataclasses import fields, replace
import math

import numpy as np
import pytest
from scipy.signal import lfilter
from scipy.special import ndtr
from scipy.stats import t as student

from heading_intercompare.core.decision.criteria import Limits
from heading_intercompare.core.decision.guarded import (
    count_risk,
    decide,
    gather_evidence,
    Guarded,
    REASONS,
    variance_risk,
)
from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.settings import Norms, Risk
from heading_intercompare.core.statistics.cells import Cells
from heading_intercompare.core.statistics.confidence_bounds import (
    confidence,
    duration_factor,
    mean_confidence,
)
from heading_intercompare.core.statistics.variance_uncertainty import (
    estimate_spread,
    lower_bound,
    upper_bound,
)
from heading_intercompare.core.typed_reader import make_plain

pytestmark = pytest.mark.filterwarnings('error')

KEYS = """
d_hat_deg2 nu f corner_j r_slow slow_variance_deg2 slow_allowance_deg2 stated_times
upper_bound_deg2 lower_bound_deg2 acceptance_limit_deg2 rejection_limit_deg2
sigma_ts_lower_deg sigma_ts_upper_deg confidence_compliant confidence_non_compliant
conformance_probability duration_factor hours_needed m_low_needed bias_u_deg bias_interval_deg
bias_significant rate_plus rate_plus_plus rate_plus_lower rate_plus_plus_upper
count_outcome outcome reason
""".split()


ANY = Risk(min_duration_s=0.0)
"""Risks that allow runs of any length."""


def limits_of(sigma=1.0, ref=0.5, m_low=0.9, m_up=1.0, p=0.997, factor=1.0, ts_factor=1.0):
    return Limits.of(Norms(sigma_max_deg=sigma, sigma_ref_max_deg=ref, m_low=m_low, m_up=m_up,
                           probability=p), 'NN', factor, ts_factor)


def judged(x, limits=None, risk=None, span_s=None, **given):
    """Return the decision on differences, with counts about their mean."""
    x = np.asarray(x, dtype=np.float64)
    limits, risk = limits or limits_of(), risk or ANY
    deviation = np.abs(x - x.mean()) if x.size else x
    evidence = gather_evidence(
        Cells.of(x), n_plus=int(np.sum(deviation > limits.count_limit_deg)),
        n_plus_plus=int(np.sum(deviation > limits.tightened_count_limit_deg)),
        span_s=max(0, x.size - 1) / 10.0 if span_s is None else span_s,
        **{'mean_deg': float(x.mean()) if x.size else None, **given})
    return decide(evidence, limits, risk)


def ar1(rows, n, tau, rng):
    """Return rows of AR(1) noise of unit variance in its stationary state."""
    phi = math.exp(-1.0 / tau)
    start = phi * rng.standard_normal((rows, 1))
    white = rng.standard_normal((rows, n)) * math.sqrt(1.0 - phi * phi)
    return lfilter([1.0], [1.0, -phi], white, axis=1, zi=start)[0]


def scaled(x, variance):
    """Return the series with this variance D."""
    return x * math.sqrt(variance / estimate_spread(Cells.of(x)).d_deg2)


# --- the form ---

def test_the_fields_are_the_keys_of_the_json():
    assert [f.name for f in fields(Guarded)] == KEYS


def test_all_reasons_are_codes_with_words():
    assert len(REASONS) == 8
    assert all(text and code == code.lower() for code, text in REASONS.items())


# --- the table, row by row; A = 1 + 0.45^2 = 1.2025, R = 1.25 ---

def test_upper_bound_within_the_acceptance_limit_complies(rng):
    got = judged(scaled(rng.standard_normal(20_000), 1.0))
    assert (got.outcome, got.reason) == (Outcome.COMPLIANT, 'upper_bound_within_acceptance_limit')
    assert got.acceptance_limit_deg2 == pytest.approx(1.2025)
    assert got.rejection_limit_deg2 == pytest.approx(1.25)
    assert got.upper_bound_deg2 <= 1.2025
    assert got.confidence_compliant >= 0.95
    assert got.duration_factor == 1.0 and got.hours_needed == pytest.approx(1999.9 / 3600.0)


def test_lower_bound_above_the_rejection_limit_does_not_comply(rng):
    got = judged(scaled(rng.standard_normal(20_000), 1.5), span_s=0.0,
                 risk=Risk(min_duration_s=1e6))
    assert got.outcome is Outcome.NON_COMPLIANT
    assert got.reason == 'lower_bound_above_rejection_limit'
    assert got.confidence_non_compliant >= 0.95


def test_a_run_is_as_long_as_its_slowest_error_asks():
    """Twenty times 100 s; 600 s if nothing is stated. The result says how much longer."""
    x = scaled(np.random.default_rng(1).standard_normal(20_000), 1.0)
    for risk, least_s in ((Risk(), 600.0), (Risk(slowest_error_s=100.0), 2000.0),
                          (Risk(slowest_error_s=1.0, min_duration_s=50.0), 50.0)):
        short, long = (judged(x, risk=risk, span_s=s) for s in (0.5 * least_s, least_s))
        assert short.reason == 'insufficient_duration' and long.outcome is Outcome.COMPLIANT
        assert short.duration_factor == pytest.approx(2.0)
        assert short.hours_needed == pytest.approx(least_s / 3600.0)
        assert long.duration_factor == 1.0


def test_a_drift_left_in_that_may_break_the_norm_by_itself_does_not_comply(rng):
    """D = 1.0 and A = 1.2025: a bound of the drift of 0.2 leaves room, one of 0.21 does not."""
    x = scaled(rng.standard_normal(20_000), 1.0)
    assert judged(x, drift_left_deg2=0.2).outcome is Outcome.COMPLIANT
    got = judged(x, drift_left_deg2=0.21)
    assert (got.outcome, got.reason) == (Outcome.INDETERMINATE, 'drift_left_in')
    bad = judged(scaled(x, 1.5), drift_left_deg2=9.0)
    assert bad.outcome is Outcome.NON_COMPLIANT


def test_a_variance_above_its_limit_within_its_own_error_stays_open(rng):
    got = judged(scaled(rng.standard_normal(300), 1.3))
    assert (got.outcome, got.reason) == (Outcome.INDETERMINATE, 'data_limited')
    assert 1.0 < got.duration_factor < math.inf


def test_a_variance_known_well_between_the_limits_waits_for_the_reference(rng):
    limits = limits_of(ref=1.0, m_low=0.0)
    got = judged(scaled(rng.standard_normal(20_000), 1.5), limits)
    assert (got.outcome, got.reason) == (Outcome.INDETERMINATE, 'reference_limited')
    assert got.duration_factor == got.hours_needed == math.inf


def test_a_short_run_may_be_rejected_but_not_accepted(rng):
    x = scaled(rng.standard_normal(20_000), 1.0)
    got = judged(x, risk=Risk(min_duration_s=2000.0), span_s=1999.9)
    assert (got.outcome, got.reason) == (Outcome.INDETERMINATE, 'insufficient_duration')
    assert got.count_outcome is not Outcome.COMPLIANT
    assert judged(x, risk=Risk(min_duration_s=2000.0), span_s=2000.0).outcome \
        is Outcome.COMPLIANT


def test_a_slow_part_that_shows_is_not_resolved(rng):
    """Without the allowance the bound is within A; with it, it is not: a drift under noise."""
    x = scaled(np.linspace(-1.0, 1.0, 5000) + 0.5 * rng.standard_normal(5000), 0.4)
    got = judged(x)
    assert got.r_slow > 45.0 and got.slow_variance_deg2 > 0.2
    assert got.upper_bound_deg2 > 1.2025 >= got.upper_bound_deg2 - got.slow_allowance_deg2
    assert (got.outcome, got.reason) == (Outcome.INDETERMINATE, 'slow_errors_not_resolved')
    assert got.duration_factor == math.inf


def test_a_slow_part_without_weight_does_not_matter(rng):
    x = scaled(0.05 * np.linspace(-1.0, 1.0, 5000) + rng.standard_normal(5000), 0.5)
    assert judged(x).outcome is Outcome.COMPLIANT


def test_a_slow_error_far_above_the_limit_is_rejected():
    """A ramp has few degrees of freedom: L is about half of D, and no row stands before L > R."""
    x = np.linspace(-1.0, 1.0, 5000)
    low = judged(x).lower_bound_deg2 / judged(x).d_hat_deg2
    assert 0.4 < low < 0.6
    below, above = judged(scaled(x, 1.24 / low)), judged(scaled(x, 1.26 / low))
    assert below.outcome is Outcome.INDETERMINATE
    assert (above.outcome, above.reason) == \
        (Outcome.NON_COMPLIANT, 'lower_bound_above_rejection_limit')


# --- the figures by another route ---

def test_figures_follow_from_the_spread(rng):
    x = 0.4 + ar1(1, 20_000, 5.0, rng)[0]
    limits = limits_of(factor=2.0 / 3.0)
    risk = replace(ANY, alpha_consumer=0.02, alpha_producer=0.1, count_share=0.25)
    got = judged(x, limits, risk, offset_u_deg=0.05)
    s = estimate_spread(Cells.of(x))
    assert (got.d_hat_deg2, got.nu, got.f, got.corner_j) == (s.d_deg2, s.nu, s.f, s.corner_j)
    assert (got.r_slow, got.slow_variance_deg2, got.slow_allowance_deg2) == \
        (s.r_slow, s.slow_variance_deg2, s.slow_allowance_deg2)
    assert got.acceptance_limit_deg2 == pytest.approx(1.0 + 0.45 ** 2 * 2.0 / 3.0)
    assert got.upper_bound_deg2 == upper_bound(s, 0.02)
    assert got.lower_bound_deg2 == lower_bound(s, variance_risk(risk))
    assert got.sigma_ts_lower_deg == pytest.approx(math.sqrt(got.lower_bound_deg2 - 0.25))
    assert got.sigma_ts_upper_deg == \
        pytest.approx(math.sqrt(got.upper_bound_deg2 - 0.2025 * 2.0 / 3.0))
    assert got.confidence_compliant == confidence(s, got.acceptance_limit_deg2)
    assert got.confidence_non_compliant == 1.0 - confidence(s, 1.25)
    assert got.conformance_probability == \
        mean_confidence(s, 1.0, 0.45 * math.sqrt(2.0 / 3.0), 0.5)
    # An interpolated TS shows as little as two thirds of its variance; the lower bound stays.
    of_ts = judged(x, limits_of(ts_factor=2.0 / 3.0), risk, offset_u_deg=0.05)
    assert of_ts.sigma_ts_upper_deg == \
        pytest.approx(math.sqrt((of_ts.upper_bound_deg2 - 0.2025) * 1.5))
    assert of_ts.sigma_ts_lower_deg == pytest.approx(math.sqrt(of_ts.lower_bound_deg2 - 0.25))
    assert of_ts.conformance_probability == mean_confidence(s, math.sqrt(2.0 / 3.0), 0.45, 0.5)
    assert got.duration_factor == \
        duration_factor(s, got.acceptance_limit_deg2, 1.25, 0.02, variance_risk(risk))
    assert got.hours_needed == pytest.approx(got.duration_factor * 1999.9 / 3600.0)
    assert got.bias_u_deg == pytest.approx(math.hypot(math.sqrt(s.mean_variance_deg2), 0.05))
    half = student.ppf(0.975, 8) * got.bias_u_deg
    assert got.bias_interval_deg == pytest.approx((x.mean() - half, x.mean() + half))
    assert got.bias_significant is True


def test_variance_and_counts_share_the_producers_risk():
    """By default 0.1 of it is for the counts; the two parts together never exceed it."""
    assert (variance_risk(Risk()), count_risk(Risk())) == pytest.approx((0.045, 0.005))
    for share in (0.001, 0.3, 0.999):
        risk = Risk(alpha_producer=0.08, count_share=share)
        assert variance_risk(risk) + count_risk(risk) == pytest.approx(0.08, rel=1e-12)
        assert count_risk(risk) == pytest.approx(0.08 * share)


def test_chunks_say_the_same_as_the_whole(rng):
    x = rng.standard_normal(5000)
    given = {'n_plus': 3, 'n_plus_plus': 5, 'span_s': 10.0, 'mean_deg': 0.0}
    parts = Cells()
    for lo in range(0, 5000, 777):
        parts.update(x[lo:lo + 777])
    limits = limits_of()
    assert decide(gather_evidence(parts, **given), limits, ANY) == \
        decide(gather_evidence(Cells.of(x), **given), limits, ANY)


def test_residuals_of_a_polynomial_lose_its_degrees_of_freedom(rng):
    t = np.linspace(-1.0, 1.0, 3000)
    x = rng.standard_normal(3000) + 7.0 + 4.0 * t
    residual = x - np.polynomial.Polynomial.fit(t, x, 1)(t)
    got = judged(residual, order=1, mean_deg=7.0)
    assert got.d_hat_deg2 == estimate_spread(Cells.of(residual), 1).d_deg2
    assert got.slow_allowance_deg2 < 0.1 < judged(x).slow_allowance_deg2
    low, up = got.bias_interval_deg
    assert (low + up) / 2.0 == pytest.approx(7.0)
    assert judged(np.zeros(200), order=3, mean_deg=0.0).nu == 196.0


def test_known_reference_leaves_one_point_of_conformance(rng):
    got = judged(rng.standard_normal(3000), limits_of(m_low=0.8, m_up=0.8))
    assert got.acceptance_limit_deg2 == got.rejection_limit_deg2
    assert got.conformance_probability == pytest.approx(got.confidence_compliant)
    assert got.confidence_compliant + got.confidence_non_compliant == pytest.approx(1.0)


# --- counts ---

def evidence(n_plus, n_plus_plus, rng, n=200_000):
    """Return evidence of white errors with these counts."""
    return gather_evidence(Cells.of(scaled(rng.standard_normal(n), 1.0)), n_plus=n_plus,
                           n_plus_plus=n_plus_plus, span_s=1e5, mean_deg=0.0)


@pytest.mark.parametrize('n_plus, n_plus_plus, outcome', [
    (0, 0, Outcome.COMPLIANT), (100, 480, Outcome.COMPLIANT), (100, 600, Outcome.INDETERMINATE),
    (620, 640, Outcome.INDETERMINATE), (800, 900, Outcome.NON_COMPLIANT)])
def test_counts_decide_with_their_bounds(n_plus, n_plus_plus, outcome, rng):
    """600 of 200 000 is the rate allowed; its standard error is at least 24."""
    got = decide(evidence(n_plus, n_plus_plus, rng), limits_of(), ANY)
    assert got.count_outcome is outcome
    assert (got.rate_plus, got.rate_plus_plus) == (n_plus / 2e5, n_plus_plus / 2e5)
    assert got.rate_plus_lower <= got.rate_plus and got.rate_plus_plus_upper > got.rate_plus_plus


def test_correlation_widens_the_bounds_of_counts(rng):
    """The same rates in 16 384 samples: white, and with two hundred per correlation time."""
    white, slow = rng.standard_normal(16_384), ar1(1, 16_384, 30.0, rng)[0]
    given = {'n_plus': 80, 'n_plus_plus': 90, 'span_s': 1e4, 'mean_deg': 0.0}
    a, b = (decide(gather_evidence(Cells.of(x), **given), limits_of(), ANY)
            for x in (white, slow))
    assert a.rate_plus_lower > 2.0 * b.rate_plus_lower
    assert b.rate_plus_plus_upper - b.rate_plus_plus > \
        2.0 * (a.rate_plus_plus_upper - a.rate_plus_plus)


# --- degenerate data ---

@pytest.mark.parametrize('n', [0, 1, 2, 127])
def test_fewer_than_128_differences_are_too_few(n, rng):
    got = judged(rng.standard_normal(n))
    assert (got.outcome, got.reason) == (Outcome.INDETERMINATE, 'insufficient_data')
    assert got.count_outcome is Outcome.INDETERMINATE
    assert got.acceptance_limit_deg2 == pytest.approx(1.2025)
    known = {'acceptance_limit_deg2', 'rejection_limit_deg2', 'count_outcome', 'outcome',
             'reason'} | ({'rate_plus', 'rate_plus_plus'} if n else set())
    assert {k for k in KEYS if getattr(got, k) is not None} == known


def test_128_differences_are_enough(rng):
    got = judged(scaled(rng.standard_normal(128), 0.1))
    assert got.reason == 'upper_bound_within_acceptance_limit'


@pytest.mark.parametrize('n', [128, 200, 5000])
@pytest.mark.parametrize('value', [0.0, 0.1, -179.99])
def test_equal_differences_have_zero_bounds(n, value):
    got = judged(np.full(n, value))
    assert (got.d_hat_deg2, got.upper_bound_deg2, got.lower_bound_deg2) == (0.0, 0.0, 0.0)
    assert got.nu == got.f == n - 1
    assert (got.corner_j, got.r_slow, got.slow_allowance_deg2) == (math.inf, 0.0, 0.0)
    assert got.outcome is Outcome.COMPLIANT
    assert (got.sigma_ts_lower_deg, got.sigma_ts_upper_deg) == (0.0, 0.0)
    assert got.bias_interval_deg == pytest.approx((value, value), rel=1e-14)
    assert got.bias_significant is (value != 0.0)


@pytest.mark.parametrize('x', [
    np.tile([1.0, -1.0], 100), np.repeat([0.0, 1.0], 80), np.append(np.zeros(199), 1e6),
    np.append(1e-200, np.zeros(199)), np.arange(128.0), np.tile([0.01, 0.02], 400)],
    ids=['alternating', 'one step', 'one outlier', 'denormal', 'ramp', 'two values'])
@pytest.mark.parametrize('ref', [0.0, 0.5])
def test_no_figure_is_ever_nan(x, ref):
    got = judged(x, limits_of(ref=ref))
    for name in KEYS:
        value = getattr(got, name)
        # Only what nothing is stated of is missing.
        assert (value is not None) or name in ('stated_times', 'm_low_needed')
        numbers = value if isinstance(value, tuple) else (value,)
        assert not any(isinstance(v, float) and math.isnan(v) for v in numbers), name
    assert set(KEYS) - set(make_plain(got)) <= {'stated_times', 'm_low_needed'}
    for name in ('confidence_compliant', 'confidence_non_compliant', 'conformance_probability',
                 'rate_plus_lower', 'rate_plus_plus_upper'):
        assert 0.0 <= getattr(got, name) <= 1.0


def test_an_alternating_series_counts_all_its_samples():
    """Equal squares in all cells scatter not at all: nearly as many as samples, 200 / 1.15."""
    assert judged(np.tile([1.0, -1.0], 100)).nu == pytest.approx(200.0 / 1.15)


def test_data_that_bound_nothing_give_null_and_stay_open():
    """One outlier among 200: the upper bound is infinite, which JSON holds as null."""
    got = judged(np.append(np.zeros(199), 0.1))
    assert got.upper_bound_deg2 == got.sigma_ts_upper_deg == math.inf
    assert (got.outcome, got.reason) == (Outcome.INDETERMINATE, 'data_limited')
    assert make_plain(got)['upper_bound_deg2'] is None


# --- properties ---

@pytest.mark.parametrize('offset', [-170.0, 3.0])
def test_an_offset_changes_the_bias_and_nothing_else(offset, rng):
    x = np.rint(ar1(1, 5000, 4.0, rng)[0] * 2 ** 20) / 2 ** 20
    a, b = make_plain(judged(x)), make_plain(judged(x + offset))
    for name in KEYS:
        if not name.startswith('bias'):
            assert a.get(name) == (pytest.approx(b[name], rel=1e-9) if isinstance(
                b.get(name), float) else b.get(name)), name


def test_the_unit_of_the_angle_does_not_matter(rng):
    x = ar1(1, 5000, 4.0, rng)[0]
    a = judged(x, limits_of(1.0, 0.5))
    b = judged(x * 0.125, limits_of(0.125, 0.0625))
    same = ('nu', 'f', 'corner_j', 'r_slow', 'confidence_compliant', 'confidence_non_compliant',
            'conformance_probability', 'duration_factor', 'rate_plus', 'rate_plus_lower')
    assert [getattr(a, k) for k in same] == pytest.approx([getattr(b, k) for k in same],
                                                          rel=1e-9)
    assert (a.outcome, a.reason, a.count_outcome) == (b.outcome, b.reason, b.count_outcome)
    assert a.upper_bound_deg2 == pytest.approx(64.0 * b.upper_bound_deg2, rel=1e-12)


def test_less_risk_never_turns_a_verdict_over(rng):
    rank = {Outcome.COMPLIANT: 1, Outcome.INDETERMINATE: 0, Outcome.NON_COMPLIANT: -1}
    for variance in (0.9, 1.1, 1.2, 1.3, 1.6):
        x = scaled(rng.standard_normal(2000), variance)
        ranks = [rank[judged(x, risk=replace(ANY, alpha_consumer=a, alpha_producer=a)).outcome]
                 for a in (0.3, 0.05, 0.001, 1e-6)]
        assert len({r for r in ranks if r}) <= 1
        assert np.all(np.diff(np.abs(ranks)) <= 0)


# --- measured ---

def narrow_band(rows, n, coherence, rng, period=12.0):
    """Return rows of unit variance whose envelope is AR(1)."""
    turn = 2.0 * np.pi * np.arange(n) / period
    envelopes = ar1(rows, n, coherence, rng), ar1(rows, n, coherence, rng)
    return envelopes[0] * np.cos(turn) + envelopes[1] * np.sin(turn)


def white_and_band(rows, n, coherence, rng):
    return math.sqrt(0.5) * (rng.standard_normal((rows, n)) + narrow_band(rows, n, coherence, rng))


def student_5(rows, n, tau, rng):
    return student.ppf(ndtr(ar1(rows, n, tau, rng)), 5) / math.sqrt(5.0 / 3.0)


def sea_state(rows, n, tau, rng):
    """Return white errors whose log-variance is AR(1) with a standard deviation of 0.7."""
    level = 0.7 * ar1(rows, n, tau, rng)
    return rng.standard_normal((rows, n)) * np.exp(0.5 * level - 0.25 * 0.7 ** 2)


def parabola_removed(rows, n, tau, rng):
    x = ar1(rows, n, tau, rng)
    t = np.linspace(-1.0, 1.0, n)
    return x - np.polynomial.legendre.legval(t, np.polynomial.legendre.legfit(t, x.T, 2))


@pytest.mark.slow
@pytest.mark.parametrize('process, n, tau, runs, former', [
    (white_and_band, 2000, 100.0, 1500, (0.105, 0.011)),
    (student_5, 2000, 20.0, 1500, (0.096, 0.019)),
    (sea_state, 1200, 60.0, 1500, (0.130, 0.081)),
    (parabola_removed, 1500, 30.0, 3000, (0.080, 0.000)),
    (ar1, 1000, 50.0, 1500, None)],
    ids=['white and narrow band', 'Student 5', 'sea state', 'parabola removed', 'AR(1)'])
def test_a_sensor_at_its_limit_is_judged_wrongly_at_the_stated_risk(process, n, tau, runs,
                                                                    former, rng):
    """
    At most 0.05 a side, within three standard errors of so many runs (0.0056 for 1500).

    Lengths of 20 to 100 correlation times. `former` are the rates of a rule that took the
    larger of two plain standard errors, of Gaussian tails, and had a gate: one of them fails.
    """
    order = 2 if process is parabola_removed else 0
    found = [estimate_spread(Cells.of(x), order) for x in process(runs, n, tau, rng)]
    accepted = np.mean([upper_bound(s, 0.05) < 1.0 for s in found])
    rejected = np.mean([lower_bound(s, 0.05) > 1.0 for s in found])
    most = 0.05 + 3.0 * math.sqrt(0.05 * 0.95 / runs)
    assert accepted < most and rejected < most
    assert former is None or max(former) > most


def certified(sigma, n, tau, rng, runs=300):
    """Return the share of runs in which AR(1) errors of this size are certified at limit 1."""
    limits = limits_of(ref=0.0)
    return np.mean([judged(sigma * x, limits).outcome is Outcome.COMPLIANT
                    for x in ar1(runs, n, tau, rng)])


@pytest.mark.slow
def test_a_good_sensor_is_certified_in_a_short_run(rng):
    """Half of the norm, 30 correlation times: 0.75 of runs; a gate would refuse 0.99 of them."""
    assert certified(0.5, 900, 30.0, rng) > 0.75 - 6.0 * math.sqrt(0.75 * 0.25 / 300)


@pytest.mark.slow
def test_the_number_of_differences_between_powers_of_two_does_not_matter(rng):
    """
    100 correlation times in 2048 and in 4090 differences: 0.91 certified at 0.7 of the norm.

    Blocks counted down to 32 would hold 3.1 and 1.6 correlation times.
    """
    shares = [certified(0.7, n, n / 100.0, rng) for n in (2048, 4090)]
    error = math.sqrt(0.91 * 0.09 / 300)
    assert max(abs(share - 0.91) for share in shares) < 6.0 * error
    assert abs(shares[0] - shares[1]) < 4.0 * math.sqrt(2.0) * error


@pytest.mark.slow
def test_white_errors_at_the_limit_are_rejected_at_one_risk_not_two(rng):
    """
    Variance and counts together keep to 0.05; each at 0.05 they took 0.057.

    3000 runs; the standard error of a rate of 0.05 is 0.004.
    """
    limits, rejected = limits_of(ref=0.0), 0
    for x in rng.standard_normal((3000, 1000)):
        got = judged(x, limits)
        rejected += Outcome.NON_COMPLIANT in (got.outcome, got.count_outcome)
    assert rejected / 3000 < 0.05


def test_no_bound_is_beyond_what_two_headings_can_differ(rng):
    """One jump of 100 degrees bounds nothing: no finite bound such as 1e76 is told."""
    got = judged(np.append(np.zeros(199), 100.0))
    assert got.upper_bound_deg2 == got.sigma_ts_upper_deg == math.inf
    low, up = judged(np.linspace(-170.0, 170.0, 2000)).bias_interval_deg
    assert up - low <= 360.0
