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

"""Tests of the comparison of two sequences of values."""

import numpy as np
import pytest
from trials import find_finding

from heading_intercompare import analyze
from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.pairing.ledger import LedgerKey
from heading_intercompare.core.pairing.pairer import pair, Pairer
from heading_intercompare.core.raw_streams.sequence_match import Matched, SequenceMatch
from heading_intercompare.core.records import Headings
from heading_intercompare.core.settings import Settings

T0 = 1_700_000_000_000_000_000
NORMS = {'sigma_max_deg': 0.2, 'sigma_ref_max_deg': 0.1}


def ship(t_s, rng, rms_deg=0.7, period_s=10.0):
    """Return a heading: 40 sines, their periods spread by 15 %."""
    rate = 2.0 * np.pi / (period_s * (1.0 + 0.15 * rng.standard_normal(40)))
    a, b = rng.standard_normal((2, 40))
    waves = np.sin(t_s[:, None] * rate) @ a + np.cos(t_s[:, None] * rate) @ b
    return 200.0 + rms_deg * waves / np.sqrt(0.5 * (a @ a + b @ b))


def readings(t_s, heading_deg, step_deg=0.01):
    return Headings.of(T0 + np.round(t_s * 1e9).astype(np.int64),
                       np.round(np.round(heading_deg / step_deg) * step_deg, 6) % 360.0)


@pytest.fixture
def sensor(rng):
    """Return the times and values of a sensor at 10 Hz, in steps of 0.01 deg."""
    t_s = np.arange(0.0, 1200.0, 0.1)
    return t_s, np.round(ship(t_s, rng) + 0.02 * rng.standard_normal(t_s.size), 2)


def compare(a, b, rng=None):
    match = SequenceMatch(2.0)
    found, at = [], [0, 0]
    while at[0] < len(a) or at[1] < len(b):
        n = [len(a), len(b)] if rng is None else rng.integers(0, 300, 2).tolist()
        found.append(match.take(a[at[0]:at[0] + n[0]], b[at[1]:at[1] + n[1]]))
        at = [at[0] + n[0], at[1] + n[1]]
    found.append(match.end())
    return Matched(*(np.concatenate([getattr(one, name) for one in found])
                     for name in ('compared_ns', 'differing_ns')))


COPIES = {
    'late by one reading': lambda t, h, rng: readings(t + 0.1, h),
    'late by a fraction of a step': lambda t, h, rng: readings(t + 0.53, h),
    'early': lambda t, h, rng: readings(t - 1.91, h),
    'with a constant added': lambda t, h, rng: readings(t, h + 1.23),
    'thinned': lambda t, h, rng: readings(t[::5] + 0.03, h[::5]),
    'rounded': lambda t, h, rng: readings(t + 0.04, h, 0.1),
    'thinned, rounded, with a constant added': lambda t, h, rng: readings(
        t[::3], h[::3] + 7.4, 0.1),
    'with readings lost': lambda t, h, rng: readings(
        t[np.arange(t.size) % 97 > 0], h[np.arange(t.size) % 97 > 0]),
    'with uneven stamps': lambda t, h, rng: readings(t + rng.uniform(-0.02, 0.02, t.size), h),
}


@pytest.mark.parametrize('way', COPIES)
def test_a_copy_changes_when_the_sensor_does(sensor, rng, way):
    found = compare(readings(*sensor), COPIES[way](*sensor, rng))
    assert len(found.compared_ns) >= 300 and not len(found.differing_ns)


@pytest.mark.parametrize('step_deg, noise_deg', [(0.01, 0.005), (0.1, 0.01), (0.1, 0.03),
                                                 (1.0, 0.05)])
def test_two_quiet_sensors_in_steps_change_apart(rng, step_deg, noise_deg):
    t_s = np.arange(0.0, 1200.0, 0.1)
    motion = ship(t_s, rng)
    a, b = (readings(t_s, motion + noise_deg * rng.standard_normal(t_s.size), step_deg)
            for _ in range(2))
    found = compare(a, b)
    assert len(found.compared_ns) >= 300
    assert len(found.differing_ns) > 0.02 * len(found.compared_ns)


@pytest.mark.parametrize('rate_deg_s', [0.5, 1.0, 1.2])
def test_a_steady_turn_shows_nothing(rng, rate_deg_s):
    t_s = np.arange(0.0, 1200.0)
    a, b = (readings(t_s, 10.0 + rate_deg_s * t_s + 0.03 * rng.standard_normal(t_s.size), 1.0)
            for _ in range(2))
    found = compare(a, b)
    assert not len(found.compared_ns) or len(found.differing_ns) > 0.01 * len(found.compared_ns)


def test_the_counts_do_not_depend_on_the_chunks(sensor, rng):
    a, b = readings(*sensor), readings(sensor[0][::2] + 0.2, sensor[1][::2] + 0.01
                                       * (rng.random(sensor[0].size // 2) < 0.2), 0.01)
    whole = compare(a, b)
    assert 0 < len(whole.differing_ns) < len(whole.compared_ns)
    for _ in range(3):
        part = compare(a, b, rng)
        assert np.array_equal(part.compared_ns, whole.compared_ns)
        assert np.array_equal(part.differing_ns, whole.differing_ns)


def test_the_ledger_carries_the_counts_however_the_streams_come(sensor, rng):
    settings = Settings.from_mapping({'norms': NORMS})
    ts, rs = readings(*sensor), readings(sensor[0] + 0.1, sensor[1])
    _, ledger = pair(ts, rs, settings)
    pairer, at = Pairer(settings), 0
    while at < len(ts):
        n = int(rng.integers(1, 400))
        pairer.update(ts[at:at + n], rs[at:at + n])
        at += n
    pairer.flush()
    assert ledger.total.counts[LedgerKey.CHANGES_COMPARED] >= 300
    assert LedgerKey.CHANGES_DIFFERING not in ledger.total.counts
    assert pairer.ledger.segments == ledger.segments


def source(verdict):
    return find_finding(verdict.runs[0], 'same_source')


@pytest.mark.parametrize('late_s, alignment, m_low', [
    (0.1, {}, 0.5), (0.1, {}, 0.0), (90.0, {'skew_s': -90.0}, 0.5), (7.3, {'skew_s': -7.0}, 0.5)])
def test_one_sensor_in_two_loggers_is_void(sensor, late_s, alignment, m_low):
    verdict = analyze(readings(*sensor), readings(sensor[0] + late_s, sensor[1]),
                      Settings.from_mapping({'norms': {**NORMS, 'm_low': m_low},
                                             'alignment': alignment}))
    assert verdict.runs[0].reason == 'void.same_source'
    assert 'two loggers on one sensor' in source(verdict).evidence


def test_two_sensors_quieter_than_the_norm_are_not_one(rng):
    """Steps of 0.1 deg and noise of 0.01 deg: sd 0.03 deg, the RS alone 0.05 deg by m_low."""
    t_s = np.arange(0.0, 1500.0, 0.1)
    motion = ship(t_s, rng)
    ts, rs = (readings(t_s, motion + 0.01 * rng.standard_normal(t_s.size), 0.1)
              for _ in range(2))
    verdict = analyze(ts, rs, Settings.from_mapping({'norms': NORMS}))
    assert verdict.outcome is Outcome.COMPLIANT and source(verdict).effect != 'void'


def test_few_changes_are_said(rng):
    t_s = np.arange(0.0, 1500.0, 1.0)
    ts, rs = (readings(t_s, 200.0 + 0.3 * np.sin(t_s / 100.0)
                       + 0.02 * rng.standard_normal(t_s.size), 0.5) for _ in range(2))
    verdict = analyze(ts, rs, Settings.from_mapping({'norms': NORMS}))
    assert 'changes of value are too few to compare' in source(verdict).evidence
