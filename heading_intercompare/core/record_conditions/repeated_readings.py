#!/usr/bin/env python3
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
"""The condition that each reading counts once, in a run and among the runs of a trial."""

from __future__ import annotations

from heading_intercompare.core.conditions.shared_readings import find_repeats, Shared
from heading_intercompare.core.utc_text import utc
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


def _describe(shared: Shared) -> str:
    return (f'the differences from {utc(shared.other_ns)} UTC on are those from '
            f'{utc(shared.first_ns)} UTC on, for {shared.span_s:.0f} s (correlation '
            f'{shared.correlation:.2f} of what the differences before do not tell)')


def _judge(e: Examined) -> Finding:
    fingerprint = e.columns.fingerprint
    if fingerprint is None:
        return REPEATED_READINGS.find(NOT_TESTABLE, '', 'there are too few readings')
    if worst_effect(e.findings) == VOID:
        return REPEATED_READINGS.find(NOT_TESTABLE, '', 'the run is void, and its differences may '
                                      'repeat the motion of the ship')
    shared = find_repeats(fingerprint)
    if shared is None:
        return REPEATED_READINGS.find(HOLDS, '', 'no stretch of some minutes comes twice')
    return REPEATED_READINGS.find(
        VOID, f'the readings from {utc(shared.first_ns)} UTC come again '
        f'at {utc(shared.other_ns)} UTC', _describe(shared))


def judge_repeated_runs(repeated: dict[int, tuple[int, Shared | None]]) -> Finding | None:
    """
    Judge the runs of a trial, of which some hold the readings of an earlier one.

    Parameters
    ----------
    repeated : dict of int to (int, Shared or None)
        By the number of a run that of the earlier one, and what they share; None for all.

    Returns
    -------
    Finding or None
        None if no run does.

    """
    if not repeated:
        return None
    pairs = [f'{earlier} and {later}' for later, (earlier, _) in repeated.items()]
    words = (f'runs {", ".join(pairs[:3])}{" and others" if len(pairs) > 3 else ""} hold the same '
             'readings, which count once')
    shared = next((readings for _, readings in repeated.values() if readings is not None), None)
    return REPEATED_READINGS.find(DOUBTFUL, words, words if shared is None
                                  else f'{words}: {_describe(shared)}')


REPEATED_READINGS = Condition(
    name='repeated_readings',
    holds='each reading counts once',
    void='some minutes of the run come twice',
    void_when='the differences of two minutes or more come again in the run, also rounded or with '
              'an offset',
    void_why='the copy shows no more of the TS than the original, but counts as if it did',
    doubtful_when='runs of a trial hold the same readings: two recorders, or one record under two '
                  'dates; they count once, and with `campaign.rule: sensor` they certify nothing',
    judge=_judge,
    weighs_others=True)
