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

"""The condition that no sensor repeats its value while the ship turns."""

from __future__ import annotations

from heading_intercompare.core.conditions.standstill import find_frozen, Frozen
from heading_intercompare.core.diagnostics.run_columns import RunColumns
from heading_intercompare.core.utc_text import utc
from heading_intercompare.core.validity.condition import (
    Condition,
    DOUBTFUL,
    Finding,
    HOLDS,
    NOT_TESTABLE,
    VOID,
)
from heading_intercompare.core.validity.examined import Examined

#: Share of the acceptance limit from which the motion missed by a sticking sensor counts.
_MISSED = 0.05


def _find(columns: RunColumns) -> dict[str, Frozen]:
    """Return how each sensor repeats its value while the other one moves."""
    c = columns.at_one_time
    sensors = {'TS': (c.ts_deg, c.rs_deg, c.limits.sigma_ref_max_deg),
               'RS': (c.rs_deg, c.ts_deg, c.limits.sigma_max_deg)}
    return {name: find_frozen(c.stamp_ns, heading_deg, other_deg, moved_deg=0.0,
                              sigma_deg=other_sigma_deg)
            for name, (heading_deg, other_deg, other_sigma_deg) in sensors.items()}


def _judge(e: Examined) -> Finding:
    repetitions = _find(e.columns)
    if repetitions['TS'].kind == 'not_testable':
        return FROZEN.find(NOT_TESTABLE, '', 'there are too few readings')
    sigma_deg = max(e.limits.sigma_max_deg, e.limits.sigma_ref_max_deg)
    for name, sign in repetitions.items():
        if sign.kind == 'frozen' and sign.is_plain(sigma_deg):
            return FROZEN.find(VOID, f'the {name} froze', _describe(name, sign))
        if sign.kind == 'dead':
            return FROZEN.find(VOID, f'the {name} sent one value for an hour',
                               f'the {name} sent one value for {sign.longest_s:.0f} s, although '
                               'it reports decimals')
    stamp_ns = e.columns.stamp_ns
    run_s = (int(stamp_ns[-1]) - int(stamp_ns[0])) / 1e9
    for name, sign in repetitions.items():
        if sign.kind == 'constant':
            lasted = f'for {sign.longest_s:.0f} s'
            never = sign.hold_s is None and sign.longest_s >= run_s
            return FROZEN.find(DOUBTFUL, f'the {name} never changed its value' if never
                               else f'the {name} did not change its value {lasted}',
                               f'the {name} sent one value {lasted}, although it reports '
                               'decimals, and the other sensor did not')
    for name, sign in repetitions.items():
        if sign.kind == 'frozen':
            missed_deg2 = sign.frozen_s / run_s * sign.moved_variance_deg2
            what = (f'{_describe(name, sign)}, which may be its friction: it misses at most '
                    f'{missed_deg2:.2g} deg2 of the variance')
            if missed_deg2 > _MISSED * e.guarded.acceptance_limit_deg2:
                return FROZEN.find(DOUBTFUL, f'the {name} sticks', what)
            return FROZEN.find(HOLDS, '', what)
    longest = max(sign.longest_s for sign in repetitions.values())
    return FROZEN.find(HOLDS, '', f'no value was repeated for more than {longest:.1f} s '
                       'while the other sensor turned' if longest else 'no value was repeated')


def _describe(name: str, sign: Frozen) -> str:
    times = 'once' if sign.stretches == 1 else f'{sign.stretches} times'
    return (f'the {name} repeated its value {times} while the other sensor turned, for '
            f'{sign.duration_s:.1f} s by {sign.other_moved_deg:.2f} deg '
            f'at {utc(sign.start_ns)} UTC')


FROZEN = Condition(
    name='frozen',
    holds='no sensor repeats its value while the ship turns',
    void='void: a sensor repeats its value while the other shows that the ship turns',
    void_when='a sensor repeats its value while the other turns by more than ten of its steps and '
              'twice the larger norm, or sends one value for an hour although it reports decimals',
    void_why='a dead sensor has no error to measure',
    doubtful_when='a sensor that reports decimals sends one value for nine tenths of the run, and '
                  'the motion is too small to call it void: "the TS never changed its value"; or '
                  'it sticks so often that it misses 5 % of the acceptance limit',
    judge=_judge, watched_by=('ts_frozen', 'rs_frozen'))
