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

"""Cells of equal time: by hand, against a plain loop, independent of the chunks to the bit."""

from __future__ import annotations

import math
import tracemalloc

from hypothesis import given, strategies as st
import numpy as np
import pytest
from scipy.signal import lfilter

from heading_intercompare.core.statistics.cells import _coarsen, Cells, LEAST_CELLS

STEP_NS = 100_000_000
T0 = 1_400_000_000 * 10 ** 9


def correlated(n, rng, tau=20.0, offset=170.0):
    """Return skew AR(1) noise with a slow wave on an offset."""
    phi = math.exp(-1.0 / tau)
    e = lfilter([math.sqrt(1.0 - phi * phi)], [1.0, -phi], rng.exponential(size=n) - 1.0)
    return offset + 0.3 * e + 0.05 * np.sin(np.arange(n) * 2e-3)


def stamps_of(steps):
    """Return stamps with these steps, in units of the usual step of 0.1 s."""
    return T0 + np.cumsum(np.append(0, np.rint(np.asarray(steps) * STEP_NS).astype(np.int64)))


def places_by_definition(stamps):
    """Return the places of stamped differences, one by one."""
    steps = [int(b) - int(a) for a, b in zip(stamps, stamps[1:])]
    usual = sorted(steps[:127])[63]
    places, anchor, at_anchor = [0], int(stamps[0]), 0
    for step, stamp in zip(steps, stamps[1:]):
        if usual <= 2 * step <= 3 * usual:
            places.append(places[-1] + 1)
            anchor, at_anchor = int(stamp), places[-1]
        else:
            places.append(at_anchor + (2 * (int(stamp) - anchor) + usual) // (2 * usual))
    return places


def by_definition(x, stamps=None):
    """Return n, mean, q, k4, b and y as the page has them, cell by cell."""
    x, n = [float(v) for v in x], len(x)
    places = range(n) if stamps is None else places_by_definition(stamps)
    level = 0
    while (places[-1] + 1) >> level > 1023:
        level += 1
    cells = (places[-1] + 1) >> level
    # Deviations from the first are exact for values of one binade.
    mean = x[0] + math.fsum(v - x[0] for v in x) / n
    e = [(v - x[0]) - (mean - x[0]) for v in x]
    q = math.fsum(v * v for v in e) / n
    k4 = math.fsum(v ** 4 for v in e) / n / q ** 2 if q else 3.0
    members = [[] for _ in range(cells)]
    for place, v in zip(places, e):
        if place >> level < cells:
            members[place >> level].append(v)
    taken = sum(len(m) for m in members)
    b = [cells * math.fsum(m) / taken for m in members]
    y = [cells * (math.fsum(v * v for v in m) - len(m) * q) / taken + q for m in members]
    return n, mean, q, k4, np.array(b), np.array(y)


def assert_agrees(found, expected, rel=1e-11):
    n, mean, q, k4, b, y = expected
    assert found.n == n and found.b_deg.size == b.size
    assert found.mean_deg == pytest.approx(mean, rel=1e-14)
    assert found.mean_square_deg2 == pytest.approx(q, rel=1e-12)
    assert found.kurtosis == pytest.approx(k4, rel=1e-12)
    scale = math.sqrt(q) * b.size / n + 1e-300
    assert found.b_deg == pytest.approx(b, rel=rel, abs=rel * max(scale, np.abs(b).max()))
    assert found.y_deg2 == pytest.approx(y, rel=rel, abs=rel * max(q, np.abs(y).max()))


def assert_same(a, b):
    """Compare two sets of cell values, to the bit."""
    a, b = a.values(), b.values()
    if a is None or b is None:
        assert a is b
        return
    for name in ('n', 'mean_deg', 'mean_square_deg2', 'kurtosis', 'rounding_deg'):
        assert getattr(a, name) == getattr(b, name), name
    assert np.array_equal(a.b_deg, b.b_deg) and np.array_equal(a.y_deg2, b.y_deg2)


def fed(x, stamps, sizes, ask=False):
    """Return the cells of a series that comes in chunks of these sizes, then all the rest."""
    cells, lo = Cells(), 0
    for size in (*sizes, len(x)):
        cells.update(x[lo:lo + size], None if stamps is None else stamps[lo:lo + size])
        lo += size
        if ask:
            cells.values()
    return cells


# --- by hand ---

def test_cells_of_one_difference_by_hand():
    """128 differences 0, 2, 0, 2, ...: mean 1, each cell its own: b = -1, 1, y = 1; k4 = 1."""
    found = Cells.of([0.0, 2.0] * 64).values()
    assert (found.n, found.mean_deg, found.mean_square_deg2, found.kurtosis) == (128, 1, 1, 1)
    assert found.b_deg.tolist() == [-1.0, 1.0] * 64
    assert found.y_deg2.tolist() == [1.0] * 128


def test_cells_of_two_differences_by_hand():
    """
    1024 differences 1, 3, 5, 7, ... of 4: mean 4, cells (1, 3), (5, 7).

    Deviations -3, -1, 1, 3: b = -2, 2 and y = (9 + 1)/2 = 5 in every cell; q = 5,
    k4 = (81 + 1)/2 / 25 = 1.64.
    """
    found = Cells.of([1.0, 3.0, 5.0, 7.0] * 256).values()
    assert found.b_deg.tolist() == [-2.0, 2.0] * 256
    assert found.y_deg2 == pytest.approx(np.full(512, 5.0), rel=1e-14)
    assert (found.mean_square_deg2, found.kurtosis) == (5.0, pytest.approx(1.64))


def test_a_gap_leaves_cells_empty_by_hand():
    """
    150 places, 0.1 s each, 10 of them empty: 0 and q there, 150/140 of the deviation elsewhere.

    Differences 0 and 2 in turn, so the deviations are -1 and 1 and q is 1.
    """
    stamps = T0 + STEP_NS * np.delete(np.arange(150), np.arange(60, 70))
    found = Cells.of([0.0, 2.0] * 70, stamps).values()
    scale = 150.0 / 140.0
    expected = np.concatenate(([-scale, scale] * 30, np.zeros(10), [-scale, scale] * 40))
    assert found.b_deg == pytest.approx(expected, rel=1e-14)
    assert found.y_deg2 == pytest.approx(np.ones(150), rel=1e-14)


def test_empty_cells_know_nothing_rather_than_no_scatter(rng):
    """An empty cell has b = 0 and y = q exactly."""
    stamps = stamps_of([*[1.0] * 300, 100.0, *[1.0] * 299])
    found = Cells.of(correlated(600, rng), stamps).values()
    assert found.b_deg.size == 700
    assert found.b_deg[301:400].tolist() == [0.0] * 99
    assert found.y_deg2[301:400].tolist() == [found.mean_square_deg2] * 99


def test_a_burst_shares_one_place():
    """Three differences 0.45 to 0.49 of a step after the last regular one share its place."""
    stamps = stamps_of([*[1.0] * 140, 0.45, 0.02, 0.02, 1.0])
    assert places_by_definition(stamps)[-5:] == [140, 140, 140, 140, 141]
    found = Cells.of(np.arange(145.0), stamps).values()
    mean = 72.0
    assert found.b_deg.size == 142
    assert found.b_deg[140] == pytest.approx(
        142.0 / 145.0 * sum(v - mean for v in (140, 141, 142, 143)))


# --- against the plain loop ---

@pytest.mark.parametrize('n, cells', [
    (128, 128), (500, 500), (511, 511), (512, 512), (1022, 1022), (1023, 1023), (1024, 512),
    (1025, 512), (2046, 1023), (2047, 1023), (2048, 512), (5000, 625)])
def test_cells_agree_with_a_plain_loop(n, cells, rng):
    x = correlated(n, rng)
    found = Cells.of(x).values()
    assert found.b_deg.size == cells
    assert_agrees(found, by_definition(x))


STEPS = {
    'regular': lambda rng, n: np.ones(n),
    'jitter': lambda rng, n: rng.uniform(0.6, 1.4, n),
    'random': lambda rng, n: rng.exponential(1.0, n) + 1e-3,
    'lost': lambda rng, n: rng.geometric(0.5, n).astype(float),
    'gaps of hours': lambda rng, n: np.where(rng.random(n) < 0.005, 72_000.0, 1.0),
    'a gap of 1e9 s': lambda rng, n: np.where(np.arange(n) == n // 2, 1e10, 1.0),
    'bursts': lambda rng, n: np.where(rng.random(n) < 0.3, 0.01, 1.0),
    'at the edges': lambda rng, n: rng.choice([0.5, 1.0, 1.0, 1.0, 1.5, 2.5], n),
}


@pytest.mark.parametrize('n', [130, 1030, 3000])
@pytest.mark.parametrize('name', STEPS)
def test_stamped_cells_agree_with_a_plain_loop(name, n, rng):
    stamps = stamps_of(STEPS[name](rng, n - 1))
    x = correlated(n, rng)
    cells = Cells.of(x, stamps)
    expected = places_by_definition(stamps)
    if expected[-1] + 1 < LEAST_CELLS:
        assert cells.values() is None
        return
    assert cells._last_place == expected[-1]
    assert_agrees(cells.values(), by_definition(x, stamps))


def test_regular_stamps_and_none_say_the_same_to_the_bit(rng):
    x = correlated(5000, rng)
    steps = rng.uniform(0.51, 1.49, 4999)
    assert_same(Cells.of(x), Cells.of(x, stamps_of(steps)))


def test_a_slow_clock_does_not_move_the_places(rng):
    """A step 0.1 % longer than the usual one would cost a place in 1000; it costs none."""
    steps = np.append(np.ones(200), np.full(4799, 1.001))
    x = correlated(5000, rng)
    assert_same(Cells.of(x), Cells.of(x, stamps_of(steps)))


# --- chunks ---

@pytest.mark.parametrize('n', [127, 128, 1023, 1024, 1025, 70_000])
@pytest.mark.parametrize('stamped', [False, True])
def test_the_chunks_do_not_matter_to_the_bit(n, stamped, rng):
    x = correlated(n, rng)
    stamps = stamps_of(STEPS['at the edges'](rng, n - 1)) if stamped else None
    whole = Cells.of(x, stamps)
    for sizes in ([1] * 140, [64], [1, 62, 0, 3, 1000], [1023, 1, 1], [n - 1]):
        parts = fed(x, stamps, sizes, ask=True)
        assert parts.n == whole.n == n
        assert_same(parts, whole)


@pytest.mark.slow
@given(st.lists(st.integers(0, 400), max_size=12), st.integers(0, 2 ** 32),
       st.sampled_from([None, *STEPS]))
def test_any_chunks_give_the_same_values_to_the_bit(sizes, seed, kind):
    rng = np.random.default_rng(seed)
    n = sum(sizes) + 130
    x = correlated(n, rng)
    stamps = None if kind is None else stamps_of(STEPS[kind](rng, n - 1))
    assert_same(fed(x, stamps, sizes), Cells.of(x, stamps))


# --- moments ---

@pytest.mark.parametrize('offset', [0.0, 170.0, -179.9])
@pytest.mark.parametrize('n', [200, 4097, 100_000])
def test_moments_to_the_fourth_order_keep_twelve_digits(n, offset, rng):
    """Against two passes in extended precision; a step in the mean makes the joins work."""
    x = correlated(n, rng, offset=offset) + 0.5 * (np.arange(n) > n // 3)
    found = Cells.of(x).values()
    long = x.astype(np.longdouble)
    e = long - long.mean()
    q = np.mean(e ** 2)
    assert found.mean_deg == pytest.approx(float(long.mean()), rel=1e-14, abs=1e-15)
    assert found.mean_square_deg2 == pytest.approx(float(q), rel=1e-12)
    assert found.kurtosis == pytest.approx(float(np.mean(e ** 4) / q ** 2), rel=1e-12)


def test_an_offset_of_the_sensor_costs_no_digits(rng):
    """Steps of 2^-20 degree on 170 degrees are exact, so nothing but the mean changes."""
    x = np.rint(correlated(5000, rng, offset=0.0) * 2 ** 20) / 2 ** 20
    a, b = Cells.of(x).values(), Cells.of(x + 170.0).values()
    assert np.array_equal(a.b_deg, b.b_deg) and np.array_equal(a.y_deg2, b.y_deg2)
    assert (a.mean_square_deg2, a.kurtosis) == (b.mean_square_deg2, b.kurtosis)
    assert b.mean_deg - a.mean_deg == pytest.approx(170.0, rel=1e-15)


def test_equal_differences_have_values_of_exactly_zero():
    found = Cells.of(np.full(777, 0.1)).values()
    assert (found.mean_deg, found.mean_square_deg2, found.kurtosis) == (0.1, 0.0, 3.0)
    assert not found.b_deg.any() and not found.y_deg2.any()


# --- edges ---

@pytest.mark.parametrize('n', [0, 1, 2, 127])
@pytest.mark.parametrize('stamped', [False, True])
def test_fewer_than_128_differences_say_nothing(n, stamped):
    cells = Cells.of(np.arange(float(n)), T0 + STEP_NS * np.arange(n) if stamped else None)
    assert cells.n == n and cells.values() is None


def test_128_differences_in_fewer_places_say_nothing():
    """127 of them within one usual step: two places."""
    stamps = np.append(T0 + np.arange(0, 128 * 1000, 1000), T0 + 10 ** 6)
    regular = T0 + STEP_NS * np.arange(140)
    burst = np.concatenate((regular[:100], regular[99] + np.arange(1, 200)))
    assert Cells.of(np.ones(299), burst).values() is None
    assert Cells.of(np.ones(129), stamps).values() is not None


@pytest.mark.parametrize('bad', [math.nan, math.inf, -math.inf])
def test_values_that_are_not_finite_are_refused_and_nothing_is_taken(bad):
    cells = Cells.of([1.0, 2.0])
    with pytest.raises(ValueError, match='not finite'):
        cells.update([3.0, bad])
    assert cells.n == 2
    cells.update(np.ones(126))
    assert cells.values().mean_deg == pytest.approx(129.0 / 128.0)


def test_the_series_given_is_left_as_it_is(rng):
    x = rng.standard_normal(2000)
    before = x.copy()
    Cells.of(x)
    assert np.array_equal(x, before)


# --- merging ---

@pytest.mark.parametrize('first, second', [
    (0, 200), (200, 0), (130, 1), (1, 300), (1024, 1000), (1024, 3000), (4096, 777), (96, 100),
    (65_536, 70_000), (128, 128), (2048, 5)])
@pytest.mark.parametrize('stamped', [False, True])
def test_adding_continues_the_series(first, second, stamped, rng):
    if stamped and 0 < min(first, second) < LEAST_CELLS:
        pytest.skip('the usual step of so few is not known')
    n = first + second
    x = correlated(n, rng)
    stamps = T0 + STEP_NS * np.arange(n) if stamped else None
    parts = [Cells.of(x[part], None if stamps is None else stamps[part])
             for part in (slice(None, first), slice(first, None))]
    joined = parts[0] + parts[1]
    assert joined.n == n
    assert_agrees(joined.values(), by_definition(x), rel=1e-9)


@pytest.mark.parametrize('second', [2000, 2001, 2002])
def test_a_sum_can_be_continued_and_leaves_its_parts_alone(second, rng):
    """Also where the last cell of the sum is not complete."""
    x = correlated(9000, rng)
    a, b = Cells.of(x[:1024]), Cells.of(x[1024:second])
    before = [c.values() for c in (a, b)]
    joined = a + b
    for lo in range(second, 9000, 700):
        joined.update(x[lo:lo + 700])
        assert_agrees(joined.values(), by_definition(x[:lo + 700]), rel=1e-9)
    for cells, values in zip((a, b), before):
        assert values is None or np.array_equal(cells.values().y_deg2, values.y_deg2)


def test_a_gap_between_the_parts_leaves_places_empty(rng):
    x = correlated(2048, rng)
    stamps = T0 + STEP_NS * np.append(np.arange(1024), 4096 + np.arange(1024))
    joined = Cells.of(x[:1024], stamps[:1024]) + Cells.of(x[1024:], stamps[1024:])
    assert_agrees(joined.values(), by_definition(x, stamps), rel=1e-9)


def test_sums_that_do_not_align_are_refused(rng):
    x = correlated(2000, rng)
    with pytest.raises(ValueError, match='131 places cannot be followed by cells of 2'):
        Cells.of(x[:131]) + Cells.of(x[131:])


def test_sums_with_other_steps_are_refused(rng):
    x, stamps = correlated(256, rng), T0 + STEP_NS * np.arange(256)
    plain, stamped = Cells.of(x[:128]), Cells.of(x[:128], stamps[:128])
    faster = Cells.of(x[128:], stamps[127] + STEP_NS // 2 * np.arange(1, 129))
    few = Cells.of(x[128:200], stamps[128:200])
    for a, b in ((plain, stamped), (stamped, plain), (stamped, faster), (stamped, few)):
        with pytest.raises(ValueError, match='usual steps of the two series differ'):
            a + b
    with pytest.raises(TypeError):
        plain + 1


# --- size ---

def test_twelve_hours_at_100_hz_take_little_memory(rng):
    x = rng.standard_normal(1_000_000)
    stamps = T0 + 10_000_000 * np.arange(x.size)
    cells = Cells()
    tracemalloc.start()
    for lo in range(0, x.size, 20_000):
        cells.update(x[lo:lo + 20_000], stamps[lo:lo + 20_000])
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 5e6


def test_the_state_stays_small(rng):
    cells = Cells()
    for _ in range(50):
        cells.update(rng.standard_normal(20_011))
        assert cells._index.size <= 1024
        assert sum(x.size for _, x in cells._open) <= 1 << cells._level


@pytest.mark.parametrize('first', [0, 6, 7])
@pytest.mark.parametrize('cells', [1, 2, 3, 512, 1023])
def test_cells_without_a_hole_are_joined_to_the_same_bits_as_cells_with_one(first, cells, rng):
    index, rows = first + np.arange(cells + 1), rng.uniform(1.0, 9.0, (5, cells + 1))
    index[-1] += 10
    whole_index, whole_rows = _coarsen(index[:-1], rows[:, :-1])
    holed_index, holed_rows = _coarsen(index, rows)
    assert whole_index.tolist() == holed_index[:-1].tolist()
    assert whole_rows.tobytes() == holed_rows[:, :-1].tobytes()
