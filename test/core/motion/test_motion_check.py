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

"""Gross errors that the motion of a ship shows: each class is named, sound sensors never are."""

from __future__ import annotations

from core.motion.sailing import sail, Voyage
import numpy as np
import pytest

from heading_intercompare.core.motion.motion_check import check_motion
from heading_intercompare.core.records import Motion
from heading_intercompare.core.settings import MotionRule
from heading_intercompare.drivers.logs import read_log
from heading_intercompare.drivers.motion.motion_log import read_log_motion
from heading_intercompare.drivers.settings import DriverSettings

SEEDS = 10


def _freeze(heading):
    """Return a heading that stays where it was after 200 s."""
    return np.where(np.arange(heading.size) > 1000, heading[1000], heading)


def _stay(heading):
    """Return a heading that never leaves its first value, but for noise."""
    noise = np.random.default_rng(1).standard_normal(heading.size)
    return heading[0] + 0.01 * noise


# Class of error: what it makes of TS and RS, whose it is, and its kind.
ERRORS = {
    'ts_backwards': (lambda ts, rs: (ts + 180.0, rs), 'ts', 'off'),
    'rs_backwards': (lambda ts, rs: (ts, rs + 180.0), 'rs', 'off'),
    'both_backwards': (lambda ts, rs: (ts + 180.0, rs + 180.0), 'both', 'off'),
    'ts_across': (lambda ts, rs: (ts + 90.0, rs), 'ts', 'off'),
    'both_across': (lambda ts, rs: (ts - 90.0, rs - 90.0), 'both', 'off'),
    'both_45': (lambda ts, rs: (ts + 45.0, rs + 45.0), 'both', 'off'),
    'ts_mirrored': (lambda ts, rs: (-ts, rs), 'ts', 'mirrored'),
    'rs_yaw': (lambda ts, rs: (ts, 90.0 - rs), 'rs', 'mirrored'),
    'both_mirrored': (lambda ts, rs: (-ts, -rs), 'both', 'mirrored'),
    'both_yaw': (lambda ts, rs: (90.0 - ts, 90.0 - rs), 'both', 'mirrored'),
    'ts_frozen': (lambda ts, rs: (_freeze(ts), rs), 'ts', 'frozen'),
    'rs_frozen': (lambda ts, rs: (ts, _freeze(rs)), 'rs', 'frozen'),
    'both_frozen': (lambda ts, rs: (_stay(ts), _stay(rs)), 'both', 'frozen'),
}


@pytest.fixture(scope='module')
def voyages():
    """Return voyages of several seeds."""
    return [sail(seed) for seed in range(SEEDS)]


def checked(voyage: Voyage, ts, rs, motion, **rule):
    """Return the check of two headings."""
    return check_motion(motion.split(), voyage.stamp_ns, np.mod(ts, 360.0), np.mod(rs, 360.0),
                        MotionRule(**rule))


@pytest.mark.parametrize('error', ERRORS)
def test_the_course_names_each_error_and_its_sensor(voyages, rng, error):
    change, whose, kind = ERRORS[error]
    for voyage in voyages:
        found = checked(voyage, *change(*voyage.sensors(rng)), voyage.courses)
        assert (found.kind, found.whose) == ('contradicts', whose)
        wrong = {'ts': [found.ts], 'rs': [found.rs], 'both': [found.ts, found.rs]}[whose]
        assert [each.kind for each in wrong] == [kind] * len(wrong)
        assert all(each.kind == 'agrees' for each in (found.ts, found.rs) if each not in wrong)


@pytest.mark.parametrize('error', ['both_backwards', 'both_across', 'both_yaw', 'ts_frozen'])
def test_positions_alone_name_it_too(voyages, rng, error):
    change, whose, kind = ERRORS[error]
    for voyage in voyages:
        found = checked(voyage, *change(*voyage.sensors(rng)), voyage.positions)
        assert (found.kind, found.whose, found.n_velocities) == ('contradicts', whose, 0)


@pytest.mark.parametrize('what', ['courses', 'positions', 'rates', 'all'])
@pytest.mark.parametrize('speed, current, leeway', [
    (10.0, 1.5, 4.0), (10.0, 3.0, 9.0), (5.0, 2.9, -9.0), (4.0, 2.5, 8.0), (16.0, 3.0, -9.0)])
def test_sound_headings_raise_nothing(rng, what, speed, current, leeway):
    for seed in range(SEEDS if what == 'courses' else 2):
        voyage = sail(seed, speed_kn=speed, current_kn=current, leeway_deg=leeway)
        motion = (voyage.courses + voyage.rates + voyage.positions if what == 'all'
                  else getattr(voyage, what))
        found = checked(voyage, *voyage.sensors(rng), motion)
        assert found.kind in ('agrees', 'not_testable') and found.whose == ''


@pytest.mark.parametrize('error, ts, rs, kind, whose', [
    ('ts_mirrored', 'against', 'follows', 'contradicts', 'ts'),
    ('rs_yaw', 'follows', 'against', 'contradicts', 'rs'),
    ('ts_frozen', 'astray', 'follows', 'contradicts', 'ts'),
    ('both_mirrored', 'against', 'against', 'doubt', 'both'),
    ('both_frozen', 'astray', 'astray', 'doubt', 'both'),
    ('both_backwards', 'follows', 'follows', 'agrees', '')])
def test_the_rate_of_turn_alone_names_what_it_can(voyages, rng, error, ts, rs, kind, whose):
    """A rate of turn that neither follows may itself be wrong: no more than a doubt."""
    for voyage in voyages:
        found = checked(voyage, *ERRORS[error][0](*voyage.sensors(rng)), voyage.rates)
        assert (found.ts.turns.kind, found.rs.turns.kind) == (ts, rs)
        assert (found.kind, found.whose, found.ts.kind) == (kind, whose, 'not_testable')


def test_a_wrong_rate_of_turn_does_no_harm_if_the_course_shows_the_headings_right(voyages, rng):
    voyage = voyages[0]
    for factor in (-1.0, 60.0):
        wrong = Motion.of_rates(voyage.rates.stamp_ns, factor * voyage.rates.rate_deg_s)
        found = checked(voyage, *voyage.sensors(rng), voyage.courses + wrong)
        assert found.kind == 'agrees' and found.ts.turns.kind != 'follows'


def test_headings_of_another_unit_than_the_rate_are_no_error(voyages, rng):
    voyage = voyages[0]
    wrong = Motion.of_rates(voyage.rates.stamp_ns, 60.0 * voyage.rates.rate_deg_s)
    found = checked(voyage, *voyage.sensors(rng), wrong)
    assert (found.kind, found.ts.turns.kind) == ('agrees', 'scaled')


def test_a_ship_that_goes_astern_for_a_while_raises_nothing(voyages, rng):
    """The last leg of 10 minutes goes backwards."""
    voyage = voyages[0]
    astern = voyage.courses.stamp_ns > voyage.courses.stamp_ns[1800]
    turned = np.where(astern, -1.0, 1.0)
    motion = Motion.of_velocities(voyage.courses.stamp_ns, turned * voyage.courses.east_m_s,
                                  turned * voyage.courses.north_m_s)
    found = checked(voyage, *voyage.sensors(rng), motion)
    assert found.kind == 'agrees' and 400.0 < found.astern_s < 650.0


def two_legs(off_deg):
    """Return courses of 10 minutes to the north and 6 to the east, and headings off them."""
    stamps = 10 ** 18 + np.arange(960) * 10 ** 9
    course = np.where(np.arange(960) < 600, 0.0, 90.0)
    return (Motion.of_courses(stamps, course, np.full(960, 10.0)), stamps,
            np.mod(course + np.where(np.arange(960) < 600, 0.0, off_deg), 360.0))


def test_a_ship_that_goes_astern_after_a_turn_is_not_surely_mirrored():
    """North ahead, then east astern: the headings 0 and 270 are also those of mirrored sensors."""
    motion, stamps, heading = two_legs(180.0)
    found = check_motion(motion.split(), stamps, heading, heading, MotionRule())
    assert (found.kind, found.whose, found.ts.kind) == ('doubt', 'both', 'mirrored')
    turned = np.unwrap(heading, period=360.0)
    rates = Motion.of_rates(stamps, np.gradient(np.interp(
        np.arange(960), [500, 590, 960], [turned[0], turned[-1], turned[-1]])))
    smooth = np.interp(np.arange(960), [500, 590, 960], [turned[0], turned[-1], turned[-1]])
    heading = np.mod(smooth, 360.0)
    found = check_motion((motion + rates).split(), stamps, heading, heading, MotionRule())
    assert (found.kind, found.ts.turns.kind) == ('agrees', 'follows') and found.astern_s > 300.0


def test_a_contradiction_for_a_small_part_of_the_time_is_a_doubt(voyages, rng):
    voyage = voyages[0]
    ts, rs = voyage.sensors(rng)
    last = np.arange(ts.size) > 0.8 * ts.size
    found = checked(voyage, np.where(last, ts + 60.0, ts), rs, voyage.courses)
    assert (found.kind, found.whose, found.ts.kind) == ('doubt', 'ts', 'astray')
    assert 90.0 <= found.ts.against_s < 0.5 * found.legs_s


def test_less_than_two_minutes_against_the_course_are_nothing(voyages, rng):
    voyage = voyages[0]
    ts, rs = voyage.sensors(rng)
    n = int(20 * 60 * 5)
    ts[n:n + 300] += 120.0
    assert checked(voyage, ts, rs, voyage.courses).kind == 'agrees'


def test_a_stronger_current_allows_more(voyages, rng):
    voyage = voyages[0]
    ts, rs = voyage.sensors(rng)
    assert checked(voyage, ts + 45.0, rs + 45.0, voyage.courses).kind == 'contradicts'
    assert checked(voyage, ts + 45.0, rs + 45.0, voyage.courses,
                   current_max_kn=8.0).kind == 'agrees'


def test_at_a_speed_below_the_current_nothing_can_be_tested(rng):
    voyage = sail(3, speed_kn=2.5, current_kn=0.0)
    ts, rs = voyage.sensors(rng)
    found = checked(voyage, ts + 180.0, rs + 180.0, voyage.courses, least_speed_kn=1.0)
    assert (found.kind, found.ts.kind, found.least_bound_deg) == (
        'not_testable', 'not_testable', 180.0)


@pytest.mark.parametrize('pairs, rows', [(0, 100), (1000, 0)])
def test_no_pairs_or_no_motion_show_nothing(voyages, pairs, rows):
    voyage = voyages[0]
    found = check_motion(voyage.courses[:rows].split(), voyage.stamp_ns[:pairs],
                         voyage.heading_deg[:pairs], voyage.heading_deg[:pairs], MotionRule())
    assert (found.kind, found.n_legs, found.least_bound_deg) == ('not_testable', 0, None)


def test_rows_outside_the_run_and_their_order_do_not_matter(voyages, rng):
    voyage = voyages[0]
    ts, rs = voyage.sensors(rng)
    every = voyage.courses + voyage.rates + voyage.positions
    before = Motion.of_courses(voyage.stamp_ns[:1] - 10 ** 10, [200.0], [50.0])
    mixed = (every + before)[rng.permutation(len(every) + 1)]
    one, other = (checked(voyage, ts, rs, motion) for motion in (every, mixed))
    assert one.legs == other.legs and one.ts == other.ts and one.n_rates == other.n_rates


def test_at_most_64_legs_are_listed_the_longest_in_their_order():
    stamps = 10 ** 18 + np.arange(70 * 120) * 10 ** 9
    course = 20.0 * (np.arange(stamps.size) // 120)
    motion = Motion.of_courses(stamps, course, np.full(stamps.size, 10.0))
    found = check_motion(motion.split(), stamps, course % 360.0, course % 360.0, MotionRule())
    assert found.n_legs == 70 and len(found.legs) == 64
    assert list(found.legs.start_ns) == sorted(found.legs.start_ns)


@pytest.mark.parametrize('off, kind', [(0.0, 'agrees'), (180.0, 'contradicts')])
def test_the_compass_of_a_real_yacht_agrees_with_its_course(shared_data, off, kind):
    """The figures of docs/howto/check_against_motion.md."""
    log = shared_data / 'gpsd' / 'bundg_zeus_9.log'
    rule = DriverSettings(time='validity')
    headings, _ = read_log(log, rule)
    motion = Motion.concatenate(list(read_log_motion(log, rule).rows.values()))
    heading = np.mod(headings.heading_deg + off, 360.0)
    found = check_motion(motion.split(), headings.stamp_ns, heading, heading, MotionRule())
    assert found.kind == kind and found.n_legs == 1
    assert found.legs_s / 60.0 == pytest.approx(2.0, abs=0.05)
    assert found.least_bound_deg == pytest.approx(42.4, abs=0.5)
    if not off:
        assert found.ts.off_deg == pytest.approx(1.1, abs=0.05)
