# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Fits to measurements at rest."""

from __future__ import annotations

import math

import numpy as np
import pytest

from heading_intercompare.ahrs.gimballed.calibration import (
    accelerometer_bias,
    azimuth_from_rates,
    course_drift,
    course_drift_sigma,
    drift_correction,
    fit_rotation,
    gps_drift,
    hann,
    WindowedMean,
)


def sectors(angle):
    """Return readings of a meter with biases 0.4, -0.3 that is turned over rates 9, -4."""
    c, s = np.cos(angle), np.sin(angle)
    return c, s, 9.0 * c - 4.0 * s + 0.4, -9.0 * s - 4.0 * c - 0.3


@pytest.mark.parametrize('weights', [None, hann(36)])
def test_rotation_fit_recovers_biases_and_rates(weights):
    fit = fit_rotation(*sectors(np.radians(10.0 * np.arange(36) + 5.0)), weights=weights)
    assert fit[:4] == pytest.approx((0.4, -0.3, 9.0, -4.0), abs=1e-12)
    assert fit.residual < 1e-12


def test_rotation_fit_agrees_with_the_plain_means_over_a_full_turn():
    """Over a full turn with equal weights the rates cancel: the bias is the mean reading."""
    rng = np.random.default_rng(1)
    c, s, x, y = sectors(np.radians(10.0 * np.arange(36)))
    x, y = x + rng.normal(size=36), y + rng.normal(size=36)
    fit = fit_rotation(c, s, x, y)
    assert (fit.bias_x, fit.bias_y) == pytest.approx((x.mean(), y.mean()), abs=1e-12)


def test_rotation_fit_needs_three_sectors():
    with pytest.raises(ValueError, match='2 sectors'):
        fit_rotation(*sectors(np.array([0.0, 1.0])))


@pytest.mark.parametrize('azimuth_deg', [-179.0, -135.0, -90.0, -1.0, 0.0, 45.0, 90.0, 180.0])
def test_azimuth_in_all_quadrants(azimuth_deg):
    a = math.radians(azimuth_deg)
    assert azimuth_from_rates(10.0 * math.cos(a), -10.0 * math.sin(a)) == pytest.approx(a)


def test_course_drift_of_a_straight_line():
    for method in ('lsq', 'pairs'):
        drift, residual = course_drift(7.0 + 0.01 * 90.0 * np.arange(6), 90.0, method)
        assert (drift, residual) == pytest.approx((0.01, 0.0), abs=1e-12)


@pytest.mark.slow
def test_line_has_less_noise_than_pairs_as_derived(rng):
    """
    White readings: variance s^2 / (17.5 h^2) by a line, 2 s^2 / (3 h^2) by pairs, ratio 3.4^2.

    20000 trials: the ratio of two variances is good to 6 sqrt(4 / 20000) = 8.5 %.
    """
    readings = rng.normal(size=(20000, 6))
    line, pairs = ([course_drift(row, 1.0, method)[0] for row in readings]
                   for method in ('lsq', 'pairs'))
    assert np.var(line) * 17.5 == pytest.approx(1.0, abs=0.06)
    assert np.var(pairs) / np.var(line) == pytest.approx(11.67, rel=0.085)
    for method, found in (('lsq', line), ('pairs', pairs)):
        assert course_drift_sigma(1.0, 1.0, 6, method) == pytest.approx(np.std(found), rel=0.04)


@pytest.mark.parametrize('n, method, reason', [
    (6, 'spline', 'method'), (2, 'lsq', '2 readings'), (5, 'pairs', '5 readings')])
def test_course_drift_refuses(n, method, reason):
    with pytest.raises(ValueError, match=reason):
        course_drift(np.zeros(n), 90.0, method)


def test_satellite_offset_and_drift_by_hand():
    """-0.2 and 0.4 degrees half an hour apart: offset 0.1, drift 1.2 deg/h."""
    offset, drift = gps_drift(-0.2, 0.4, 0.5)
    assert (offset, drift) == pytest.approx((0.1, 1.2))


def test_drift_correction_undoes_the_corrections_before():
    """Drift 3 with estimates 0 and 2 in force: the heading moved by -3 and then by -1 an hour."""
    t = [0.0, 1.0, 2.0]
    assert drift_correction(t, [0.0, -3.0, -4.0], [0.0, 0.0, 2.0]) == pytest.approx(3.0)
    assert drift_correction(t, [0.0, -3.0, -4.0], [0.0, 0.0, 2.0], 'pair') == pytest.approx(2.5)


def test_accelerometer_bias_weighs_early_readings_more():
    """a1 = 2 S / t^2 weighs with 2 (1 - u), a2 = V / t evenly: the mean with 3/2 - u."""
    late = np.concatenate((np.zeros(500), np.ones(500)))
    assert accelerometer_bias(late, 0.1) == pytest.approx(0.5 * (0.25 + 0.5), rel=1e-3)
    assert accelerometer_bias([0.3], 5.0) == pytest.approx(0.3)


def test_first_and_second_integral_of_a_ramp():
    """
    S (16), (17): a force r t has V = r t^2 / 2 and S = r t^3 / 6 at the end.

    So S (18) gives a1 = 2 S / t^2 = r t / 3 and a2 = V / t = r t / 2, and S (19) their mean.
    """
    ramp = 0.2 * 0.01 * (np.arange(10000) + 0.5)
    assert accelerometer_bias(ramp, 0.01) == pytest.approx(0.2 * 100.0 * 5.0 / 12.0, rel=1e-6)


def test_window_suppresses_an_oscillation_that_does_not_fit():
    """17.3 periods: the Hann mean leaves less than 1e-4 of it, the plain mean 6e-3."""
    wave = np.sin(2.0 * np.pi * 17.3 * (np.arange(1000) + 0.5) / 1000.0)
    window = WindowedMean(1000, 2)
    for value in wave:
        window.add(value, 4.0)
    mean = window.mean()
    assert abs(mean[0]) < 1e-4
    assert mean[1] == pytest.approx(4.0)
    assert abs(wave.mean()) > 5e-3


@pytest.mark.slow
@pytest.mark.parametrize('weights', [None, hann(36)])
def test_standard_deviation_of_a_bias_is_its_scatter(rng, weights):
    """1000 fits: the scatter is known to 6 / sqrt(2000) = 14 %."""
    c, s, x, y = sectors(np.radians(10.0 * np.arange(36)))
    fits = [fit_rotation(c, s, x + rng.normal(size=36), y + rng.normal(size=36), weights)
            for _ in range(1000)]
    stated = math.sqrt(np.mean([fit.bias_sigma**2 for fit in fits]))
    assert stated == pytest.approx(np.std([fit.bias_x for fit in fits]), rel=0.14)
