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

"""The error of interpolation, from how far its kernels part: on streams of a moving ship."""

from __future__ import annotations

import math

import numpy as np
import pytest

from heading_intercompare.core.pairing.ledger import LedgerKey
from heading_intercompare.core.pairing.pairer import pair
from heading_intercompare.core.records import Headings
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.timing.interpolation_error import estimate_interpolation_error

S = 1_000_000_000
T0 = 1_700_000_000 * S


def streams(rng, sd_deg, period_s, ts_hz, rs_hz, span_s=900.0, noise_deg=0.0):
    """Return TS and RS of a ship that moves as 20 sines around one period."""
    w = 2.0 * math.pi / period_s * (1.0 + 0.1 * rng.standard_normal(20))
    phase = rng.uniform(0.0, 2.0 * math.pi, 20)
    for rate_hz, shift in ((ts_hz, 0.0), (rs_hz, 0.5)):
        t = (np.arange(span_s * rate_hz) + shift) / rate_hz
        yaw = sd_deg * math.sqrt(0.1) * np.sin(np.outer(t, w) + phase).sum(axis=1)
        yield Headings.of(T0 + np.round(t * 1e9).astype(np.int64),
                          90.0 + yaw + noise_deg * rng.standard_normal(t.size))


def estimate(streams_, norm_deg=0.1, kernel='band_limited'):
    """Return the estimate, and the variance of the differences."""
    settings = Settings.from_mapping({'pairing.kernel': kernel})
    pairs, ledger = pair(*streams_, settings)
    found = estimate_interpolation_error(ledger.total.counts, norm_deg, is_line=kernel == 'line')
    return found, float(np.var(pairs.ts_deg - pairs.rs_deg))


@pytest.mark.parametrize('sd_deg, period_s', [(2.0, 6.0), (2.0, 5.0), (1.0, 8.0), (3.0, 4.5)])
def test_resolved_motion_adds_less_than_its_bound(rng, sd_deg, period_s):
    """Sensors without errors: the differences are the error of interpolation alone."""
    found, added_deg2 = estimate(streams(rng, sd_deg, period_s, 1.0, 1.0))
    assert found.kind == 'estimated' and found.is_resolved and found.step_s == 1.0
    assert added_deg2 <= found.upper_deg2


@pytest.mark.parametrize('sd_deg, period_s, rate_hz', [
    (3.0, 2.6, 1.0), (2.0, 6.0, 0.5), (1.0, 8.0, 0.2), (0.1, 20.0, 0.2)])
def test_motion_too_fast_for_the_readings_is_not_resolved(rng, sd_deg, period_s, rate_hz):
    """Also where readings are so seldom that fast motion may look slow."""
    found, _ = estimate(streams(rng, sd_deg, period_s, rate_hz, rate_hz, 3600.0))
    assert not found.is_resolved and found.upper_deg2 == math.inf


@pytest.mark.parametrize('noise_deg', [0.02, 0.1])
def test_noise_adds_little_to_the_estimate(rng, noise_deg):
    """White noise adds 0.002 to 0.003 of its variance to b6."""
    found, _ = estimate(streams(rng, 0.01, 20.0, 1.0, 1.0, 3600.0, noise_deg), noise_deg)
    assert found.is_resolved
    assert found.variance_deg2 < 0.0066 * noise_deg ** 2


def test_the_line_adds_what_it_misses(rng):
    """2 deg in 6 s at 1 Hz, half a step apart: 0.0883 deg2 for a true 0.0890 deg2 or so."""
    found, added_deg2 = estimate(streams(rng, 2.0, 6.0, 1.0, 1.0), kernel='line')
    assert found.is_line and found.variance_deg2 == pytest.approx(added_deg2, rel=0.03)
    assert found.line_deg2 == found.variance_deg2


def test_a_fast_sensor_needs_no_comparison(rng):
    found, added_deg2 = estimate(streams(rng, 3.0, 3.0, 1.0, 10.0))
    assert found.is_resolved and found.variance_deg2 == 0.0
    assert dict(found.readings) == {4: 899}
    assert added_deg2 < 1e-3


def test_equal_stamps_need_no_interpolation(rng):
    ts, _ = streams(rng, 3.0, 3.0, 1.0, 1.0)
    found, _ = estimate((ts, ts))
    assert found.kind == 'none' and found.upper_deg2 == 0.0


def test_by_hand():
    """
    b6 = 2 / 4 = 0.5, b4 = 10, b2 = 200 units at 4 pairs; 3 of 8 pairs by 8, 1 by 6, 2 by 4.

    The others take a reading: (4 b6 + 2 b4) / 8 = 2.75 units. 0.5 <= 0.06 * 10: resolved.
    """
    counts = {'paired': 8, 'bridged.8': 3, 'bridged.6': 1, 'bridged.4': 2,
              'bridged.step': 6 * 10 ** 6, 'compared': 4, 'apart.6': 2 * 10 ** 9,
              'apart.4': 40 * 10 ** 9, 'apart.2': 800 * 10 ** 9}
    found = estimate_interpolation_error({LedgerKey(k): n for k, n in counts.items()}, 0.1)
    assert found.variance_deg2 == pytest.approx(2.75) and found.upper_deg2 == pytest.approx(5.5)
    assert found.is_resolved and found.step_s == 1.0 and found.line_deg2 == pytest.approx(150.0)


def test_pairs_that_nothing_could_be_compared_at_show_nothing():
    """Six readings a pair at most, 1 s apart: no value by eight."""
    counts = {LedgerKey.PAIRED: 5, LedgerKey.BRIDGED_6: 5, LedgerKey.STEP: 5 * 10 ** 6}
    found = estimate_interpolation_error(counts, 0.1)
    assert found.variance_deg2 is None and found.upper_deg2 == math.inf
