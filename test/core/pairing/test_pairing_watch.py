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

"""The health of a live pairing: share, offset and words."""

from __future__ import annotations

import numpy as np
import pytest

from heading_intercompare.core.pairing.pairer import Pairer
from heading_intercompare.core.pairing.pairing_watch import PairingState, PairingWatch
from heading_intercompare.core.records import Headings
from heading_intercompare.core.settings import Settings

S = 10 ** 9
T0 = 1_700_000_000 * S


def watch(stamps_of, seconds, **rule):
    """
    Pair two streams live, a chunk a second; return the state after each second.

    `stamps_of(second)` returns the stamps of both sensors in that second.
    """
    settings = Settings.from_mapping({f'pairing.{k}': v for k, v in rule.items()})
    pairer, watcher, states = Pairer(settings), PairingWatch(settings.pairing), []
    for second in range(seconds):
        ts, rs = (Headings.of(s, np.zeros(len(s))) for s in stamps_of(second))
        pairer.update(ts, rs, now_s=float(second))
        states.append(watcher.look(pairer.ledger, *pairer.heard_ns, float(second)))
    return states


def at_10_hz(second, offset_s=0.0):
    """Return the stamps of a second."""
    return T0 + second * S + np.arange(10) * S // 10 + round(offset_s * S)


@pytest.mark.parametrize('method', ['auto', 'interpolate', 'interpolate_ts', 'nearest'])
@pytest.mark.parametrize('offset_s', [3600.0, -3600.0])
def test_a_clock_an_hour_off_is_told_within_seconds(method, offset_s):
    states = watch(lambda s: (at_10_hz(s, offset_s), at_10_hz(s)), 30, method=method)
    assert states[-1] == PairingState(
        0.0, offset_s, 'the stamps of TS and RS lie 3600.0 s apart: nothing can be paired')
    assert [bool(state.trouble) for state in states].index(True) == 7


@pytest.mark.parametrize('method', ['auto', 'interpolate', 'interpolate_ts', 'nearest'])
@pytest.mark.parametrize('rs_hz', [1, 10])
def test_sound_sensors_are_never_warned_of(method, rs_hz):
    """With a slow RS nine of ten TS readings have no pair of their own, as they should."""
    states = watch(lambda s: (at_10_hz(s), at_10_hz(s)[::10 // rs_hz]), 200, method=method,
                   tolerance_s=0.01)
    assert {state.trouble for state in states} == {''}
    assert states[-1].paired_share == pytest.approx(1.0, abs=0.05)


def test_a_sensor_that_comes_late_is_not_warned_of():
    def stamps_of(second):
        return at_10_hz(second), at_10_hz(second) if second >= 90 else []
    states = watch(stamps_of, 200)
    assert {state.trouble for state in states} == {''}
    assert states[50] == PairingState(None, None, '')


def test_a_clock_that_steps_in_the_trial_is_told_within_a_minute():
    """100 s after the start of the trial the TS clock goes an hour ahead."""
    states = watch(lambda s: (at_10_hz(s, 3600.0 if s >= 100 else 0.0), at_10_hz(s)), 200)
    troubled = [second for second, state in enumerate(states) if state.trouble]
    assert troubled == list(range(troubled[0], 200)) and 150 < troubled[0] <= 161
    assert states[-1].trouble == (
        'the stamps of TS and RS lie 3600.0 s apart: nothing can be paired')


def test_pairs_that_are_few_for_another_reason_are_told_with_the_offset():
    """Nearest stamps 0.04 s apart, and a tolerance of 0.01 s."""
    states = watch(lambda s: (at_10_hz(s, 0.04), at_10_hz(s)), 30, method='nearest',
                   tolerance_s=0.01)
    assert states[-1].trouble == ('only 0 % of the readings of the last minute are paired; '
                                  'the stamps of TS and RS lie 0.04 s apart')


def test_the_last_minute_forgets():
    """The RS clock is an hour off for 100 s, then right; a minute later all is well."""
    states = watch(lambda s: (at_10_hz(s), at_10_hz(s, -3600.0 if s < 100 else 0.0)), 240,
                   method='interpolate')
    assert states[99].trouble and not states[120].trouble
    assert states[-1].paired_share == pytest.approx(1.0, abs=0.05)


def test_silent_sensors_have_no_share():
    states = watch(lambda s: (at_10_hz(s), at_10_hz(s)) if s < 20 else ([], []), 100)
    assert states[-1] == PairingState(None, 0.0, '')
