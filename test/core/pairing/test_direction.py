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

"""The choice of the sensor to interpolate: by the stamps alone, and right for a ship's yaw."""

from __future__ import annotations

import math

import numpy as np
import pytest

from heading_intercompare import analyze, Headings, pair, Pairs, Settings
from heading_intercompare.core.pairing.direction import is_slower, typical_step_ns
from heading_intercompare.core.pairing.pairer import Pairer

S = 1_000_000_000
T0 = 1_400_000_000 * S


def rules(**names):
    return Settings.from_mapping({k.replace('__', '.'): v for k, v in names.items()})


def stamps(rate_hz, start_s, span_s):
    return T0 + np.round((start_s + np.arange(round(span_s * rate_hz)) / rate_hz) * 1e9).astype(
        np.int64)


def level(*parts):
    """Return readings of 90 degrees at the stamps of parts (rate_hz, start_s, span_s)."""
    at = np.concatenate([stamps(*part) for part in parts])
    return Headings.of(at, np.full(at.size, 90.0))


def is_on_rs(pairs, rs):
    return np.isin(pairs.stamp_ns, rs.stamp_ns)


def test_the_typical_step_by_hand():
    """In 1, 1, 4 half of the time, 3 of 6, falls into 4; in 1, 1, 2 it falls into 1, 1."""
    assert typical_step_ns(np.array([0, 1, 2, 6])) == 4
    assert typical_step_ns(np.array([0, 1, 2, 4])) == 1
    assert typical_step_ns(np.array([5])) is None and typical_step_ns(np.empty(0, int)) is None


def test_bursts_count_as_their_pauses_and_a_dropout_does_not_count():
    bursts = (np.arange(60)[:, np.newaxis] * 1000 + np.arange(5)).ravel()
    assert typical_step_ns(bursts) == 996
    steady = np.delete(np.arange(0, 6000, 10), slice(100, 350))
    assert typical_step_ns(steady) == 10


def test_slower_is_more_than_half_as_long_again_and_more_than_the_setting():
    assert is_slower(100, 151, 150) and not is_slower(100, 150, 100)
    assert not is_slower(100, 250, 250) and is_slower(100, 251, 250)
    assert is_slower(None, 1, 0) is None and is_slower(1, None, 0) is None


@pytest.mark.parametrize('ts_hz, rs_hz, onto_rs', [
    (10.0, 1.0, True), (5.0, 1.0, True), (1.0, 0.5, True), (2.0, 2.0, False), (1.0, 10.0, False),
    (1.0, 0.7, False), (100.0, 5.0, False), (10.0, 3.9, True)])
def test_the_rates_decide(ts_hz, rs_hz, onto_rs):
    ts, rs = level((ts_hz, 0.013, 200.0)), level((rs_hz, 0.0, 200.0))
    named = rules(pairing__method='interpolate_ts' if onto_rs else 'interpolate')
    assert pair(ts, rs)[0] == pair(ts, rs, named)[0]


def test_only_the_first_minute_decides():
    """From 61 s on the RS is as fast as the TS, or slow: that changes nothing in the run."""
    ts = level((10.0, 0.013, 200.0))
    slow_first, fast_first = (level((a, 0.0, 61.0), (b, 61.0, 139.0))
                              for a, b in ((1.0, 10.0), (10.0, 1.0)))
    assert is_on_rs(pair(ts, slow_first)[0], slow_first).all()
    assert not is_on_rs(pair(ts, fast_first)[0], fast_first).any()


def test_behind_a_silence_the_choice_is_made_again():
    ts = level((10.0, 0.013, 100.0), (10.0, 200.013, 100.0))
    rs = level((1.0, 0.0, 100.0), (10.0, 200.0, 100.0))
    pairs, ledger = pair(ts, rs)
    late = pairs.stamp_ns > T0 + 150 * S
    assert is_on_rs(pairs, rs)[~late].all() and not is_on_rs(pairs, rs)[late].any()
    # No bracket reaches over the change, and nothing is lost but the ends.
    assert (np.count_nonzero(~late), np.count_nonzero(late)) == (99, 999)
    first, second = ledger.shares([int(pairs.stamp_ns[0]), int(pairs.stamp_ns[late][0])])
    assert first.counts['ts_used'] == 4 * 99 and 'ts_paired' not in first.counts
    assert second.counts['ts_paired'] == 999 and 'ts_used' not in second.counts
    assert ledger.balance() == {'ts': 0, 'rs': 0}


def test_a_silence_as_long_as_allowed_is_none():
    ts = level((10.0, 0.013, 300.0))
    for silence_s, again in ((60.0, False), (60.5, True)):
        rs = level((1.0, 0.0, 101.0), (10.0, 100.0 + silence_s, 100.0))
        late = pair(ts, rs)[0].stamp_ns > T0 + 150 * S
        assert is_on_rs(pair(ts, rs)[0], rs)[late].all() != again


def test_a_sensor_that_comes_late_is_waited_for():
    """The TS starts 100 s before the RS: the first minute counts from when both report."""
    ts = level((1.0, 0.0, 100.0), (10.0, 100.0, 100.0))
    rs = level((1.0, 100.004, 100.0))
    pairs, ledger = pair(ts, rs)
    assert is_on_rs(pairs, rs).all() and len(pairs) == 100
    assert ledger.balance() == {'ts': 0, 'rs': 0}


def test_pairs_wait_for_the_choice_and_none_is_lost_live():
    ts, rs = level((5.0, 0.013, 120.0)), level((1.0, 0.0, 120.0))
    pairer, chunks = Pairer(rules(pairing__max_wait_s=1.0)), []
    for second in range(120):
        lo, hi = (np.searchsorted(ts.stamp_ns, T0 + (second + k) * S) for k in (0, 1))
        chunks.append(pairer.update(ts[lo:hi], rs[second:second + 1], now_s=float(second)))
        # A minute from the first TS reading, at 13 ms, both have been heard.
        assert bool(len(chunks[-1])) == (second >= 61)
        if second == 59:
            assert pairer.ledger.total.counts == {'ts_pending': 300, 'rs_pending': 60}
    chunks.append(pairer.flush())
    assert Pairs.concatenate(chunks) == pair(ts, rs)[0]


@pytest.mark.slow
@pytest.mark.parametrize('silent_wait_s, most', [(1.0, 30), (60.0, 620)])
def test_memory_is_bounded_while_the_choice_is_open(silent_wait_s, most):
    pairer = Pairer(rules(pairing__max_wait_s=1.0, pairing__silent_wait_s=silent_wait_s))
    for second in range(3000):
        pairer.update(ts=level((10.0, float(second), 1.0)), now_s=float(second))
    assert pairer.ledger.total.counts['ts_pending'] <= most
    assert len(pairer._direction._stamp_ns['ts']) <= 2 * 600 + 30


def yawing(rng, rs_hz, yaw_deg, period_s, sigma_deg):
    """Return a TS of 10 Hz and an RS of a ship that yaws, with white errors."""
    period_s, phase = period_s * rng.uniform(0.95, 1.05), rng.uniform(0.0, 2.0 * math.pi)
    found = []
    for rate_hz, error_deg in ((10.0, sigma_deg), (rs_hz, 0.02)):
        t = np.arange(rng.uniform(0.0, 1.0 / rate_hz), 600.0, 1.0 / rate_hz)
        heading = (100.0 + yaw_deg * np.sin(2.0 * math.pi * t / period_s + phase)
                   + error_deg * rng.standard_normal(t.size))
        found.append(Headings.of(T0 + np.round(t * 1e9).astype(np.int64), heading))
    return found


@pytest.mark.slow
@pytest.mark.parametrize('rs_hz, yaw_deg, period_s, share, least', [
    (0.5, 1.0, 8.0, 0.0, 0.4), (1.0, 2.0, 6.0, 0.7, 0.9)])
def test_a_slow_rs_does_not_make_a_sound_ts_fail(rng, rs_hz, yaw_deg, period_s, share, least):
    """
    With the RS interpolated they are rejected for the yaw between its readings; by default none.

    A bracket of length h is off by (5 / 3 + cos(q) / 3 - 4 (1 - cos q) / q^2) A^2 / 2, q = 2 pi h
    / T, on average: 0.023 deg2 for 2 s, 0.019 deg2 for 1 s. R is 0.017 and 0.0229 deg2, and the
    second TS adds 0.011 deg2 of its own.
    """
    norm_deg = 0.15 if share else 0.13
    rejected = dict.fromkeys(('interpolate', 'auto'), 0)
    for _ in range(10):
        ts, rs = yawing(rng, rs_hz, yaw_deg, period_s, norm_deg * share)
        for method in rejected:
            (run,) = analyze(ts, rs, rules(
                pairing__method=method, pairing__kernel='line', norms__sigma_max_deg=norm_deg,
                norms__sigma_ref_max_deg=0.02)).runs
            found = run.guarded
            rejected[method] += found.lower_bound_deg2 > found.rejection_limit_deg2
            if method == 'auto':
                assert found.upper_bound_deg2 <= found.acceptance_limit_deg2
    assert rejected['interpolate'] >= 10 * least and rejected['auto'] == 0


@pytest.mark.slow
def test_a_ts_at_its_norm_is_not_certified_for_the_noise_that_interpolation_took(rng):
    """White TS errors of the norm, 5 Hz put onto 1 Hz: the mean factor of a cubic is 0.775."""
    settings = rules(norms__sigma_max_deg=0.2, norms__sigma_ref_max_deg=0.02)
    certified, would_have_been = 0, 0
    for _ in range(20):
        t = np.arange(0.0, 1000.0, 0.2 * 1.0007)
        ts = Headings.of(T0 + np.round(t * 1e9).astype(np.int64),
                         10.0 + 0.2 * rng.standard_normal(t.size))
        (run,) = analyze(ts, level((1.0, 0.0, 1000.0)), settings).runs
        factor, found = run.pairing.ts_variance_factor, run.guarded
        assert factor == pytest.approx(0.7754, abs=0.01)
        assert found.acceptance_limit_deg2 == pytest.approx(factor * 0.2 ** 2)
        assert found.rejection_limit_deg2 == pytest.approx(0.2 ** 2 + 0.02 ** 2)
        certified += found.upper_bound_deg2 <= found.acceptance_limit_deg2
        would_have_been += found.upper_bound_deg2 <= 0.2 ** 2
    # 20 runs at 0.05 each: more than 5 in 3 cases of 10,000.
    assert certified <= 5 and would_have_been >= 10
