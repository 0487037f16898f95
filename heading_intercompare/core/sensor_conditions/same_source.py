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

from heading_intercompare.core.conditions.common_noise import CommonNoise
from heading_intercompare.core.pairing.ledger import LedgerKey
from heading_intercompare.core.validity.condition import (
    Condition,
    DOUBTFUL,
    Finding,
    HOLDS,
    NOT_TESTABLE,
    VOID,
)
from heading_intercompare.core.validity.examined import Examined, RunAccount

#: Changes of value needed to tell, and the share of them that one sensor in two loggers shows.
_LEAST_CHANGES, _MOST_DIFFERING = 300, 0.003
_TOO_QUIET = 'TS and RS differ by less than the RS alone should'

_NO_NOISE = {
    'too_short': 'the run is too short to compare the noise of TS and RS',
    'too_slow': 'readings more than a second apart do not show noise above the motion',
    '': 'the RS shows no noise of its own that could reveal a common source',
}


def _judge(e: Examined) -> Finding:
    source = e.columns.source
    noise, glitches = source.noise, source.glitches
    words = 'TS and RS look like one sensor'
    followed = f'the TS follows {glitches.followed} of {glitches.count} glitches of the RS'
    shared = _describe(noise)
    if noise.kind == 'common':
        return SAME_SOURCE.find(VOID, words, shared)
    if glitches.kind == 'common' and glitches.chance is not None:
        return SAME_SOURCE.find(
            VOID, words, f'{followed}, {glitches.delay_s:.3g} s later; chance '
            f'would do this with a probability below {max(glitches.chance, 1e-99):.1g}')
    least = e.limits.m_low * e.limits.sigma_ref_max_deg
    upper_deg2 = e.guarded.upper_bound_deg2
    if upper_deg2 is not None and 0.0 < upper_deg2 < least ** 2:
        return SAME_SOURCE.find(
            VOID, _TOO_QUIET,
            f'the difference scatters by at most {math.sqrt(upper_deg2):.3g} '
            f'deg, but by its norm the RS alone by at least {least:.3g} deg')
    if noise.kind == 'unsure':
        return SAME_SOURCE.find(DOUBTFUL, 'TS and RS share a part of their noise', f'{shared}, '
                                'less than that of a copy, more than chance explains')
    if noise.kind == 'independent':
        return SAME_SOURCE.find(HOLDS, '', f'the noise of the RS, {noise.of_rs.noise_deg:.2g} '
                                f'deg, is not found in the TS (coherence '
                                f'{noise.of_rs.coherence:.2f}), nor that of the TS, '
                                f'{noise.of_ts.noise_deg:.2g} deg, in the RS (coherence '
                                f'{noise.of_ts.coherence:.2f})')
    if glitches.kind == 'independent':
        return SAME_SOURCE.find(HOLDS, '', followed)
    if source.kind == 'suspected':
        # Two perfect sensors without noise do that too; real ones never do.
        effect = VOID if noise.reason else DOUBTFUL
        return SAME_SOURCE.find(effect, 'one sensor twice, or two without error', 'the TS repeats '
                                f'the RS, reading by reading, and {_NO_NOISE[noise.reason]}')
    for name, partner, single in (('RS', 'TS', noise.of_rs), ('TS', 'RS', noise.of_ts)):
        if single.kind == 'independent':
            return SAME_SOURCE.find(
                NOT_TESTABLE, '', f'the noise of the {name}, {single.noise_deg:.2g} deg, is not '
                f'found in the {partner} (coherence {single.coherence:.2f}), which shows none of '
                'its own to be found the other way')
    return SAME_SOURCE.find(NOT_TESTABLE, '', _NO_NOISE[noise.reason])


def _describe(noise: CommonNoise) -> str:
    """Describe the noise that both show; empty if there is none."""
    strongest, name, follower = noise.strongest, 'RS', 'TS'
    if strongest is noise.of_ts:
        name, follower = follower, name
    if strongest.band_hz is None:
        return ''
    return (f'from {strongest.band_hz[0]:.3g} to {strongest.band_hz[1]:.3g} Hz, above the motion '
            f'of the ship, the {follower} follows the noise of the {name}: coherence '
            f'{strongest.coherence:.2f}')


def _settle(finding: Finding | None, account: RunAccount) -> Finding | None:
    """Compare the sequences of values as the sensors sent them: two loggers write the same."""
    if finding is None or account.inside is None:
        return finding
    n = account.inside.counts.get(LedgerKey.CHANGES_COMPARED, 0)
    differing = account.inside.counts.get(LedgerKey.CHANGES_DIFFERING, 0)
    if n < _LEAST_CHANGES:
        return finding if finding.effect == VOID else SAME_SOURCE.find(
            finding.effect, finding.words, f'{finding.evidence}; {n} changes of value are too few '
            'to compare the sequences')
    if differing <= _MOST_DIFFERING * n:
        evidence = (f'{n - differing} of {n} changes of value of one sensor are found in the '
                    'other, but for a delay, a constant and rounding: two loggers on one sensor')
        if finding.effect == VOID and finding.words != _TOO_QUIET:
            return SAME_SOURCE.find(VOID, finding.words, f'{finding.evidence}; {evidence}')
        return SAME_SOURCE.find(VOID, 'TS and RS write the same sequence of values', evidence)
    evidence = (f'{finding.evidence}; {differing} of {n} changes of value of one sensor differ in '
                'the other')
    if finding.words == _TOO_QUIET:
        return SAME_SOURCE.find(HOLDS, '', f'{evidence}: two sensors, of which the RS is better '
                                'than norms.m_low says')
    return SAME_SOURCE.find(finding.effect, finding.words, evidence)


SAME_SOURCE = Condition(
    name='same_source',
    holds='TS and RS are two sensors',
    void='void: TS and RS show the same noise, glitches or values, so both may come from one '
         'sensor',
    void_when="one of TS and RS shows the noise of the other on top of the ship's motion, the "
              'same glitches or the same sequence of readings, also late, thinned, repeated, '
              'rounded or with a constant added; or they differ by less than the RS alone should '
              'by its norm, and too few values change to compare the sequences',
    void_why='two outputs of one sensor agree whatever their error',
    doubtful_when='one sensor follows the noise of the other significantly, but less than a copy '
                  'would; or the TS repeats the RS, reading by reading, and neither noise nor '
                  'glitches show: this is one sensor twice, or two without error; void if the '
                  'readings are too few or too slow to show noise',
    judge=_judge, settle=_settle, is_permanent=True, watched_by=('same_source',))
