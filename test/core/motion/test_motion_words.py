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

"""The words for what the motion of a ship shows."""

from __future__ import annotations

import re

from core.motion.sailing import sail
import numpy as np
import pytest

from heading_intercompare.core.motion.motion_check import check_motion
from heading_intercompare.core.motion.motion_words import describe_motion, explain_motion
from heading_intercompare.core.records import Motion
from heading_intercompare.core.settings import MotionRule


@pytest.fixture(scope='module')
def voyage():
    """Return one voyage."""
    return sail(1)


def check(voyage, ts, rs, motion):
    """Return the check of two headings."""
    return check_motion(motion.split(), voyage.stamp_ns, np.mod(ts, 360.0), np.mod(rs, 360.0),
                        MotionRule())


@pytest.mark.parametrize('change, words', [
    (lambda h: (h + 180.0, h), r'the TS points -?17\d deg off the course over ground \(mounted '
     r'backwards, or the ship goes astern\), which the RS follows'),
    (lambda h: (h, h - 90.0), r'the RS points -9\d deg off the course over ground \(turned to '
     r'port\), which the TS follows'),
    (lambda h: (h + 50.0, h + 50.0), r'TS and RS both point 4\d deg off the course over ground'),
    (lambda h: (-h, -h), 'TS and RS both turn against the course over ground'),
    (lambda h: (h, 0.0 * h), 'the RS stays while the course over ground changes, which the TS '
     'follows'),
    (lambda h: (h, h), '')])
def test_headlines(voyage, change, words):
    assert re.fullmatch(words, describe_motion(check(voyage, *change(voyage.heading_deg),
                                                     voyage.courses)))


@pytest.mark.parametrize('change, words', [
    (lambda h: (-h, h), 'the TS turns against the rate of turn'),
    (lambda h: (h, 2.0 * np.unwrap(h, period=360.0)),
     'the RS turns 2 times as far as the rate of turn says'),
    (lambda h: (-h, -h), 'TS and RS both turn against the rate of turn'),
    (lambda h: (0.0 * h, h), 'the TS does not turn with the rate of turn')])
def test_headlines_of_the_rate_of_turn(voyage, change, words):
    assert describe_motion(check(voyage, *change(voyage.heading_deg), voyage.rates)) == words


def test_the_evidence_gives_the_figures(voyage):
    h = voyage.heading_deg
    said = explain_motion(check(voyage, h, h, voyage.courses + voyage.rates))
    assert said.startswith('4 straight legs of 3') and 'TS - course is -' in said
    assert 'leeway and current explain at least 2' in said
    assert 'RS on rate of turn: slope 1, correlation 1.00 in 479 spans of 5 s' in said


def test_the_evidence_says_why_nothing_can_be_tested(voyage):
    h = voyage.heading_deg
    slow = Motion.of_courses(voyage.stamp_ns[::5], h[::5], np.full(h[::5].size, 1.0))
    assert explain_motion(check(voyage, h, h, slow)) == (
        'the ship did not go straight and fast enough to compare headings with the course over '
        'ground')
    still = Motion.of_rates(voyage.rates.stamp_ns, 0.0 * voyage.rates.rate_deg_s)
    assert explain_motion(check(voyage, h, h, still)) == (
        'there is no course over ground; TS cannot be compared with the rate of turn: the ship '
        'turned too little; RS cannot be compared with the rate of turn: the ship turned too '
        'little')


def test_the_evidence_blames_a_rate_of_turn_that_is_wrong(voyage):
    h = voyage.heading_deg
    for factor, words in ((60.0, 'the rate of turn seems to be in another unit, by a factor of '
                           '0.0167'),
                          (-1.0, 'the headings follow the course, so the rate of turn is wrong')):
        rates = Motion.of_rates(voyage.rates.stamp_ns, factor * voyage.rates.rate_deg_s)
        assert explain_motion(check(voyage, h, h, voyage.courses + rates)).endswith(words)
