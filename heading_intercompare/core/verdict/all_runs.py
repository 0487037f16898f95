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
from typing import Collection, Sequence

from heading_intercompare.core.decision.campaign import (
    conclude_every_run,
    conclude_sensor,
    judge_together,
    Together,
)
from heading_intercompare.core.decision.coverage import Coverage, coverage_of
from heading_intercompare.core.decision.sequential import risk_at_the_end
from heading_intercompare.core.decision.taken_out import TakenOut
from heading_intercompare.core.norm_tests.judged_test import (
    find_not_met,
    JudgedTest,
    TestRisks,
)
from heading_intercompare.core.norm_tests.table import merge_tables
from heading_intercompare.core.outcome import Outcome, worst
from heading_intercompare.core.record_conditions.left_out import judge_left_out
from heading_intercompare.core.record_conditions.mean_over_runs import judge_mean_over_runs
from heading_intercompare.core.record_conditions.repeated_readings import judge_repeated_runs
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.statistics.stationarity import (
    examine_homogeneity,
    Homogeneity,
    RunFigures,
)
from heading_intercompare.core.validity.condition import Finding, VOID

from .judge import RunResult
from .recorded import find_left_out
from .runs_together import find_repeated_runs, shortest_apart_s
from .verdict_document import Campaign, Input, Verdict


def compare_runs(results: Sequence[RunResult]) -> Homogeneity:
    """Compare the means and variances of the runs with each other, repeated readings once."""
    repeated = find_repeated_runs(results)
    return examine_homogeneity([
        RunFigures(r.verdict.mean_deg, r.evidence.spread.mean_variance_deg2,
                   r.evidence.spread.d_deg2, r.evidence.spread.nu,
                   None if r.verdict.drift.order is None else r.verdict.drift.order.order)
        for number, r in enumerate(results, 1) if number not in repeated
        and r.evidence.spread is not None and r.verdict.mean_deg is not None])


def conclude_campaign(results: Sequence[RunResult], runs: Homogeneity,
                      settings: Settings, incomplete: bool = False,
                      stated: Together | None = None,
                      ) -> tuple[Outcome, Coverage | None, Campaign]:
    """
    Return the outcome of the runs together, its coverage, and the figures.

    Parameters
    ----------
    results, settings
        The runs, and what they were judged by.
    runs
        How the runs compare with each other.
    incomplete
        Whether an input could not be judged.
    stated
        The variance of all runs as a verdict states it, where no figures are left to bound it
        with.

    Notes
    -----
    Runs with the readings of an earlier one count once, and certify nothing by the rule `sensor`.
    A void run says nothing, so it is left out of the common variance. With a void run the
    campaign is indeterminate, unless the others reject. It does not comply either if an input
    could not be judged (`incomplete`).

    """
    risk = risk_at_the_end(settings)
    repeated = find_repeated_runs(results)
    once = [r for number, r in enumerate(results, 1) if number not in repeated]
    sound = [r for r in once if r.verdict.validity_effect != VOID]
    shared = stated or judge_together(
        [r.evidence for r in sound], [r.limits for r in sound], risk, settings.variant,
        shortest_apart_s([r.verdict for r in sound]))
    if settings.campaign.rule == 'sensor':
        met = all(r.printed.total.outcome in (None, Outcome.COMPLIANT) for r in results)
        outcome, reason = conclude_sensor(shared, [r.limits for r in results], met, risk)
        if repeated and outcome is not Outcome.NON_COMPLIANT:
            outcome, reason = Outcome.INDETERMINATE, 'a_run_repeated'
    else:
        outcome, reason = conclude_every_run(
            [r.verdict.outcome for r in results],
            [r.outcome_among(len(once)) for r in results])
    tests = _merge_tests(results, repeated, settings)
    if find_not_met(tests) is not None and outcome is not Outcome.NON_COMPLIANT:
        outcome, reason = Outcome.NON_COMPLIANT, 'a_test_not_met'
    if len(sound) < len(once) and outcome is not Outcome.NON_COMPLIANT:
        outcome, reason = Outcome.INDETERMINATE, 'a_run_void'
    if incomplete and outcome is Outcome.COMPLIANT:
        outcome, reason = Outcome.INDETERMINATE, 'an_input_not_judged'
    verdicts = [r.verdict for r in results]
    coverage = _cover_together(results, shared, settings)
    return outcome, coverage, Campaign.of(verdicts, runs, settings.campaign.rule, reason, shared,
                                          _judge_campaign(results, runs, settings, incomplete),
                                          tests)


def _merge_tests(results: Sequence[RunResult], repeated: Collection[int],
                 settings: Settings) -> tuple[JudgedTest, ...]:
    """Return the tests of the norm by all sound runs, whose readings count once."""
    tables = [(number, r.verdict.norm_tests) for number, r in enumerate(results, 1)
              if r.verdict.norm_tests and number not in repeated
              and r.verdict.validity_effect != VOID]
    if not tables:
        return ()
    return merge_tables(tables, TestRisks.of(settings.risk, len(tables[0][1]), len(tables)))


def _cover_together(results: Sequence[RunResult], shared: Together | None, settings: Settings,
                    ) -> Coverage | None:
    """Return what the verdict on the runs together covers; None without evidence."""
    risk = risk_at_the_end(settings)
    scopes = [scope for r in results if (scope := r.verdict.coverage.scope) is not None]
    if settings.campaign.rule != 'sensor':
        spans = [r.evidence.span_s for r in results]
        return coverage_of(min(spans), risk, scopes=scopes) if spans else None
    if shared is None:
        return None
    apart_s = None if shared.between_upper_bound_deg2 is None else shared.apart_s
    return coverage_of(shared.span_s, risk, apart_s=apart_s, scopes=scopes)


def _judge_campaign(results: Sequence[RunResult], runs: Homogeneity, settings: Settings,
                    incomplete: bool) -> tuple[Finding, ...]:
    """Return the findings on the runs together."""
    repeats = judge_repeated_runs(find_repeated_runs(results))
    others = () if repeats is None else (repeats,)
    if settings.variant != 'B' or len(results) < 2:
        return others
    in_variant_c = conclude_campaign(results, runs, replace(settings, variant='C'),
                                     incomplete)[0]
    finding = judge_mean_over_runs(runs, max(r.limits.sigma_max_deg for r in results),
                                   in_variant_c)
    return others if finding is None else (*others, finding)


def join(results: Sequence[RunResult], settings: Settings,
         inputs: Sequence[Input] = (), *, incomplete: bool = False) -> Verdict:
    """
    Return the verdict on runs, and number them in the order given.

    Parameters
    ----------
    results
        Runs of one input or of several.
    settings
        By which the runs were judged.
    inputs
        The sources of the runs.
    incomplete
        Whether an input could not be judged; then the verdict is never compliant.

    """
    runs = compare_runs(results)
    results = [r.place_among(at, runs) for at, r in enumerate(results, 1)]
    left_out = find_left_out((piece for r in results for piece in r.pieces),
                             (r.left_out for r in results), settings)
    return compose_verdict(results, conclude_campaign(results, runs, settings, incomplete),
                           settings, inputs, left_out=left_out, incomplete=incomplete)


def compose_verdict(results: Sequence[RunResult],
                    together: tuple[Outcome, Coverage | None, Campaign], settings: Settings,
                    inputs: Sequence[Input], *, left_out: TakenOut | None,
                    incomplete: bool) -> Verdict:
    """Return the verdict on numbered runs with their result together and what they leave out."""
    outcome, coverage, campaign = together
    if left_out is not None:
        campaign = replace(campaign, validity=(*(campaign.validity or ()), judge_left_out(
            outcome, left_out, bool(settings.exclusions))))
    whole = Verdict.of([r.verdict for r in results], outcome, campaign, coverage, settings, inputs)
    whole = replace(whole, taken_out=left_out)
    if incomplete:
        whole = replace(whole, paper_outcome=worst([whole.paper_outcome, Outcome.INDETERMINATE]))
    return whole
