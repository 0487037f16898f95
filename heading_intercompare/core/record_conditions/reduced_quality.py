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

"""The condition that no reading decides of which its own sensor says that it is poor."""

from __future__ import annotations

from heading_intercompare.core.diagnostics.sensor_quality import QualityCheck, SensorQuality
from heading_intercompare.core.validity.condition import (
    Condition,
    DOUBTFUL,
    Finding,
    HOLDS,
    NOT_TESTABLE,
)
from heading_intercompare.core.validity.examined import Examined


def _judge(e: Examined) -> Finding | None:
    check = e.quality
    if check is None:
        return None
    evidence = '; '.join(filter(None, (_describe('TS', check.ts), _describe('RS', check.rs),
                                       _describe_claim(e, check))))
    if not check.n_reduced:
        return REDUCED_QUALITY.find(HOLDS, '', evidence)
    if check.without_reduced is None:
        return REDUCED_QUALITY.find(NOT_TESTABLE, '', f'{evidence}; too few pairs are left '
                                    'without these readings')
    if check.without_reduced is e.outcome:
        return REDUCED_QUALITY.find(HOLDS, '', f'{evidence}; the outcome is the same without '
                                    'these readings')
    poor = '; '.join(f'{name} {words}' for name, words in (
        ('TS', '' if check.ts is None else check.ts.words),
        ('RS', '' if check.rs is None else check.rs.words)) if words)
    return REDUCED_QUALITY.find(
        DOUBTFUL, f'readings decide that their sensor calls poor ({poor}), without them '
        f'{check.without_reduced.words}',
        f'{evidence}; without these readings the outcome is {check.without_reduced.words}')


def _describe(name: str, sensor: SensorQuality | None) -> str:
    """Return what a sensor says of its readings, in words."""
    if sensor is None:
        return ''
    claim = '' if sensor.stated_median_deg is None or sensor.stated_largest_deg is None else (
        f' and claims {sensor.stated_median_deg:.3g} deg, at most '
        f'{sensor.stated_largest_deg:.3g} deg')
    poor = f' ({sensor.words})' if sensor.words else ''
    share = f'{100.0 * sensor.reduced_share:.3g} %'
    return f'the {name} calls {share} of its readings poor{poor}{claim}'


def _describe_claim(e: Examined, check: QualityCheck) -> str:
    """Return the claim of the TS beside what the data show, in words."""
    guarded = e.guarded
    if check.ts_claim == 'not_testable':
        return ''
    return (f'the data show a standard deviation of the TS of {guarded.sigma_ts_lower_deg:.3g} to '
            f'{guarded.sigma_ts_upper_deg:.3g} deg: its claim is '
            + {'agrees': 'honest', 'too_small': 'too small',
               'too_large': 'too large'}[check.ts_claim])


REDUCED_QUALITY = Condition(
    name='reduced_quality',
    holds='no reading decides that its own sensor calls poor',
    doubtful_when='a sensor says that some of its readings are of reduced quality, and without '
                  'them the outcome would differ: the headline says how many, what the sensor '
                  'says of them, and the outcome without them',
    judge=_judge)
