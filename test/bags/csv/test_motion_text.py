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

"""The motion of the ship as text."""

from __future__ import annotations

import numpy as np
import pytest

from heading_intercompare.bags.csv.pairs_account import motion_of_text, text_of_motion
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
