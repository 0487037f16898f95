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

"""The bins of the rate of turn hold the means of seconds, whatever the chunks."""

from __future__ import annotations

import numpy as np
import pytest

from heading_intercompare.core.records import Motion
from heading_intercompare.report.sketching.turning import Turning


def turning_of(stamps, x, rs, size):
    """Return the bins of columns given in chunks."""
    turning = Turning()
    for lo in range(0, len(x), size):
        turning.update(stamps[lo:lo + size], x[lo:lo + size], rs[lo:lo + size])
    return turning


@pytest.mark.parametrize('size', [1, 7, 100])
def test_the_bins_do_not_depend_on_the_chunks(rng, size):
    t = np.arange(500) * 0.3
    stamps = 10 ** 18 + (t * 1e9).astype(np.int64)
    rs, x = 30.0 * np.sin(t / 9.0), rng.normal(size=500)
    whole, parts = turning_of(stamps, x, rs, 500), turning_of(stamps, x, rs, size)
    assert parts.width_deg_s == whole.width_deg_s
    assert np.array_equal(parts.bins.n, whole.bins.n) and whole.bins.n.sum() == 147
    np.testing.assert_allclose(parts.bins.mean_deg, whole.bins.mean_deg, atol=1e-12)


def test_a_steady_turn_is_in_the_bin_of_its_rate():
    """2.5 deg/s at 4 Hz; the first and the last second have no neighbour."""
    stamps = 10 ** 18 + np.arange(40) * 250_000_000
    turning = turning_of(stamps, np.full(40, 0.7), 2.5 * np.arange(40) / 4.0, 40)
    (at,) = np.flatnonzero(turning.bins.n)
    assert turning.bins.n[at] == 7 and turning.bins.mean_deg[at] == pytest.approx(0.7)
    assert turning.rate_deg_s[at] == pytest.approx(2.5, abs=turning.width_deg_s)


def test_there_is_no_rate_over_a_silence():
    stamps = 10 ** 18 + np.arange(10) * 20 * 10 ** 9
    assert turning_of(stamps, np.zeros(10), np.arange(10.0), 10).bins.n.sum() == 0


@pytest.mark.parametrize('size', [1, 7, 200])
def test_a_measured_rate_goes_before_that_of_the_rs(size):
    """The RS stands still, and a sensor says 1.5 deg/s, with a silence of 10 s."""
    stamps = 10 ** 18 + np.arange(200) * 250_000_000
    seconds = 10 ** 18 + np.arange(50) * 10 ** 9
    spoken = (np.arange(50) < 20) | (np.arange(50) > 30)
    turning = Turning()
    turning.take_rates(Motion.of_rates(seconds[spoken], np.full(39, 1.5)))
    for lo in range(0, 200, size):
        turning.update(stamps[lo:lo + size], np.full(200, 0.3)[lo:lo + size],
                       np.zeros(200)[lo:lo + size])
    (at,) = np.flatnonzero(turning.bins.n)
    assert turning.measured and turning.bins.n[at] == 35
    assert turning.rate_deg_s[at] == pytest.approx(1.5, abs=turning.width_deg_s)


def test_rates_of_no_sensor_change_nothing():
    turning = Turning()
    turning.take_rates(Motion.empty())
    assert not turning.measured
