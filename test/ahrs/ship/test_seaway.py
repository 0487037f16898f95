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

"""Motion of the ship in the sea."""

from __future__ import annotations

import numpy as np
import pytest

from heading_intercompare.ahrs.ship.seaway import CHANNELS, Seaway

RMS_SS5 = (*np.radians([4.0, 1.2, 0.6]), 0.3, 0.5, 0.8)


def test_rms_is_that_of_the_preset():
    """Over 3 h the mean square of 32 sinusoids is within some percent of that over all time."""
    sea = Seaway('ss5', 3)
    motion = np.concatenate([sea.block(i)[:, 0, :600] for i in range(180)], axis=1)
    assert np.sqrt(np.mean(motion**2, axis=1)) == pytest.approx(RMS_SS5, rel=0.05)


def test_derivatives_are_those_of_the_motion():
    """Central differences over 0.1 s, periods above 3.6 s: error below w^2 h^2 / 6."""
    block = Seaway('ss5', 3).block(7)
    for order in (0, 1):
        steps = (block[:, order, 2:] - block[:, order, :-2]) / 0.2
        exact = block[:, order + 1, 1:-1]
        assert np.abs(steps - exact).max(axis=1) == pytest.approx(
            0.0, abs=0.006 * np.abs(exact).max())


def test_blocks_join():
    sea = Seaway('ss3', 3)
    assert sea.block(4)[:, :, -1] == pytest.approx(sea.block(5)[:, :, 0], abs=1e-12)


def test_reading_between_the_grid_is_exact_enough():
    """Against the sum of sinusoids itself, at instants off the grid too."""
    sea = Seaway('ss5', 3)
    t_s = np.linspace(50.0, 130.0, 2001)
    for row, name in enumerate(CHANNELS[:3]):
        exact = np.zeros(t_s.shape)
        for omega, start in zip(sea._omega[row], sea._complex[row]):
            exact += (start * np.exp(1j * omega * t_s)).real
        value = sea.read(t_s, (name, 0))[0]
        assert np.degrees(np.abs(value - exact).max()) * 3600.0 < 0.02


def test_an_instant_gives_the_same_bits_alone_and_in_company():
    sea, t_s = Seaway('ss5', 3), np.array([599.97, 12.34, 61.2, 59.999999, 3600.0])
    together = sea.read(t_s, ('yaw', 0))[0]
    alone = [Seaway('ss5', 3).read(t_s[[i]], ('yaw', 0))[0][0] for i in range(5)]
    assert together.tolist() == alone


def test_calm_is_still():
    value, rate = Seaway('calm', 1).read(np.array([0.0, 5.0]), ('yaw', 0), ('yaw', 1))
    assert not value.any() and not rate.any()
