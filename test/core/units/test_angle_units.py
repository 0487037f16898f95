#!/usr/bin/env python3
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
"""Headings in radians, revolutions and signed degrees are known by name or by their numbers."""

from __future__ import annotations

import math

import numpy as np
import pytest

from heading_intercompare import analyze
from heading_intercompare.core.records import Headings
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.units.angle_units import (
    AngleWatch,
    find_named_unit,
    fold_angles,
    read_angles,
)

T = np.arange(1500)
STAMPS = 1_700_000_000_000_000_000 + T * 1_000_000_000
SETTINGS = Settings.of(sigma_max_deg=0.2, sigma_ref_max_deg=0.1)


def course(rng, noise_deg=0.1, *, middle_deg=20.0, swing_deg=60.0, period_s=400.0):
    """Return the readings of a sensor on a ship that turns to and fro."""
    return (middle_deg + swing_deg * np.sin(2.0 * np.pi * T / period_s)
            + noise_deg * rng.standard_normal(T.size)) % 360.0


def look(values, stamps=STAMPS, cuts=()):
    """Return the watch after the angles, in chunks."""
    watch = AngleWatch()
    for part in np.split(np.arange(len(values)), cuts):
        watch.update(stamps[part], np.asarray(values)[part])
    return watch


@pytest.mark.parametrize('name, unit', [
    ('gyro_heading_rad', 'rad'), ('HeadingRadians', 'rad'), ('hdg[rad]', 'rad'),
    ('HDG_RAD', 'rad'), ('hdg_deg', 'deg'), ('headingDeg', 'deg'),
    ('heading (\u00b0)', 'deg'), ('hdg_rev', 'rev'),
    ('heading', None), ('Gyr1HeadingTrue', None), ('radar_heading', None), ('degauss_hdg', None)])
def test_the_name_of_a_column_tells_the_unit_as_a_word_of_its_own(name, unit):
    assert find_named_unit(name) == unit


@pytest.mark.parametrize('unit, turn', [('rad', 2.0 * math.pi), ('rev', 1.0)])
@pytest.mark.parametrize('noise_deg', [0.0, 0.1, 5.2])
@pytest.mark.parametrize('decimals', [2, 4, 9])
def test_angles_that_wrap_at_their_turn_show_their_unit(unit, turn, noise_deg, decimals, rng):
    angle = np.round(course(rng, noise_deg) / 360.0 * turn, decimals)
    assert look(angle).unit == unit
    assert look(angle, cuts=(1, 7, 900)).unit == unit


def test_signed_radians_wrap_at_a_half_turn(rng):
    angle = np.radians((course(rng, middle_deg=170.0) + 180.0) % 360.0 - 180.0)
    assert look(angle).unit == 'rad'


def test_fine_radians_that_turn_through_the_circle_without_a_wrap_show_their_unit(rng):
    for swing_deg in (50.0, 100.0, 160.0):
        angle = np.radians(course(rng, middle_deg=180.0, swing_deg=swing_deg, period_s=700.0))
        assert look(np.round(angle, 4)).unit == 'rad'
        assert 'turn smoothly through a circle of 6.283' in look(angle, cuts=(1, 2, 700)).words
    assert look(np.round(angle, 2)).unit is None


@pytest.mark.parametrize('middle_deg', [0.0, 0.5, 1.0, 3.0, 5.0, 357.0])
@pytest.mark.parametrize('swing_deg', [0.0, 0.1, 0.5, 1.0, 2.5])
@pytest.mark.parametrize('period_s', [8.0, 20.0, 200.0])
@pytest.mark.parametrize('decimals', [1, 2, 4])
def test_degrees_near_north_are_degrees(middle_deg, swing_deg, period_s, decimals, rng):
    """A ship that is moored or steers about 003 steps to 359, not by 2 pi."""
    for noise_deg in (0.02, 0.1, 0.3):
        angle = np.round(course(rng, noise_deg, middle_deg=middle_deg, swing_deg=swing_deg,
                                period_s=period_s), decimals)
        assert look(angle).unit is None
        signed = (angle + 180.0) % 360.0 - 180.0
        assert look(signed).unit is None


def test_zeros_for_missing_readings_of_a_ship_on_006_are_no_wraps(rng):
    angle = course(rng, 0.05, middle_deg=6.0, swing_deg=0.05)
    angle[rng.random(angle.size) < 0.05] = 0.0
    assert look(angle).unit is None


def test_few_angles_show_nothing():
    assert look(np.tile([0.1, 6.2], 20), np.arange(40)).unit is None
    assert look([]).unit is None and look([]).words == ''


def test_signed_degrees_are_read_as_what_they_are():
    heading_deg, wrong = read_angles(np.array([-180.0, -0.5, 0.0, 179.9, np.nan]))
    assert heading_deg.tolist()[:4] == [180.0, 359.5, 0.0, 179.9] and not wrong.any()


@pytest.mark.parametrize('flags', [[-1.0, -1.0], [-99.0, -99.0], [-0.5, -3.0]])
def test_negative_numbers_among_headings_beyond_180_are_out_of_range(flags):
    heading_deg, wrong = read_angles(np.array([200.0, 10.0, *flags]))
    assert wrong.tolist() == [False, False, True, True]
    assert heading_deg[:2].tolist() == [200.0, 10.0] and np.isnan(heading_deg[2:]).all()


def test_a_negative_number_that_comes_again_far_from_all_others_is_a_flag():
    assert read_angles(np.array([100.0, -1.0, 101.0, -1.0]))[1].tolist() == [
        False, True, False, True]
    # Whole degrees of a ship on 000 are none.
    assert not read_angles(np.array([0.0, -1.0, 1.0, -1.0]))[1].any()


def test_radians_round_a_full_turn_up():
    assert read_angles(np.array([6.2832, 0.0]), 'rad')[0] == pytest.approx([0.0, 0.0], abs=1e-3)


def test_headings_are_made_of_any_unit(rng):
    heading_deg = course(rng)
    signed = (heading_deg + 180.0) % 360.0 - 180.0
    for angle, unit in ((np.radians(heading_deg), 'rad'), (heading_deg / 360.0, 'rev'),
                        (np.radians(signed), 'rad'), (signed, 'deg')):
        found = Headings.of(STAMPS, angle, unit).heading_deg
        assert np.abs((found - heading_deg + 180.0) % 360.0 - 180.0).max() < 1e-9
    assert Headings.of(STAMPS[:2], [400.0, -200.0]).heading_deg.tolist() == [400.0, -200.0]
    with pytest.raises(ValueError, match="unit = 'gon': use 'deg', 'rad', 'rev'"):
        Headings.of(STAMPS, heading_deg, 'gon')


def test_good_headings_are_not_touched(rng):
    heading_deg = course(rng)
    assert fold_angles(heading_deg) is heading_deg


def test_a_program_that_hands_over_radians_is_told_so(rng):
    ts, rs = (np.radians(course(rng, noise_deg)) for noise_deg in (5.2, 0.05))
    with pytest.raises(ValueError, match='ts: the headings lie .* radians, not'):
        analyze(Headings.of(STAMPS, ts), Headings.of(STAMPS, rs), SETTINGS)
    verdict = analyze(Headings.of(STAMPS, ts, 'rad'), Headings.of(STAMPS, rs, 'rad'), SETTINGS)
    assert verdict.outcome.value == 'non_compliant'
    assert verdict.runs[0].std_deg == pytest.approx(5.2, rel=0.1)
