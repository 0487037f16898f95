# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""One run judged at its end: figures, criteria as printed, guarded decision, diagnostics."""

from __future__ import annotations

from dataclasses import dataclass, replace
import math
from typing import Iterator, Sequence

import numpy as np

from .analysed import Analysed, analysed, HIGHEST_ORDER_REMOVED
from .angles import circular_mean
from .cells import Cells
from .criteria import Limits
from .early import conclude, EarlyVerdict, risk_at_the_end
from .ergodicity import Homogeneity, homogeneity, RunFigures
from .guarded import decide, Evidence, evidence_of, Guarded
from .ledger import LedgerSegment
from .noise import correlation_times
from .outcome import Outcome
from .printed import as_printed, Printed
from .run_diagnostics import diagnose, with_runs
from .run_series import RunSeries
from .settings import Settings
from .verdict import PairingFigures, RunVerdict

__all__ = ['compare_runs', 'judge', 'RunResult']

CONSTANT_DEG = 1e-9
"""Peak-to-peak difference up to which two sensors are taken for a frozen pair, degrees."""


@dataclass(frozen=True, slots=True)
class RunResult:
    """A judged run, and what is needed to decide on it again among several runs."""

    verdict: RunVerdict
    evidence: Evidence
    limits: Limits
    printed: Printed

    def with_pairing(self, share: LedgerSegment, warnings: Sequence[str] = ()) -> 'RunResult':
        """Return the result with its share of the pairing ledger."""
        old = self.verdict.pairing
        pairing = PairingFigures.of(share, old.mean_lag_s, old.max_lag_s, old.rs_variance_factor)
        return replace(self, verdict=replace(
            self.verdict, pairing=pairing, warnings=(*self.verdict.warnings, *warnings)))

    def among(self, run: int, runs: Homogeneity) -> 'RunResult':
        """Return the result with its number among the runs, and what they say of each other."""
        checked = with_runs(self.verdict.assumptions, runs)
        return replace(self, verdict=replace(self.verdict, run=run, assumptions=checked))

    def outcome_among(self, m: int, settings: Settings) -> Outcome:
        """Return the outcome when m runs share the producer's risk."""
        if m == 1 or self.verdict.outcome is not Outcome.NON_COMPLIANT:
            return self.verdict.outcome
        risk = risk_at_the_end(settings)
        shared = replace(risk, alpha_producer=risk.alpha_producer / m)
        return conclude(decide(self.evidence, self.limits, shared), self.printed)[0]


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
    With a plan of looks the end of the run is the last look and takes its share, so that all
    looks together keep to the risks.

    References
    ----------
    GK (4)-(7); ``docs/verdict.md`` for the guarded decision.

    """
    factor = run.rs_variance_factor
    limits = Limits.of(settings.norms, settings.model, 1.0 if factor is None else factor)
    data = analysed(run, limits, settings)
    moments = data.moments
    n = moments.n
    printed = _printed(data, limits, settings)
    series = data.x_deg if data.residual_deg is None else data.residual_deg
    # Live figures come from the same sums, so they are the same to the bit.
    as_it_came = data.residual_deg is None and not data.n_left_out
    evidence = evidence_of(
        run.cells() if as_it_came else Cells.of(series, data.stamp_ns),
        n_plus=printed.counts.n_plus, n_plus_plus=printed.counts.n_plus_plus,
        span_s=data.span_s, offset_u_deg=settings.installation_offset_u_deg,
        order=HIGHEST_ORDER_REMOVED if settings.drift_order == 'auto' else data.order,
        mean_deg=moments.mean_deg if n else None)
    guarded = decide(evidence, limits, risk_at_the_end(settings))
    outcome, reason = (early.outcome, early.reason) if early else conclude(guarded, printed)
    found = diagnose(data.stamp_ns, data.x_deg, data.rs_deg, settings, guarded, limits,
                     residual_deg=data.residual_deg, times=correlation_times(series))
    direction, length = circular_mean(data.x_deg) if n else (None, None)
    verdict = RunVerdict(
        run=number, source=source, start_ns=run.start_ns, end_ns=run.end_ns,
        duration_s=(run.end_ns - run.start_ns) / 1e9,
        pairing=PairingFigures.of(LedgerSegment(None), run.mean_lag_s, run.max_lag_s, factor),
        n_input=run.n_input, n_invalid=run.n_invalid,
        n_stabilization=run.n_stabilization + data.n_left_out, n=n,
        mean_deg=moments.mean_deg if n else None,
        min_deg=moments.min_deg if n else None,
        max_deg=moments.max_deg if n else None,
        max_abs_deg=max(abs(moments.min_deg), abs(moments.max_deg)) if n else None,
        mean_square_deg2=moments.mean_square_deg2,
        circular_mean_deg=direction, resultant_length=length,
        drift_coefficients_deg=data.coefficients_deg, variance_deg2=data.variance_deg2,
        std_deg=None if data.variance_deg2 is None else math.sqrt(data.variance_deg2),
        variance_criterion=printed.variance, count_criterion=printed.counts,
        total_error=printed.total, outcome=outcome, reason=reason,
        paper_outcome=printed.outcome, guarded=guarded, skew=found.skew, drift=found.drift,
        heading_dependence=found.heading_dependence, normality=found.normality,
        stationarity=found.stationarity, correlation=found.correlation, allan=found.allan,
        assumptions=found.assumptions,
        warnings=(*([str(early)] if early else ()),
                  *_warnings(data, limits, guarded, settings), *found.warnings))
    return RunResult(verdict, evidence, limits, printed)


def _printed(data: Analysed, limits: Limits, settings: Settings) -> Printed:
    deviation = data.deviations(settings.variant)
    return as_printed(data.moments.n, data.moments.mean_deg if data.moments.n else None,
                      data.variance_deg2,
                      lambda limit: int(np.count_nonzero(deviation > limit)), limits, settings)


def _warnings(data: Analysed, limits: Limits, guarded: Guarded,
              settings: Settings) -> Iterator[str]:
    moments = data.moments
    if settings.norms.preset is not None:
        yield (f'sigma_max = {limits.sigma_max_deg:.6g} deg follows from the norm '
               f'{settings.norms.preset}')
    if data.order:
        yield f'drift_removed: a polynomial of order {data.order} is taken out of the differences'
    if moments.n > 1 and moments.max_deg - moments.min_deg <= CONSTANT_DEG:
        yield ('constant_difference: the two sensors never differ by more or less: is one of '
               'them frozen, or a copy of the other?')
    reference_deg2 = (limits.m_low * limits.sigma_ref_max_deg) ** 2
    if data.variance_deg2 is not None and data.variance_deg2 < reference_deg2:
        yield ('difference_variance_below_reference_variance: the norm of the RS is too large, '
               'or its errors and those of the TS are correlated')
    if settings.variant == 'A' and guarded.bias_significant:
        yield ('variant_A_mean_not_zero: the mean difference is not zero, but variant A takes '
               'it for zero')


def compare_runs(results: Sequence[RunResult]) -> Homogeneity:
    """Return what the runs say of each other."""
    return homogeneity([
        RunFigures(r.verdict.mean_deg, r.evidence.spread.mean_variance_deg2,
                   r.evidence.spread.d_deg2, r.evidence.spread.nu)
        for r in results if r.evidence.spread is not None])
