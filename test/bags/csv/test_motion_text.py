# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The motion of the ship as text."""

from __future__ import annotations

import numpy as np
import pytest

from heading_intercompare.bags.csv.motion_text import motion_of_text, text_of_motion
from heading_intercompare.core.records import Motion


def test_it_comes_back_to_the_bit(rng):
    stamps = 10 ** 18 + np.arange(50)
    parts = (Motion.of_positions(stamps, rng.standard_normal(50), rng.standard_normal(50)),
             Motion.of_velocities(stamps, rng.standard_normal(50), rng.standard_normal(50)),
             Motion.of_rates(stamps, rng.standard_normal(50)))
    motion = Motion.concatenate(parts)
    text = text_of_motion(motion)
    assert motion_of_text(text) == motion and {*text} == {'position', 'velocity', 'rate'}
    assert motion_of_text(text_of_motion(parts[1])) == parts[1]


def test_no_motion_is_no_text():
    assert text_of_motion(Motion.empty()) is None
    assert motion_of_text(None) == Motion.empty()


@pytest.mark.parametrize('text, words', [
    ({'rate': '!'}, 'motion.rate is no base64'), ({'rate': 'AAAA'}, 'has 3 bytes'),
    ({'way': ''}, 'motion.way has 0 bytes')])
def test_what_is_none_is_refused(text, words):
    with pytest.raises(ValueError, match=words):
        motion_of_text(text)
