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

"""The runs that were judged, by day."""

from __future__ import annotations

import math

import pytest

from heading_intercompare.core.outcome import Outcome
from heading_intercompare.messages.status_messages import OK, Status
from heading_intercompare.web.bridge.bridge_records import Tone
from heading_intercompare.web.bridge.judged_runs import group_by_day, list_runs

S = 1_000_000_000
#: 2023-11-14 22:13:20 UTC.
T0 = 1_700_000_000 * S
DAY = 86_400 * S


def run(number, end_ns, outcome=Outcome.COMPLIANT, validity='holds', n=100, mean=0.1, std=0.2):
    return Status(f'run {number}', OK, 'why', {
        'outcome': outcome, 'validity': validity, 'n': str(n), 'start_ns': str(end_ns - 600 * S),
        'end_ns': str(end_ns), 'mean_deg': str(mean), 'std_deg': str(std)})


def days(*runs):
    return group_by_day(list_runs(runs))


def test_the_runs_stand_under_the_day_on_which_they_ended_the_newest_first():
    listed = days(run(1, T0), run(2, T0 + 6000 * S), run(3, T0 + 7000 * S), run(4, T0 + 2 * DAY))
    assert [(day.date, [r.number for r in day.runs]) for day in listed] == [
        ('2023-11-16', [4]), ('2023-11-15', [3]), ('2023-11-14', [2, 1])]


def test_the_figures_of_a_day_are_those_of_one_record():
    day, = days(run(1, T0, n=100, mean=0.1, std=0.2), run(2, T0 + S, n=300, mean=0.5, std=0.4))
    assert (day.n, day.mean_deg) == (400, pytest.approx(0.4))
    assert day.std_deg == pytest.approx(math.sqrt(
        (100 * (0.04 + 0.09) + 300 * (0.16 + 0.01)) / 400))


def test_a_void_run_counts_for_the_verdict_of_its_day_and_not_for_its_figures():
    day, = days(run(1, T0), run(2, T0 + S, Outcome.INDETERMINATE, 'void', mean=90.0, std=50.0))
    assert (day.n, day.mean_deg, day.std_deg) == (100, 0.1, pytest.approx(0.2))
    assert (day.word, day.tone) == ('INDETERMINATE, VOID', Tone.DOUBT)


def test_a_day_without_sound_runs_has_no_figures():
    day, = days(run(1, T0, Outcome.INDETERMINATE, 'void'))
    assert (day.n, day.mean_deg, day.std_deg) == (0, None, None)


@pytest.mark.parametrize('outcomes, tone', [
    ((Outcome.COMPLIANT, Outcome.NON_COMPLIANT), Tone.BAD),
    ((Outcome.COMPLIANT, Outcome.INDETERMINATE), Tone.DOUBT),
    ((Outcome.COMPLIANT, Outcome.COMPLIANT), Tone.GOOD)])
def test_a_day_is_as_bad_as_its_worst_run(outcomes, tone):
    day, = days(*(run(number, T0 + number * S, outcome)
                  for number, outcome in enumerate(outcomes, 1)))
    assert day.tone is tone
