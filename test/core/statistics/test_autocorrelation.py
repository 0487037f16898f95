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

"""Correlation in time: by hand, by definition, NIST SP 1065 and real ship logs."""

from __future__ import annotations

from datetime import datetime, timezone
import json
import math
import re
import tracemalloc

from checksums import checksum_of
import numpy as np
import pytest
from scipy.signal import lfilter

from heading_intercompare.core.angles import unwrap_deg, wrap180
from heading_intercompare.core.statistics.autocorrelation import (
    allan_dof,
    autocorrelate,
    compute_allan_deviation,
    effective_size,
    estimate_correlation_times,
    geyer_time,
    SeriesCorrelation,
    sokal_times,
)


def ar1(n, tau, rng):
    """Return AR(1) noise of unit variance, started in its stationary state."""
    phi = math.exp(-1.0 / tau)
    white = rng.standard_normal(n) * math.sqrt(1.0 - phi * phi)
    return lfilter([1.0], [1.0, -phi], white, zi=[phi * rng.standard_normal()])[0]


def by_definition(x, max_lag):
    """Return r_0 to r_max_lag, lag by lag."""
    e = x - x.mean()
    return np.array([np.dot(e[:e.size - k], e[k:]) for k in range(max_lag + 1)]) / np.dot(e, e)


def nist_series():
    """Return the 1000 numbers of NIST SP 1065: a linear congruential generator."""
    value, numbers = 1234567890, []
    for _ in range(1000):
        numbers.append(value / 2147483647)
        value = 16807 * value % 2147483647
    return np.array(numbers)


# --- autocorrelation ---

def test_autocorrelation_by_hand():
    """1, 2, 3 about 2: -1, 0, 1; power 2; lag 1: 0; lag 2: -1."""
    assert autocorrelate([1.0, 2.0, 3.0], 5) == pytest.approx([1.0, 0.0, -0.5], abs=1e-15)


@pytest.mark.parametrize('n, lags', [(2, 1), (50, 49), (1001, 300), (150_000, 40),
                                     (300_001, 150_000)])
def test_autocorrelation_agrees_with_the_definition(n, lags, rng):
    x = 170.0 + ar1(n, 12.0, rng)
    got = autocorrelate(x, lags)
    some = np.unique(np.linspace(0, lags, 25).astype(int))
    e = x - x.mean()
    expected = [np.dot(e[:n - k], e[k:]) / np.dot(e, e) for k in some]
    assert got.size == lags + 1
    assert got[some] == pytest.approx(expected, abs=1e-13)


def test_autocorrelation_of_degenerate_series():
    assert autocorrelate([], 3).size == 0
    assert autocorrelate([7.5], 3).tolist() == [1.0]
    assert autocorrelate([0.1] * 9, 3).tolist() == [1.0, 0.0, 0.0, 0.0]
    with pytest.raises(ValueError, match='max_lag = -1'):
        autocorrelate([1.0, 2.0], -1)


@pytest.mark.slow
def test_all_lags_that_the_decision_needs_fit_into_200_megabytes(rng):
    x = rng.standard_normal(4_320_000)
    tracemalloc.start()
    autocorrelate(x, x.size // 4)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 200e6


# --- correlation times ---

@pytest.mark.parametrize('n, tau', [(64, 3.0), (500, 1.0), (3000, 40.0), (30_000, 700.0)])
def test_correlation_times_agree_with_the_definition(n, tau, rng):
    x = ar1(n, tau, rng)
    last = max(2, n // 4) - 1
    r = by_definition(x, last)
    tau_1 = tau_2 = 1.0
    for w in range(last + 1):
        if w:
            tau_1 += 2.0 * r[w]
            tau_2 += 2.0 * r[w] ** 2
        if w >= 10.0 * max(tau_1, tau_2, 1.0):
            break
    got = estimate_correlation_times(x)
    assert (got.n, got.window) == (n, w)
    assert (got.tau_1, got.tau_2) == pytest.approx((tau_1, tau_2), rel=1e-10)
    assert effective_size(x) == pytest.approx(n / max(tau_2, 1.0), rel=1e-10)


def test_the_window_grows_beyond_the_first_lags_computed(rng):
    x = ar1(200_000, 2000.0, rng)
    got = estimate_correlation_times(x)
    assert got.window > 4096
    r = autocorrelate(x, got.window)[1:]
    assert got.tau_2 == pytest.approx(1.0 + 2.0 * np.sum(r * r), rel=1e-10)


def test_correlation_times_of_ar1_are_those_of_theory(rng):
    """
    Sums of phi^k: tau_1 = (1 + phi)/(1 - phi), tau_2 the same of phi^2.

    Six standard errors sqrt(2 (2 W + 1) / n) of tau_1 (Sokal 1997); tau_2 scatters less.
    """
    phi = math.exp(-1.0 / 20.0)
    got = estimate_correlation_times(ar1(400_000, 20.0, rng))
    rel = 6.0 * math.sqrt(2.0 * (2 * got.window + 1) / got.n)
    assert rel < 0.4
    assert got.tau_1 == pytest.approx((1 + phi) / (1 - phi), rel=rel)
    assert got.tau_2 == pytest.approx((1 + phi ** 2) / (1 - phi ** 2), rel=rel)


@pytest.mark.parametrize('x, size', [([], 0.0), ([1.0], 1.0), ([1.0, 2.0], 4.0 / 3.0),
                                     ([0.3] * 100, 100.0)])
def test_effective_size_of_degenerate_series(x, size):
    assert effective_size(x) == size


def test_geyer_sums_while_pairs_are_positive():
    """1, 1, -1, -1 twice: r = 1, 1/8, -3/4, -1/8, 1/2 ...; first pair 9/8, second negative."""
    x = [1.0, 1.0, -1.0, -1.0] * 2
    assert geyer_time(x) == pytest.approx(-1.0 + 2.0 * 9.0 / 8.0)
    assert geyer_time([]) == geyer_time([2.0]) == 1.0


def test_geyer_reaches_beyond_the_first_lags_computed(rng):
    x = np.cos(np.pi * np.arange(40_000) / 40_000) + 0.01 * rng.standard_normal(40_000)
    r = autocorrelate(x, 39_999)
    pairs = r.reshape(-1, 2).sum(axis=1)
    count = int(np.argmax(pairs <= 0.0))
    assert 2 * count > 4096
    assert geyer_time(x) == pytest.approx(-1.0 + 2.0 * pairs[:count].sum(), rel=1e-9)


# --- real logs ---

def stamp_ns(text):
    """Return nanoseconds of an ISO stamp or of one with the day of the year."""
    form = '%Y-%m-%dT%H:%M:%S' if 'T' in text else '%y+%j:%H:%M:%S'
    seconds, fraction = text.rstrip('Z').split('.')
    whole = datetime.strptime(seconds, form).replace(tzinfo=timezone.utc)
    return round(whole.timestamp()) * 10 ** 9 + int(fraction.ljust(9, '0'))


def headings(path, talker, field):
    """Return stamps and headings of the good sentences of one kind, in file order."""
    stamps, values = [], []
    for line in path.read_text('ascii', 'replace').splitlines():
        found = re.match(r'(\S+) \$((%s),[^*]*)\*([0-9A-Fa-f]{2})\s*$' % talker, line)
        if found and checksum_of(found[2]) == int(found[4], 16):
            text = found[2].split(',')[field]
            if text and 0.0 <= float(text) < 360.0:
                stamps.append(stamp_ns(found[1]))
                values.append(float(text))
    return np.array(stamps), np.array(values)


@pytest.mark.parametrize('data_set, pair, ts, rs', [
    ('NBP1406', 'gyr1-s330', ('nbp1406/NBP1406_gyr1-2014-08-01', 'HEHDT', 1),
     ('nbp1406/NBP1406_s330-2014-08-01', 'INHDT', 1)),
    ('NBP1406', 'seap-s330', ('nbp1406/NBP1406_seap-2014-08-01', 'GPHDT', 1),
     ('nbp1406/NBP1406_s330-2014-08-01', 'INHDT', 1)),
    ('LMG1903', 'lgyr-lsep', ('lmg1903/LMG1903_lgyr.d085', 'HEHDT', 1),
     ('lmg1903/LMG1903_lsep.d085', 'PSXN,23', 4))])
def test_correlation_of_real_logs_agrees_with_independent_programs(shared_data, data_set, pair,
                                                                   ts, rs):
    golden = json.loads((shared_data / 'golden_nbp1406_lmg1903.json').read_text('utf-8'))
    expected = golden['sets'][data_set]['pairs'][pair]['interp']
    t, h = headings(shared_data / ts[0], *ts[1:])
    t_ref, h_ref = headings(shared_data / rs[0], *rs[1:])
    last = np.searchsorted(t_ref, t)
    inside = (t >= t_ref[0]) & (t <= t_ref[-1])
    last = np.clip(last, 1, t_ref.size - 1)
    inside &= ((t_ref[last] - t_ref[last - 1] <= 3_000_000_000) | (t == t_ref[last])
               | (t == t_ref[last - 1]))
    t0 = t_ref[0]
    x = wrap180(h - np.interp(t - t0, t_ref - t0, unwrap_deg(h_ref)))[inside]
    times = sokal_times(x)
    assert (x.size, times.window) == (expected['n'], expected['W'])
    assert x.mean() == pytest.approx(expected['mean'], rel=1e-9)
    got = {'r1': autocorrelate(x, 1)[1], 'tau': times.tau_1, 'tau2': times.tau_2,
           'tau_geyer': geyer_time(x)}
    assert got == pytest.approx({name: expected[name] for name in got}, rel=1e-9)


# --- Allan deviation ---

def test_allan_deviation_of_the_nist_series():
    """NIST SP 1065, test suite of 1000 points: seven digits as printed."""
    plain = compute_allan_deviation(nist_series(), 1.0, m=[1, 10, 100], overlapping=False)
    overlapped = compute_allan_deviation(nist_series(), 1.0, [1.0, 10.0, 100.0])
    assert [f'{v:.6e}' for v in plain.deviation] == \
        ['2.922319e-01', '9.965736e-02', '3.897804e-02']
    assert [f'{v:.6e}' for v in overlapped.deviation] == \
        ['2.922319e-01', '9.159953e-02', '3.241343e-02']
    assert plain.terms.tolist() == [999, 99, 9]
    assert overlapped.terms.tolist() == [999, 981, 801]


def test_allan_deviation_by_hand():
    """0, 2, 4, 10: averages of two 1, 7: sqrt(36/2); steps of one 2, 2, 6: sqrt(44/3/2)."""
    got = compute_allan_deviation([0.0, 2.0, 4.0, 10.0], 4.0)
    assert got.m.tolist() == [1, 2]
    assert got.tau_s.tolist() == [0.25, 0.5]
    assert got.deviation == pytest.approx([math.sqrt(44.0 / 6.0), math.sqrt(18.0)])


@pytest.mark.parametrize('m', [1, 3, 64])
def test_overlapped_allan_deviation_agrees_with_the_definition(m, rng):
    x = 350.0 + ar1(700, 30.0, rng)
    means = np.array([x[i:i + m].mean() for i in range(x.size - m + 1)])
    expected = math.sqrt(0.5 * np.mean((means[m:] - means[:-m]) ** 2))
    got = compute_allan_deviation(x, 10.0, [m / 10.0])
    assert got.deviation == pytest.approx([expected], rel=1e-10)


@pytest.mark.parametrize('m', [1, 5, 2048])
def test_plain_allan_deviation_agrees_with_the_definition(m, rng):
    x = ar1(4096, 9.0, rng)
    means = [math.fsum(x[i:i + m]) / m for i in range(0, x.size - m + 1, m)]
    expected = math.fsum((b - a) ** 2 for a, b in zip(means, means[1:])) / (2 * len(means) - 2)
    got = compute_allan_deviation(x, 1.0, m=[m], overlapping=False)
    assert got.deviation ** 2 == pytest.approx([expected], rel=1e-9)


def test_allan_deviation_of_white_noise_falls_with_the_root_of_time(rng):
    """As sigma / sqrt(m); six standard errors, 1 / sqrt(2 n / 3 m), of the overlapped form."""
    n = 200_000
    got = compute_allan_deviation(rng.standard_normal(n), 10.0, [0.1, 1.0, 10.0])
    for m, deviation in zip((1, 10, 100), got.deviation):
        assert abs(deviation * math.sqrt(m) - 1.0) < 6.0 / math.sqrt(2.0 * n / (3.0 * m))


@pytest.mark.parametrize('x', [[], [1.0]])
def test_allan_deviation_of_too_few_samples_is_empty(x):
    got = compute_allan_deviation(x, 1.0)
    assert (got.m.size, got.deviation.size, got.terms.size) == (0, 0, 0)


def test_allan_deviation_leaves_out_times_that_the_record_does_not_hold():
    got = compute_allan_deviation(np.arange(10.0), 2.0, [0.1, 0.5, 0.5, 2.5, 3.0])
    assert got.m.tolist() == [1, 5]
    with pytest.raises(ValueError, match='rate_hz = 0.0'):
        compute_allan_deviation([1.0, 2.0], 0.0)


def test_the_allan_variance_of_white_noise_scatters_as_its_degrees_of_freedom_say(rng):
    """400 records of 256 samples: a ratio of variances of 400 values is good to 25 %."""
    found = [compute_allan_deviation(rng.standard_normal(256), 1.0) for _ in range(400)]
    variance = np.array([one.deviation ** 2 for one in found])
    dof = allan_dof(found[0].m, found[0].terms)
    measured = 2.0 * variance.mean(axis=0) ** 2 / variance.var(axis=0)
    # The last has one or two: its formula is an approximation there.
    assert dof[:-1] == pytest.approx(measured[:-1], rel=0.35)
    assert np.all(dof >= 1.0) and np.all(np.diff(dof) < 0.0)


def errors_of_many_kinds(n, rng):
    """Yield errors that a run may hold: white, slow, wandering, periodic, with gaps and steps."""
    white, t = rng.standard_normal(n), np.arange(n)
    yield 'white', white
    yield 'AR(1)', ar1(n, 2000.0, rng)
    yield 'random walk', np.cumsum(white)
    yield 'periodic', np.sin(t / 3.0) + np.sin(t / 5000.0) + 0.1 * white
    yield 'gaps', ar1(n, 300.0, rng)[rng.random(n) > 0.1 * (t % 50_000 < 5000)]
    yield 'steps', white + 3.0 * (t > n // 3) - 2.0 * (t > n // 2)
    yield 'offset', 179.0 + 1e-3 * white


def test_segments_give_the_autocorrelation_of_the_whole(rng):
    """Lags within a segment, of nearly a segment, and so long that there is one segment."""
    for kind, x in errors_of_many_kinds(400_000, rng):
        e = x - x.mean()
        spectrum = np.abs(np.fft.rfft(e, 2 * e.size)) ** 2
        expected = np.fft.irfft(spectrum)[:e.size] / (e @ e)
        for m in (1, 7, 5000, 40_000, 150_000):
            assert np.abs(autocorrelate(x, m) - expected[:m + 1]).max() < 1e-11, (kind, m)


def test_one_measurement_serves_all_who_ask_for_the_correlation(rng):
    for kind, x in errors_of_many_kinds(300_000, rng):
        found = SeriesCorrelation.of(x)
        wide, narrow = estimate_correlation_times(x), sokal_times(x)
        for mine, alone in ((found.wide, wide), (found.narrow, narrow)):
            assert (mine.n, mine.window) == (alone.n, alone.window), kind
            assert mine.tau_1 == pytest.approx(alone.tau_1, rel=1e-9)
            assert mine.tau_2 == pytest.approx(alone.tau_2, rel=1e-9)
        assert found.r1 == pytest.approx(autocorrelate(x, 1)[1], abs=1e-12)
    assert SeriesCorrelation.of([3.0]).r1 is None
