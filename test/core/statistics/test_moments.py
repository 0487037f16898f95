# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Moments by hand and by property; the growing column; the rolling window."""

from __future__ import annotations

from fractions import Fraction

from hypothesis import given, strategies as st
import numpy as np
import pytest

from heading_intercompare.core.records import Differences
from heading_intercompare.core.runs.rolling_window import Rolling
from heading_intercompare.core.statistics.cells import Cells
from heading_intercompare.core.statistics.moments import (
    count_outside,
    exact_sum,
    Moments,
    sum_products,
    UNIT,
)

S = 1_000_000_000
values = st.lists(st.floats(-180.0, 180.0, allow_subnormal=False), max_size=30)


def test_moments_by_hand():
    """1, 2, 6: mean 3, squares of deviations 4 + 1 + 9 = 14, variance 7."""
    m = Moments.of([1.0, 2.0, 6.0])
    assert (m.n, m.mean_deg, m.m2_deg2, m.min_deg, m.max_deg) == (3, 3.0, 14.0, 1.0, 6.0)
    assert m.variance_deg2 == 7.0 and m.mean_square_deg2 == pytest.approx(41 / 3)


@given(values, values)
def test_moments_add_like_the_values_together(a, b):
    both, whole = Moments.of(a) + Moments.of(b), Moments.of(a + b)
    assert (both.n, both.min_deg, both.max_deg) == (whole.n, whole.min_deg, whole.max_deg)
    assert both.mean_deg == pytest.approx(whole.mean_deg, rel=1e-12, abs=1e-12)
    assert both.m2_deg2 == pytest.approx(whole.m2_deg2, rel=1e-12, abs=1e-8)


def test_the_variance_survives_a_large_mean(rng):
    x = 179.9 + 1e-3 * rng.standard_normal(100_000)
    parts = sum((Moments.of(part) for part in np.split(x, 100)), Moments())
    exact = np.var((x - 179.9).astype(np.longdouble), ddof=1)
    assert parts.variance_deg2 == pytest.approx(float(exact), rel=1e-9)


@pytest.mark.parametrize('n, variance', [(0, None), (1, None), (2, 0.0)])
def test_few_values_have_no_variance_rather_than_nan(n, variance):
    assert Moments.of([1.5] * n).variance_deg2 == variance


def test_exceeding_is_strict():
    assert count_outside(np.array([1.0, -1.0, 1.0000001]), 0.0, 1.0) == 1


def differences(rng, n, rate_hz=10.0):
    stamps = 1_400_000_000 * S + (np.arange(n) * (S / rate_hz)).astype(np.int64)
    return Differences.of(stamps, rng.standard_normal(n))


@pytest.mark.parametrize('chunk', [1, 7, 5000])
def test_the_window_holds_its_panes_exactly(rng, chunk):
    d = differences(rng, 5000)
    rolling = Rolling(64.0)
    for k in range(0, len(d), chunk):
        rolling.update(d[k:k + chunk])
    # 64 panes of 1 s end with the one of the newest sample.
    pane = d.stamp_ns // S
    inside = d.x_deg[pane > pane[-1] - 64]
    m = rolling.moments()
    assert m.n == len(inside)
    assert m.variance_deg2 == pytest.approx(np.var(inside, ddof=1), rel=1e-12)
    for limit in (0.0, 1.0, 3.0):
        assert rolling.count_outside(0.1, limit) == count_outside(inside, 0.1, limit)
    assert rolling.start_ns == d.stamp_ns[pane > pane[-1] - 64][0]
    assert rolling.span_s == (d.stamp_ns[-1] - rolling.start_ns) / 1e9
    ours = rolling.cells().values()
    theirs = Cells.of(inside, d.stamp_ns[pane > pane[-1] - 64]).values()
    assert (ours.mean_square_deg2, ours.kurtosis) == (theirs.mean_square_deg2, theirs.kurtosis)
    assert np.array_equal(ours.y_deg2, theirs.y_deg2)


def test_a_window_that_gets_another_length_holds_what_it_held_and_is_not_too_old(rng):
    d = differences(rng, 5000)
    rolling = Rolling(64.0)
    for k in range(0, 4000, 37):
        rolling.update(d[k:min(k + 37, 4000)])
    held = rolling.moments()
    rolling.resize(640.0)
    assert rolling.moments().n == held.n and rolling.moments().mean_deg == pytest.approx(
        held.mean_deg, rel=1e-12)
    rolling.update(d[4000:])
    assert rolling.start_ns < d.stamp_ns[-1] - 100 * S
    rolling.resize(32.0)
    half = d.stamp_ns // (S // 2)
    assert rolling.moments().n == np.count_nonzero(half > half[-1] - 64)


def test_an_empty_window_has_no_values():
    rolling = Rolling(10.0)
    rolling.update(Differences.of([S], [np.nan]))
    assert rolling.moments().n == 0 and rolling.start_ns is None
    assert rolling.count_outside(0.0, 1.0) == 0


def test_the_memory_of_the_window_is_bounded(rng):
    rolling = Rolling(64.0)
    d = differences(rng, 20_000)
    for k in range(0, len(d), 100):
        rolling.update(d[k:k + 100])
    assert rolling.moments().n <= 650


def test_an_exact_sum_does_not_depend_on_the_chunks(rng):
    """Numbers from 1/2 to 1; fractions.Fraction also adds them exactly."""
    w = rng.random(2000)
    values = (1.0 - w) ** 2 + w ** 2
    whole = exact_sum(values)
    assert whole == exact_sum(values[:7]) + exact_sum(values[7:1300]) + exact_sum(values[1300:])
    assert Fraction(whole) * Fraction(UNIT) == sum(map(Fraction, values.tolist()))
    assert exact_sum([]) == 0


def test_the_exact_sum_of_equal_numbers_is_that_of_any():
    for value in (0.5, 1.0, 0.1 + 0.6):
        assert exact_sum(np.full(1000, value)) == 1000 * exact_sum([value])
        assert exact_sum([value, 1.0, value]) == exact_sum([value, value]) + exact_sum([1.0])


def test_products_are_summed_alike_however_many_there_are(rng):
    a, b = rng.standard_normal((2, 30_000))
    assert sum_products(a, b) == pytest.approx(float(np.sum(a * b)), abs=1e-9)
    assert sum_products(a[:0], b[:0]) == 0.0
