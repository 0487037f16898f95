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
Whether a verdict that was read follows from its own figures.

The functions that made a verdict make it again from the figures that it holds. What does not hold
the figures it rests on stays as it is: so a verdict without a contradiction may still be untrue.
"""

from __future__ import annotations

from dataclasses import replace
import json
import math
from typing import Any, Sequence

from heading_intercompare.core.decision.campaign import judge_together, Together
from heading_intercompare.core.decision.coverage import (
    Coverage,
    coverage_of,
    Scope,
    slowest_error_s,
)
from heading_intercompare.core.decision.criteria import apply_gk, Limits
from heading_intercompare.core.decision.guarded import decide, Evidence, Guarded
from heading_intercompare.core.decision.sequential import risk_at_the_end
from heading_intercompare.core.diagnostics.run_columns import HIGHEST_ORDER_REMOVED
from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.record_conditions.drift_removed import DRIFT_REMOVED
from heading_intercompare.core.record_conditions.left_out import LEFT_OUT
from heading_intercompare.core.record_conditions.norm_tests import NORM_TESTS
from heading_intercompare.core.record_conditions.reduced_quality import REDUCED_QUALITY
from heading_intercompare.core.record_conditions.repeated_readings import REPEATED_READINGS
from heading_intercompare.core.sensor_conditions.motion import MOTION
from heading_intercompare.core.settings import Risk, Settings
from heading_intercompare.core.statistics.stationarity import Homogeneity
from heading_intercompare.core.statistics.variance_uncertainty import (
    Above,
    excess,
    LEAST_TIMES,
    Spread,
    STUDENT_DOF,
)
from heading_intercompare.core.typed_reader import make_plain, VerdictError
from heading_intercompare.core.utc_text import utc
from heading_intercompare.core.validity.condition import DOUBTFUL, Finding, NOT_TESTABLE, VOID
from heading_intercompare.core.version import RULE_VERSION, VERSION

from .all_runs import compare_runs, compose_verdict, conclude_campaign, join
from .compare_verdicts import list_differences
from .conclusion import conclude
from .judge import conclude_run, RunResult, share_among
from .run_evidence import RunEvidence
from .runs_together import find_repeated_runs, shortest_apart_s
from .spread_of_run import spread_of_run
from .validity import CONDITIONS
from .verdict_document import Campaign, Input, mark_intermediate, RunVerdict, Verdict

#: Figures of a file have all their digits; a sum made from them may lose some.
_REL, _LEAST = 1e-6, 1e-9
_LONGEST = 60
_CAUSES = 'settings', 'inputs', 'verdicts', 'pairs', 'runs'


class ContradictionError(VerdictError):
    """A verdict does not follow from its own figures; one line that names the first of them."""


def check_consistency(verdict: Verdict) -> None:
    """
    Check that a verdict follows from its own figures.

    Raises
    ------
    ContradictionError
        One line with the place, what stands there, and what its figures give.

    """
    compare_with(verdict, derive_verdict(verdict))


def compare_with(verdict: Any, derived: Any, source: str = 'figures') -> None:
    """Raise ContradictionError at the first place where a verdict differs from a derived one."""
    _compare_plain(_put_causes_first(verdict.to_dict()), derived.to_dict(), source,
                   explain_difference(verdict))


def _compare_plain(stated: Any, derived: Any, source: str, why: str) -> None:
    for place, value, figures in list_differences(stated, derived, '', _REL, _LEAST):
        raise ContradictionError(
            f'{place} is {_show(value)}, but its {source} give {_show(figures)}: {why}')


def _put_causes_first(document: dict[str, Any]) -> dict[str, Any]:
    """Return a document that begins with what the rest of it follows from."""
    return {**{key: document[key] for key in _CAUSES if key in document}, **document}


def explain_difference(verdict: Any) -> str:
    """Return in words why a verdict may differ from what this version derives."""
    version, rule = verdict.software.version, verdict.rule_version
    if (version, rule) == (VERSION, RULE_VERSION):
        return 'the file was changed'
    return (f'the file was changed, or made by version {version} with rule {rule}, and this is '
            f'version {VERSION} with rule {RULE_VERSION}')


def _show(value: Any) -> str:
    """Return a value of a JSON for a line; a long one is cut."""
    text = value if isinstance(value, str) and value else json.dumps(value, ensure_ascii=False)
    text = ' '.join(text.split())
    return text if len(text) <= _LONGEST else f'{text[:_LONGEST]}...'


def derive_verdict(verdict: Verdict) -> Verdict:
    """Return the verdict that the figures of a verdict give."""
    settings = verdict.settings
    results = [_rebuild_run(run, settings) for run in verdict.runs]
    runs = compare_runs(results)
    if is_close(runs, verdict.campaign.homogeneity) or _find_repeats(verdict):
        # Words with rounded figures are those of the figures that stand there.
        runs = verdict.campaign.homogeneity
    results = [result.place_among(at, runs) for at, result in enumerate(results, 1)]
    incomplete = _is_incomplete(verdict)
    together = _conclude_together(verdict, results, runs, incomplete)
    derived = compose_verdict(results, together, settings, verdict.inputs,
                              left_out=verdict.taken_out, incomplete=incomplete)
    missed = [problem for problem in derived.ledger_problems
              if problem not in verdict.ledger_problems]
    derived = replace(derived, software=verdict.software, rule_version=verdict.rule_version,
                      operator_actions=verdict.operator_actions, recordings=verdict.recordings,
                      chosen=verdict.chosen and replace(verdict.chosen, asked=len(verdict.runs)),
                      ledger_problems=(*missed, *verdict.ledger_problems))
    return mark_intermediate(derived) if verdict.intermediate else derived


def judge_kept_runs(runs: Sequence[RunVerdict], settings: Settings,
                    inputs: Sequence[Input]) -> Verdict:
    """
    Judge runs together that were judged before, each in a verdict of its own.

    Parameters
    ----------
    runs
        In the order of time, each with its evidence.
    settings
        By which all were judged; the rule of campaigns may be another.
    inputs
        The sources of the runs.

    Raises
    ------
    ContradictionError
        If a run does not follow from its figures and its evidence.

    """
    results = []
    for run in runs:
        evidence: RunEvidence = run.evidence
        result = _rebuild_run(run, settings, evidence.evidence)
        try:
            _compare_plain(make_plain(run), make_plain(result.verdict), 'figures',
                           'the record was changed')
        except ContradictionError as error:
            raise ContradictionError(f'the record of the run of {utc(run.start_ns)} UTC: '
                                     f'{error}') from error
        results.append(replace(result, fingerprint=evidence.fingerprint,
                               pieces=evidence.pieces, outside=evidence.outside))
    return join(results, settings, inputs)


def is_close(first: Any, second: Any) -> bool:
    """Tell whether two parts of a verdict are equal but for rounding."""
    return not any(list_differences(make_plain(first), make_plain(second), '', _REL, _LEAST))


def _is_incomplete(verdict: Verdict) -> bool:
    """Tell whether an input could not be judged, so that nothing complies."""
    return verdict.campaign.reason == 'an_input_not_judged' or any(
        recording.error is not None or recording.no_run is not None
        for recording in verdict.inputs)


def _find_repeats(verdict: Verdict) -> list[Finding]:
    """Return the finding that runs share readings; which they are is only in its words."""
    return [finding for finding in verdict.campaign.validity
            if finding.condition == REPEATED_READINGS.name
            and finding.effect == DOUBTFUL and len(verdict.runs) > 1]


def _conclude_together(verdict: Verdict, results: Sequence[RunResult], runs: Homogeneity,
                       incomplete: bool) -> tuple[Outcome, Coverage | None, Campaign]:
    """Return the result of the runs together; what rests on their readings stays as it is."""
    campaign, settings = verdict.campaign, verdict.settings
    of_readings = _find_repeats(verdict)
    outcome, coverage, derived = conclude_campaign(
        results, runs, settings, incomplete, _state_together(campaign.sensor, results, settings))
    if not of_readings:
        return outcome, coverage, derived
    others = [finding for finding in derived.validity
              if finding.condition != REPEATED_READINGS.name]
    if len(others) < len(derived.validity):
        return outcome, coverage, replace(derived, validity=(*of_readings, *others))
    reason = campaign.reason
    if settings.campaign.rule == 'sensor':
        if verdict.outcome is Outcome.COMPLIANT:
            return Outcome.INDETERMINATE, coverage, derived
        outcome = verdict.outcome
    elif outcome is Outcome.INDETERMINATE and verdict.outcome is not Outcome.COMPLIANT:
        # Fewer runs share the risk of a false rejection.
        outcome = verdict.outcome
    else:
        reason = derived.reason
    return outcome, coverage, replace(
        derived, reason=reason, sensor=campaign.sensor, homogeneity=campaign.homogeneity,
        validity=tuple(finding for finding in campaign.validity
                       if finding.condition != LEFT_OUT.name))


def _state_together(stated: Together | None, results: Sequence[RunResult],
                    settings: Settings) -> Together | None:
    """
    Return the variance of all runs with the upper bound that a verdict states.

    None if the figures of the runs give that bound: it may rest on the kurtosis of the runs, or on
    the slow parts of several of which only some are visible.
    """
    repeated = find_repeated_runs(results)
    sound = [r for number, r in enumerate(results, 1)
             if number not in repeated and r.verdict.validity_effect != VOID]
    spreads = [r.evidence.spread for r in sound if r.evidence.spread is not None]
    is_slow = [spread.slow_variance_deg2 > 0.0 for spread in spreads]
    if stated is None or len(spreads) < 2 or not (
            stated.stated_times is not None or any(is_slow) and not all(is_slow)):
        return None
    derived = judge_together(
        [r.evidence for r in sound], [r.limits for r in sound], risk_at_the_end(settings),
        settings.variant, shortest_apart_s([r.verdict for r in sound]))
    if derived is None:
        return None
    bound = stated.upper_bound_deg2 if derived.between_upper_bound_deg2 is None \
        else derived.upper_bound_deg2
    return replace(
        derived, slow_allowance_deg2=stated.slow_allowance_deg2,
        pooled_upper_bound_deg2=stated.pooled_upper_bound_deg2, upper_bound_deg2=bound)


def _rebuild_run(run: RunVerdict, settings: Settings,
                 evidence: Evidence | None = None) -> RunResult:
    """Return the result of a run as its own figures give it, and its evidence if that is kept."""
    ts, rs = run.pairing.ts_variance_factor, run.pairing.rs_variance_factor
    limits = Limits.of(settings.norms, settings.model, *(
        () if ts is None or rs is None else (rs, ts)))
    risk = risk_at_the_end(settings, run.coverage.span_s)
    rates = run.guarded.rate_plus, run.guarded.rate_plus_plus
    n_plus, n_plus_plus = (0 if rate is None else round(rate * run.n) for rate in rates)
    left_deg2 = 0.0 if run.drift_coefficients_deg else run.drift.left_deg2 or 0.0
    evidence = evidence or Evidence(
        n=run.n, spread=_rebuild_spread(run, settings, risk), mean_deg=run.mean_deg,
        offset_u_deg=settings.installation_offset_u_deg, span_s=run.coverage.span_s,
        n_plus=n_plus, n_plus_plus=n_plus_plus, drift_left_deg2=left_deg2)
    guarded = _keep_what_rests_on_more(decide(evidence, limits, risk), run.guarded)
    counts = iter((run.count_criterion.n_plus, run.count_criterion.n_plus_plus))
    printed = apply_gk(run.n, run.mean_deg, run.variance_deg2, lambda limit_deg: next(counts),
                       limits, settings)
    alone = conclude(guarded, printed)
    verdict = replace(
        run, **_sum_up(run, settings), variance_criterion=printed.variance,
        count_criterion=printed.counts, total_error=printed.total, paper_outcome=printed.outcome,
        guarded=run.guarded if is_close(guarded, run.guarded) else guarded,
        coverage=_rebuild_coverage(run, settings, risk),
        norm_tests=share_among(run.norm_tests, settings.risk, 1) or None)
    return RunResult(
        verdict=conclude_run(verdict, alone, _list_findings(run)), evidence=evidence,
        limits=limits, printed=printed, alone=alone, risk=risk, settings=settings,
        stabilization_s=settings.runs.stabilization_s)


def _rebuild_spread(run: RunVerdict, settings: Settings, risk: Risk) -> Spread | None:
    """Return the variance of a run and how well it is known, with the bound that is stated."""
    spread, guarded, slowest_s = spread_of_run(run), run.guarded, slowest_error_s(risk)
    if spread is None:
        return None
    spread = replace(
        spread, order=HIGHEST_ORDER_REMOVED if settings.drift_order == 'auto' else spread.order,
        mean_variance_deg2=max(0.0, spread.mean_variance_deg2
                               - settings.installation_offset_u_deg ** 2),
        times=None if slowest_s is None else run.coverage.span_s / slowest_s)
    if spread.times is None or spread.times < LEAST_TIMES or guarded.stated_times is None:
        return spread
    # The widening of this bound is not in the verdict, so it is chosen for the stated bound.
    upper, slow = guarded.upper_bound_deg2, guarded.slow_allowance_deg2 or 0.0
    room = math.inf if upper is None else upper - spread.d_deg2 - slow
    distance = excess(spread.f, risk.alpha_consumer)
    return replace(spread, stated=Above(spread.d_deg2, room / distance, spread.f, STUDENT_DOF,
                                        allowance_deg2=slow))


def _keep_what_rests_on_more(derived: Guarded, stated: Guarded) -> Guarded:
    """Return a derived decision with the figures that rest on more than the verdict holds."""
    if not stated.slow_variance_deg2:
        derived = replace(derived, r_slow=None if stated.r_slow is None or derived.r_slow is None
                          else min(1.0, stated.r_slow))
    if derived.stated_times is None:
        return derived
    return replace(derived, confidence_compliant=stated.confidence_compliant,
                   confidence_non_compliant=stated.confidence_non_compliant,
                   conformance_probability=stated.conformance_probability)


def _rebuild_coverage(run: RunVerdict, settings: Settings, risk: Risk) -> Coverage:
    scope = run.coverage.scope
    if scope is not None:
        scope = replace(Scope.state(settings), shortest_s=scope.shortest_s,
                        headings_deg=scope.headings_deg)
    return coverage_of(run.coverage.span_s, risk, scopes=[] if scope is None else [scope])


def _sum_up(run: RunVerdict, settings: Settings) -> dict[str, Any]:
    """Return the figures of a run that are sums or functions of others, by their keys."""
    pairing, taken_out = run.pairing, run.taken_out
    variance_deg2, mean_deg = run.variance_deg2, run.mean_deg
    figures: dict[str, Any] = {
        'duration_s': (run.end_ns - run.start_ns) / 1e9,
        'n': run.n_input - run.n_invalid - run.n_stabilization - (
            0 if taken_out is None else taken_out.n),
        'std_deg': None if variance_deg2 is None else math.sqrt(max(0.0, variance_deg2)),
        'pairing': replace(
            pairing,
            ts_received=pairing.ts_paired + pairing.ts_used + pairing.ts_unpaired
            + pairing.ts_unbridged + pairing.ts_held + sum(pairing.rejected.ts.values()),
            rs_received=pairing.rs_used + pairing.rs_unused + pairing.rs_unbridged
            + pairing.rs_held + sum(pairing.rejected.rs.values()))}
    if run.min_deg is not None and run.max_deg is not None:
        figures['max_abs_deg'] = max(abs(run.min_deg), abs(run.max_deg))
    if run.drift_coefficients_deg or variance_deg2 is None or mean_deg is None or run.n < 2:
        return figures
    spread = spread_of_run(run)
    if spread is not None and settings.drift_order == 0:
        absorbed_deg2 = spread.mean_variance_deg2 - settings.installation_offset_u_deg ** 2
        figures['variance_deg2'] = (spread.d_deg2 - absorbed_deg2) * run.n / (run.n - 1)
    figures['mean_square_deg2'] = variance_deg2 * (run.n - 1) / run.n + mean_deg ** 2
    return figures


def _list_findings(run: RunVerdict) -> tuple[Finding, ...]:
    """Return the findings of a run; one that every run has and that is missing does not hold."""
    by_name = {finding.condition: finding for finding in run.validity}
    missing = {MOTION.name: run.motion is None, REDUCED_QUALITY.name: run.quality is None,
               DRIFT_REMOVED.name: not run.drift_coefficients_deg,
               NORM_TESTS.name: not run.norm_tests}
    return tuple(
        by_name.get(condition.name) or condition.find(NOT_TESTABLE, '', '')
        for condition in CONDITIONS
        if (condition.judge is not None or condition.settle is not None)
        and not missing.get(condition.name, False))
