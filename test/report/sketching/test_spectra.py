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

"""Spectrum and autocovariance from segments: right levels, bounded memory, any chunks."""

from __future__ import annotations

import numpy as np
import pytest

from heading_intercompare.report.sketching.spectra import Spectra


def spectra_of(x, size, gap_at=None):
    """Return the levels of a series at 1 Hz given in chunks."""
    stamps = 10 ** 18 + np.arange(len(x)) * 10 ** 9
    if gap_at is not None:
        stamps[gap_at:] += 1000 * 10 ** 9
    spectra = Spectra(60.0)
    for lo in range(0, len(x), size):
        spectra.update(stamps[lo:lo + size], x[lo:lo + size])
    return spectra.levels()


@pytest.mark.parametrize('size', [7, 5000])
def test_the_levels_do_not_depend_on_the_chunks(rng, size):
    x = rng.normal(3.0, 0.5, 9000)
    whole, parts = spectra_of(x, 9000), spectra_of(x, size)
    assert [level.segments for level in parts] == [level.segments for level in whole] == [2, 1, 1]
    for a, b in zip(parts, whole):
        np.testing.assert_allclose(a.power_deg2, b.power_deg2, rtol=1e-6, atol=1e-9)
        np.testing.assert_allclose(a.covariance_deg2, b.covariance_deg2, rtol=1e-6, atol=1e-9)


def test_white_noise_has_its_variance_at_every_rate(rng):
    """One-sided density per cycle a sample is twice the variance; means over 8 have an eighth."""
    levels = spectra_of(rng.normal(0.0, 0.5, 80_000), 80_000)
    assert [level.joined for level in levels] == [1, 8, 64, 512]
    for level in levels[:2]:
        variance = 0.25 / level.joined
        assert level.covariance_deg2[0] == pytest.approx(variance, rel=0.05)
        assert level.power_deg2[10:-10].mean() == pytest.approx(2.0 * variance, rel=0.05)
        assert np.abs(level.covariance_deg2[1:]).max() < 0.2 * variance


def test_the_covariance_is_that_of_a_plain_loop(rng):
    x = np.cumsum(rng.normal(size=4096))
    (level, *_) = spectra_of(x, 4096)
    for lag in (0, 1, 100, 512):
        heads, tails = x[:4096 - lag], x[lag:]
        assert level.covariance_deg2[lag] == pytest.approx(
            (heads * tails).mean() - heads.mean() * tails.mean(), rel=1e-9)


def test_a_silence_begins_a_segment_again():
    x = np.zeros(5000)
    assert [level.segments for level in spectra_of(x, 5000)][0] == 1
    (level, *_) = spectra_of(x, 5000, gap_at=3000)
    assert (level.segments, level.length) == (1, 3000), 'the longest part stands for the record'


def test_a_short_series_has_no_level():
    assert spectra_of(np.zeros(63), 63) == []
