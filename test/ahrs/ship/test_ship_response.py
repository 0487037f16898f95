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

"""How a ship answers waves, against the water that it lies in."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import quad

from heading_intercompare.ahrs.ship.wave_sea import Hull, respond


def answer(hull, k, away_deg, encounter=0.01):
    """Return the response to one wave that goes this way from the bow, clockwise."""
    away = math.radians(away_deg)
    return respond(hull, np.array([k]), np.array([math.cos(away)]), np.array([math.sin(away)]),
                   np.array([encounter]))[:, 0]


def test_a_small_ship_lies_as_the_water_does():
    """In a wave of 200 m from astern, 45 degrees to starboard; slopes and the orbit by hand."""
    k, c = 2.0 * math.pi / 200.0, math.sqrt(0.5)
    roll, pitch, yaw, surge, sway, heave = answer(Hull(1.0, 0.5, 0.01), k, 45.0)
    assert heave == pytest.approx(-1.0, rel=1e-3)
    assert surge == pytest.approx(-1j * c, rel=1e-3)
    assert sway == pytest.approx(-1j * c, rel=1e-3)
    # The elevation cos(wt - k x) has the slope k sin(wt - k x), of which -jk is the phasor.
    assert pitch == pytest.approx(-1j * k * c, rel=1e-3)
    assert roll == pytest.approx(1j * k * c, rel=1e-2)
    assert yaw == pytest.approx(-k * 0.5, rel=1e-3)


def test_pitch_is_the_line_fitted_to_the_wave_along_the_hull():
    """Least squares over 80 m by quadrature; heave is the mean, each with the draught's share."""
    hull, k = Hull(), 0.06
    depth = math.exp(-0.5 * hull.draught_m * k)
    slope = quad(lambda x: x * math.sin(k * x), -40.0, 40.0)[0] / (2.0 * 40.0**3 / 3.0)
    mean = quad(lambda x: math.cos(k * x), -40.0, 40.0)[0] / 80.0
    _, pitch, _, _, _, heave = answer(hull, k, 0.0)
    assert pitch == pytest.approx(-1j * slope * depth, rel=1e-9)
    assert heave == pytest.approx(-mean * depth, rel=1e-9)


def test_roll_resonates_at_its_period():
    """The magnification at resonance is 1 / (2 damping), a quarter turn late."""
    hull = Hull(roll_period_s=10.0, roll_damping=0.05)
    slow = answer(hull, 0.01, 90.0, 1e-6)[0]
    at = answer(hull, 0.01, 90.0, 2.0 * math.pi / 10.0)[0]
    assert at / slow == pytest.approx(-10j, rel=1e-4)


def test_an_overtaken_wave_has_the_conjugate_response():
    """A negative frequency of encounter turns the phasor the other way."""
    hull = Hull()
    there, back = (answer(hull, 0.02, 90.0, w)[0] / answer(hull, 0.02, 90.0, 1e-9)[0]
                   for w in (0.5, -0.5))
    assert back == pytest.approx(np.conj(there))


@pytest.mark.parametrize('k', [0.02, 0.05])
def test_roll_is_largest_abeam_and_pitch_from_ahead(k):
    angles = np.arange(0.0, 181.0, 15.0)
    rolls, pitches = np.abs([answer(Hull(), k, away)[:2] for away in angles]).T
    assert angles[np.argmax(rolls)] == 90.0
    assert angles[np.argmax(pitches)] in (0.0, 180.0)
    assert pitches[6] == pytest.approx(0.0, abs=1e-12)
    assert rolls[[0, -1]] == pytest.approx(0.0, abs=1e-12)
