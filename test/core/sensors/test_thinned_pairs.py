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

"""Pairs that are chosen out of more: what was not chosen is not lost, what is missing is."""

from __future__ import annotations

import numpy as np
import pytest
from trials import find_finding

from heading_intercompare.core.pairing.pair_sampling import PairSampler
from heading_intercompare.core.pipeline import Intercomparison
from heading_intercompare.core.records import Headings
from heading_intercompare.core.settings import Settings

S = 1_000_000_000
NORMS = {'norms.sigma_max_deg': 0.2, 'norms.sigma_ref_max_deg': 0.2}


def stream(rng, rate_hz, jitter, missing):
    """Return the readings of ten minutes."""
    n = round(600 * rate_hz)
    t = (np.arange(n) + rng.uniform() + jitter * rng.uniform(-0.5, 0.5, n)) / rate_hz
    heading = 90.0 + 20.0 * np.sin(t / 60.0) + np.sin(t) + 0.1 * rng.standard_normal(n)
    whole = Headings.of(1_700_000_000 * S + np.round(t * 1e9).astype(np.int64), heading)
    return whole[rng.uniform(size=n) >= missing]


def losses(rng, ts_hz, rs_hz, jitter, missing=0.0):
    """Return the finding on losses of pairs of which two a second are judged."""
    one = Intercomparison(Settings.from_mapping(NORMS), sampler=PairSampler())
    one.update(stream(rng, ts_hz, jitter, missing), stream(rng, rs_hz, jitter, 0.0))
    one.finish()
    (run,) = one.verdict().runs
    return find_finding(run, 'losses')


@pytest.mark.parametrize('jitter', [0.0, 0.2, 0.6])
@pytest.mark.parametrize('ts_hz, rs_hz', [
    (2.2, 2.2), (2.5, 2.5), (3.0, 3.0), (5.0, 5.0), (10.0, 5.0), (10.0, 7.0), (6.25, 6.25),
    (4.0, 10.0), (20.0, 20.0)])
def test_what_is_not_chosen_is_not_lost(rng, ts_hz, rs_hz, jitter):
    """At 5 Hz "60 % lost", and void."""
    found = losses(rng, ts_hz, rs_hz, jitter)
    assert found.effect == 'holds', found.evidence


@pytest.mark.parametrize('rate_hz', [1.0, 5.0, 20.0])
def test_what_the_sensor_did_not_send_is_lost(rng, rate_hz):
    """A quarter of the TS."""
    found = losses(rng, rate_hz, rate_hz, 0.0, 0.25)
    assert found.effect == 'doubtful'
    assert int(found.words.split()[0]) == pytest.approx(25, abs=6)
