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

"""Judges a run at its end: figures, criteria as printed, guarded decision, diagnostics."""

from __future__ import annotations

from dataclasses import dataclass, replace
import math
from typing import Any, Callable, Iterator, Mapping, Sequence

import numpy as np

from heading_intercompare.core.angles import circular_mean
from heading_intercompare.core.decision.coverage import coverage_of, Scope, slowest_error_s
from heading_intercompare.core.decision.criteria import apply_gk, Limits, Printed
from heading_intercompare.core.decision.guarded import decide, Evidence, gather_evidence, Guarded
from heading_intercompare.core.decision.sequential import Look, LookVerdict, risk_at_the_end
from heading_intercompare.core.decision.taken_out import Stretch, TakenOut
from heading_intercompare.core.diagnostics.percentile import estimate_percentile, Percentile
from heading_intercompare.core.diagnostics.run_columns import (
    HIGHEST_ORDER_REMOVED,
    prepare_run,
    PreparedRun,
    RunColumns,
    SETTLED_SHARE,
)
from heading_intercompare.core.diagnostics.run_diagnostics import diagnose, with_runs
from heading_intercompare.core.diagnostics.run_findings import describe_drift, left_in_deg2
from heading_intercompare.core.diagnostics.sensor_quality import (
    check_quality,
    compare_claim,
    leaves_enough,
    QualityCheck,
    warn_of_claim,
)
from heading_intercompare.core.motion.motion_check import check_motion
from heading_intercompare.core.norm_tests.judged_test import JudgedTest, TestRisks
from heading_intercompare.core.norm_tests.resolution_error import settle_resolution
from heading_intercompare.core.norm_tests.table import judge_tests
from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.pairing.ledger import LedgerSegment
from heading_intercompare.core.record_conditions.losses import (
    warn_of_alone,
    warn_of_held,
    warn_of_rejected,
)
from heading_intercompare.core.records import Integers, Motion, Quality, Reals
from heading_intercompare.core.runs.pairing_figures import PairingFigures
from heading_intercompare.core.runs.run_series import RunSeries
from heading_intercompare.core.settings import Risk, Settings
from heading_intercompare.core.statistics.cells import Cells
from heading_intercompare.core.statistics.stationarity import Homogeneity
from heading_intercompare.core.time_rules.exclusions import (
    Exclusion,
    find_excluded,
    read_exclusions,
)
from heading_intercompare.core.timing.stamp_steps import measure_stamp_steps
from heading_intercompare.core.validity.condition import Finding
from heading_intercompare.core.validity.examined import Examined, RunAccount

from .conclusion import (
    conclude,
    effect_with_looks,
    explain,
    with_findings,
    with_looks,
    with_tests,
)
from .headline import add_looks, compose_headline
from .recorded import JudgedPiece
from .run_evidence import RunEvidence
from .validity import examine, settle
from .verdict_document import RunVerdict

#: Share of the work of judging a run before its diagnostics.
_BEFORE = 0.1


@dataclass(frozen=True, slots=True)
class RunResult:
    """
    A judged run, with everything needed to decide again on it among several runs.

    Attributes
    ----------
    alone
        Outcome and reason before any finding.
    risk
        Its risks: what its looks leave, or all without looks.
    judged
        Findings on its pairs, before the account of its readings is known.
    first_pair
        Pairs of its input before its first one, in runs or not.
    pieces
        The record of its input as the sensors made it.
    outside
        Pairs of its input that lie in no run, with the first run of the input.
    share, inside
        Ledger of its readings, and of those between its first and last pair.
    fingerprint
        By which its readings are known in another run; None if there are too few.

    """

    verdict: RunVerdict
    evidence: Evidence
    limits: Limits
    printed: Printed
    alone: tuple[Outcome, str]
    risk: Risk
    settings: Settings
    stabilization_s: float | str
    judged: tuple[Finding, ...] = ()
    first_pair: int = 0
    pieces: tuple[JudgedPiece, ...] = ()
    outside: tuple[Stretch, ...] = ()
    share: LedgerSegment | None = None
    inside: LedgerSegment | None = None
    fingerprint: str | None = None

    def with_pairing(self, share: LedgerSegment, inside: LedgerSegment,
                     warnings: Sequence[str] = ()) -> 'RunResult':
        """
        Return the result with the account of its readings, and what that says of its conditions.

        Parameters
        ----------
        share
            Share of the whole ledger, in which every reading belongs to a run.
        inside
            The part of the share between the first and the last pair of the run.
        warnings : sequence of str
            Warnings to add.

        """
        old = self.verdict.pairing
        pairing = PairingFigures.of(share, old.mean_lag_s, old.max_lag_s,
                                    old.rs_variance_factor, old.ts_variance_factor)
        verdict = replace(self.verdict, pairing=pairing,
                          warnings=(*self.verdict.warnings, *warnings,
                                    *warn_of_rejected(share), *warn_of_held(share),
                                    *warn_of_alone(share, inside)))
        return replace(self, verdict=verdict, share=share, inside=inside).conclude()

    @property
    def left_out(self) -> tuple[Stretch, ...]:
        """Return what is left out of the run, and of its input outside the runs."""
        run = self.verdict
        settled_ns = run.start_ns + round(
            1e9 * run.duration_s * run.n_stabilization / max(1, run.n_input))
        settling = Stretch(run.start_ns, settled_ns, 'settling', run.n_stabilization)
        by_hand = run.taken_out.stretches if run.taken_out is not None else ()
        return (*self.outside, *([settling] if settling.n else []), *by_hand)

    def with_evidence(self) -> 'RunResult':
        """Return the result whose verdict has the evidence that a logbook keeps."""
        run = self.verdict
        around = tuple(piece for piece in self.pieces
                       if piece.start_ns <= run.end_ns and piece.end_ns >= run.start_ns)
        return replace(self, verdict=replace(run, evidence=RunEvidence(
            self.evidence, self.fingerprint, around, self.outside)))

    def without_lost_share(self) -> 'RunResult':
        """Return the result of pairs chosen out of more: their gaps do not show what was lost."""
        correlation = self.verdict.correlation
        stamps = replace(correlation.stamps, lost_share=None)
        return replace(self, verdict=replace(
            self.verdict, correlation=replace(correlation, stamps=stamps))).conclude()

    def conclude(self) -> 'RunResult':
        """Return the result with outcome and headline after findings and looks."""
        verdict, (alone, _) = self.verdict, self.alone
        if verdict.norm_tests and self.inside is not None:
            verdict = replace(verdict, norm_tests=settle_resolution(
                verdict.norm_tests, self.inside.changes('ts'),
                TestRisks.of(self.settings.risk, len(verdict.norm_tests))))
        findings = settle(self.judged, RunAccount(
            outcome=alone, guarded=verdict.guarded, limits=self.limits, settings=self.settings,
            lost_share=verdict.correlation.stamps.lost_share,
            interpolated=verdict.pairing.find_interpolated(self.settings.pairing.method),
            share=self.share, inside=self.inside, normality=verdict.normality,
            tests=verdict.norm_tests or ()))
        return replace(self, verdict=conclude_run(verdict, self.alone, findings))

    def place_among(self, run: int, runs: Homogeneity) -> 'RunResult':
        """Return the result with its number among the runs, and with (g) judged from all runs."""
        checked = with_runs(self.verdict.assumptions, runs)
        return replace(self, verdict=replace(self.verdict, run=run, assumptions=checked))

    def outcome_among(self, m: int) -> Outcome:
        """
        Return the outcome if m runs share the producer's risk.

        A run that is rejected on its own may be indeterminate among others, but it never
        complies: a look may have rejected it.
        """
        if m == 1 or self.verdict.outcome is not Outcome.NON_COMPLIANT:
            return self.verdict.outcome
        shared = replace(self.risk, alpha_producer=self.risk.alpha_producer / m)
        among, _ = with_tests(
            *conclude(decide(self.evidence, self.limits, shared), self.printed),
            share_among(self.verdict.norm_tests, self.settings.risk, m))
        return Outcome.INDETERMINATE if among is Outcome.COMPLIANT else among


def conclude_run(verdict: RunVerdict, alone: tuple[Outcome, str],
                 findings: Sequence[Finding]) -> RunVerdict:
    """Return a verdict with outcome and headline after findings and looks."""
    tests = verdict.norm_tests or ()
    at_end = with_findings(*with_tests(*alone, tests), findings)
    outcome, reason = with_looks(*at_end, verdict.looks)
    line = compose_headline(at_end[0], findings, verdict.coverage,
                            explain(verdict, at_end[1]), tests)
    return replace(verdict, outcome=outcome, reason=reason, validity=tuple(findings),
                   validity_effect=effect_with_looks(findings, reason, verdict.looks),
                   headline=add_looks(line, outcome, reason, verdict.looks))


def share_among(tests: Sequence[JudgedTest] | None, risk: Risk,
                runs: int) -> tuple[JudgedTest, ...]:
    """Return the tests of a run if runs share the producer's risk."""
    risks = TestRisks.of(risk, len(tests or ()), runs)
    return tuple(test.judge(risks) for test in tests or ())


class _Decision:
    """The decision rule of one run, for its differences and for variations of them."""

    def __init__(self, limits: Limits, settings: Settings, risk: Risk,
                 taken_out_s: float) -> None:
        self._limits, self._settings, self._risk = limits, settings, risk
        self._taken_out_s = taken_out_s

    def __call__(self, data: PreparedRun, cells: Cells,
                 drift_left_deg2: float) -> tuple[Evidence, Guarded, Printed]:
        """Return the evidence, the guarded decision, and GK as printed."""
        settings = self._settings
        printed = _apply_gk(data, self._limits, settings)
        auto = settings.drift_order == 'auto'
        evidence = gather_evidence(
            cells,
            n_plus=data.count_outside(settings.variant, self._limits.count_limit_deg),
            n_plus_plus=data.count_outside(settings.variant,
                                           self._limits.tightened_count_limit_deg),
            span_s=data.span_s, slowest_s=slowest_error_s(self._risk),
            offset_u_deg=settings.installation_offset_u_deg,
            order=HIGHEST_ORDER_REMOVED if auto else data.order,
            mean_deg=data.moments.mean_deg if data.moments.n else None,
            drift_left_deg2=drift_left_deg2)
        return evidence, decide(evidence, self._limits, self._risk), printed

    def outcome(self, stamp_ns: Integers, x_deg: Reals, rs_factor: float = 1.0,
                **changes: Any) -> Outcome:
        """Return the outcome of other differences, RS noise or settings; see `Examined`."""
        limits, settings = self._limits, replace(self._settings, **changes)
        if rs_factor != 1.0:
            limits = limits.with_rs_factor(rs_factor)
        if 'model' in changes:
            limits = limits.with_model(settings.model)
        decision = _Decision(limits, settings, self._risk, self._taken_out_s)
        data = replace(PreparedRun.of(stamp_ns, x_deg, np.zeros_like(x_deg), settings),
                       taken_out_s=self._taken_out_s)
        drift_left_deg2 = left_in_deg2(stamp_ns, x_deg) if data.residual_deg is None else 0.0
        _, guarded, printed = decision(data, Cells.of(data.series_deg, stamp_ns), drift_left_deg2)
        return conclude(guarded, printed)[0]


def judge_run(run: RunSeries, settings: Settings, number: int, source: str, *,
              risk: Risk | None = None, looks: Sequence[LookVerdict] = (),
              motion: Mapping[str, Motion] | None = None,
              quality: Mapping[str, Quality] | None = None, is_look: bool = False,
              progress: Callable[[float], None] = lambda share: None) -> RunResult:
    """
    Judge a run as it is.

    Parameters
    ----------
    run
        Must hold at least one pair; may hold no analysed differences.
    settings
        Must hold the norms.
    number
        Number of the run, from 1.
    source
        Name of the input.
    risk
        Share of the risks for this judgement; default that of the end of a run.
    looks
        Results of the looks so far.
    motion
        The motion of the ship by what it tells, to check the headings against; None if there is
        none.
    quality
        What ``'ts'`` and ``'rs'`` say of their readings, as far as they say something.
    is_look
        Whether the run goes on: the tests of the norm have no looks.
    progress
        Called with the share of the work that is done, from 0 to 1.

    Returns
    -------
    RunResult

    Raises
    ------
    ValueError
        If the run has no pair.

    Notes
    -----
    With looks, the end of the run is the last one and takes its share of the risks, so that all
    looks together keep the stated risks. A look judges just as the end does.

    References
    ----------
    GK (4)-(7); ``docs/verdict.md`` for the guarded decision.

    """
    if run.start_ns is None or run.end_ns is None:
        raise ValueError('run: has no pair, must have at least one')
    risk = risk_at_the_end(settings, run.span_s) if risk is None else risk
    exclusions = [exclusion for exclusion in read_exclusions(settings.exclusions)
                  if exclusion.start_ns <= run.end_ns and exclusion.end_ns > run.start_ns]
    limits = run.limits(settings.norms, settings.model)
    data = prepare_run(run, limits, settings, exclusions)
    moments = data.moments
    drift, rest = describe_drift(data.stamp_ns, data.x_deg, SETTLED_SHARE * limits.sigma_max_deg)
    progress(_BEFORE)
    left = drift.left_deg2 if data.residual_deg is None and drift.left_deg2 is not None else 0.0
    # Live figures use the same sums, so they are the same to the bit.
    as_it_came = data.residual_deg is None and not data.n_left_out and not exclusions
    cells = run.cells() if as_it_came else Cells.of(data.series_deg, data.stamp_ns)
    decision = _Decision(limits, settings, risk, data.taken_out_s)
    evidence, guarded, printed = decision(data, cells, left)
    outcome, reason = conclude(guarded, printed)
    factor, taken_out = run.factor.values[data.n_left_out:], None
    if exclusions:
        at = find_excluded(run.stamp_ns.values[data.n_left_out:], exclusions)
        factor, taken_out = factor[at < 0], _count_taken_out(at, exclusions)
    columns = RunColumns(stamp_ns=data.stamp_ns, x_deg=data.x_deg, rs_deg=data.rs_deg,
                         settings=settings, limits=limits, residual_deg=data.residual_deg,
                         factor=factor, interpolates_ts=run.interpolates_ts)
    diagnostics = diagnose(columns, guarded, drift=drift, rest=rest,
                           progress=lambda share: progress(_BEFORE + (1.0 - _BEFORE) * share))
    correlation = diagnostics.correlation
    if taken_out is not None:
        # A reading that was taken out is not lost.
        every = measure_stamp_steps(run.stamp_ns.values[data.n_left_out:])
        correlation = replace(correlation, stamps=replace(correlation.stamps,
                                                          lost_share=every.lost_share))
    checked = None if motion is None or not settings.motion.compare else check_motion(
        motion, data.stamp_ns, data.rs_deg + data.x_deg, data.rs_deg, settings.motion)
    claims = _weigh_quality(quality or {}, data, guarded, decision, settings)
    judged = examine(Examined(columns=columns, diagnostics=diagnostics, settings=settings,
                              outcome=outcome, guarded=guarded, decide=decision.outcome,
                              motion=checked, quality=claims))
    progress(_BEFORE + 0.9 * (1.0 - _BEFORE))
    coverage = coverage_of(data.span_s, risk,
                           scopes=[Scope.of(data.stamp_ns, data.rs_deg, settings)])
    verdict = RunVerdict(
        run=number, source=source, start_ns=run.start_ns, end_ns=run.end_ns,
        duration_s=(run.end_ns - run.start_ns) / 1e9,
        pairing=PairingFigures.of(LedgerSegment(None), run.mean_lag_s, run.max_lag_s,
                                  run.rs_variance_factor, run.ts_variance_factor),
        n_input=run.n_input, n_invalid=run.n_invalid,
        n_stabilization=run.n_stabilization + data.n_left_out, n=moments.n, clock_segment=None,
        mean_square_deg2=moments.mean_square_deg2, **_summarise(data),
        drift_coefficients_deg=data.coefficients_deg, variance_deg2=data.variance_deg2,
        std_deg=None if data.variance_deg2 is None else math.sqrt(data.variance_deg2),
        variance_criterion=printed.variance, count_criterion=printed.counts,
        total_error=printed.total, outcome=outcome, reason=reason, headline='',
        validity=(), validity_effect='', coverage=coverage,
        looks=tuple(looks),
        paper_outcome=printed.outcome, guarded=guarded, skew=diagnostics.skew,
        drift=diagnostics.drift, heading_dependence=diagnostics.heading_dependence,
        by_motion=diagnostics.by_motion, normality=diagnostics.normality,
        stationarity=diagnostics.stationarity,
        correlation=correlation, allan=diagnostics.allan,
        assumptions=diagnostics.assumptions, taken_out=taken_out, motion=checked,
        quality=claims,
        limit_95=_estimate_limit_95(data, settings, correlation.n_effective_variance),
        norm_tests=None if is_look else judge_tests(
            columns, moments.mean_deg if moments.n else None, guarded,
            diagnostics.by_motion, run) or None,
        warnings=(*_warnings(data, limits, guarded, settings), *diagnostics.warnings,
                  *warn_of_claim(claims, guarded.sigma_ts_lower_deg,
                                 guarded.sigma_ts_upper_deg)))
    return RunResult(
        verdict=verdict, evidence=evidence, limits=limits, printed=printed,
        alone=(outcome, reason), risk=risk, settings=settings,
        stabilization_s=run.stabilization_s, judged=judged,
        fingerprint=None if columns.fingerprint is None
        else columns.fingerprint.to_text()).conclude()


def _weigh_quality(quality: Mapping[str, Quality], data: PreparedRun, guarded: Guarded,
                   decision: _Decision, settings: Settings) -> QualityCheck | None:
    """Return what sensors say, with the claim of the TS and the outcome without poor readings."""
    matched = check_quality(quality, data.stamp_ns,
                            late_ns=round(settings.alignment.skew_s * 1e9))
    if matched is None:
        return None
    check, is_reduced = matched
    without = None
    if leaves_enough(is_reduced):
        without = decision.outcome(data.stamp_ns[~is_reduced], data.x_deg[~is_reduced])
    return replace(check, without_reduced=without, ts_claim=compare_claim(
        check, guarded.sigma_ts_lower_deg, guarded.sigma_ts_upper_deg))


def _summarise(data: PreparedRun) -> dict[str, float | None]:
    """Return mean and range of the differences, by their keys in the verdict; None for n = 0."""
    moments = data.moments
    keys = 'mean_deg', 'min_deg', 'max_deg', 'max_abs_deg', 'circular_mean_deg', 'resultant_length'
    if not moments.n:
        return dict.fromkeys(keys)
    return dict(zip(keys, (
        moments.mean_deg, moments.min_deg, moments.max_deg,
        max(abs(moments.min_deg), abs(moments.max_deg)), *circular_mean(data.x_deg))))


def _estimate_limit_95(data: PreparedRun, settings: Settings, n_effective: float,
                       ) -> Percentile | None:
    """Return the distance within which 95 % of the differences lie; None for n = 0."""
    if not data.moments.n:
        return None
    is_centred = settings.variant == 'A' or data.residual_deg is not None
    return estimate_percentile(data.series_deg, 0.0 if is_centred else data.moments.mean_deg,
                               n_effective)


def look_at(run: RunSeries, look: Look, looks: int, settings: Settings,
            motion: Mapping[str, Motion] | None = None,
            quality: Mapping[str, Quality] | None = None) -> LookVerdict:
    """
    Judge a run in progress at a look, just as its end would be judged.

    Parameters
    ----------
    run
        Must hold the differences up to the look.
    look
        Holds its share of the risks.
    looks
        Number of looks, with the end of the run.
    settings
        By which its end will be judged.
    motion, quality
        The motion of the ship so far, and what the sensors said, as for `judge_run`.

    Notes
    -----
    Only the ledger is not known yet: a look counts gaps between the pairs, but readings rejected
    or without partner count only at the end.

    """
    verdict = judge_run(run, settings, 0, '', risk=look.risk, motion=motion,
                        quality=quality, is_look=True).verdict
    return LookVerdict(look=look.index + 1, looks=looks, span_s=run.span_s,
                       outcome=verdict.outcome, reason=verdict.reason,
                       validity_effect=verdict.validity_effect, headline=verdict.headline)


def _count_taken_out(at: Integers, exclusions: Sequence[Exclusion]) -> TakenOut | None:
    """Return the account of the differences taken out by hand; None if there are none."""
    count = np.bincount(at[at >= 0], minlength=len(exclusions)).tolist()
    n = sum(count)
    return TakenOut(n, n / at.size, tuple(
        Stretch(exclusion.start_ns, exclusion.end_ns, exclusion.reason, within)
        for exclusion, within in zip(exclusions, count) if within)) if n else None


def _apply_gk(data: PreparedRun, limits: Limits, settings: Settings) -> Printed:
    return apply_gk(data.moments.n, data.moments.mean_deg if data.moments.n else None,
                    data.variance_deg2,
                    lambda limit: data.count_outside(settings.variant, limit), limits, settings)


def _warnings(data: PreparedRun, limits: Limits, guarded: Guarded,
              settings: Settings) -> Iterator[str]:
    if settings.norms.preset is not None:
        yield (f'sigma_max = {limits.sigma_max_deg:.6g} deg follows from the norm '
               f'{settings.norms.preset}')
    if data.order:
        yield (f'drift_removed: a polynomial of order {data.order} is subtracted from the '
               'differences')
    reference_deg2 = (limits.m_low * limits.sigma_ref_max_deg) ** 2
    if data.variance_deg2 is not None and data.variance_deg2 < reference_deg2:
        yield ('difference_variance_below_reference_variance: the norm of the RS is too large, '
               'or its errors and those of the TS are correlated')
    if settings.variant == 'A' and guarded.bias_significant:
        yield ('variant_A_mean_not_zero: the mean difference is not zero, but variant A assumes '
               'that it is')
