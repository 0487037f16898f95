# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""What can be said before a run ends: figures of the moment, and early verdicts at looks."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from .criteria import Limits
from .guarded import decide, Evidence, evidence_of, Guarded, REASONS
from .outcome import Outcome
from .printed import as_printed, Printed
from .rolling import Rolling
from .run_series import RunSeries
from .sequential import Look, Looks
from .settings import Risk, Settings

__all__ = ['ALL_REASONS', 'conclude', 'EarlyVerdict', 'figures', 'look_at', 'risk_at_the_end']


ALL_REASONS = {
    **REASONS,
    'count_lower_bound_above_allowed': 'too many extreme differences, at the stated risk',
    'total_error_not_within_norm': 'the total error is not shown to be within its norm',
}
"""Why the outcome of a run is what it is: code and words."""


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


def risk_at_the_end(settings: Settings) -> Risk:
    """Return the risks of the verdict at the end of a run: with a plan, those of its last look."""
    plan, risk = settings.sequential, settings.risk
    if plan.plan_s is None:
        return risk
    return Looks(plan.plan_s, plan.looks, risk).plan[-1].risk


def conclude(guarded: Guarded, printed: Printed) -> tuple[Outcome, str]:
    """Return the outcome of a run and its reason."""
    if guarded.outcome is Outcome.NON_COMPLIANT:
        return guarded.outcome, guarded.reason
    if guarded.count_outcome is Outcome.NON_COMPLIANT:
        return Outcome.NON_COMPLIANT, 'count_lower_bound_above_allowed'
    if (guarded.outcome is Outcome.COMPLIANT
            and printed.total.outcome not in (None, Outcome.COMPLIANT)):
        return Outcome.INDETERMINATE, 'total_error_not_within_norm'
    return guarded.outcome, guarded.reason


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
        None while the look is indeterminate. The last look is the end of the run, whenever that
        is, so it is left to `judge`.

    Notes
    -----
    A look takes the differences about their mean: a drift is removed, and a start found to be
    unsettled left out, at the end of the run only.

    """
    if look.index == settings.sequential.looks - 1:
        return None
    limits = Limits.of(settings.norms, settings.model, run.rs_variance_factor)
    printed = _printed_so_far(run, limits, settings)
    evidence = _evidence(run, printed, settings)
    outcome, reason = conclude(decide(evidence, limits, look.risk), printed)
    if outcome is Outcome.INDETERMINATE:
        return None
    return EarlyVerdict(look.index + 1, settings.sequential.looks, run.span_s, outcome, reason)


def _printed_so_far(part: RunSeries | Rolling, limits: Limits, settings: Settings) -> Printed:
    moments = part.moments()
    center = 0.0 if settings.variant == 'A' else moments.mean_deg
    return as_printed(moments.n, moments.mean_deg, moments.variance_deg2,
                      lambda limit: part.count_outside(center, limit), limits, settings)


def _evidence(part: RunSeries | Rolling, printed: Printed, settings: Settings) -> Evidence:
    return evidence_of(part.cells(), n_plus=printed.counts.n_plus,
                       n_plus_plus=printed.counts.n_plus_plus, span_s=part.span_s,
                       mean_deg=part.moments().mean_deg,
                       offset_u_deg=settings.installation_offset_u_deg)


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
    printed = _printed_so_far(part, limits, settings)
    evidence = _evidence(part, printed, settings)
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
            'nu', 'f', 'slow_allowance_deg2', 'lower_bound_deg2', 'upper_bound_deg2',
            'acceptance_limit_deg2', 'rejection_limit_deg2', 'sigma_ts_lower_deg',
            'sigma_ts_upper_deg', 'bias_u_deg')}}
