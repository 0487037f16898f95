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

"""Headings against the rate of turn."""

from __future__ import annotations

from core.motion.sailing import sail
import numpy as np
import pytest

from heading_intercompare.core.motion.turn_rate import compare_turns
from heading_intercompare.core.records import Motion

S = 10 ** 9


@pytest.fixture(scope='module')
def voyage():
    """Return a voyage with three turns."""
    return sail(4)


def compared(voyage, heading, rates=None):
    """Return the comparison of a heading with the rate of turn of a voyage."""
    return compare_turns(voyage.rates if rates is None else rates, voyage.stamp_ns,
                         np.mod(heading, 360.0))


def test_a_sound_heading_follows(voyage, rng):
    found = compared(voyage, voyage.sensors(rng)[0])
    assert found.kind == 'follows' and found.delay_s == 0.0 and found.n > 400
    assert found.slope == pytest.approx(1.0, abs=0.02) and found.correlation > 0.99


@pytest.mark.parametrize('delay_s', [-3.0, 2.0])
def test_a_delay_is_found_and_does_no_harm(voyage, delay_s):
    """The heading of 2 s earlier is late by 2 s."""
    late = np.interp(voyage.stamp_ns - delay_s * S, voyage.stamp_ns,
                     np.unwrap(voyage.heading_deg, period=360.0))
    found = compared(voyage, late)
    assert (found.kind, found.delay_s) == ('follows', delay_s)


@pytest.mark.parametrize('change, kind, slope', [
    (lambda h: -h, 'against', -1.0), (lambda h: 90.0 - h, 'against', -1.0),
    (lambda h: h + 180.0, 'follows', 1.0), (lambda h: 2.0 * h, 'scaled', 2.0)])
def test_what_is_wrong_is_named(voyage, change, kind, slope):
    found = compared(voyage, change(np.unwrap(voyage.heading_deg, period=360.0)))
    assert found.kind == kind and found.slope == pytest.approx(slope, rel=0.02)


def test_degrees_a_minute_read_as_degrees_a_second_scale_by_a_sixtieth(voyage):
    rates = Motion.of_rates(voyage.rates.stamp_ns, 60.0 * voyage.rates.rate_deg_s)
    found = compared(voyage, voyage.heading_deg, rates)
    assert found.kind == 'scaled' and found.slope == pytest.approx(1.0 / 60.0, rel=0.02)


def test_a_frozen_heading_goes_astray(voyage, rng):
    found = compared(voyage, 80.0 + 0.01 * rng.standard_normal(voyage.heading_deg.size))
    assert found.kind == 'astray'


def test_a_ship_that_hardly_turns_shows_nothing(voyage, rng):
    n = voyage.heading_deg.size
    rates = Motion.of_rates(voyage.rates.stamp_ns, 0.01 * rng.standard_normal(len(voyage.rates)))
    assert compared(voyage, 80.0 + 0.1 * rng.standard_normal(n), rates).kind == 'not_testable'


def test_a_rate_of_turn_of_noise_shows_nothing(voyage, rng):
    """Spans with 0.2 deg/s of white noise turn by up to 2 deg, but seldom."""
    rates = Motion.of_rates(voyage.rates.stamp_ns, 0.2 * rng.standard_normal(len(voyage.rates)))
    still = 80.0 + 0.1 * rng.standard_normal(voyage.heading_deg.size)
    assert compared(voyage, still, rates).kind == 'not_testable'


def test_spans_with_a_gap_do_not_count(voyage):
    """A rate every 3 s is too seldom to be integrated."""
    assert compared(voyage, voyage.heading_deg, voyage.rates[::3]).n == 0
    assert compared(voyage, voyage.heading_deg, voyage.rates[:60]).kind == 'not_testable'


@pytest.mark.parametrize('n', [0, 1])
def test_without_rates_nothing_is_testable(voyage, n):
    found = compared(voyage, voyage.heading_deg, voyage.rates[:n])
    assert (found.kind, found.n, found.slope) == ('not_testable', 0, None)
