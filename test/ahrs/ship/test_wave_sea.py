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

"""The motion of a ship in waves that it meets."""

from __future__ import annotations

from functools import cache
import math

import numpy as np
import pytest

from heading_intercompare.ahrs.ship.earth import KNOT_M_S
from heading_intercompare.ahrs.ship.seaway import CHANNELS
from heading_intercompare.ahrs.ship.ship_motion import ShipTruth
from heading_intercompare.ahrs.ship.steering import Leg, Steering
from heading_intercompare.ahrs.ship.wave_sea import (
    Hull,
    respond,
    STANDARD_GRAVITY_M_S2,
    Waves,
    WaveSea,
)

SPEED_KN = 10.0


def sail(waves, course_deg, speed_kn=SPEED_KN, seed=1):
    """Return the sea of a ship on a steady course."""
    return WaveSea(waves, Hull(), Steering([Leg(0.0, course_deg, speed_kn)], 45.0), seed)


def tabulate(sea, minutes):
    """Return the motion, shape (6, 3, n), on the grid."""
    return np.concatenate([sea.block(i)[:, :, :600] for i in range(minutes)], axis=2)


@cache
def expected_variance(waves, course_deg, speed_kn=SPEED_KN):
    """Return the integral of spectrum, spreading and squared response of each channel."""
    peak = 2.0 * math.pi / waves.peak_period_s
    edges = peak * np.linspace(0.5, 3.0, 1201)
    omega, step = 0.5 * (edges[1:] + edges[:-1]), edges[1] - edges[0]
    total = np.zeros(6)
    angles = np.linspace(-math.pi, math.pi, 361)[:-1]
    density = np.cos(0.5 * angles) ** (2.0 * (waves.spreading or 0.0))
    if waves.spreading is None:
        angles, density = np.zeros(1), np.ones(1)
    for angle, share in zip(angles, density / density.sum()):
        away = math.radians(waves.from_deg + 180.0 - course_deg) + angle
        k = omega**2 / STANDARD_GRAVITY_M_S2
        met = omega - k * speed_kn * KNOT_M_S * math.cos(away)
        answers = respond(Hull(), k, np.full(k.shape, math.cos(away)),
                          np.full(k.shape, math.sin(away)), met)
        total += share * np.sum(waves.density_m2_s(omega) * np.abs(answers)**2, axis=1) * step
    return total


@pytest.mark.slow
@pytest.mark.parametrize('course_deg', [0.0, 130.0])
def test_the_variances_are_the_integrals_of_spectrum_and_response(course_deg):
    """
    Over 12 seeds of 10 min; the mean square of each channel within six standard errors.

    The waves come from north, so the courses are those of head and of quartering seas.
    """
    waves = Waves(3.0, 9.0, from_deg=0.0)
    found = np.array([np.mean(tabulate(sail(waves, course_deg, seed=seed), 10)[:, 0]**2, axis=1)
                      for seed in range(12)])
    error = found.std(axis=0) / math.sqrt(12.0)
    exact = expected_variance(waves, course_deg)
    assert np.all(np.abs(found.mean(axis=0) - exact) < 6.0 * error)
    assert np.all(error < 0.25 * exact)


def test_roll_is_largest_in_beam_seas_and_pitch_in_head_seas():
    """Over 10 min on five courses at rest; under way the resonance of roll may lie elsewhere."""
    waves = Waves(3.0, 9.0, spreading=None)
    rms = {course: np.std(tabulate(sail(waves, course, 0.0), 10)[:, 0], axis=1)
           for course in (0.0, 45.0, 90.0, 135.0, 180.0)}
    roll, pitch = ({course: values[row] for course, values in rms.items()} for row in (0, 1))
    assert max(roll, key=roll.__getitem__) == 90.0
    assert max(pitch, key=pitch.__getitem__) in (0.0, 180.0)
    assert roll[0.0] < 1e-12 and pitch[90.0] < 0.02 * pitch[0.0]


@pytest.mark.parametrize('course_deg, speed_kn', [(0.0, 12.0), (180.0, 12.0), (180.0, 40.0)])
def test_waves_are_met_with_the_frequency_of_encounter(course_deg, speed_kn):
    """It is w - k V cos: higher in head seas, lower in following seas; by a fit to the heave."""
    waves = Waves(2.0, 12.0, spreading=None)
    sea = sail(waves, course_deg, speed_kn)
    away = math.pi - math.radians(course_deg)
    omega = sea._waves.omega_rad_s
    met = omega * (1.0 - omega * speed_kn * KNOT_M_S * math.cos(away) / STANDARD_GRAVITY_M_S2)
    t_s = 0.1 * np.arange(600 * 20)
    heave = tabulate(sea, 20)[CHANNELS.index('heave'), 0]
    right = np.concatenate((np.cos(np.outer(t_s, met)), np.sin(np.outer(t_s, met))), axis=1)
    fitted = np.linalg.lstsq(right[::7], heave[::7], rcond=None)[0]
    assert np.std(heave - right @ fitted) < 1e-6 * np.std(heave)


def test_derivatives_are_those_of_the_motion_also_in_a_turn():
    """Central differences over 0.1 s in a turn of 90 degrees through the sea."""
    sea = WaveSea(Waves(3.0), Hull(), Steering([Leg(0.0, 0.0, 15.0), Leg(30.0, 90.0, 15.0)],
                                               45.0), 3)
    block = sea.block(1)
    for order in (0, 1):
        steps = (block[:, order, 2:] - block[:, order, :-2]) / 0.2
        exact = block[:, order + 1, 1:-1]
        assert np.all(np.abs(steps - exact).max(axis=1) < 0.02 * np.abs(exact).max(axis=1))


def test_a_course_that_is_steady_enough_is_a_steady_one(monkeypatch):
    """Twenty minutes after a turn: one response a block, or one an instant, to 1e-5."""
    def make():
        return WaveSea(Waves(3.0), Hull(), Steering([Leg(0.0, 0.0, 15.0), Leg(30.0, 90.0, 12.0)],
                                                    45.0), 3)
    quick = make().block(25)
    monkeypatch.setattr('heading_intercompare.ahrs.ship.wave_sea._STEADY', -1.0)
    exact = make().block(25)
    assert quick.tolist() != exact.tolist()
    for one, other in zip(quick, exact):
        assert one == pytest.approx(other, abs=1e-5 * np.abs(other).max())


def test_blocks_join():
    sea = sail(Waves(3.0), 70.0)
    for order in range(3):
        assert sea.block(4)[:, order, -1] == pytest.approx(sea.block(5)[:, order, 0], abs=1e-9)


def test_the_first_instants_are_smooth():
    """There is nothing before 0, and yet no step of the rates there."""
    block = sail(Waves(4.0), 70.0).block(0)
    steps = np.abs(np.diff(block[:, 2, :40], axis=1))
    assert np.all(steps[:, :4].max(axis=1) < 1.5 * steps.max(axis=1))


def test_the_true_heading_yaws_in_waves_and_is_the_same_bits_in_any_order():
    def make():
        return ShipTruth([Leg(0.0, 60.0, 12.0)], 45.0, seed=5, waves=Waves(4.0))
    t_s, one, other = np.linspace(0.0, 200.0, 501), make(), make()
    backwards = np.concatenate([other.heading_rad(t_s[k:k + 1]) for k in range(500, -1, -1)])
    assert backwards[::-1].tolist() == one.heading_rad(t_s).tolist()
    assert 0.05 < np.degrees(np.std(one.heading_rad(t_s))) < 3.0


def test_no_height_is_a_calm_sea():
    sea = sail(Waves(0.0), 10.0)
    assert sea.calm and not sea.read(np.array([1.0, 2.0]), ('roll', 0))[0].any()
