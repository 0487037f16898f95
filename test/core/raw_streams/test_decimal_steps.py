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

"""Tests of the step in which a sensor reports, and of rounding that the motion does not show."""

import numpy as np
import pytest

from heading_intercompare import analyze
from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.raw_streams.decimal_steps import find_decimal_step, StepCount
from heading_intercompare.core.records import Headings
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.statistics.resolution import find_step_seen

T0 = 1_700_000_000_000_000_000


def readings(t_s, heading_deg, step_deg):
    return Headings.of(T0 + np.round(t_s * 1e9).astype(np.int64),
                       np.round(np.round(heading_deg / step_deg) * step_deg, 6) % 360.0)


def count(headings, sizes=None):
    steps, found, lo = StepCount(), {}, 0
    for n in [len(headings)] if sizes is None else sizes:
        for step, stamps in steps.take(headings[lo:lo + n]).items():
            found[step] = found.get(step, 0) + len(stamps)
        lo += n
    return found


@pytest.mark.parametrize('step_deg', [1.0, 0.5, 0.25, 0.2, 0.1, 0.05, 0.02, 0.01])
@pytest.mark.parametrize('offset_deg', [0.0, 0.37])
def test_the_step_follows_from_the_changes(rng, step_deg, offset_deg):
    t_s = np.arange(0.0, 300.0)
    heading = 359.0 + 3.0 * step_deg * rng.standard_normal(t_s.size)
    rounded = readings(t_s, heading, step_deg)
    moved = Headings.of(rounded.stamp_ns, np.round(rounded.heading_deg + offset_deg, 6) % 360.0)
    assert find_decimal_step(count(moved)) == pytest.approx(step_deg)
    assert count(moved, rng.multinomial(len(moved), [0.1] * 10)) == count(moved)


def test_a_step_finer_than_a_hundredth_or_of_radians_is_none(rng):
    t_s = np.arange(0.0, 300.0)
    heading = 100.0 + rng.standard_normal(t_s.size)
    for step_deg in (0.001, np.degrees(1e-4)):
        assert find_decimal_step(count(readings(t_s, heading, step_deg))) is None


def test_two_changes_show_no_step():
    assert find_decimal_step({100: 2}) is None and find_decimal_step({}) is None
    assert count(Headings.empty()) == {}


def test_rounding_is_seen_from_a_motion_of_a_third_of_a_step(rng):
    """|E exp(2 pi i h)| = exp(-2 (pi s)^2): 0.11 at s = 0.33, 0.29 at 0.25."""
    motion = rng.standard_normal(20_000)
    assert find_step_seen(90.2 + 0.33 * motion) == 1.0
    assert find_step_seen(90.2 + 0.25 * motion) == 0.5


def test_two_courses_are_not_motion_through_the_steps():
    assert find_step_seen(np.repeat([10.1, 90.13], 500)) <= 0.02


def judged(rng, *, course_deg, motion_deg, ts_step_deg, ts_hz, rs_hz, rs_step_deg=0.01):
    rate = 2.0 * np.pi / (10.0 + 2.0 * rng.standard_normal(40))
    phase = rng.uniform(0.0, 2.0 * np.pi, 40)

    def heading(t_s):
        waves = np.sin(t_s[:, None] * rate + phase).sum(axis=1) / np.sqrt(20.0)
        return course_deg + motion_deg * waves + 0.03 * rng.standard_normal(t_s.size)

    ts_s, rs_s = np.arange(0.0, 1500.0, 1.0 / ts_hz), np.arange(0.01, 1500.0, 1.0 / rs_hz)
    verdict = analyze(
        readings(ts_s, heading(ts_s), ts_step_deg), readings(rs_s, heading(rs_s), rs_step_deg),
        Settings.from_mapping({'norms': {'sigma_max_deg': 0.2, 'sigma_ref_max_deg': 0.1}}))
    return verdict, {found.condition: found for found in verdict.runs[0].validity}


@pytest.mark.parametrize('course_deg', [90.0, 90.2, 90.42])
@pytest.mark.parametrize('ts_hz, rs_hz', [(1.0, 10.0), (10.0, 1.0)])
def test_whole_degrees_on_a_steady_course_get_no_certificate(rng, course_deg, ts_hz, rs_hz):
    """One value at 90.0 and 90.2 deg, two at 90.42 deg; interpolated or not."""
    verdict, found = judged(rng, course_deg=course_deg, motion_deg=0.03, ts_step_deg=1.0,
                            ts_hz=ts_hz, rs_hz=rs_hz)
    assert verdict.outcome is not Outcome.COMPLIANT
    assert found['resolution'].effect == 'void' or verdict.outcome is Outcome.NON_COMPLIANT
    assert 'in steps of 1 deg' in found['resolution'].evidence


@pytest.mark.parametrize('step_deg, motion_deg', [(0.1, 0.01), (0.1, 0.5), (0.01, 0.01),
                                                  (0.2, 0.02)])
def test_fine_steps_bind_nothing(rng, step_deg, motion_deg):
    verdict, found = judged(rng, course_deg=90.23, motion_deg=motion_deg, ts_step_deg=step_deg,
                            ts_hz=1.0, rs_hz=5.0)
    assert found['resolution'].effect == 'holds'
    assert verdict.outcome is Outcome.COMPLIANT


def test_coarse_steps_that_the_motion_shows_reject(rng):
    verdict, found = judged(rng, course_deg=90.2, motion_deg=1.0, ts_step_deg=1.0, ts_hz=1.0,
                            rs_hz=10.0)
    assert verdict.outcome is Outcome.NON_COMPLIANT
    assert found['resolution'].effect == 'holds' and 'motion shows' in found['resolution'].evidence


def test_an_interpolated_rs_of_whole_degrees_rejects_no_ts(rng):
    verdict, found = judged(rng, course_deg=90.2, motion_deg=1.0, ts_step_deg=0.01, ts_hz=1.03,
                            rs_hz=10.0, rs_step_deg=1.0)
    assert verdict.runs[0].reason == 'void.reference'
