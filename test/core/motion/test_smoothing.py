# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Smooth functions through samples: what they keep, what they remove, their derivatives."""

from __future__ import annotations

import math

import numpy as np
import pytest

from heading_intercompare.core.motion.smoothing import bridge_gaps, find_spikes, smooth


@pytest.mark.parametrize('rate_hz', [2.0, 10.0])
@pytest.mark.parametrize('period_s', [3.0, 4.5, 6.0, 12.0, 60.0])
def test_the_share_of_an_oscillation_that_is_kept(rate_hz, period_s):
    """1 / (1 + (3 / T)^6) whatever the rate; the basis departs from it by 0.01 near 3 s."""
    t_s = np.arange(0.0, 1200.0, 1.0 / rate_hz)
    wave = np.sin(2.0 * math.pi * t_s / period_s)
    read, inner = smooth(t_s, wave, 3.0).read(t_s), slice(100, -100)
    kept = (read[inner] @ wave[inner]) / (wave[inner] @ wave[inner])
    assert kept == pytest.approx(1.0 / (1.0 + (3.0 / period_s)**6), abs=0.012)


def test_a_parabola_passes_unchanged():
    """The penalty on third differences costs it nothing, whatever the period."""
    t_s = np.sort(np.random.default_rng(3).uniform(0.0, 100.0, 400))
    made = smooth(t_s, 3.0 - 0.2 * t_s + 0.01 * t_s**2, 20.0)
    at = np.linspace(t_s[0], t_s[-1], 77)
    assert made.read(at) == pytest.approx(3.0 - 0.2 * at + 0.01 * at**2, abs=1e-8)
    assert made.read(at, 1) == pytest.approx(-0.2 + 0.02 * at, abs=1e-8)
    assert made.read(at, 2) == pytest.approx(np.full(77, 0.02), abs=1e-8)


def test_derivatives_fit_the_values(rng):
    """Central differences over 2 ms of a smoothed random walk."""
    t_s = np.arange(0.0, 300.0, 0.2)
    made = smooth(t_s, np.cumsum(rng.standard_normal(t_s.size)), 4.0)
    at, h = np.linspace(1.0, 298.0, 999), 1e-3
    for order in (0, 1):
        steps = (made.read(at + h, order) - made.read(at - h, order)) / (2.0 * h)
        exact = made.read(at, order + 1)
        assert np.abs(steps - exact).max() < 1e-5 * np.abs(exact).max()


def test_white_noise_does_not_become_wild_accelerations(rng):
    """
    Noise of 0.05 m/s at 1 Hz, halved at 60 s: noise of 0.0091 m/s, and 0.00055 m/s^2.

    The variance is 0.05^2 times the integral of 2 H(f)^2 df, with 1 / (1 + (60 f)^6) for H; its
    acceleration has (2 pi f)^2 more in the integral.
    """
    f = np.linspace(0.0, 0.5, 200_001)
    kept = 2.0 * 0.05**2 / (1.0 + (60.0 * f)**6)**2 * (f[1] - f[0])
    value, slope = math.sqrt(kept.sum()), math.sqrt((kept * (2.0 * math.pi * f)**2).sum())
    t_s = np.arange(0.0, 40_000.0)
    made, at = smooth(t_s, 0.05 * rng.standard_normal(t_s.size), 60.0), t_s[200:-200]
    assert np.std(made.read(at)) == pytest.approx(value, rel=0.15)
    assert np.std(made.read(at, 1)) == pytest.approx(slope, rel=0.15)
    assert slope < 6e-4


def test_an_instant_gives_the_same_bits_alone_and_in_company(rng):
    t_s = np.arange(0.0, 60.0, 0.1)
    made, at = smooth(t_s, rng.standard_normal(t_s.size), 2.0), np.linspace(-5.0, 70.0, 1001)
    for order in (0, 1, 2):
        alone = [made.read(at[k:k + 1], order)[0] for k in range(at.size)]
        assert alone == made.read(at, order).tolist()


def test_beyond_its_ends_the_function_goes_straight_on():
    t_s = np.arange(0.0, 10.5, 0.5)
    made = smooth(t_s, t_s**2, 2.0)
    outside = np.array([-2.0, 12.0])
    assert made.read(outside) == pytest.approx([0.0, 140.0], abs=1e-6)
    assert made.read(outside, 1) == pytest.approx([0.0, 20.0], abs=1e-6)
    assert made.read(outside, 2).tolist() == [0.0, 0.0]


def test_a_gap_is_bridged_from_mean_to_mean():
    """Ten seconds of 5, a minute of nothing, ten seconds of 7; nothing overshoots."""
    t_s = np.concatenate((np.arange(0.0, 10.0, 0.5), np.arange(70.0, 80.0, 0.5)))
    values = np.where(t_s < 40.0, 5.0, 7.0) + 0.1 * (-1.0)**np.arange(t_s.size)
    full_s, full = bridge_gaps(t_s, values, 3.0)
    made = smooth(full_s, full, 3.0)
    at = np.linspace(9.5, 70.0, 400)
    assert 4.95 < made.read(at).min() and made.read(at).max() < 7.05
    assert made.read(np.array([39.75]))[0] == pytest.approx(6.0, abs=0.01)
    assert np.isin(t_s, full_s).all()


def test_spikes_are_found_and_waves_are_not(rng):
    """Two single spikes and a pair; a swell of 5 degrees at four samples a period is none."""
    wave = 5.0 * np.sin(0.5 * math.pi * np.arange(400) + 0.3) + 0.01 * rng.standard_normal(400)
    assert not find_spikes(wave, 2.0).any()
    slow = 0.05 * np.arange(400) + 0.01 * rng.standard_normal(400)
    slow[[50, 200, 201, 398]] += 30.0
    assert np.flatnonzero(find_spikes(slow, 2.0)).tolist() == [50, 200, 201, 398]
    assert not find_spikes(np.full(3, 1.0), 2.0).any()


@pytest.mark.parametrize('n, period_s', [(0, 3.0), (1, 3.0), (5, 0.0)])
def test_what_cannot_be_smoothed(n, period_s):
    with pytest.raises(ValueError, match='at least 2 samples and a period'):
        smooth(np.arange(float(n)), np.zeros(n), period_s)
