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

"""The condition that TS and RS are two sensors, not two outputs of one."""

from __future__ import annotations

import math

from heading_intercompare.core.validity.condition import (
    Condition,
    DOUBTFUL,
    Finding,
    HOLDS,
    NOT_TESTABLE,
    VOID,
)
from heading_intercompare.core.validity.examined import Examined

__all__ = ['SAME_SOURCE']

_NO_NOISE = {
    'too_short': 'the run is too short to compare the noise of TS and RS',
    'too_slow': 'readings more than a second apart do not show noise above the motion',
    'no_rs_noise': 'the RS shows no noise of its own that could reveal a common source',
}


def _judge(e: Examined) -> Finding:
    source = e.columns.source
    noise, glitches = source.noise, source.glitches
    words = 'TS and RS look like one sensor'
    followed = f'the TS follows {glitches.followed} of {glitches.count} glitches of the RS'
    if noise.kind == 'common' and noise.band_hz is not None:
        return SAME_SOURCE.find(
            VOID, words, f'from {noise.band_hz[0]:.3g} to {noise.band_hz[1]:.3g} '
            'Hz, above the motion of the ship, the TS follows the noise of the RS: '
            f'coherence {noise.coherence:.2f}')
    if glitches.kind == 'common' and glitches.chance is not None:
        return SAME_SOURCE.find(
            VOID, words, f'{followed}, {glitches.delay_s:.3g} s later; chance '
            f'would do this with a probability below {max(glitches.chance, 1e-99):.1g}')
    least = e.limits.m_low * e.limits.sigma_ref_max_deg
    upper_deg2 = e.guarded.upper_bound_deg2
    if upper_deg2 is not None and 0.0 < upper_deg2 < least ** 2:
        return SAME_SOURCE.find(
            VOID, 'TS and RS differ by less than the RS alone should',
            f'the difference scatters by at most {math.sqrt(upper_deg2):.3g} '
            f'deg, but by its norm the RS alone by at least {least:.3g} deg')
    if noise.kind == 'independent':
        return SAME_SOURCE.find(
            HOLDS, '', f'the noise of the RS, {noise.rs_noise_deg:.2g} deg, is '
            f'not found in the TS: coherence {noise.coherence:.2f}')
    if glitches.kind == 'independent':
        return SAME_SOURCE.find(HOLDS, '', followed)
    if source.kind == 'suspected':
        # Two perfect sensors without noise do that too; real ones never do.
        effect = DOUBTFUL if noise.reason == 'no_rs_noise' else VOID
        return SAME_SOURCE.find(effect, 'one sensor twice, or two without error', 'the TS repeats '
                                f'the RS, reading by reading, and {_NO_NOISE[noise.reason]}')
    return SAME_SOURCE.find(NOT_TESTABLE, '', _NO_NOISE[noise.reason])


SAME_SOURCE = Condition(
    name='same_source',
    holds='TS and RS are two sensors',
    void='void: TS and RS show the same noise or glitches, so both may come from one sensor',
    void_when="TS and RS show the same noise on top of the ship's motion, the same glitches or "
              'the same readings; or they differ by less than the RS alone should by its norm',
    void_why='two outputs of one sensor agree whatever their error',
    doubtful_when='the TS repeats the RS, reading by reading, and the RS shows neither noise nor '
                  'glitches: this is one sensor twice, or two without error; void if the readings '
                  'are too few or too slow to show noise',
    judge=_judge, is_permanent=True)
