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

"""The condition that the clocks of the sensors agree."""

from __future__ import annotations

from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.timing.clock_drift import ClockDrift, estimate_clock_drift
from heading_intercompare.core.utc_text import utc
from heading_intercompare.core.validity.condition import (
    Condition,
    DOUBTFUL,
    Finding,
    HOLDS,
    NOT_TESTABLE,
    VOID,
)
from heading_intercompare.core.validity.examined import Examined, RunAccount

_UNSEEN = 'readings of different times do not show whether both come from one sensor'
_MOST_NAMED = 3
#: A skew of less than this many standard uncertainties is no news of an open run: in hundreds of
#: sound runs one has it by chance.
_SURE_SIGMAS = 4.0


def _judge(e: Examined) -> Finding:
    if e.settings.alignment.skew == 'off':
        return CLOCKS.find(NOT_TESTABLE, '', 'latency and clock offset are not estimated '
                           '(alignment.skew off)')
    c, estimate = e.columns, e.columns.skew
    apart_s = estimate.apart_s
    clock = estimate_clock_drift(
        c.stamp_ns, c.x_deg, c.rs_deg, range_s=e.settings.alignment.skew_range_s,
        max_gap_s=e.settings.pairing.longest_gap_s, near_s=estimate.about_s, tracks=c.tracks)
    if clock.kind in ('drifting', 'stepped'):
        words, evidence = _describe_unsteady(clock, int(c.stamp_ns[0]))
        if apart_s is not None:
            words = f'{_describe_apart(e, apart_s)}; {words}'
            evidence = f'the clocks lie {abs(apart_s):.1f} s apart; {evidence}'
        t = (c.stamp_ns - c.stamp_ns[0]) / 1e9
        steady = e.decide_without_skew(clock.late_s(t))
        if steady is not e.outcome:
            return CLOCKS.find(VOID, words,
                           f'{evidence}; with this removed the outcome is {steady.words}')
        if apart_s is not None and e.outcome is not Outcome.NON_COMPLIANT:
            return CLOCKS.find(VOID, words, f'{evidence}; {_UNSEEN}')
        return CLOCKS.find(HOLDS, '', f'{evidence}; the outcome is the same without this')
    if estimate.kind == 'beyond' and estimate.beyond_s is not None:
        return _judge_beyond(e, estimate.beyond_s)
    if not estimate.well_determined or estimate.skew_s is None:
        return CLOCKS.find(NOT_TESTABLE, '', estimate.why_not(
            e.settings.alignment.skew_range_s))
    figures = (f'the latency or clock offset is {estimate.skew_s:.3f} s (standard uncertainty '
               f'{estimate.u_s:.3f} s)')
    if not estimate.significant or (
            e.outcome is Outcome.INDETERMINATE and estimate.u_s is not None
            and abs(estimate.skew_s) < _SURE_SIGMAS * estimate.u_s):
        return CLOCKS.find(HOLDS, '', figures)
    words = f'a latency or clock offset of {estimate.skew_s:.2f} s decides, without it'
    return _weigh_skew(e, estimate.skew_s, words, figures)


def _settle(finding: Finding | None, account: RunAccount) -> Finding | None:
    """Add the clocks that were set back within the run."""
    set_backs = () if account.share is None else account.share.set_backs
    if finding is None or not set_backs:
        return finding
    steps = [str(set_back) for set_back in set_backs]
    if len(steps) > _MOST_NAMED:
        steps[_MOST_NAMED:] = [f'clocks were set back {len(steps)} times in all']
    evidence = '; '.join((*steps, 'the run ends there', finding.evidence))
    if finding.effect == VOID:
        return CLOCKS.find(VOID, finding.words, evidence)
    words = '; '.join(filter(None, (*steps, finding.words)))
    return CLOCKS.find(DOUBTFUL, words, evidence)


def _describe_unsteady(clock: ClockDrift, start_ns: int) -> tuple[str, str]:
    """Describe the change of the skew, in a few words and with the figures."""
    if clock.kind == 'drifting' and clock.interval_s_per_h is not None:
        words = f'the clocks drift apart by {clock.slope_s_per_h:.2g} s/h'
        return words, (f'{words} (95 % interval {clock.interval_s_per_h[0]:.2g} to '
                       f'{clock.interval_s_per_h[1]:.2g})')
    sizes = [(step.after_s - step.before_s, start_ns + round(step.time_s * 1e9))
             for step in clock.steps]
    size, at_ns = max(sizes, key=lambda step: abs(step[0]))
    steps = ', '.join(f'by {size:.2f} s at {utc(at)} UTC' for size, at in sizes)
    return (f'the latency or clock offset changes by {size:.2g} s at {utc(at_ns)} UTC',
            f'the latency or clock offset steps {steps}; before that it is '
            f'{clock.steps[0].before_s:.2f} s')


def _describe_apart(e: Examined, skew_s: float) -> str:
    """Say which clock lags, by how much, and which setting mends that."""
    known_s, also_s = e.settings.alignment.skew_s, e.columns.skew.also_s
    also = '' if also_s is None else f', or {known_s + also_s:.1f}: the motion repeats itself'
    return (f'the clock of the {"RS" if skew_s > 0.0 else "TS"} lags by about {abs(skew_s):.1f} s '
            f'(alignment.skew_s = {known_s + skew_s:.1f} mends it{also})')


def _judge_beyond(e: Examined, skew_s: float) -> Finding:
    """Judge a skew beyond the range, at which the differences scatter least."""
    range_s = e.settings.alignment.skew_range_s
    estimate = e.columns.skew
    if estimate.apart_s is not None:
        words = _describe_apart(e, skew_s)
        evidence = f'{words}: {estimate.why_not(range_s)}'
        if e.outcome is not Outcome.NON_COMPLIANT and e.decide_without_skew(skew_s) is e.outcome:
            return CLOCKS.find(VOID, words, f'{evidence}; {_UNSEEN}')
        return _weigh_skew(e, skew_s, f'{words}, without that', evidence, VOID)
    words = (f'the TS may be {"late" if skew_s > 0.0 else "early"} by about {abs(skew_s):.1f} s, '
             'beyond alignment.skew_range_s')
    evidence = (f'the clocks may be off by more than {range_s:g} s (alignment.skew_range_s): '
                f'the differences scatter least with a clock offset of about {skew_s:.1f} s, '
                f'which alignment.skew_s = {e.settings.alignment.skew_s + skew_s:.1f} removes')
    if e.outcome is Outcome.COMPLIANT:
        return CLOCKS.find(DOUBTFUL, words, f'{evidence}; {_UNSEEN}')
    return _weigh_skew(e, skew_s, f'{words}, without that', evidence)


def _weigh_skew(e: Examined, skew_s: float, words: str, evidence: str,
                effect: str = DOUBTFUL) -> Finding:
    """Judge a constant skew by what it could change; `words` lead to the other outcome."""
    aligned = e.decide_without_skew(skew_s)
    if aligned is e.outcome:
        return CLOCKS.find(HOLDS, '', f'{evidence}; the outcome is the same without it')
    return CLOCKS.find(effect, f'{words} {aligned.words}',
                   f'{evidence}; with it removed the outcome is {aligned.words}')


CLOCKS = Condition(
    name='clocks',
    holds='the clocks of the sensors agree',
    void='void: the clocks of the sensors lie minutes apart, or drift apart or step, and that '
         'decides the outcome',
    void_when='the clocks drift apart, or one steps, and without that the outcome would differ; '
              'or they lie more than a minute apart, unless the TS is rejected with that removed, '
              'too: the headline says which lags, by how much, and which setting mends it',
    void_why='the difference compares two moments',
    doubtful_when='a constant latency or clock offset is significant, and without it the outcome '
                  'would differ: the headline gives both outcomes; or it is beyond '
                  '`alignment.skew_range_s` (up to 60 s), and the run complies or would differ: '
                  'the headline says by how much; or a clock was set back: the headline says '
                  'which, by how much and when',
    judge=_judge, settle=_settle, is_permanent=True, watched_by=('clock_step',))
