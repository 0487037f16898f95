# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Dyadic components: by hand, against the definitions, independent of the chunks."""

from __future__ import annotations

import math
import time
import tracemalloc

from hypothesis import given, settings as hypothesis_settings, strategies as st
import numpy as np
import pytest
from scipy.signal import lfilter

from heading_intercompare.core.dyadic import Dyadic


def correlated(n, rng, tau=20.0, offset=170.0):
    """Return AR(1) noise with a slow wave on an offset."""
    phi = math.exp(-1.0 / tau)
    e = lfilter([math.sqrt(1.0 - phi * phi)], [1.0, -phi], rng.standard_normal(n))
    return offset + 0.3 * e + 0.05 * np.sin(np.arange(n) * 2e-3)


def by_definition(x, order=0):
    """Return the figures of G.1 to G.5 as they are written down, block by block."""
    n = len(x)
    e = [float(v) for v in np.asarray(x) - math.fsum(x) / n]

    def means(values, level):
        size = 2 ** level
        return [math.fsum(values[i * size:(i + 1) * size]) / size for i in range(n // size)]

    def level_of(b):
        return max(level for level in range(64) if n // 2 ** level >= b)

    def variance(values, lost=1):
        m = math.fsum(values) / len(values)
        return math.fsum((v - m) ** 2 for v in values) / (len(values) - lost)

    octaves, pairs = [], []
    for j in range(1, level_of(16) + 1):
        b = means(e, j - 1)
        k = len(b) // 2
        octaves.append(math.fsum((b[2 * i + 1] - b[2 * i]) ** 2 for i in range(k)) / (4 * k))
        pairs.append(k)
    slow = variance(means(e, level_of(16)), 1 + order)
    d_hat = math.fsum(octaves) + slow
    squares = [v * v for v in e]
    scatter = [variance(means(squares, level_of(b))) * 2 ** level_of(b) / n for b in (8, 16, 32)]
    c = means(e, level_of(32))
    m = math.fsum(c) / len(c)
    c = [v - m for v in c]
    power = math.fsum(v * v for v in c)
    return {
        'octave_deg2': octaves, 'octave_dof': pairs, 'slow_deg2': slow,
        'slow_dof': n // 2 ** level_of(16) - 1 - order, 'd_hat_deg2': d_hat,
        'mean_variance_deg2': slow * 2 ** level_of(16) / n,
        'nu_batch': 2.0 * d_hat ** 2 / max(scatter),
        'nu_components': d_hat ** 2 / (math.fsum(v * v / k for v, k in zip(octaves, pairs))
                                       + slow ** 2 / (n // 2 ** level_of(16) - 1 - order)),
        'r1_blocks': math.fsum(a * b for a, b in zip(c[:-1], c[1:])) / power,
        'slow_share': power / (len(c) - 1) / d_hat}


def assert_same(a, b, **tolerance):
    """Compare components; to the bit unless a tolerance is given."""
    names = ('n', 'octave_deg2', 'octave_dof', 'slow_deg2', 'slow_dof', 'slow_samples',
             'square_scatter', 'r1_blocks', 'block_variance_deg2')
    for name in names:
        left, right = np.asarray(getattr(a, name)), np.asarray(getattr(b, name))
        if tolerance:
            assert left == pytest.approx(right, **tolerance), name
        else:
            assert np.array_equal(left, right), name


def hand_series(scale=None):
    """
    Return 64 differences: 1 every sample, 2 every pair, 3 every four samples, about 5.

    Signs alternate with periods of 2, 4 and 8 samples; the amplitudes are multiplied by
    `scale` per block of eight.
    """
    i = np.arange(64)
    e = 1.0 * (-1.0) ** i + 2.0 * (-1.0) ** (i // 2) + 3.0 * (-1.0) ** (i // 4)
    return 5.0 + e * (1.0 if scale is None else np.repeat(scale, 8))


def test_components_by_hand():
    """
    E_1: halves of neighbours differ by 1, so 1; E_2 likewise 2^2 = 4.

    Level 2 has 16 block means of +-3: S = 16 * 9 / 15 = 9.6 with 15 degrees of freedom.
    D = 1 + 4 + 9.6 = 14.6; variance of the mean 9.6 * 4 / 64 = 0.6.
    """
    c = Dyadic.of(hand_series()).components()
    assert c.octave_deg2 == pytest.approx([1.0, 4.0], rel=1e-15)
    assert c.octave_dof.tolist() == [32, 16]
    assert (c.slow_deg2, c.slow_dof, c.slow_samples) == (pytest.approx(9.6), 15, 4)
    assert c.d_hat_deg2 == pytest.approx(14.6)
    assert c.mean_variance_deg2 == pytest.approx(0.6)
    assert Dyadic.of(hand_series()).mean == 5.0


def test_slow_part_by_hand():
    """
    Level 1 has 32 block means: 5, 1, -1, -5 about 0, repeated. Sum of squares 8 * 52 = 416.

    Products of neighbours: 5 - 1 + 5 = 9 in each four, -25 from four to four:
    8 * 9 - 7 * 25 = -103; r1 = -103/416; share (416/31) / 14.6.
    """
    c = Dyadic.of(hand_series()).components()
    assert c.r1_blocks == pytest.approx(-103.0 / 416.0)
    assert c.slow_share == pytest.approx(416.0 / 31.0 / 14.6)


def test_degrees_of_freedom_by_hand():
    """
    Blocks of eight scaled 1 and 2 in turn: mean squares 14 and 56, their squares scatter.

    8 blocks: sample variance 8 * 21^2 / 7 = 504, times 8/64: 63. 16 blocks of four: e^2 is
    (6, 4, 2, 0)^2 and (0, -2, -4, -6)^2, mean 14 each, so again 14 or 56:
    16 * 441 / 15 * 4/64 = 29.4. 32 blocks of two: means of squares 26, 2, 2, 26, then
    104, 8, 8, 104, about 35: 4 * 2 * (9^2 + 33^2 + 69^2 + 27^2) / 31 * 2/64 = 53280/992.
    D = 2.5 * 5 + S, for the mean of 1 and 4 is 2.5: E = 2.5 and 10, S = 16 * 22.5 / 15 = 24;
    D = 36.5.
    """
    c = Dyadic.of(hand_series([1, 2] * 4)).components()
    assert c.octave_deg2 == pytest.approx([2.5, 10.0])
    assert c.slow_deg2 == pytest.approx(24.0)
    assert c.square_scatter == pytest.approx(
        np.array([63.0, 29.4, 53280.0 / 992.0]) / 36.5 ** 2)
    assert c.nu_batch == pytest.approx(2.0 * 36.5 ** 2 / 63.0)
    assert c.nu_components == pytest.approx(
        36.5 ** 2 / (2.5 ** 2 / 32 + 10.0 ** 2 / 16 + 24.0 ** 2 / 15))


@pytest.mark.parametrize('n', [64, 65, 127, 128, 500, 1023, 1024, 4095, 5000])
@pytest.mark.parametrize('order', [0, 3])
def test_components_agree_with_the_definitions(n, order, rng):
    x = correlated(n, rng)
    got = Dyadic.of(x).components(order)
    for name, value in by_definition(x, order).items():
        assert np.asarray(getattr(got, name)) == pytest.approx(value, rel=1e-11), name


@pytest.mark.parametrize('n', [63, 64, 1000, 131_071, 300_000])
def test_the_chunks_do_not_matter_to_the_bit(n, rng):
    x = correlated(n, rng)
    whole = Dyadic.of(x)
    for sizes in ([1] * 70, [64], [1, 62, 3, 1000], [65_537], [100_000, 1, 1]):
        parts, lo = Dyadic(), 0
        for size in sizes:
            parts.update(x[lo:lo + size])
            parts.components()
            lo += size
        parts.update(x[lo:])
        parts.update([])
        assert parts.n == whole.n and parts.mean == whole.mean
        if n >= 64:
            assert_same(parts.components(), whole.components())


@given(st.lists(st.integers(0, 90), max_size=12), st.integers(0, 2 ** 32))
@hypothesis_settings(max_examples=40, deadline=None)
def test_any_chunks_give_the_same_octaves_to_the_bit(sizes, seed):
    x = correlated(sum(sizes) + 70, np.random.default_rng(seed))
    parts, lo = Dyadic(), 0
    for size in sizes:
        parts.update(x[lo:lo + size])
        lo += size
    parts.update(x[lo:])
    for left, right in zip(parts.octaves(), Dyadic.of(x).octaves()):
        assert np.array_equal(left, right)


@pytest.mark.parametrize('n', [0, 1, 2, 3, 5, 31, 63])
def test_fewer_than_64_samples_have_octaves_but_no_components(n, rng):
    x = rng.standard_normal(n)
    blocks = Dyadic.of(x)
    m, variance, pairs = blocks.octaves()
    assert blocks.components() is None
    assert m.tolist() == [2 ** j for j in range(n.bit_length() - 1)]
    assert pairs.tolist() == [n // (2 * k) for k in m.tolist()]
    if n >= 2:
        assert variance[0] == pytest.approx(
            np.mean((x[1:n // 2 * 2:2] - x[:n // 2 * 2:2]) ** 2) / 4.0)


def test_no_samples_have_no_mean():
    assert Dyadic().mean is None
    assert Dyadic.of([4.25]).mean == 4.25


def test_octaves_of_a_power_of_two_add_up_to_the_variance(rng):
    """Haar and Parseval: the mean square about the mean is the sum of all octaves."""
    x = correlated(2 ** 14, rng)
    assert Dyadic.of(x).octaves()[1].sum() == pytest.approx(x.var(), rel=1e-12)


def test_expected_components_of_white_noise(rng):
    """E_j has mean 2^-j and k_j degrees of freedom; six standard errors of 40 octave values."""
    n, sets = 1000, 400
    values = np.array([Dyadic.of(rng.standard_normal(n)).components().variances_deg2
                       for _ in range(sets)])
    c = Dyadic.of(rng.standard_normal(n)).components()
    j = np.arange(1, c.octave_deg2.size + 1)
    expected = np.append(0.5 ** j, 0.5 ** j[-1])
    standard_error = expected * np.sqrt(2.0 / c.dof / sets)
    assert np.all(np.abs(values.mean(axis=0) - expected) < 6.0 * standard_error)


def test_equal_samples_have_components_of_exactly_zero():
    c = Dyadic.of(np.full(777, 0.1)).components()
    assert c.variances_deg2.tolist() == [0.0] * (c.octave_deg2.size + 1)
    assert (c.d_hat_deg2, c.r1_blocks, c.slow_share, c.mean_variance_deg2) == (0, 0, 0, 0)
    assert (c.nu_batch, c.nu_components) == (math.inf, 776.0)


def test_an_offset_of_the_sensor_costs_no_digits(rng):
    """Steps of 2^-20 degree on 179 degrees are exact, so every component is the same."""
    x = np.rint(correlated(5000, rng, offset=0.0) * 2 ** 20) / 2 ** 20
    assert_same(Dyadic.of(x).components(), Dyadic.of(x + 179.0).components(), rel=1e-12)


def test_the_unit_does_not_matter(rng):
    """A power of two scales the variances exactly and leaves the rest alone."""
    x = correlated(3000, rng)
    a, b = Dyadic.of(x).components(), Dyadic.of(x * 2.0 ** -30).components()
    assert np.array_equal(a.variances_deg2 * 2.0 ** -60, b.variances_deg2)
    assert (a.nu_batch, a.nu_components, a.r1_blocks) == (b.nu_batch, b.nu_components,
                                                          b.r1_blocks)


def test_denormal_differences_give_figures():
    x = np.tile([0.0, 5e-324], 100)
    c = Dyadic.of(x).components()
    assert c.d_hat_deg2 == 0.0 and c.nu_batch == math.inf


@pytest.mark.parametrize('first, second', [
    (64, 0), (0, 64), (64, 1), (64, 63), (128, 200), (1024, 1000), (4096, 777), (96, 100),
    (65_536, 70_000), (64, 64), (3, 40)])
def test_adding_continues_the_series(first, second, rng):
    x = correlated(first + second, rng)
    joined = Dyadic.of(x[:first]) + Dyadic.of(x[first:])
    whole = Dyadic.of(x)
    assert joined.n == whole.n
    assert joined.mean == pytest.approx(whole.mean, rel=1e-13)
    if whole.n >= 64:
        assert_same(joined.components(), whole.components(), rel=1e-10, abs=1e-14)


def test_a_sum_can_be_continued_and_leaves_its_parts_alone(rng):
    x = correlated(3000, rng)
    a, b = Dyadic.of(x[:1024]), Dyadic.of(x[1024:2000])
    before = a.components(), b.components()
    joined = a + b
    joined.update(x[2000:])
    assert_same(joined.components(), Dyadic.of(x).components(), rel=1e-10, abs=1e-14)
    assert_same(a.components(), before[0])
    assert_same(b.components(), before[1])


def test_sums_that_do_not_align_are_refused(rng):
    x = correlated(1000, rng)
    with pytest.raises(ValueError, match='100 samples cannot be followed by blocks of 8'):
        Dyadic.of(x[:100]) + Dyadic.of(x[:300])


@pytest.mark.parametrize('bad', [math.nan, math.inf])
def test_values_that_are_not_finite_are_refused_and_nothing_is_taken(bad):
    blocks = Dyadic.of([1.0, 2.0])
    with pytest.raises(ValueError, match='not finite'):
        blocks.update([3.0, bad])
    assert (blocks.n, blocks.mean) == (2, 1.5)


def test_twelve_hours_at_100_hz_take_well_under_a_second_and_little_memory(rng):
    x = rng.standard_normal(4_320_000)
    started = time.perf_counter()
    blocks = Dyadic.of(x)
    blocks.components()
    assert time.perf_counter() - started < 1.0
    tracemalloc.start()
    Dyadic.of(x)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 10e6


def test_the_state_stays_small(rng):
    blocks = Dyadic()
    for _ in range(50):
        blocks.update(rng.standard_normal(20_011))
    held = blocks._top.size + sum(p.size for p in blocks._pending)
    assert held < 64 * 20 + 20 * 20
