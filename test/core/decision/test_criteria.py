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

"""GK (5), (6), (7): worked by hand, at the edges, and against their limits."""

from __future__ import annotations

from fractions import Fraction
import math

from hypothesis import given, strategies as st
import numpy as np
import pytest
from scipy import stats

from heading_intercompare.core.decision.criteria import (
    apply_count_criterion,
    apply_variance_criterion,
    estimate_total_error,
    Limits,
    require_norms,
    variance_limits,
)
from heading_intercompare.core.declared_settings import SettingsError
from heading_intercompare.core.outcome import Outcome, worst
from heading_intercompare.core.settings import Norms

GOOD, BAD, OPEN = Outcome.COMPLIANT, Outcome.NON_COMPLIANT, Outcome.INDETERMINATE


def limits(sigma=0.3, ref=0.4, factor=1.0, model='NN', **norms):
    return Limits.of(Norms(sigma_max_deg=sigma, sigma_ref_max_deg=ref, **norms), model, factor)


def test_variance_limits_by_hand():
    """GK (5), (5'): 0.3² + (0.5 · 0.4)² = 0.13 and 0.3² + 0.4² = 0.25."""
    assert variance_limits(0.3, 0.4, m=0.5) == pytest.approx((0.13, 0.25))


@pytest.mark.parametrize('m', [-0.1, 1.1, float('nan')])
def test_m_outside_its_range_is_refused(m):
    with pytest.raises(ValueError, match='m = '):
        variance_limits(0.3, 0.4, m)


@pytest.mark.parametrize('name', ['sigma_max_deg', 'sigma_ref_max_deg'])
def test_a_missing_norm_is_named(name):
    norms = {'sigma_max_deg': 0.3, 'sigma_ref_max_deg': 0.4, name: None}
    with pytest.raises(SettingsError, match=f'norms.{name} is missing'):
        Limits.of(Norms(**norms))
    with pytest.raises(SettingsError, match=f'norms.{name} is missing'):
        require_norms(Norms(**norms), 'NN')


@pytest.mark.parametrize('model', ['NN', 'UN'])
@pytest.mark.parametrize('norms', [{'sigma_max_deg': 0.3}, {'limiting_error_max_deg': 0.6},
                                   {'preset': 'imo_a821', 'latitude_deg': 60.0}])
def test_the_norms_that_are_required_are_those_of_the_limits(norms, model):
    norms = Norms(**norms, sigma_ref_max_deg=0.2)
    at = Limits.of(norms, model)
    assert require_norms(norms, model) == (at.sigma_max_deg, at.sigma_ref_max_deg)


def test_both_equalities_are_on_the_side_of_not_exceeded():
    at = limits(m_low=0.5)
    assert apply_variance_criterion(at.tightened_limit_deg2, at).outcome is GOOD
    assert apply_variance_criterion(np.nextafter(at.tightened_limit_deg2, 1), at).outcome is OPEN
    assert apply_variance_criterion(at.limit_deg2, at).outcome is OPEN
    assert apply_variance_criterion(np.nextafter(at.limit_deg2, 1), at).outcome is BAD
    assert apply_variance_criterion(None, at).outcome is OPEN


def test_the_ratio_of_the_dead_zone_by_hand():
    """GK (5''): sqrt(0.13 - 0.09) / 0.4 = 0.5; below sigma_max² there is none."""
    assert apply_variance_criterion(0.13, limits(m_low=0.5)).ratio == pytest.approx(0.5)
    assert apply_variance_criterion(0.08, limits()).ratio is None
    assert apply_variance_criterion(0.13, limits(ref=0.0)).ratio is None
    assert apply_variance_criterion(0.13, limits(m_low=0.75)).dead_zone_width == 0.25


def test_an_rs_known_from_its_log_sets_both_bounds_of_m():
    at = limits(sigma_ref_deg=0.2)
    assert (at.m_low, at.m_up) == (0.5, 0.5)
    assert at.limit_deg2 == pytest.approx(0.25), 'GK rejects with the norm of the RS'
    assert at.rejection_limit_deg2 == pytest.approx(0.13)


def test_interpolation_tightens_acceptance_but_not_rejection():
    """F = 2/3: M² = 0.25 · 2/3, so the tightened limit is 0.09 + 0.16 / 6."""
    at = limits(m_low=0.5, factor=2 / 3)
    assert at.tightened_limit_deg2 == pytest.approx(0.09 + 0.16 / 6)
    assert at.limit_deg2 == pytest.approx(0.25) and at.rejection_limit_deg2 == pytest.approx(0.25)


def test_an_interpolated_ts_tightens_acceptance_but_not_rejection():
    """F = 2/3: 0.09 * 2/3 + 0.25 * 0.16 = 0.1; wide limits of (7) from (D - 0.04) / F."""
    norms = Norms(sigma_max_deg=0.3, sigma_ref_max_deg=0.4, m_low=0.5, total_error_max_deg=1.0)
    plain, at = Limits.of(norms), Limits.of(norms, ts_variance_factor=2 / 3)
    assert at.tightened_limit_deg2 == pytest.approx(0.1)
    assert at.limit_deg2 == plain.limit_deg2 == pytest.approx(0.25)
    assert at.rejection_limit_deg2 == plain.rejection_limit_deg2
    assert at.count_limit_deg == plain.count_limit_deg
    assert at.tightened_count_limit_deg == pytest.approx(at.k_tightened * 0.1 ** 0.5)
    wide = estimate_total_error(0.0, 0.09, at, norms)
    assert wide.sigma_ts_up_deg == pytest.approx((0.05 * 1.5) ** 0.5)
    assert wide.sigma_ts_low_deg == estimate_total_error(0.0, 0.09, plain, norms).sigma_ts_low_deg


@pytest.mark.parametrize('model', ['NN', 'UN', 'NU', 'UU'])
def test_the_tightened_factor_is_that_of_the_ratio_that_interpolation_leaves(model):
    norms = Norms(sigma_max_deg=0.3, sigma_ref_max_deg=0.4, m_low=0.5)
    at = Limits.of(norms, model, ts_variance_factor=0.5)
    same = Limits.of(Norms(sigma_max_deg=0.3 * 0.5 ** 0.5, sigma_ref_max_deg=0.4, m_low=0.5),
                     model)
    assert at.k_tightened == pytest.approx(same.k_tightened)
    assert at.tightened_limit_deg2 == pytest.approx(same.tightened_limit_deg2)


@pytest.mark.parametrize('factors', [(1.0, 1.0), (0.6, 1.0), (1.0, 0.6), (0.7, 0.8)])
def test_the_rs_factor_of_limits_may_come_later(factors):
    """Interpolation that reduces the RS noise twice is one with the product of the factors."""
    norms = Norms(sigma_max_deg=0.3, sigma_ref_max_deg=0.4, m_low=0.5)
    first, second = factors
    later = Limits.of(norms, 'NN', first, 0.9).with_rs_factor(second)
    at_once = Limits.of(norms, 'NN', first * second, 0.9)
    for name in ('m_low', 'tightened_limit_deg2', 'rs_variance_factor', 'ts_variance_factor',
                 'limit_deg2', 'rejection_limit_deg2'):
        assert getattr(later, name) == pytest.approx(getattr(at_once, name), rel=1e-12), name


@pytest.mark.parametrize('factors', [(1.0, 1.0), (0.6, 1.0), (1.0, 0.6), (0.7, 0.8)])
def test_the_least_m_low_puts_a_variance_onto_the_tightened_limit(factors):
    norms = Norms(sigma_max_deg=0.3, sigma_ref_max_deg=0.4, m_low=0.1)
    at = Limits.of(norms, 'NN', *factors)
    variance_deg2 = at.tightened_limit_deg2 + 0.02
    known = Norms(sigma_max_deg=0.3, sigma_ref_max_deg=0.4, m_low=at.m_low_for(variance_deg2))
    assert Limits.of(known, 'NN', *factors).tightened_limit_deg2 == pytest.approx(variance_deg2)
    assert at.m_low_for(at.tightened_limit_deg2) is None
    highest_deg2 = factors[1] * 0.09 + factors[0] * 0.16
    assert at.m_low_for(highest_deg2 * (1.0 - 1e-9)) == pytest.approx(1.0)
    assert at.m_low_for(highest_deg2 * (1.0 + 1e-9)) is None


@pytest.mark.parametrize('model', ['UN', 'NU', 'UU'])
def test_limits_of_another_model_are_those_made_for_it(model):
    norms = Norms(sigma_max_deg=0.3, sigma_ref_max_deg=0.4, m_low=0.5)
    other, made = Limits.of(norms, 'NN', 0.7, 0.8).with_model(model), Limits.of(
        norms, model, 0.7, 0.8)
    assert (other.k, other.k_tightened) == pytest.approx((made.k, made.k_tightened))


@pytest.mark.parametrize('rule, k', [('exact', stats.norm.ppf(0.9985)), ('three', 3.0),
                                     (2.5, 2.5)])
def test_the_rule_of_k(rule, k):
    assert limits(k_rule=rule).k == pytest.approx(k, abs=1e-12)


def test_the_allowed_number_is_exact():
    """In binary 10 (1 - 0.9) < 1, which would turn one exceedance into a false alarm."""
    assert limits(probability=0.9).allowed(10) == Fraction(1)
    assert apply_count_criterion(10, 1, 1, limits(probability=0.9)).outcome is GOOD
    assert apply_count_criterion(1000, 3, 3, limits()).outcome is GOOD
    assert apply_count_criterion(1000, 3, 4, limits()).outcome is OPEN
    assert apply_count_criterion(1000, 4, 4, limits()).outcome is BAD


def test_one_exceedance_is_bad_in_a_short_run():
    assert apply_count_criterion(333, 1, 1, limits()).outcome is BAD
    assert apply_count_criterion(334, 1, 1, limits()).outcome is GOOD
    assert apply_count_criterion(2, 0, 0, limits()).outcome is GOOD


@pytest.mark.parametrize('n, n_plus', [(0, 0), (1, 0), (1, 1)])
def test_a_single_difference_meets_no_count(n, n_plus):
    """It deviates from its own mean by nothing: GK (6') as printed would call it compliant."""
    assert apply_count_criterion(n, n_plus, n_plus, limits()).outcome is OPEN


def test_total_error_by_hand():
    """GK (7): 0.1 ± 3 sqrt(0.25 - 0.16) = 0.1 ± 0.9; with M = 0: 0.1 ± 3 · 0.5."""
    norms = Norms(sigma_max_deg=0.3, sigma_ref_max_deg=0.4, probability=0.997300203936740)
    found = estimate_total_error(0.1, 0.25, Limits.of(norms), norms)
    assert found.k == pytest.approx(3.0, abs=1e-9)
    assert (found.low_deg, found.up_deg) == pytest.approx((-1.4, 1.6))
    assert (found.low_narrow_deg, found.up_narrow_deg) == pytest.approx((-0.8, 1.0))
    assert (found.sigma_ts_low_deg, found.sigma_ts_up_deg) == pytest.approx((0.3, 0.5))
    assert found.outcome is None


@pytest.mark.parametrize('norm, outcome', [(1.7, GOOD), (1.2, OPEN), (0.9, BAD)])
def test_total_error_against_its_norm(norm, outcome):
    norms = Norms(sigma_max_deg=0.3, sigma_ref_max_deg=0.4, total_error_max_deg=norm)
    assert estimate_total_error(0.1, 0.25, Limits.of(norms), norms).outcome is outcome
    assert estimate_total_error(None, None, Limits.of(norms), norms).outcome is OPEN


@pytest.mark.parametrize('model', ['NN', 'UN', 'NU', 'UU'])
def test_total_error_by_composition_is_finite_even_without_a_ts_error(model):
    norms = Norms(sigma_max_deg=0.3, sigma_ref_max_deg=0.4, k_total_rule='composition')
    found = estimate_total_error(0.0, 0.01, Limits.of(norms, model), norms, model)
    assert found.sigma_ts_low_deg == 0.0
    assert all(math.isfinite(v) for v in (found.k, found.low_deg, found.low_narrow_deg))


@pytest.mark.slow
@pytest.mark.parametrize('model', ['NN', 'UN', 'NU', 'UU'])
@given(sigma=st.floats(0.01, 1.0), ref=st.floats(0.0, 2.0), m=st.floats(0.0, 1.0))
def test_the_tightened_count_limit_is_never_above_the_limit(model, sigma, ref, m):
    at = limits(sigma, ref, model=model, m_low=m)
    assert at.tightened_count_limit_deg <= at.count_limit_deg * (1 + 1e-12)


@pytest.mark.parametrize('outcomes, combined', [
    ([GOOD, GOOD], GOOD), ([GOOD, OPEN], OPEN), ([OPEN, BAD], BAD), ([], OPEN)])
def test_the_worst_outcome_decides(outcomes, combined):
    assert worst(outcomes) is combined


def test_the_knowledge_of_the_rs_that_a_variance_needs_by_hand():
    """0.2^2 + m^2 0.1^2 = 0.0464 needs m = 0.8; interpolation to 0.64 of the noise, m = 1."""
    limits = Limits.of(Norms(sigma_max_deg=0.2, sigma_ref_max_deg=0.1, m_low=0.5), 'NN')
    assert limits.m_low_for(0.0464) == pytest.approx(0.8)
    assert limits.m_low_for(0.0425) is None and limits.m_low_for(0.0501) is None
    halved = Limits.of(Norms(sigma_max_deg=0.2, sigma_ref_max_deg=0.1, m_low=0.5), 'NN', 0.64)
    assert halved.m_low_for(0.0464) == pytest.approx(1.0)
    assert limits.with_rs_factor(0.64).m_low_for(0.0464) == pytest.approx(1.0)
    exact = Limits.of(Norms(sigma_max_deg=0.2, sigma_ref_max_deg=0.0), 'NN')
    assert exact.m_low_for(0.05) is None


@pytest.mark.parametrize('norms, model, k', [
    ({}, 'NN', 3.0), ({'probability': 0.95}, 'NN', None), ({'k_rule': 2.5}, 'NN', None),
    ({'k_rule': 'three', 'probability': 0.95}, 'NN', 3.0), ({}, 'UN', None)])
def test_the_paper_prints_three_for_normal_errors_at_0_997(norms, model, k):
    limits = Limits.of(Norms(sigma_max_deg=0.2, sigma_ref_max_deg=0.1, **norms), model)
    assert limits.as_printed.k == (limits.k if k is None else k)
    assert limits.as_printed.k_tightened == (limits.k_tightened if k is None else k)
    if not norms and model == 'NN':
        assert limits.k == pytest.approx(2.967738, abs=1e-6)
