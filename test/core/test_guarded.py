# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The guarded decision: each row of its table, degenerate data, measured gates and risks."""

from __future__ import annotations

from dataclasses import fields
import math

import numpy as np
import pytest
from scipy.signal import lfilter
from scipy.stats import chi2, t as student

from heading_intercompare.core.bounds import (
    confidence,
    lower_bound,
    mean_confidence,
    upper_bound,
)
from heading_intercompare.core.criteria import Limits
from heading_intercompare.core.dyadic import Dyadic
from heading_intercompare.core.guarded import decide, Evidence, evidence_of, Guarded, REASONS
from heading_intercompare.core.noise import effective_size
from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.settings import Norms, Risk
from heading_intercompare.core.verdict import plain

pytestmark = pytest.mark.filterwarnings('error')

KEYS = """
d_hat_deg2 nu nu_batch nu_acf nu_components resolved r1_blocks slow_share
upper_bound_deg2 lower_bound_deg2 acceptance_limit_deg2 rejection_limit_deg2
sigma_ts_lower_deg sigma_ts_upper_deg confidence_compliant confidence_non_compliant
conformance_probability nu_needed duration_factor bias_u_deg bias_interval_deg bias_significant
rate_plus rate_plus_plus rate_plus_lower rate_plus_plus_upper count_outcome outcome reason
""".split()


def limits_of(sigma=1.0, ref=0.5, m_low=0.9, m_up=1.0, p=0.997, factor=1.0):
    return Limits.of(Norms(sigma_max_deg=sigma, sigma_ref_max_deg=ref, m_low=m_low, m_up=m_up,
                           probability=p), 'NN', factor)


def judged(x, limits=None, risk=None, span_s=None, **given):
    """Return the decision on differences, counts made about their mean."""
    x = np.asarray(x, dtype=np.float64)
    limits, risk = limits or limits_of(), risk or Risk()
    deviation = np.abs(x - x.mean()) if x.size else x
    evidence = evidence_of(
        x, n_plus=int(np.sum(deviation > limits.count_limit_deg)),
        n_plus_plus=int(np.sum(deviation > limits.tightened_count_limit_deg)),
        span_s=max(0, x.size - 1) / 10.0 if span_s is None else span_s,
        method=risk.method, **given)
    return decide(evidence, limits, risk)


def ar1(rows, n, tau, rng):
    """Return rows of AR(1) noise of unit variance in its stationary state."""
    phi = math.exp(-1.0 / tau)
    start = phi * rng.standard_normal((rows, 1))
    white = rng.standard_normal((rows, n)) * math.sqrt(1.0 - phi * phi)
    return lfilter([1.0], [1.0, -phi], white, axis=1, zi=start)[0]


def scaled(x, variance):
    """Return the series with this variance by the dyadic estimate."""
    d_hat = Dyadic.of(x).components().d_hat_deg2
    return x * math.sqrt(variance / d_hat)


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
    assert got.nu_needed <= min(got.nu, got.nu_components) and got.duration_factor <= 1.0


def test_lower_bound_above_the_rejection_limit_does_not_comply(rng):
    got = judged(scaled(rng.standard_normal(20_000), 1.5), span_s=0.0,
                 risk=Risk(min_duration_s=1e6))
    assert got.outcome is Outcome.NON_COMPLIANT
    assert got.reason == 'lower_bound_above_rejection_limit'
    assert got.confidence_non_compliant >= 0.95


def test_a_variance_above_its_limit_within_its_own_error_stays_open(rng):
    got = judged(scaled(rng.standard_normal(300), 1.3))
    assert (got.outcome, got.reason) == (Outcome.INDETERMINATE, 'data_limited')
    assert 1.0 < got.duration_factor < math.inf


def test_a_variance_known_well_between_the_limits_waits_for_the_reference(rng):
    limits = limits_of(ref=1.0, m_low=0.0)
    got = judged(scaled(rng.standard_normal(20_000), 1.5), limits)
    assert (got.outcome, got.reason) == (Outcome.INDETERMINATE, 'reference_limited')
    assert got.nu_needed == got.duration_factor == math.inf


def test_a_short_run_may_be_rejected_but_not_accepted(rng):
    x = scaled(rng.standard_normal(20_000), 1.0)
    got = judged(x, risk=Risk(min_duration_s=2000.0), span_s=1999.9)
    assert (got.outcome, got.reason) == (Outcome.INDETERMINATE, 'insufficient_duration')
    assert got.count_outcome is not Outcome.COMPLIANT
    assert judged(x, risk=Risk(min_duration_s=2000.0), span_s=2000.0).outcome \
        is Outcome.COMPLIANT


def test_a_drift_that_fills_the_record_is_not_resolved(rng):
    x = scaled(np.linspace(-1.0, 1.0, 5000) + 0.1 * rng.standard_normal(5000), 0.5)
    got = judged(x)
    assert got.resolved is False and got.r1_blocks > 0.4 and got.slow_share > 0.05
    assert (got.outcome, got.reason) == (Outcome.INDETERMINATE, 'insufficient_effective_data')
    assert got.count_outcome is Outcome.INDETERMINATE


def test_an_unresolved_variance_far_above_the_limit_is_rejected():
    """D / chi2(0.95, 1) > R: 1.25 * 3.8415 = 4.8018."""
    x = np.linspace(-1.0, 1.0, 5000)
    below, above = judged(scaled(x, 4.80)), judged(scaled(x, 4.81))
    assert below.reason == 'insufficient_effective_data'
    assert above.outcome is Outcome.NON_COMPLIANT
    assert above.reason == 'unresolved_but_far_above_rejection_limit'
    assert chi2.ppf(0.95, 1) * 1.25 == pytest.approx(4.8018, abs=1e-4)


def test_too_few_effective_degrees_of_freedom_leave_it_open(rng):
    x = scaled(ar1(1, 3000, 40.0, rng)[0], 0.3)
    nu = judged(x).nu
    closed = judged(x, risk=Risk(nu_min=nu + 0.1))
    assert closed.reason == 'insufficient_effective_data'
    assert closed.count_outcome is Outcome.INDETERMINATE
    assert judged(x, risk=Risk(nu_min=nu, r1_max=1.0)).reason != 'insufficient_effective_data'


def test_the_gate_needs_both_a_slow_part_and_a_share(rng):
    x = np.linspace(-1.0, 1.0, 5000) + 20.0 * rng.standard_normal(5000)
    got = judged(scaled(x, 0.5))
    assert got.slow_share < 0.05 and got.resolved is True
    ramp = np.linspace(-1.0, 1.0, 5000) + rng.standard_normal(5000)
    assert not judged(ramp).resolved
    assert judged(ramp, risk=Risk(share_max=0.9)).resolved
    assert judged(ramp, risk=Risk(r1_max=1.0)).resolved


# --- the figures by another route ---

def test_figures_follow_from_the_components(rng):
    x = 0.4 + ar1(1, 20_000, 5.0, rng)[0]
    limits, risk = limits_of(factor=2.0 / 3.0), Risk(alpha_consumer=0.02, alpha_producer=0.1)
    got = judged(x, limits, risk, offset_u_deg=0.05)
    c = Dyadic.of(x).components()
    nu = min(c.nu_batch, effective_size(x), 19_999.0)
    assert (got.nu, got.nu_acf) == (nu, effective_size(x))
    assert got.acceptance_limit_deg2 == pytest.approx(1.0 + 0.45 ** 2 * 2.0 / 3.0)
    assert got.upper_bound_deg2 == upper_bound(c, nu, 0.02)
    assert got.lower_bound_deg2 == lower_bound(c, nu, 0.1)
    assert got.sigma_ts_lower_deg == pytest.approx(math.sqrt(got.lower_bound_deg2 - 0.25))
    assert got.sigma_ts_upper_deg == \
        pytest.approx(math.sqrt(got.upper_bound_deg2 - 0.2025 * 2.0 / 3.0))
    assert got.confidence_compliant == confidence(c, nu, got.acceptance_limit_deg2)
    assert got.confidence_non_compliant == 1.0 - confidence(c, nu, 1.25)
    assert got.conformance_probability == \
        mean_confidence(c, nu, 1.0, 0.45 * math.sqrt(2.0 / 3.0), 0.5)
    assert got.bias_u_deg == pytest.approx(math.hypot(math.sqrt(c.mean_variance_deg2), 0.05))
    half = student.ppf(0.975, c.slow_dof) * got.bias_u_deg
    assert got.bias_interval_deg == pytest.approx((x.mean() - half, x.mean() + half))
    assert got.bias_significant is True


def test_the_method_without_autocorrelation_has_no_such_figure(rng):
    x = rng.standard_normal(500)
    got = judged(x, risk=Risk(method='dyadic'))
    assert got.nu_acf is None and got.nu == min(got.nu_batch, 499.0)


def test_summaries_say_the_same_as_the_samples(rng):
    x = rng.standard_normal(5000)
    given = {'n_plus': 3, 'n_plus_plus': 5, 'span_s': 10.0, 'method': 'dyadic'}
    parts = Dyadic()
    for lo in range(0, 5000, 777):
        parts.update(x[lo:lo + 777])
    limits = limits_of()
    assert decide(evidence_of(parts, **given), limits, Risk()) == \
        decide(evidence_of(x, **given), limits, Risk())
    with pytest.raises(ValueError, match='dyadic\\+acf'):
        evidence_of(parts, n_plus=0, n_plus_plus=0, span_s=1.0)


def test_residuals_of_a_polynomial_lose_its_degrees_of_freedom(rng):
    t = np.linspace(-1.0, 1.0, 3000)
    x = rng.standard_normal(3000) + 7.0 + 4.0 * t
    residual = x - np.polynomial.Polynomial.fit(t, x, 1)(t)
    got = judged(residual, order=1, mean_deg=7.0)
    c = Dyadic.of(residual).components(1)
    assert c.slow_dof == Dyadic.of(residual).components().slow_dof - 1
    assert got.d_hat_deg2 == c.d_hat_deg2
    low, up = got.bias_interval_deg
    assert (low + up) / 2.0 == pytest.approx(7.0)
    assert judged(np.zeros(100), order=3, mean_deg=0.0).nu == 96.0


def test_known_reference_leaves_one_point_of_conformance(rng):
    got = judged(rng.standard_normal(3000), limits_of(m_low=0.8, m_up=0.8))
    assert got.acceptance_limit_deg2 == got.rejection_limit_deg2
    assert got.conformance_probability == pytest.approx(got.confidence_compliant)
    assert got.confidence_compliant + got.confidence_non_compliant == pytest.approx(1.0)


# --- counts ---

def evidence(n_plus, n_plus_plus, rng, n=200_000):
    """Return white errors with these counts."""
    return evidence_of(scaled(rng.standard_normal(n), 1.0), n_plus=n_plus,
                       n_plus_plus=n_plus_plus, span_s=1e5)


@pytest.mark.parametrize('n_plus, n_plus_plus, outcome', [
    (0, 0, Outcome.COMPLIANT), (100, 480, Outcome.COMPLIANT), (100, 600, Outcome.INDETERMINATE),
    (620, 640, Outcome.INDETERMINATE), (800, 900, Outcome.NON_COMPLIANT)])
def test_counts_decide_with_their_bounds(n_plus, n_plus_plus, outcome, rng):
    """600 of 200 000 is the rate allowed; its standard error is at least 24."""
    got = decide(evidence(n_plus, n_plus_plus, rng), limits_of(), Risk())
    assert got.count_outcome is outcome
    assert (got.rate_plus, got.rate_plus_plus) == (n_plus / 2e5, n_plus_plus / 2e5)
    assert got.rate_plus_lower <= got.rate_plus and got.rate_plus_plus_upper > got.rate_plus_plus


def test_correlation_widens_the_bounds_of_counts(rng):
    """The same rates in 16 384 samples: white, and with two hundred per correlation time."""
    white, slow = rng.standard_normal(16_384), ar1(1, 16_384, 30.0, rng)[0]
    given = {'n_plus': 80, 'n_plus_plus': 90, 'span_s': 1e4}
    a, b = (decide(evidence_of(x, **given), limits_of(), Risk()) for x in (white, slow))
    assert a.rate_plus_lower > 2.0 * b.rate_plus_lower
    assert b.rate_plus_plus_upper > 2.0 * a.rate_plus_plus_upper


# --- degenerate data ---

@pytest.mark.parametrize('n', [0, 1, 2, 63])
def test_fewer_than_64_differences_are_too_few(n, rng):
    got = judged(rng.standard_normal(n))
    assert (got.outcome, got.reason) == (Outcome.INDETERMINATE, 'insufficient_data')
    assert got.count_outcome is Outcome.INDETERMINATE
    assert got.acceptance_limit_deg2 == pytest.approx(1.2025)
    known = {'acceptance_limit_deg2', 'rejection_limit_deg2', 'count_outcome', 'outcome',
             'reason'} | ({'rate_plus', 'rate_plus_plus'} if n else set())
    assert {k for k in KEYS if getattr(got, k) is not None} == known


def test_64_differences_are_enough(rng):
    got = judged(scaled(rng.standard_normal(64), 0.1))
    assert got.reason == 'upper_bound_within_acceptance_limit'


@pytest.mark.parametrize('n', [64, 100, 5000])
@pytest.mark.parametrize('value', [0.0, 0.1, -179.99])
def test_equal_differences_have_zero_bounds(n, value):
    got = judged(np.full(n, value))
    assert (got.d_hat_deg2, got.upper_bound_deg2, got.lower_bound_deg2) == (0.0, 0.0, 0.0)
    assert got.nu == got.nu_components == n - 1
    assert got.resolved is True and got.outcome is Outcome.COMPLIANT
    assert (got.sigma_ts_lower_deg, got.sigma_ts_upper_deg) == (0.0, 0.0)
    assert got.bias_interval_deg == (value, value)
    assert got.bias_significant is (value != 0.0)


@pytest.mark.parametrize('x', [
    np.tile([1.0, -1.0], 50), np.repeat([0.0, 1.0], 40), np.append(np.zeros(99), 1e6),
    np.append(1e-200, np.zeros(99)), np.arange(64.0), np.tile([0.01, 0.02], 400)],
    ids=['alternating', 'one step', 'one outlier', 'denormal', 'ramp', 'two values'])
@pytest.mark.parametrize('ref', [0.0, 0.5])
def test_no_figure_is_ever_nan(x, ref):
    got = judged(x, limits_of(ref=ref))
    for name in KEYS:
        value = getattr(got, name)
        assert value is not None
        numbers = value if isinstance(value, tuple) else (value,)
        assert not any(isinstance(v, float) and math.isnan(v) for v in numbers), name
    assert set(plain(got)) == set(KEYS)
    for name in ('confidence_compliant', 'confidence_non_compliant', 'conformance_probability',
                 'rate_plus_lower', 'rate_plus_plus_upper'):
        assert 0.0 <= getattr(got, name) <= 1.0


def test_an_alternating_series_counts_all_its_samples():
    """Equal squares in all blocks scatter not at all: n - 1 degrees of freedom."""
    got = judged(np.tile([1.0, -1.0], 50), risk=Risk(method='dyadic'))
    assert got.nu_batch == math.inf and got.nu == 99.0


def test_evidence_without_an_effective_size_still_decides(rng):
    """A hopeless autocorrelation leaves fewer than one degree of freedom, and no statement."""
    good = evidence_of(rng.standard_normal(100), n_plus=0, n_plus_plus=0, span_s=1.0)
    for nu_acf in (0.9, 0.01, 1e-9):
        bad = Evidence(*(nu_acf if f.name == 'nu_acf' else getattr(good, f.name)
                         for f in fields(Evidence)))
        got = decide(bad, limits_of(), Risk())
        assert got.reason == 'insufficient_effective_data'
        assert got.upper_bound_deg2 == math.inf and plain(got)['upper_bound_deg2'] is None
        assert got.sigma_ts_upper_deg == math.inf and got.rate_plus_plus_upper <= 1.0


# --- properties ---

@pytest.mark.parametrize('offset', [-170.0, 3.0])
def test_an_offset_changes_the_bias_and_nothing_else(offset, rng):
    x = np.rint(ar1(1, 5000, 4.0, rng)[0] * 2 ** 20) / 2 ** 20
    a, b = plain(judged(x)), plain(judged(x + offset))
    for name in KEYS:
        if not name.startswith('bias'):
            assert a[name] == (pytest.approx(b[name], rel=1e-9)
                               if isinstance(b[name], float) else b[name]), name


def test_the_unit_of_the_angle_does_not_matter(rng):
    x = ar1(1, 5000, 4.0, rng)[0]
    a = judged(x, limits_of(1.0, 0.5))
    b = judged(x * 0.125, limits_of(0.125, 0.0625))
    same = ('nu', 'r1_blocks', 'slow_share', 'confidence_compliant', 'confidence_non_compliant',
            'conformance_probability', 'nu_needed', 'rate_plus', 'rate_plus_lower')
    assert [getattr(a, k) for k in same] == pytest.approx([getattr(b, k) for k in same],
                                                          rel=1e-9)
    assert (a.outcome, a.reason, a.count_outcome) == (b.outcome, b.reason, b.count_outcome)
    assert a.upper_bound_deg2 == pytest.approx(64.0 * b.upper_bound_deg2, rel=1e-12)


def test_less_risk_never_turns_a_verdict_over(rng):
    rank = {Outcome.COMPLIANT: 1, Outcome.INDETERMINATE: 0, Outcome.NON_COMPLIANT: -1}
    for variance in (0.9, 1.1, 1.2, 1.3, 1.6):
        x = scaled(rng.standard_normal(2000), variance)
        ranks = [rank[judged(x, risk=Risk(alpha_consumer=a, alpha_producer=a)).outcome]
                 for a in (0.3, 0.05, 0.001, 1e-6)]
        assert len({r for r in ranks if r}) <= 1
        assert np.all(np.diff(np.abs(ranks)) <= 0)


# --- measured ---

@pytest.mark.parametrize('records, opened', [(10, 0.000), (50, 0.466), (100, 0.907),
                                             (300, 0.995)])
def test_the_gate_opens_as_often_as_stated(records, opened, rng):
    """AR(1) over so many correlation times; 250 rows, six standard errors and 0.01."""
    rows = ar1(250, records * 30, 30.0, rng)
    evidences = [evidence_of(x, n_plus=0, n_plus_plus=0, span_s=1.0) for x in rows]
    limits, risk = limits_of(), Risk(nu_min=15.0)
    share = np.mean([decide(e, limits, risk).reason not in
                     ('insufficient_effective_data', 'unresolved_but_far_above_rejection_limit')
                     for e in evidences])
    assert abs(share - opened) < 6.0 * math.sqrt(opened * (1.0 - opened) / 250) + 0.01


def test_a_sensor_at_its_limit_is_rarely_certified(rng):
    """AR(1), 100 correlation times, D = A: stated rate 0.040; 250 rows, six standard errors."""
    limits = limits_of(ref=0.0)
    found = [judged(x, limits).outcome for x in ar1(250, 3000, 30.0, rng)]
    rate = np.mean([o is Outcome.COMPLIANT for o in found])
    assert rate < 0.05 + 6.0 * math.sqrt(0.05 * 0.95 / 250)
    wrongly = np.mean([o is Outcome.NON_COMPLIANT for o in found])
    assert wrongly < 0.05 + 6.0 * math.sqrt(0.05 * 0.95 / 250)
