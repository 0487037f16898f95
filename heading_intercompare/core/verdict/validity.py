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

"""
The conditions under which a comparison of two sensors is valid, and their effect on a verdict.

Each condition is judged in one place, here: from evidence to an effect and its words. A condition
counts by what it could change, not by its significance: in twelve hours everything is significant.
"""

from __future__ import annotations

from dataclasses import dataclass
import math
from typing import Callable, Iterable, Sequence

import numpy as np

from heading_intercompare.core.decision.criteria import Limits
from heading_intercompare.core.diagnostics.run_diagnostics import Diagnostics
from heading_intercompare.core.motion.motion_check import MotionCheck
from heading_intercompare.core.motion.motion_words import describe_motion, explain_motion
from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.pairing.stamp_jumps import SetBack
from heading_intercompare.core.records import Reals
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.timing.clock_drift import ClockDrift
from heading_intercompare.core.timing.realignment import realign
from heading_intercompare.core.utc_text import utc

from .prepare import PreparedRun

__all__ = ['add_set_backs', 'CONDITIONS', 'DOUBTFUL', 'examine', 'Examined', 'Finding', 'gravest',
           'HOLDS', 'is_doubtful', 'NOT_TESTABLE', 'VOID', 'VOID_REASONS', 'worst_effect']

HOLDS, NOT_TESTABLE, DOUBTFUL, VOID = 'holds', 'not_testable', 'doubtful', 'void'

VOID_REASONS = {
    'void.same_source': 'void: TS and RS show the same noise or glitches, so both may come '
                        'from one sensor',
    'void.convention': 'void: the sensors report headings by different conventions, or the wrap '
                       'splits the differences',
    'void.mean_difference': 'void: the mean difference is too large for sensors mounted parallel, '
                            'and the stated installation angle does not explain it',
    'void.motion': 'void: a heading contradicts the motion of the ship',
    'void.frozen': 'void: a sensor repeats its value while the other shows that the ship turns',
    'void.clocks': 'void: the clocks of the sensors lie minutes apart, or drift apart or step, '
                   'and that decides the outcome',
    'void.interpolation': 'void: the slower sensor is too slow for the motion, and that decides '
                          'the outcome',
    'void.losses': 'void: too many readings of the run are lost, rejected or without partner',
}
"""Reasons why a run is void: code and words."""

CONDITIONS = ('same_source', 'motion', 'convention', 'mean_difference', 'frozen', 'standstill',
              'outliers', 'clocks', 'interpolation', 'losses')
"""
All conditions; the first one that makes a run void names the reason.

A run has a finding on `motion` only if the motion of the ship is known.
"""

_RANK = {HOLDS: 0, NOT_TESTABLE: 0, DOUBTFUL: 1, VOID: 2}

_NO_NOISE = {
    'too_short': 'the run is too short to compare the noise of TS and RS',
    'too_slow': 'readings more than a second apart do not show noise above the motion',
    'no_rs_noise': 'the RS shows no noise of its own that could reveal a common source',
}

LARGE_SIGMAS = 3.0
"""A mean difference above this multiple of sigma_max is doubtful."""

_UNSEEN = 'readings of different times do not show whether both come from one sensor'

_YAWED_DEG = 5.0
_MOST_NAMED = 3

COVERED_SIGMAS = 3.0
"""A stated installation angle explains a mean difference within this many of its standard
uncertainties."""


@dataclass(frozen=True, slots=True)
class Finding:
    """
    The finding on one condition; keys of the JSON.

    Attributes
    ----------
    condition : str
        One of `CONDITIONS`.
    effect : {'holds', 'doubtful', 'void', 'not_testable'}
        'doubtful': the outcome stands, and the headline says why it is doubtful. 'void': the run
        says nothing about the TS. 'not_testable': these data cannot show whether the condition
        holds.
    words : str
        The finding in a few words, for a headline.
    evidence : str
        The figures, in a sentence.

    """

    condition: str
    effect: str
    words: str
    evidence: str


def worst_effect(findings: Iterable[Finding]) -> str:
    """Return the most serious effect of findings: 'holds', 'doubtful' or 'void'."""
    return gravest(f.effect for f in findings)


def is_doubtful(outcome: Outcome, effect: str | None) -> bool:
    """Tell whether a decision is in doubt; no decision, no doubt."""
    return outcome is not Outcome.INDETERMINATE and effect == DOUBTFUL


def gravest(effects: Iterable[str]) -> str:
    """Return the most serious of effects: 'holds', 'doubtful' or 'void'."""
    worst = max((_RANK[effect] for effect in effects), default=0)
    return (HOLDS, DOUBTFUL, VOID)[worst]


@dataclass(frozen=True, slots=True)
class Examined:
    """
    The data by which the conditions are judged.

    Attributes
    ----------
    data : PreparedRun
    found : Diagnostics
    limits : Limits
    settings : Settings
    outcome : Outcome
        Outcome of the run as it is.
    decide : callable
        ``decide(stamp_ns, x_deg, rs_factor=1.0)`` returns the outcome of other differences under
        the same rule. `rs_factor` is the factor by which interpolation reduced the variance of
        the RS noise.
    d_hat_deg2, lower_bound_deg2, upper_bound_deg2 : float or None
        The variance and its bounds.
    motion : MotionCheck or None
        The headings against the motion of the ship; None if it is unknown.

    """

    data: PreparedRun
    found: Diagnostics
    limits: Limits
    settings: Settings
    outcome: Outcome
    decide: Callable[..., Outcome]
    d_hat_deg2: float | None
    lower_bound_deg2: float | None
    upper_bound_deg2: float | None
    motion: MotionCheck | None = None


def examine(examined: Examined) -> tuple[Finding, ...]:
    """Return the findings of a run on all conditions except `losses`."""
    found = tuple(judge(examined) for judge in (
        _judge_same_source, _judge_convention, _judge_mean_difference, _judge_frozen,
        _judge_standstill, _judge_outliers, _judge_clocks, _judge_interpolation))
    if examined.motion is None:
        return found
    # It names the sensor that is wrong, which the conditions after it cannot.
    stands = examined.outcome is Outcome.NON_COMPLIANT and worst_effect(found) != VOID
    return found[0], _judge_motion(examined.motion, stands), *found[1:]


def _judge_same_source(e: Examined) -> Finding:
    source = e.found.signs.source
    noise, glitches = source.noise, source.glitches
    name, words = 'same_source', 'TS and RS look like one sensor'
    followed = f'the TS follows {glitches.followed} of {glitches.count} glitches of the RS'
    if noise.kind == 'common' and noise.band_hz is not None:
        return Finding(name, VOID, words, f'from {noise.band_hz[0]:.3g} to {noise.band_hz[1]:.3g} '
                       'Hz, above the motion of the ship, the TS follows the noise of the RS: '
                       f'coherence {noise.coherence:.2f}')
    if glitches.kind == 'common' and glitches.chance is not None:
        return Finding(name, VOID, words, f'{followed}, {glitches.delay_s:.3g} s later; chance '
                       f'would do this with a probability below {max(glitches.chance, 1e-99):.1g}')
    least = e.limits.m_low * e.limits.sigma_ref_max_deg
    if e.upper_bound_deg2 is not None and 0.0 < e.upper_bound_deg2 < least ** 2:
        return Finding(name, VOID, 'TS and RS differ by less than the RS alone should',
                       f'the difference scatters by at most {math.sqrt(e.upper_bound_deg2):.3g} '
                       f'deg, but by its norm the RS alone by at least {least:.3g} deg')
    if noise.kind == 'independent':
        return Finding(name, HOLDS, '', f'the noise of the RS, {noise.rs_noise_deg:.2g} deg, is '
                       f'not found in the TS: coherence {noise.coherence:.2f}')
    if glitches.kind == 'independent':
        return Finding(name, HOLDS, '', followed)
    if source.kind == 'suspected':
        # Two perfect sensors without noise do that too; real ones never do.
        effect = DOUBTFUL if noise.reason == 'no_rs_noise' else VOID
        return Finding(name, effect, 'one sensor twice, or two without error', 'the TS repeats '
                       f'the RS, reading by reading, and {_NO_NOISE[noise.reason]}')
    return Finding(name, NOT_TESTABLE, '', _NO_NOISE[noise.reason])


def _judge_convention(e: Examined) -> Finding:
    found = e.found.signs.convention
    if found.kind == 'not_testable':
        return Finding('convention', NOT_TESTABLE, '', 'there are no differences')
    if found.kind == 'offset':
        return Finding('convention', VOID, f'TS - RS is near {found.angle_deg:.0f} deg',
                       f'TS - RS is {found.angle_deg:.2f} deg: does one of them report yaw (ENU) '
                       'as heading, or is one mounted backwards?')
    if found.kind == 'mirrored':
        return Finding('convention', VOID, 'TS turns against RS', 'TS turns against RS, and their '
                       f'sum stays at {found.angle_deg:.1f} deg: one of them counts '
                       f'counter-clockwise{_add_late(found.turned_deg)}')
    mean = e.found.signs.mean
    if mean.is_torn(e.settings.wrap_center_deg):
        return Finding('convention', VOID, 'the differences lie on the seam of wrap_center_deg',
                       'the differences are wrapped to within 180 deg of '
                       f'{e.settings.wrap_center_deg:g} deg, which splits them: they lie '
                       f'about {mean.mean_deg:.2f} deg, {100.0 * mean.seam_share:.3g} % of them a '
                       'whole turn away from the others')
    if found.direction == 'not_testable':
        return Finding('convention', NOT_TESTABLE, '', 'the ship did not move enough to show '
                       'whether both count clockwise, or only in a swell, in which a skew looks '
                       'the same')
    return Finding('convention', HOLDS, '', 'TS turns with RS, by the same axes')


def _add_late(turned_deg: float) -> str:
    """Return the other explanation that remains if the ship only yawed."""
    return ', or is late by half a period of the yaw' if turned_deg < _YAWED_DEG else ''


def _judge_mean_difference(e: Examined) -> Finding:
    found, settings = e.found.signs.mean, e.settings
    name = 'mean_difference'
    if found.mean_deg is None:
        return Finding(name, NOT_TESTABLE, '', 'there is no mean difference')
    words = f'the mean difference is {found.mean_deg:.2f} deg'
    most = settings.detectors.mean_max_deg
    u_offset = settings.installation_offset_u_deg
    if abs(found.mean_deg) > max(most, COVERED_SIGMAS * u_offset):
        return Finding(name, VOID, words, f'{words}, above {most:g} deg, and the stated '
                       f'installation angle, {settings.installation_offset_deg:g} deg with a '
                       f'standard uncertainty of {u_offset:g} deg, does not explain it')
    if found.surely_exceeds(LARGE_SIGMAS * e.limits.sigma_max_deg):
        return Finding(name, DOUBTFUL, words, f'{words}, significantly above {LARGE_SIGMAS:g} '
                       f'sigma_max = {LARGE_SIGMAS * e.limits.sigma_max_deg:.3g} deg')
    return Finding(name, HOLDS, '', words)


def _judge_frozen(e: Examined) -> Finding:
    signs = e.found.signs
    if signs.ts_frozen.kind == 'not_testable':
        return Finding('frozen', NOT_TESTABLE, '', 'there are too few readings')
    for name, sign in (('TS', signs.ts_frozen), ('RS', signs.rs_frozen)):
        if sign.kind == 'frozen':
            return Finding(
                'frozen', VOID, f'the {name} froze', f'the {name} repeated its value '
                f'{sign.stretches} times while the other sensor turned, for '
                f'{sign.duration_s:.1f} s by {sign.other_moved_deg:.2f} deg '
                f'at {utc(sign.start_ns)} UTC')
        if sign.kind == 'dead':
            return Finding('frozen', VOID, f'the {name} sent one value for an hour',
                           f'the {name} sent one value for {sign.longest_s:.0f} s, although it '
                           'reports decimals')
    for name, sign in (('TS', signs.ts_frozen), ('RS', signs.rs_frozen)):
        if sign.kind == 'constant':
            lasted = f'for {sign.longest_s:.0f} s'
            never = sign.hold_s is None and sign.longest_s >= (
                int(e.data.stamp_ns[-1]) - int(e.data.stamp_ns[0])) / 1e9
            return Finding('frozen', DOUBTFUL, f'the {name} never changed its value' if never
                           else f'the {name} did not change its value {lasted}',
                           f'the {name} sent one value {lasted}, although it reports decimals, '
                           'and the other sensor did not')
    longest = max(signs.ts_frozen.longest_s, signs.rs_frozen.longest_s)
    return Finding('frozen', HOLDS, '', f'no value was repeated for more than {longest:.1f} s '
                   'while the other sensor turned' if longest else 'no value was repeated')


def _judge_standstill(e: Examined) -> Finding:
    found = e.found.signs.standstill
    if found.kind == 'not_testable':
        return Finding('standstill', NOT_TESTABLE, '', 'there are too few readings')
    ranges = (f'the headings range over {found.ts_range_deg:.3g} deg (TS) and '
              f'{found.rs_range_deg:.3g} deg (RS)')
    if found.kind == 'still':
        return Finding('standstill', DOUBTFUL, 'motion too small to tell', f'{ranges}: too '
                       'little to show whether the sensors work')
    return Finding('standstill', HOLDS, '', ranges)


def _judge_outliers(e: Examined) -> Finding:
    found = e.found.signs.outliers
    if found.kind == 'not_testable':
        return Finding('outliers', NOT_TESTABLE, '', 'there are too few differences')
    if found.kind == 'none':
        return Finding('outliers', HOLDS, '', 'no isolated difference stands out')
    largest = ', '.join(f'{o.size_deg:+.3g} deg at {utc(o.stamp_ns)} UTC'
                        for o in found.largest[:3])
    count = f'{found.count} isolated outlier{"s" if found.count != 1 else ""}'
    evidence = f'{count}, {100.0 * found.share:.3g} % of the variance: {largest}'
    without = e.decide(np.delete(e.data.stamp_ns, found.index),
                       np.delete(e.data.x_deg, found.index))
    if without is e.outcome:
        return Finding('outliers', HOLDS, '', f'{evidence}; the outcome is the same without them')
    return Finding('outliers', DOUBTFUL, f'{count} decide{"s" if found.count == 1 else ""}',
                   f'{evidence}; without them the outcome is {without}')


def _judge_clocks(e: Examined) -> Finding:
    if e.settings.alignment.skew == 'off':
        return Finding('clocks', NOT_TESTABLE, '', 'the skew is not estimated (alignment.skew '
                       'off)')
    estimate, clock = e.found.skew.estimate, e.found.signs.clock
    apart_s = estimate.apart_s
    if clock.kind in ('drifting', 'stepped'):
        words, evidence = _describe_unsteady(clock, e.data)
        if apart_s is not None:
            words = f'{_describe_apart(e, apart_s)}; {words}'
            evidence = f'the clocks lie {abs(apart_s):.1f} s apart; {evidence}'
        t = (e.data.stamp_ns - e.data.stamp_ns[0]) / 1e9
        steady = _decide_without(e, clock.late_s(t))
        if steady is not e.outcome:
            return Finding('clocks', VOID, words,
                           f'{evidence}; with this removed the outcome is {steady}')
        if apart_s is not None and e.outcome is not Outcome.NON_COMPLIANT:
            return Finding('clocks', VOID, words, f'{evidence}; {_UNSEEN}')
        return Finding('clocks', HOLDS, '', f'{evidence}; the outcome is the same without this')
    if estimate.kind == 'beyond' and estimate.beyond_s is not None:
        return _judge_beyond(e, estimate.beyond_s)
    if not estimate.well_determined or estimate.skew_s is None:
        return Finding('clocks', NOT_TESTABLE, '', estimate.why_not(
            e.settings.alignment.skew_range_s))
    figures = f'the skew is {estimate.skew_s:.3f} s (standard uncertainty {estimate.u_s:.3f} s)'
    if not estimate.significant:
        return Finding('clocks', HOLDS, '', figures)
    words = f'a skew of {estimate.skew_s:.2f} s decides, without it'
    return _weigh_skew(e, estimate.skew_s, words, figures)


def add_set_backs(finding: Finding, set_backs: Sequence[SetBack]) -> Finding:
    """
    Return the finding on the clocks with those that were set back.

    Parameters
    ----------
    finding : Finding
        The finding of `examine` on the condition `clocks`.
    set_backs : sequence of SetBack
        At least one, all within the run.

    """
    each = [str(one) for one in set_backs]
    if len(each) > _MOST_NAMED:
        each[_MOST_NAMED:] = [f'clocks were set back {len(each)} times in all']
    evidence = '; '.join((*each, 'readings with the repeated times are rejected',
                          finding.evidence))
    if finding.effect == VOID:
        return Finding('clocks', VOID, finding.words, evidence)
    words = '; '.join(filter(None, (*each, finding.words)))
    return Finding('clocks', DOUBTFUL, words, evidence)


def _describe_unsteady(clock: ClockDrift, data: PreparedRun) -> tuple[str, str]:
    """Describe the change of the skew, in a few words and with the figures."""
    if clock.kind == 'drifting' and clock.interval_s_per_h is not None:
        words = f'the clocks drift apart by {clock.slope_s_per_h:.2g} s/h'
        return words, (f'{words} (95 % interval {clock.interval_s_per_h[0]:.2g} to '
                       f'{clock.interval_s_per_h[1]:.2g})')
    sizes = [(step.after_s - step.before_s, int(data.stamp_ns[0]) + round(step.time_s * 1e9))
             for step in clock.steps]
    size, at_ns = max(sizes, key=lambda one: abs(one[0]))
    each = ', '.join(f'by {size:.2f} s at {utc(at)} UTC' for size, at in sizes)
    return (f'the skew changes by {size:.2g} s at {utc(at_ns)} UTC',
            f'the skew steps {each}; before that it is {clock.steps[0].before_s:.2f} s')


def _describe_apart(e: Examined, skew_s: float) -> str:
    """Say which clock lags, by how much, and which setting mends that."""
    known_s, also_s = e.settings.alignment.skew_s, e.found.skew.estimate.also_s
    also = '' if also_s is None else f', or {known_s + also_s:.1f}: the motion repeats itself'
    return (f'the clock of the {"RS" if skew_s > 0.0 else "TS"} lags by about {abs(skew_s):.1f} s '
            f'(alignment.skew_s = {known_s + skew_s:.1f} mends it{also})')


def _judge_beyond(e: Examined, skew_s: float) -> Finding:
    """Judge a skew beyond the range, at which the differences scatter least."""
    range_s = e.settings.alignment.skew_range_s
    estimate = e.found.skew.estimate
    if estimate.apart_s is not None:
        words = _describe_apart(e, skew_s)
        evidence = f'{words}: {estimate.why_not(range_s)}'
        if e.outcome is not Outcome.NON_COMPLIANT and _decide_without(e, skew_s) is e.outcome:
            return Finding('clocks', VOID, words, f'{evidence}; {_UNSEEN}')
        return _weigh_skew(e, skew_s, f'{words}, without that', evidence, VOID)
    words = (f'the TS may be {"late" if skew_s > 0.0 else "early"} by about {abs(skew_s):.1f} s, '
             'beyond alignment.skew_range_s')
    evidence = (f'the clocks may be off by more than {range_s:g} s (alignment.skew_range_s): '
                f'the differences scatter least with a skew of about {skew_s:.1f} s, which '
                f'alignment.skew_s = {e.settings.alignment.skew_s + skew_s:.1f} removes')
    if e.outcome is Outcome.COMPLIANT:
        return Finding('clocks', DOUBTFUL, words, f'{evidence}; {_UNSEEN}')
    return _weigh_skew(e, skew_s, f'{words}, without that', evidence)


def _weigh_skew(e: Examined, skew_s: float, words: str, evidence: str,
                effect: str = DOUBTFUL) -> Finding:
    """Judge a constant skew by what it could change; `words` lead to the other outcome."""
    aligned = _decide_without(e, skew_s)
    if aligned is e.outcome:
        return Finding('clocks', HOLDS, '', f'{evidence}; the outcome is the same without it')
    return Finding('clocks', effect, f'{words} {aligned}',
                   f'{evidence}; with it removed the outcome is {aligned}')


def _decide_without(e: Examined, late_s: float | Reals) -> Outcome:
    """
    Return the outcome with the RS read `late_s` earlier, which removes a skew.

    A compliant run stays compliant: a skew only adds to the variance.
    """
    if e.outcome is Outcome.COMPLIANT:
        return e.outcome
    return e.decide(*realign(e.data.stamp_ns, e.data.x_deg, e.data.rs_deg, late_s))


def _judge_interpolation(e: Examined) -> Finding:
    found, name = e.found.signs.interpolation, 'interpolation'
    if found.kind == 'none':
        return Finding(name, HOLDS, '', 'no reading is interpolated')
    if found.kind == 'not_testable' or found.upper_deg2 is None:
        return Finding(name, NOT_TESTABLE, '', 'these pairs do not show how much '
                       'interpolation adds')
    evidence = (f'interpolation adds {found.variance_deg2:.2g} deg2 to the variance, at most '
                f'{found.upper_deg2:.2g} deg2')
    if found.folded:
        evidence += '; the motion is so fast that the readings hardly show it'
    if _would_decide(e, found.upper_deg2, found.folded):
        return Finding(name, VOID, 'the slower sensor is too slow for the motion',
                       f'{evidence}: without this the outcome might differ')
    return Finding(name, HOLDS, '', f'{evidence}; the outcome is the same without this')


def _would_decide(e: Examined, added_deg2: float, folded: bool) -> bool:
    """Tell whether the outcome might differ without the variance that interpolation adds."""
    if e.lower_bound_deg2 is None or e.upper_bound_deg2 is None or not e.d_hat_deg2 \
            or e.outcome is Outcome.COMPLIANT:
        return False
    share = 0.0 if folded else max(0.0, 1.0 - added_deg2 / e.d_hat_deg2)
    if e.outcome is Outcome.NON_COMPLIANT:
        return share * e.lower_bound_deg2 <= e.limits.rejection_limit_deg2 < e.lower_bound_deg2
    return not folded and (share * e.upper_bound_deg2 <= e.limits.tightened_limit_deg2
                           < e.upper_bound_deg2)


def _judge_motion(found: MotionCheck, is_rejected: bool) -> Finding:
    """Judge the motion of the ship: it never makes an outcome better."""
    words, evidence = describe_motion(found), explain_motion(found)
    if found.kind == 'not_testable':
        return Finding('motion', NOT_TESTABLE, '', evidence)
    if found.kind == 'agrees':
        return Finding('motion', HOLDS, '', f'no heading contradicts the motion: {evidence}')
    # A TS that alone is wrong is not acquitted of its other errors.
    stands = is_rejected and found.whose == 'ts'
    effect = DOUBTFUL if found.kind == 'doubt' or stands else VOID
    return Finding('motion', effect, words, evidence)
