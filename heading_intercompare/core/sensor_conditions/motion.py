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

"""The condition that no heading contradicts the motion of the ship."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from heading_intercompare.core.angles import circular_mean, wrap180
from heading_intercompare.core.conditions.partings import cut_spans
from heading_intercompare.core.motion.motion_check import MotionCheck
from heading_intercompare.core.motion.motion_words import describe_motion, explain_motion
from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.utc_text import utc_span
from heading_intercompare.core.validity.condition import (
    Condition,
    DOUBTFUL,
    Finding,
    HOLDS,
    NOT_TESTABLE,
    VOID,
    worst_effect,
)
from heading_intercompare.core.validity.examined import Examined


def _judge(e: Examined) -> Finding | None:
    """Judge the headings by the motion of the ship: it never makes an outcome better."""
    check = e.motion
    if check is None:
        return None
    words, evidence = describe_motion(check), explain_motion(check)
    if check.kind == 'not_testable':
        return MOTION.find(NOT_TESTABLE, '', evidence)
    if check.kind == 'agrees':
        return MOTION.find(HOLDS, '', f'no heading contradicts the motion: {evidence}')
    # A TS that alone is wrong is not acquitted of its other errors. If the comparison is void
    # anyway, the motion still names the sensor that is wrong.
    is_rejected = e.outcome is Outcome.NON_COMPLIANT and worst_effect(e.findings) != VOID
    if check.whose == 'rs' and is_rejected:
        return _judge_wrong_reference(e, check, evidence)
    stands = is_rejected and check.whose == 'ts'
    effect = DOUBTFUL if check.kind == 'doubt' or stands else VOID
    return MOTION.find(effect, words, evidence)


def _judge_wrong_reference(e: Examined, check: MotionCheck, evidence: str) -> Finding:
    """Judge a rejection by an RS that alone contradicts the motion, perhaps for a while."""
    c = e.columns
    legs = check.find_wrong_legs('rs')
    if not legs:
        return MOTION.find(DOUBTFUL if check.kind == 'doubt' else VOID, describe_motion(check),
                           evidence)
    if check.rs.kind == 'off':
        # It may point right on other legs.
        off_deg, _ = circular_mean(np.array([leg.off_deg for leg in legs]))
        check = replace(check, rs=replace(check.rs, off_deg=float(wrap180(off_deg))))
    spans_ns = [(leg.start_ns, leg.end_ns) for leg in legs]
    # Between two such legs the ship turned, and the RS was wrong there, too.
    spans_ns += [(parting.start_ns, parting.end_ns) for parting in c.partings
                 if any(parting.start_ns <= end_ns and start_ns <= parting.end_ns
                        for start_ns, end_ns in spans_ns)]
    words = describe_motion(check) + ', ' + utc_span(
        min(start_ns for start_ns, _ in spans_ns), max(end_ns for _, end_ns in spans_ns))
    rest = e.decide(*cut_spans(c.stamp_ns, c.x_deg, spans_ns))
    if check.kind == 'doubt' and rest is e.outcome:
        return MOTION.find(DOUBTFUL, f'{words}; without these legs also {rest.words}',
                           f'{evidence}; without these legs the outcome is the same')
    return MOTION.find(VOID, f'{words}; without these legs {rest.words}',
                       f'{evidence}; without these legs the outcome is {rest.words}')


MOTION = Condition(
    name='motion',
    holds='no heading contradicts the motion of the ship',
    void='void: a heading contradicts the motion of the ship',
    void_when='a heading contradicts the motion of the ship: it points off the course over ground '
              'by more than leeway and current explain for half of the time underway, turns '
              'against the course or the rate of turn, or does not turn with them; unless the TS '
              'alone does so and is rejected; or the RS alone does so for a shorter time, and '
              'without these legs the TS is not rejected',
    void_why='the headings are grossly wrong, also if both are wrong together '
             '([how](howto/check_against_motion.md))',
    doubtful_when='a heading points off the course for a shorter time; or neither heading follows '
                  'the rate of turn, which may itself be wrong; or a TS that is rejected '
                  'contradicts the motion, too',
    judge=_judge, is_permanent=True, weighs_others=True, watched_by=('motion',))
