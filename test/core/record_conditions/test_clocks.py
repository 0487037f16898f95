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

"""What a clock that was set back adds to the finding on the clocks."""

from __future__ import annotations

import pytest

from heading_intercompare.core.decision.criteria import Limits
from heading_intercompare.core.decision.guarded import decide, Evidence
from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.pairing.ledger import LedgerSegment
from heading_intercompare.core.raw_streams.stamp_jumps import SetBack
from heading_intercompare.core.record_conditions.clocks import CLOCKS
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.validity.condition import DOUBTFUL, HOLDS, VOID
from heading_intercompare.core.validity.examined import RunAccount

SETTINGS = Settings.from_mapping({'norms': {'sigma_max_deg': 0.3, 'sigma_ref_max_deg': 0.1}})
DRIFT = 'the clocks drift apart by 2 s/h'
STEP = 'the clock of the TS was set back by 60.0 s at 2001-09-09 01:46:40.000 UTC'


def settle(effect, words, *stamps_ns):
    """Return the finding on the clocks of a run in which the TS was set back at these stamps."""
    steps = tuple(SetBack('ts', stamp_ns, 60 * 10 ** 9) for stamp_ns in stamps_ns)
    limits = Limits.of(SETTINGS.norms, SETTINGS.model)
    guarded = decide(Evidence(0, None, None, 0.0, 0.0, 0, 0, 0.0), limits, SETTINGS.risk)
    account = RunAccount(Outcome.COMPLIANT, guarded, limits, SETTINGS, lost_share=None,
                         interpolated=None, share=LedgerSegment(None, {}, steps))
    return CLOCKS.settle(CLOCKS.find(effect, words, 'as seen'), account)


def test_a_void_run_stays_void_and_its_evidence_names_the_step():
    finding = settle(VOID, DRIFT, 10 ** 18)
    assert (finding.effect, finding.words) == (VOID, DRIFT)
    assert finding.evidence == f'{STEP}; the run ends there; as seen'


@pytest.mark.parametrize('effect, words, expected', [
    (HOLDS, '', STEP), (DOUBTFUL, 'a skew decides', f'{STEP}; a skew decides')])
def test_a_step_makes_a_run_doubtful_before_its_other_doubts(effect, words, expected):
    finding = settle(effect, words, 10 ** 18)
    assert (finding.effect, finding.words) == (DOUBTFUL, expected)


def test_many_steps_are_counted_after_the_first():
    words = settle(HOLDS, '', *(10 ** 18 + n for n in range(9))).words
    assert words.count('was set back') < 9
    assert words.endswith('clocks were set back 9 times in all')


def test_without_a_step_the_finding_stays_as_it_is():
    assert settle(VOID, DRIFT).evidence == 'as seen'
