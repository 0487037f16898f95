# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""One run judged: its figures, the criteria as printed, and the guarded decision."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Callable, Mapping, Sequence

from .angles import circular_mean
from .criteria import (
    count_criterion,
    CountCriterion,
    Limits,
    total_error,
    TotalError,
    variance_criterion,
    VarianceCriterion,
)
from .guarded import decide, Evidence, evidence_of, Guarded
from .ledger import LedgerSegment
from .outcome import Outcome, worst
from .rolling import Rolling
from .run_series import RunSeries
from .sequential import Look, Looks
from .settings import Risk, Settings
from .statistics import Moments
from .verdict import PairingFigures, RunVerdict

__all__ = ['EarlyVerdict', 'figures', 'homogeneity', 'judge', 'look_at',
           'RunResult']

CONSTANT_DEG = 1e-9
"""Peak-to-peak difference up to which two sensors are taken for a frozen pair, degrees."""


@dataclass(frozen=True, slots=True)
class EarlyVerdict:
    """
    What a look at a run in progress decided.

    Attributes
    ----------
    look, looks : int
        Which look, from 1, of how many.
    span_s : float
        Time since the first difference, seconds.
    outcome : Outcome
    reason : str
        As for a run.

    """

    look: int
    looks: int
    span_s: float
    outcome: Outcome
    reason: str

    def __str__(self) -> str:
        return (f'decided at look {self.look} of {self.looks}, {self.span_s:.1f} s after the '
                'first difference')


@dataclass(frozen=True, slots=True)
class RunResult:
    """A judged run, and what is needed to decide on it again among several runs."""

    verdict: RunVerdict
    evidence: Evidence
    limits: Limits
    early: EarlyVerdict | None = None

    def with_pairing(self, share: LedgerSegment, warnings: Sequence[str] = ()) -> 'RunResult':
        """Return the result with its share of the pairing ledger."""
        old = self.verdict.pairing
        pairing = PairingFigures.of(share, old.mean_lag_s, old.max_lag_s, old.rs_variance_factor)
        return replace(self, verdict=replace(
            self.verdict, pairing=pairing, warnings=(*self.verdict.warnings, *warnings)))

    def numbered(self, run: int) -> 'RunResult':
        """Return the result with its number in the campaign."""
        return replace(self, verdict=replace(self.verdict, run=run))

    def outcome_among(self, m: int, settings: Settings) -> Outcome:
        """Return the outcome when m runs share the producer's risk."""
        if m == 1 or self.verdict.outcome is not Outcome.NON_COMPLIANT:
            return self.verdict.outcome
        risk = _risk_at_the_end(settings)
        shared = replace(risk, alpha_producer=risk.alpha_producer / m)
        guarded = decide(self.evidence, self.limits, shared)
        return _conclude(guarded, self.verdict.total_error)[0]


def judge(run: RunSeries, settings: Settings, number: int, source: str,
          early: EarlyVerdict | None = None) -> RunResult:
    """
    Judge a run that has ended.

    Parameters
    ----------
    run : RunSeries
        With at least one pair; any number of analysed differences, also none.
    settings : Settings
        With the norms.
    number : int
        Of the run, from 1.
    source : str
        Name of the input.
    early : EarlyVerdict, optional
        What a look has decided already; it stands.

    Returns
    -------
    RunResult

    Notes
    -----
    With a plan of looks the end of the run takes the share of the last look, so that all looks
    together keep to the risks.

    References
    ----------
    GK (4)-(7); ``docs/verdict.md`` for the guarded decision.

    """
    x = run.x_deg.values
    factor = run.rs_variance_factor
    limits = Limits.of(settings.norms, settings.model, 1.0 if factor is None else factor)
    moments = Moments.of(x)
    printed = _as_printed(moments, run.count_outside, limits, settings)
    counts = printed.counts
    evidence = evidence_of(
        x, method=settings.risk.method, n_plus=counts.n_plus, n_plus_plus=counts.n_plus_plus,
        span_s=run.span_s, offset_u_deg=settings.installation_offset_u_deg)
    guarded = decide(evidence, limits, _risk_at_the_end(settings))
    outcome, reason = ((early.outcome, early.reason) if early
                       else _conclude(guarded, printed.total))
    direction, length = circular_mean(x) if len(x) else (None, None)
    n = moments.n
    verdict = RunVerdict(
        run=number, source=source, start_ns=run.start_ns, end_ns=run.end_ns,
        duration_s=(run.end_ns - run.start_ns) / 1e9,
        pairing=PairingFigures.of(LedgerSegment(None), run.mean_lag_s, run.max_lag_s, factor),
        n_input=run.n_input, n_invalid=run.n_invalid, n_stabilization=run.n_stabilization, n=n,
        mean_deg=moments.mean_deg if n else None,
        min_deg=moments.min_deg if n else None,
        max_deg=moments.max_deg if n else None,
        max_abs_deg=max(abs(moments.min_deg), abs(moments.max_deg)) if n else None,
        mean_square_deg2=moments.mean_square_deg2,
        circular_mean_deg=direction, resultant_length=length, drift_coefficients_deg=(),
        variance_deg2=moments.variance_deg2, std_deg=moments.std_deg,
        variance_criterion=printed.variance, count_criterion=counts,
        total_error=printed.total, outcome=outcome, reason=reason,
        paper_outcome=printed.outcome, guarded=guarded,
        warnings=(*([str(early)] if early else ()),
                  *_warnings(moments, limits, guarded, settings)))
    return RunResult(verdict, evidence, limits, early)


def _risk_at_the_end(settings: Settings) -> Risk:
    """Return the risks of the verdict at the end of a run."""
    plan, risk = settings.sequential, settings.risk
    if plan.plan_s is None:
        return risk
    return Looks(plan.plan_s, plan.looks, risk).plan[-1].risk


def look_at(run: RunSeries, look: Look, settings: Settings) -> EarlyVerdict | None:
    """
    Decide on a run in progress at a look of the plan.

    Parameters
    ----------
    run : RunSeries
        Holding the differences up to the look.
    look : Look
        With its share of the risks.
    settings : Settings

    Returns
    -------
    EarlyVerdict or None
        None while the look is indeterminate.

    """
    limits = Limits.of(settings.norms, settings.model, run.rs_variance_factor)
    printed = _as_printed(run.moments(), run.count_outside, limits, settings)
    evidence = evidence_of(run.blocks(), method='dyadic', n_plus=printed.counts.n_plus,
                           n_plus_plus=printed.counts.n_plus_plus, span_s=run.span_s,
                           offset_u_deg=settings.installation_offset_u_deg)
    guarded = decide(evidence, limits, look.risk)
    outcome, reason = _conclude(guarded, printed.total)
    if outcome is Outcome.INDETERMINATE:
        return None
    return EarlyVerdict(look.index + 1, settings.sequential.looks, run.span_s, outcome, reason)


@dataclass(frozen=True, slots=True)
class _Printed:
    """What the criteria say as printed in GK."""

    variance: VarianceCriterion
    counts: CountCriterion
    total: TotalError
    outcome: Outcome


def _as_printed(moments: Moments, count: Callable[[float, float], int], limits: Limits,
                settings: Settings) -> _Printed:
    center = 0.0 if settings.variant == 'A' else moments.mean_deg
    variance = variance_criterion(moments.variance_deg2, limits)
    counts = count_criterion(moments.n, count(center, limits.count_limit_deg),
                             count(center, limits.tightened_count_limit_deg), limits)
    total = total_error(moments.mean_deg if moments.n else None, moments.variance_deg2, limits,
                        settings.norms, settings.model)
    outcomes = [variance.outcome, counts.outcome]
    if total.outcome is not None:
        outcomes.append(total.outcome)
    if moments.variance_deg2 is None:
        return _Printed(variance, counts, total, Outcome.INDETERMINATE)
    return _Printed(variance, counts, total, worst(outcomes))


def _conclude(guarded: Guarded, total: TotalError) -> tuple[Outcome, str]:
    """Return the outcome of a run and its reason."""
    if guarded.outcome is Outcome.NON_COMPLIANT:
        return guarded.outcome, guarded.reason
    if guarded.count_outcome is Outcome.NON_COMPLIANT:
        return Outcome.NON_COMPLIANT, 'count_lower_bound_above_allowed'
    if (guarded.outcome is Outcome.COMPLIANT
            and total.outcome not in (None, Outcome.COMPLIANT)):
        return Outcome.INDETERMINATE, 'total_error_not_within_norm'
    return guarded.outcome, guarded.reason


def _warnings(moments: Moments, limits: Limits, guarded: Guarded, settings: Settings) -> list[str]:
    found = []
    if settings.norms.preset is not None:
        found.append(f'sigma_max = {limits.sigma_max_deg:.6g} deg follows from the norm '
                     f'{settings.norms.preset}')
    if moments.n > 1 and moments.max_deg - moments.min_deg <= CONSTANT_DEG:
        found.append('constant_difference: the two sensors never differ by more or less: '
                     'is one of them frozen, or a copy of the other?')
    reference = limits.m_low * limits.sigma_ref_max_deg
    if moments.n > 1 and moments.variance_deg2 < reference ** 2:
        found.append('difference_variance_below_reference_variance: the norm of the RS is too '
                     'large, or its errors and those of the TS are correlated')
    if settings.variant == 'A' and guarded.bias_significant:
        found.append('variant_A_mean_not_zero: the mean difference is not zero, but variant A '
                     'takes it for zero')
    return found


def figures(part: RunSeries | Rolling, limits: Limits, settings: Settings) -> dict[str, Any]:
    """
    Return the figures of a window or of a run in progress, as they are published.

    Parameters
    ----------
    part : RunSeries or Rolling
        With at least one difference.
    limits : Limits
    settings : Settings

    Notes
    -----
    The bounds are what they are now, at the full risks: they are no verdict, for who waits for
    them to fall below a limit takes more than the stated risk.

    """
    moments = part.moments()
    printed = _as_printed(moments, part.count_outside, limits, settings)
    evidence = evidence_of(part.blocks(), method='dyadic', n_plus=printed.counts.n_plus,
                           n_plus_plus=printed.counts.n_plus_plus, span_s=part.span_s,
                           offset_u_deg=settings.installation_offset_u_deg)
    now = decide(evidence, limits, settings.risk)
    return {
        'n': moments.n, 'mean_deg': moments.mean_deg, 'std_deg': moments.std_deg,
        'min_deg': moments.min_deg, 'max_deg': moments.max_deg,
        'variance_deg2': moments.variance_deg2,
        'limit_deg2': limits.limit_deg2, 'tightened_limit_deg2': limits.tightened_limit_deg2,
        'n_plus': printed.counts.n_plus, 'n_plus_plus': printed.counts.n_plus_plus,
        'allowed': printed.counts.allowed,
        'total_error_low_deg': printed.total.low_deg, 'total_error_up_deg': printed.total.up_deg,
        'paper_outcome': printed.outcome.value,
        **{key: getattr(now, key) for key in (
            'nu', 'resolved', 'lower_bound_deg2', 'upper_bound_deg2', 'acceptance_limit_deg2',
            'rejection_limit_deg2', 'sigma_ts_lower_deg', 'sigma_ts_upper_deg', 'bias_u_deg')}}


def homogeneity(results: Sequence[RunResult]) -> Mapping[str, Any]:
    """Return what the runs say of each other; empty for fewer than two."""
    return {}
