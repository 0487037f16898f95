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

"""Verdicts as messages."""

from __future__ import annotations

import numpy as np
from sailed_trials import sail

from heading_intercompare import analyze
from heading_intercompare.core.pipeline import Intercomparison
from heading_intercompare.core.records import Headings
from heading_intercompare.core.settings import Settings
from heading_intercompare.messages.status_messages import decode_statuses, ERROR, OK, WARN
from heading_intercompare.messages.verdict_messages import encode_verdict, TEST
from heading_intercompare.web.bridge.bridge_records import Tone
from heading_intercompare.web.bridge.judged_runs import list_tests


def test_a_verdict_says_what_was_found_and_why(verdict_of_two_runs):
    verdict = verdict_of_two_runs
    ns, (whole, *runs) = decode_statuses(encode_verdict(verdict, 10 ** 18))
    assert (ns, whole.message) == (10 ** 18, verdict.headline)
    assert whole.values['outcome'] == verdict.outcome.value
    assert whole.values['runs'] == '2'
    assert [run.message for run in runs] == [run.reason for run in verdict.runs]
    assert float(runs[0].values['variance_deg2']) == verdict.runs[0].variance_deg2


def test_each_test_of_the_norm_has_a_status_of_its_own():
    verdict = analyze(*sail(hours=1.0, step_deg=0.5), settings=Settings.of(
        preset='imo_msc116', sigma_ref_max_deg=0.1))
    _, (_, *statuses) = decode_statuses(encode_verdict(verdict, 0))
    levels = {status.name: status.level for status in statuses if status.name.startswith(TEST)}
    assert len(levels) == 6
    assert levels['test: transmission and resolution error'] == ERROR
    assert levels['test: amplitude of the dynamic error'] == OK
    assert levels['test: follow-up error from 10 to 20 deg/s'] == WARN
    status = next(status for status in statuses if 'resolution' in status.name)
    assert status.message == 'not met, 0.25 (0.25 .. 0.25), 0.2 deg, MSC.116(73) 4.3.2.1'
    assert status.values['state'] == 'not_met' and status.values['limit'] == '0.2'
    [seen] = [test for test in list_tests(statuses) if 'resolution' in test.words]
    assert (seen.words, seen.tone) == ('transmission and resolution error', Tone.BAD)
    assert seen.result == status.message and 'steps of 0.5 deg' in seen.notes


def test_a_non_compliant_verdict_is_an_error_and_a_compliant_one_is_not():
    settings = {'norms': {'sigma_max_deg': 0.01, 'sigma_ref_max_deg': 0.01}}
    stamps = np.arange(1, 2001) * 10 ** 9
    levels = []
    course_deg = 90.0 + 30.0 * np.sin(np.arange(2000) / 50.0)
    for amplitude_deg in (0.001, 5.0):
        comparison = Intercomparison(Settings.from_mapping(settings))
        noise_deg = np.random.default_rng(1).standard_normal((2, 2000))
        comparison.update(ts=Headings.as_sent(stamps, course_deg + amplitude_deg * noise_deg[0]),
                          rs=Headings.as_sent(stamps, course_deg + 0.001 * noise_deg[1]))
        comparison.finish()
        levels.append(decode_statuses(encode_verdict(comparison.verdict(), 0))[1][0].level)
    assert levels == [OK, ERROR]
