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

"""The scan at shifts of the RS agrees with a plain loop, whatever the chunks."""

from __future__ import annotations

import numpy as np
import pytest

from heading_intercompare.report.sketching.shift_scan import ShiftScan


def scan_of(stamps, x, rs, size):
    """Return the scan of columns given in chunks."""
    scan = ShiftScan(2.0, 3.0)
    for lo in range(0, len(x), size):
        scan.update(stamps[lo:lo + size], x[lo:lo + size], rs[lo:lo + size])
    return scan


@pytest.mark.parametrize('step_ns', [30_000_000, 10 ** 9])
@pytest.mark.parametrize('size', [1, 13, 1000])
def test_the_scan_does_not_depend_on_the_chunks(rng, size, step_ns):
    stamps = 10 ** 18 + np.arange(1000) * step_ns
    rs, x = 20.0 * np.sin(np.arange(1000) / 50.0), rng.normal(size=1000)
    whole, parts = scan_of(stamps, x, rs, 1000), scan_of(stamps, x, rs, size)
    assert parts.n == whole.n > 200
    np.testing.assert_allclose(parts.std_deg, whole.std_deg, rtol=1e-9)


def test_each_shift_gives_the_scatter_of_a_plain_loop(rng):
    stamps = 10 ** 18 + np.arange(600) * 10 ** 8
    t = (stamps - stamps[0]) / 1e9
    rs, x = 20.0 * np.sin(t / 5.0), rng.normal(0.0, 0.1, 600)
    scan = scan_of(stamps, x, rs, 600)
    inside = (t >= 2.0) & (t < t[-1] - 2.0)
    for at in (0, 17, 40):
        d = (x + rs - np.interp(t - scan.latency_s[at], t, rs))[inside]
        assert scan.n == inside.sum()
        assert scan.std_deg[at] == pytest.approx(d.std(ddof=1), rel=1e-9)


def test_a_silence_is_not_bridged():
    """Of 100 readings a side, those within 2 s of an end have a shift without a reading."""
    stamps = 10 ** 18 + np.concatenate((np.arange(100), np.arange(200, 300))) * 10 ** 8
    assert scan_of(stamps, np.zeros(200), np.zeros(200), 200).n == 118
