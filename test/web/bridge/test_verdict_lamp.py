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

"""The state lamp: only verdicts that were given."""

from __future__ import annotations

import pytest

from heading_intercompare.messages.status_messages import Status
from heading_intercompare.web.bridge.bridge_records import Tone
from heading_intercompare.web.bridge.verdict_lamp import light_lamp

S = 10 ** 9
T0 = 1_700_000_000 * S
LOOK_NS = T0 + 1620 * S


def whole(outcome, runs=1, validity='holds'):
    return Status('verdict', 0, f'headline of {outcome}',
                  {'outcome': outcome, 'validity': validity, 'runs': str(runs)})


def run(number, end_ns):
    return Status(f'run {number}', 0, 'reason', {'end_ns': str(end_ns)})


def look(outcome, validity='holds'):
    return Status('run in progress', 0, 'reason', {
        'look': '2', 'looks': '3', 'outcome': outcome, 'validity_effect': validity,
        'headline': f'look says {outcome}'})


def test_without_a_verdict_the_lamp_says_when_the_next_look_is():
    lamp = light_lamp([], 0, LOOK_NS)
    assert (lamp.word, lamp.tone, lamp.what) == ('NONE YET', Tone.NONE, 'next look 22:40 UTC')
    assert light_lamp([], 0, None).what == 'at the end of the run'
    for look_ns, ends_ns, words in ((None, LOOK_NS, 'the run ends 22:40 UTC'),
                                    (LOOK_NS, LOOK_NS + 1, 'next look 22:40 UTC'),
                                    (LOOK_NS + 3600 * S, LOOK_NS, 'the run ends 22:40 UTC')):
        assert light_lamp([], 0, look_ns, ends_ns).what == words


def test_a_verdict_on_no_run_is_none():
    assert light_lamp([whole('indeterminate', runs=0)], T0, None).word == 'NONE YET'


@pytest.mark.parametrize('outcome, tone', [
    ('compliant', Tone.GOOD), ('indeterminate', Tone.DOUBT), ('non_compliant', Tone.BAD),
    ('made up', Tone.DOUBT)])
def test_the_end_of_a_run_gives_its_outcome_and_time(outcome, tone):
    lamp = light_lamp([whole(outcome), run(1, T0)], T0 + 5 * S, None)
    assert (lamp.tone, lamp.given_ns, lamp.what) == (tone, T0, 'end of run 1')
    assert lamp.headline == f'headline of {outcome}'


def test_a_look_gives_its_outcome():
    lamp = light_lamp([whole('indeterminate', runs=0), look('compliant')], T0, LOOK_NS)
    assert (lamp.word, lamp.tone, lamp.given_ns) == ('COMPLIANT', Tone.GOOD, T0)
    assert (lamp.what, lamp.headline) == ('look 2 of 3', 'look says compliant')


@pytest.mark.parametrize('validity', ['doubtful', 'void'])
def test_a_doubtful_acceptance_is_not_good_and_says_so(validity):
    for statuses in ([whole('compliant', validity=validity), run(1, T0)],
                     [look('compliant', validity)]):
        lamp = light_lamp(statuses, T0, None)
        assert lamp.tone is Tone.DOUBT and lamp.word == f'COMPLIANT, {validity.upper()}'


def test_a_good_look_does_not_excuse_an_earlier_run():
    lamp = light_lamp([whole('non_compliant', 2), run(2, T0), look('compliant')], T0 + S, None)
    assert (lamp.word, lamp.tone) == ('NON-COMPLIANT', Tone.BAD)
    assert lamp.what == 'end of run 2, all 2 together'
