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

"""The condition that the RS meets its norm, as far as the data can contradict it."""

from __future__ import annotations

from dataclasses import dataclass

from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.validity.condition import (
    Condition,
    DOUBTFUL,
    Finding,
    HOLDS,
    NOT_TESTABLE,
    VOID,
)
from heading_intercompare.core.validity.examined import Examined, RunAccount


@dataclass(frozen=True, slots=True)
class _Excess:
    """By how much the variance of the RS exceeds its norm: at least, at most, and how it shows."""

    least_deg2: float
    most_deg2: float
    words: str


def _find_excess(e: Examined) -> _Excess | None:
    """Return the proven excess of the RS; None if the data prove none."""
    norm_deg = e.limits.sigma_ref_max_deg
    noise = e.diagnostics.allan.reference_noise
    lower_deg, most_deg2 = noise.sigma_ref_lower_deg, noise.white_upper_deg2
    if lower_deg is not None and most_deg2 is not None and lower_deg > norm_deg:
        return _Excess(lower_deg ** 2 - norm_deg ** 2, most_deg2 - norm_deg ** 2,
                       f'its noise is at least {lower_deg:.3g} deg')
    return _find_rounding(e.columns.steps[1].step_deg, norm_deg)


def _find_rounding(step_deg: float | None, norm_deg: float) -> _Excess | None:
    """Return the excess of rounding to a step; None if there is none."""
    rounding_deg2 = (step_deg or 0.0) ** 2 / 12.0
    excess_deg2 = rounding_deg2 - norm_deg ** 2
    if excess_deg2 <= 0.0:
        return None
    return _Excess(excess_deg2, excess_deg2, f'it reports in steps of {step_deg:g} '
                   f'deg, which alone are {rounding_deg2 ** 0.5:.2g} deg')


def _judge(e: Examined) -> Finding:
    excess, norm_deg = _find_excess(e), e.limits.sigma_ref_max_deg
    if excess is None and (claimed := _find_claimed(e, norm_deg)) is not None:
        return _weigh_claim(e, claimed)
    if excess is None:
        lower_deg = e.diagnostics.allan.reference_noise.sigma_ref_lower_deg
        if lower_deg is None:
            return REFERENCE.find(NOT_TESTABLE, '', 'the ship is never quiet enough to show the '
                                  'noise of the RS')
        return REFERENCE.find(HOLDS, '', f'the noise of the RS is at least {lower_deg:.3g} deg, '
                              f'its norm is {norm_deg:.3g} deg')
    return _weigh(e, excess)


def _find_claimed(e: Examined, norm_deg: float) -> _Excess | None:
    """Return by how much the RS itself says that it exceeds its norm; None if it does not."""
    claim_deg = None if e.quality is None else e.quality.claimed_of_rs_deg
    if claim_deg is None or claim_deg <= norm_deg:
        return None
    excess_deg2 = claim_deg ** 2 - norm_deg ** 2
    return _Excess(excess_deg2, excess_deg2, f'it claims {claim_deg:.3g} deg')


def _weigh_claim(e: Examined, claimed: _Excess) -> Finding:
    """Judge a claim that contradicts the norm by what it could change: a claim proves nothing."""
    norm_deg = e.limits.sigma_ref_max_deg
    words = f'the RS contradicts its norm of {norm_deg:.3g} deg: {claimed.words}'
    if _decides(e, claimed):
        return REFERENCE.find(DOUBTFUL, words,
                              f'{words}; without the excess the outcome might differ')
    return REFERENCE.find(HOLDS, '', f'{words}; the outcome is the same without the excess')


def _settle(finding: Finding | None, account: RunAccount) -> Finding | None:
    """Judge the step of the RS by the changes of value that it sent: interpolation hides it."""
    excess = _find_rounding(account.step_deg('rs'), account.limits.sigma_ref_max_deg)
    if finding is None or finding.effect == VOID or excess is None:
        return finding
    weighed = _weigh(account, excess)
    return weighed if weighed.effect == VOID or finding.effect != HOLDS else finding


def _weigh(e: Examined | RunAccount, excess: _Excess) -> Finding:
    """Judge an excess by what it could change."""
    norm_deg = e.limits.sigma_ref_max_deg
    evidence = f'the RS breaks its norm of {norm_deg:.3g} deg: {excess.words}'
    if _decides(e, excess):
        return REFERENCE.find(VOID, f'the RS breaks its norm of {norm_deg:.3g} deg',
                              f'{evidence}; without the excess the outcome might differ')
    return REFERENCE.find(HOLDS, '', f'{evidence}; the outcome is the same without the excess')


def _decides(e: Examined | RunAccount, excess: _Excess) -> bool:
    """Tell whether the outcome might differ with an RS that meets its norm."""
    lower_deg2, upper_deg2 = e.guarded.lower_bound_deg2, e.guarded.upper_bound_deg2
    if e.outcome is Outcome.COMPLIANT or lower_deg2 is None or upper_deg2 is None:
        return False
    if e.outcome is Outcome.NON_COMPLIANT:
        return lower_deg2 - excess.most_deg2 <= e.limits.rejection_limit_deg2
    return upper_deg2 - excess.least_deg2 <= e.limits.tightened_limit_deg2 < upper_deg2


REFERENCE = Condition(
    name='reference',
    holds='the RS shows no more noise than its norm allows',
    void='void: the RS breaks its own norm, and that decides the outcome',
    void_when='the noise of the RS, as both headings show it, or the step in which it reports '
              'exceeds its norm, and with the excess taken off the outcome would differ',
    void_why='the paper compares with an RS within its norm: what the RS adds is not an error of '
             'the TS',
    doubtful_when='the RS claims a standard deviation above its norm, as the median over the '
                  'run, and with the excess taken off the outcome would differ',
    judge=_judge, settle=_settle, is_permanent=True)
