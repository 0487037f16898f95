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

"""A sketch does not depend on the chunks, is exact where it can be, and has bounded memory."""

from __future__ import annotations

import numpy as np
import pytest

from heading_intercompare import Pairs, Settings
from heading_intercompare.report.series_sketch import SeriesSketch

SETTINGS = Settings.from_mapping({'installation_offset_deg': 0.25})


def pairs_of(x_deg, step_ns=10 ** 8, rs_deg=None, start_ns=1_700_000_000 * 10 ** 9):
    """Return pairs with these differences, the offset of `SETTINGS` removed."""
    x_deg = np.asarray(x_deg, float)
    rs = np.zeros(len(x_deg)) if rs_deg is None else np.asarray(rs_deg, float)
    return Pairs.of(start_ns + np.arange(len(x_deg)) * step_ns, rs + x_deg + 0.25, rs)


def sketch_of(*chunks):
    """Return the sketch of chunks of pairs."""
    sketch = SeriesSketch()
    for chunk in chunks:
        sketch.update(chunk, SETTINGS)
    return sketch


@pytest.mark.slow
@pytest.mark.parametrize('size', [1, 7, 1000])
def test_a_sketch_does_not_depend_on_the_chunks(rng, size):
    n = 3000
    x = rng.normal(0.3, 0.2, n) * np.linspace(0.1, 3.0, n)
    x[::97] = np.nan
    pairs = pairs_of(x, rs_deg=rng.uniform(0.0, 360.0, n))
    whole = sketch_of(pairs)
    parts = sketch_of(*(pairs[lo:lo + size] for lo in range(0, n, size)))
    assert (parts.n, parts.n_invalid) == (whole.n, whole.n_invalid) == (2969, 31)
    assert (parts.time.start_ns, parts.time.width_ns) == (whole.time.start_ns,
                                                          whole.time.width_ns)
    assert (parts.histogram.width_deg, parts.histogram.first) == (whole.histogram.width_deg,
                                                                  whole.histogram.first)
    assert np.array_equal(parts.histogram.counts, whole.histogram.counts)
    for a, b in ((parts.time.bins, whole.time.bins), (parts.heading, whole.heading)):
        assert np.array_equal(a.n, b.n)
        assert np.array_equal(a.low_deg, b.low_deg) and np.array_equal(a.up_deg, b.up_deg)
        np.testing.assert_allclose(a.mean_deg, b.mean_deg, rtol=1e-12, atol=1e-13)
        np.testing.assert_allclose(a.m2_deg2, b.m2_deg2, rtol=1e-11, atol=1e-13)


def test_the_envelope_holds_extremes_and_mean_of_each_stretch_of_time(rng):
    x = rng.normal(0.0, 1.0, 5000)
    time = sketch_of(pairs_of(x)).time
    at = (np.arange(5000) * 10 ** 8) // time.width_ns
    for k in np.unique(at):
        part = np.round(x[at == k], 9)
        assert time.bins.n[k] == len(part)
        assert time.bins.low_deg[k] == pytest.approx(part.min(), abs=1e-8)
        assert time.bins.up_deg[k] == pytest.approx(part.max(), abs=1e-8)
        assert time.bins.mean_deg[k] == pytest.approx(part.mean(), abs=1e-8)


def test_the_envelope_uses_at_least_half_of_its_bins_on_a_long_record():
    time = sketch_of(pairs_of(np.zeros(20_000), step_ns=10 ** 9)).time
    assert 500 <= np.flatnonzero(time.bins.n)[-1] + 1 <= 1000
    assert time.bins.n.sum() == 20_000


def test_the_histogram_counts_what_numpy_counts(rng):
    x = rng.normal(2.0, 0.5, 4000)
    pairs = pairs_of(x)
    histogram = sketch_of(pairs[:10], pairs[10:]).histogram
    taken = pairs.ts_deg - pairs.rs_deg - 0.25
    counts, _ = np.histogram(taken, histogram.edges_deg())
    assert np.array_equal(histogram.counts, counts)
    assert 2048 < len(histogram.counts) <= 4096


def test_memory_stays_bounded_when_the_range_is_the_whole_circle(rng):
    sketch = sketch_of(*(pairs_of(rng.uniform(-179.0, 179.0, 500), start_ns=k * 10 ** 15)
                         for k in range(20)))
    assert len(sketch.histogram.counts) <= 4096
    assert sketch.histogram.counts.sum() == sketch.time.bins.n.sum() == sketch.n == 10_000
    assert len(sketch.time.bins.n) == 1000


def test_mean_and_deviation_belong_to_their_ten_degrees_of_heading(rng):
    rs = rng.uniform(-720.0, 720.0, 4000)
    x = np.sin(np.radians(rs)) + rng.normal(0.0, 0.1, 4000)
    bins = sketch_of(pairs_of(x, rs_deg=rs)).heading.join(4)
    at = np.floor(np.mod(rs, 360.0) / 10.0)
    for k in range(36):
        assert bins.n[k] == np.sum(at == k)
        assert bins.mean_deg[k] == pytest.approx(x[at == k].mean(), abs=1e-9)
        assert bins.std_deg[k] == pytest.approx(x[at == k].std(ddof=1), rel=1e-9)


def test_constant_differences_fall_into_one_bin():
    sketch = sketch_of(pairs_of(np.full(100, 0.5)))
    assert sketch.histogram.counts.tolist() == [100]
    assert sketch.heading.std_deg[0] == 0.0
    assert np.isnan(sketch.heading.std_deg[1])


def test_no_pairs_change_nothing_and_only_invalid_ones_are_counted():
    sketch = sketch_of(Pairs.empty(), pairs_of([np.nan, np.nan]))
    assert (sketch.n, sketch.n_invalid, sketch.time.start_ns) == (0, 2, None)
    assert len(sketch.histogram.counts) == 0


def test_stamps_that_go_back_are_refused():
    sketch = sketch_of(pairs_of([0.0, 0.1]))
    with pytest.raises(ValueError, match='stamp order'):
        sketch.update(pairs_of([0.0], start_ns=5), SETTINGS)


def test_what_is_taken_out_stays_in_time_and_leaves_the_rest(rng):
    start = 1_700_000_000 * 10 ** 9
    settings = Settings.of(exclusions=f'{start + 10 * 10 ** 9}, {start + 20 * 10 ** 9}, a tug')
    x = rng.normal(0.0, 0.1, 1000)
    x[100:200] += 5.0
    sketch = SeriesSketch()
    pairs = pairs_of(x, rs_deg=np.linspace(0.0, 50.0, 1000), start_ns=start)
    for lo in range(0, 1000, 33):
        sketch.update(pairs[lo:lo + 33], settings)
    assert (sketch.n, sketch.n_taken_out) == (900, 100)
    assert sketch.time.bins.n.sum() == sketch.rs_time.bins.n.sum() == 1000
    assert sketch.histogram.counts.sum() == sketch.heading.n.sum() == 900
    assert sketch.histogram.edges_deg()[-1] < 2.0 < sketch.time.bins.up_deg.max()
