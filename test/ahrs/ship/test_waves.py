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

"""Spectrum and spreading of waves, and the sinusoids drawn from them."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import quad

from heading_intercompare.ahrs.ship.wave_sea import draw_waves, Waves


@pytest.mark.parametrize('peak_factor', [1.0, 3.3, 7.0])
def test_the_integral_of_the_spectrum_is_the_variance(peak_factor):
    """Height squared over 16, by quadrature; the peak lies at the peak period."""
    waves = Waves(4.0, 10.0, peak_factor=peak_factor)

    def density(omega):
        return float(waves.density_m2_s(np.array([omega]))[0])
    total = quad(density, 0.1, 0.63, limit=200)[0] + quad(density, 0.63, 12.0, limit=200)[0]
    assert total == pytest.approx(1.0, rel=2e-3)
    omega = np.linspace(0.3, 2.0, 5001)
    peak = omega[np.argmax(waves.density_m2_s(omega))]
    assert 2.0 * math.pi / peak == pytest.approx(10.0, rel=2e-3)


def test_bretschneider_by_hand():
    """5/16 H^2 wp^4 / w^5 exp(-1.25 (wp / w)^4), which JONSWAP is without its peak."""
    omega, peak = np.array([0.5, 0.7, 1.4]), 2.0 * math.pi / 9.0
    by_hand = 5.0 / 16.0 * 9.0 * peak**4 / omega**5 * np.exp(-1.25 * (peak / omega)**4)
    assert Waves(3.0, peak_factor=1.0).density_m2_s(omega) == pytest.approx(by_hand, rel=2e-3)


@pytest.mark.parametrize('s', [2.0, 10.0, 75.0])
def test_directions_are_spread_as_the_cosine_says(s):
    """The mean of cos is s / (s + 1), a known moment of cos^2s of half the angle."""
    share = (np.arange(20_000) + 0.5) / 20_000
    away = Waves(1.0, spreading=s).spread_rad(share)
    assert np.mean(np.cos(away)) == pytest.approx(s / (s + 1.0), abs=1e-4)
    assert np.mean(np.sin(away)) == pytest.approx(0.0, abs=1e-3)


def test_waves_of_one_direction_go_away_from_where_they_come():
    drawn = draw_waves(Waves(2.0, from_deg=30.0, spreading=None), 1)
    assert np.degrees(drawn.towards_rad) == pytest.approx(np.full(160, 210.0))


def test_the_sinusoids_have_the_energy_of_the_spectrum():
    """
    Over forty seeds the mean variance is that between half and three times the peak.

    Each seed is off by some percent, because the frequencies are drawn; six standard errors.
    """
    waves = Waves(4.0)
    omega = np.linspace(0.5, 3.0, 20_001) * 2.0 * math.pi / 9.0
    density = waves.density_m2_s(omega)
    exact = float(np.sum(0.5 * (density[1:] + density[:-1]) * np.diff(omega)))
    found = np.array([0.5 * np.sum(draw_waves(waves, seed).amplitude_m**2) for seed in range(40)])
    assert abs(found.mean() - exact) < 6.0 * found.std() / math.sqrt(40.0)
    assert found.std() < 0.02 * exact
    assert exact == pytest.approx(1.0, abs=0.02)


def test_a_seed_gives_a_sea_and_another_another():
    one, same, other = (draw_waves(Waves(2.0), seed).omega_rad_s for seed in (1, 1, 2))
    assert one.tolist() == same.tolist() != other.tolist()
