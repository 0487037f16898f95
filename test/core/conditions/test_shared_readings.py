#!/usr/bin/env python3
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
"""The same readings are found under any date and last digit; independent runs never share any."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter

from heading_intercompare.core.conditions import shared_readings
from heading_intercompare.core.conditions.shared_readings import (
    find_repeats,
    find_shared,
    Fingerprint,
)

T0_NS = 1_700_000_000_000_000_000
DAY_S = 86400.0


def errors(rng, n, tau):
    """Return errors of variance 1, of this correlation time in samples; white for 0."""
    white = rng.standard_normal(n + round(6 * tau))
    phi = np.exp(-1.0 / tau) if tau else 0.0
    return lfilter([np.sqrt(1.0 - phi * phi)], [1.0, -phi], white)[-n:]


def course(t_s, yaw_deg=2.0):
    """Return the heading on two legs in a swell; the same for each run."""
    phases = np.random.default_rng(3).uniform(0.0, 2.0 * np.pi, 30)
    periods = 8.0 * (1.0 + 0.15 * np.random.default_rng(4).standard_normal(30))
    swell = np.sin(2.0 * np.pi * t_s[:, None] / periods + phases).sum(axis=1)
    return 40.0 + 60.0 * np.clip((t_s - 300.0) / 60.0, 0.0, 1.0) + swell * yaw_deg / np.sqrt(15.0)


def trial(rng, span_s=1200.0, hz=1.0, tau_s=0.0, late_s=0.0):
    """Return times, TS and RS of a trial; all trials have the same motion."""
    t_s = np.arange(round(span_s * hz)) / hz
    ts = course(t_s - late_s) + 0.1 * errors(rng, t_s.size, tau_s * hz)
    return t_s, ts, course(t_s) + 0.05 * rng.standard_normal(t_s.size)


def fingerprint(t_s, ts, rs):
    return Fingerprint.of(T0_NS + np.rint(t_s * 1e9).astype(np.int64), ts - rs, rs % 360.0)


def share(one, other):
    return find_shared(one.to_text(), other.to_text())


def again(rng, t_s, ts, rs, how):
    """Return a trial as another recorder, or a careless person, has it."""
    if how == 'another date':
        return t_s + 3.0 * DAY_S + 0.37, ts, rs
    if how == 'rounded, with an offset':
        return t_s + 0.61, np.round(ts, 1) + 0.3, np.round(rs, 2)
    if how == 'begins later, with losses':
        kept = (t_s > 0.1 * t_s[-1]) & (rng.random(t_s.size) > 0.05)
        return t_s[kept] + DAY_S, ts[kept], rs[kept]
    half = t_s.size // 2
    new = trial(rng, t_s[-1] + t_s[1], 1.0 / t_s[1])
    return t_s, np.concatenate((new[1][:half], ts[:-half])), np.concatenate(
        (new[2][:half], rs[:-half]))


@pytest.mark.parametrize('how', ['another date', 'rounded, with an offset',
                                 'begins later, with losses', 'the second half'])
@pytest.mark.parametrize('span_s, hz, tau_s', [
    (400.0, 1.0, 0.0), (400.0, 10.0, 60.0), (1200.0, 1.0, 300.0), (1200.0, 10.0, 2.0),
    (7200.0, 0.2, 0.0)])
def test_the_same_readings_are_found(how, span_s, hz, tau_s, rng):
    one = trial(rng, span_s, hz, tau_s)
    found = share(fingerprint(*one), fingerprint(*again(rng, *one, how)))
    assert found is not None and found.correlation > 0.7 and found.span_s >= 128.0


@pytest.mark.parametrize('tau_s', [0.0, 2.0, 60.0, 600.0])
@pytest.mark.parametrize('span_s, hz, late_s', [
    (400.0, 1.0, 0.0), (1200.0, 1.0, 0.3), (1200.0, 10.0, 0.0), (1200.0, 10.0, 0.3),
    (7200.0, 0.2, 0.0)])
def test_independent_errors_under_the_same_motion_share_nothing(span_s, hz, tau_s, late_s, rng):
    runs = [fingerprint(*trial(rng, span_s, hz, tau_s, late_s)) for _ in range(3)]
    assert [share(runs[i], runs[j]) for i in range(3) for j in range(i)] == [None] * 3
    assert [find_repeats(run) for run in runs] == [None] * 3


def test_shared_readings_are_told_with_their_places(rng):
    """The other run has them 200 s after its start, from the 500th second of the first on."""
    t_s, ts, rs = trial(rng)
    new = trial(rng)
    mixed = [np.concatenate((fresh[:200], known[500:900], fresh[600:]))
             for fresh, known in zip(new[1:], (ts, rs))]
    found = share(fingerprint(t_s, ts, rs), fingerprint(t_s, *mixed))
    assert (found.first_ns - found.other_ns) / 1e9 == pytest.approx(300.0, abs=1.0)
    assert 200.0 <= (found.other_ns - T0_NS) / 1e9 + 32.0 and 256.0 <= found.span_s <= 480.0


@pytest.mark.parametrize('hz', [1.0, 10.0])
def test_a_block_that_was_pasted_is_found_in_its_run(hz, rng):
    t_s, ts, rs = trial(rng, hz=hz)
    x = ts - rs
    x[round(700 * hz):round(950 * hz)] = x[round(100 * hz):round(350 * hz)] + 0.2
    found = find_repeats(fingerprint(t_s, rs + x, rs))
    assert (found.other_ns - found.first_ns) / 1e9 == pytest.approx(600.0, abs=2.0)
    assert 64.0 <= (found.first_ns - T0_NS) / 1e9 <= 200.0


def test_the_length_of_a_run_does_not_matter_to_another(rng):
    """12 h have grains of 4 s, 2 h of half a second."""
    t_s, ts, rs = trial(rng, 43200.0)
    part = slice(20_000, 27_200)
    found = share(fingerprint(t_s, ts, rs), fingerprint(t_s[part], ts[part], rs[part]))
    assert found is not None and abs(found.first_ns - found.other_ns) <= 4_000_000_000


def test_few_or_equal_readings_are_not_testable(rng):
    t_s, ts, rs = trial(rng, 120.0)
    assert fingerprint(t_s, ts, rs) is None
    still = np.full(1200, 5.0)
    run = fingerprint(np.arange(1200.0), still, still)
    assert share(run, run) is None and find_repeats(run) is None


def test_a_fingerprint_is_kept_to_the_bit(rng):
    run = fingerprint(*trial(rng))
    kept = Fingerprint.from_text(run.to_text())
    assert kept.to_text() == run.to_text() and len(run.to_text()) < 30_000
    assert all(np.array_equal(getattr(kept, name), getattr(run, name))
               for name in ('start_ns', 'grain_s', 'least_bin_s', 'total_deg', 'count', 'rs_deg'))


def test_spikes_at_even_times_are_no_copy(rng):
    """A degree every 50 s, up or down at random, in 0.12 deg of noise: a run was called void."""
    n = 3000
    t = np.arange(n)
    x = 0.12 * rng.standard_normal(n) + (t % 50 == 7) * rng.choice([-1.0, 1.0], n)
    rs = (180.0 + 170.0 * np.sin(t / 40.0)) % 360.0
    assert find_repeats(Fingerprint.of(1_700_000_000 * 10 ** 9 + t * 10 ** 9, x, rs)) is None


def test_a_run_is_whitened_once_however_many_it_is_compared_with(rng, monkeypatch):
    """A campaign of 300 bags took minutes, because each pair of runs did this five times."""
    whiten, calls = shared_readings._whiten, []
    monkeypatch.setattr(shared_readings, '_whiten', lambda run, phase: calls.append(
        (run.total_deg.tobytes(), phase)) or whiten(run, phase))
    texts = [fingerprint(*trial(rng)).to_text() for _ in range(6)]
    found = [find_shared(late, early) for at, late in enumerate(texts) for early in texts[:at]]
    assert not any(found)
    assert len(calls) == len({*calls}) <= 6 * 4
