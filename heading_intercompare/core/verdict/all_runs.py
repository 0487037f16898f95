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

"""The verdict on all runs together."""

from __future__ import annotations

from dataclasses import replace
from typing import Sequence

from heading_intercompare.core.outcome import Outcome, worst
from heading_intercompare.core.record_conditions.left_out import judge_left_out
from heading_intercompare.core.settings import Settings

from .judge import compare_runs, conclude_campaign, RunResult
from .recorded import find_left_out
from .verdict_document import Input, Verdict

__all__ = ['join']


def join(results: Sequence[RunResult], settings: Settings,
         inputs: Sequence[Input] = (), *, incomplete: bool = False) -> Verdict:
    """
    Return the verdict on runs, and number them in the order given.

    Parameters
    ----------
    results : sequence of RunResult
        Runs of one input or of several.
    settings : Settings
        By which the runs were judged.
    inputs : sequence of Input
        The sources of the runs.
    incomplete : bool
        Whether an input could not be judged; then the verdict is never compliant.

    """
    runs = compare_runs(results)
    results = [r.place_among(at, runs) for at, r in enumerate(results, 1)]
    outcome, coverage, campaign = conclude_campaign(results, runs, settings, incomplete)
    left_out = find_left_out((piece for r in results for piece in r.pieces),
                             (r.left_out for r in results), settings)
    if left_out is not None:
        campaign = replace(campaign, validity=(*(campaign.validity or ()), judge_left_out(
            outcome, left_out, bool(settings.exclusions))))
    whole = Verdict.of([r.verdict for r in results], outcome, campaign, coverage, settings, inputs)
    whole = replace(whole, taken_out=left_out)
    if incomplete:
        whole = replace(whole, paper_outcome=worst([whole.paper_outcome, Outcome.INDETERMINATE]))
    return whole
