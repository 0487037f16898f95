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

"""Current figures of a window or of a run in progress, without a verdict."""

from __future__ import annotations

from typing import Any

from heading_intercompare.core.decision.coverage import slowest_error_s
from heading_intercompare.core.decision.criteria import apply_gk, Limits, Printed
from heading_intercompare.core.decision.guarded import decide, Evidence, gather_evidence
from heading_intercompare.core.decision.sequential import risk_at_the_end
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.statistics.moments import Moments

from .rolling_window import Rolling
from .run_series import RunSeries


def _apply_gk_so_far(part: RunSeries | Rolling, limits: Limits, settings: Settings) -> Printed:
    moments = part.moments()
    return apply_gk(moments.n, moments.mean_deg, moments.variance_deg2,
                    lambda limit: part.count_outside(_center(moments, settings), limit), limits,
                    settings)


def _center(moments: Moments, settings: Settings) -> float:
    """Return what deviations are taken from: nothing in variant A, otherwise the mean."""
    return 0.0 if settings.variant == 'A' else moments.mean_deg


def name_moments(moments: Moments) -> dict[str, Any]:
    """Return the figures that cost little, so that they can be published with every batch."""
    return {'n': moments.n, 'mean_deg': moments.mean_deg, 'std_deg': moments.std_deg,
            'min_deg': moments.min_deg, 'max_deg': moments.max_deg,
            'variance_deg2': moments.variance_deg2}


def compute_figures(part: RunSeries | Rolling, limits: Limits,
                    settings: Settings) -> dict[str, Any]:
    """
    Return the figures of a window or of a run in progress, as they are published.

    Parameters
    ----------
    part
        Must hold at least one difference.
    limits
        Of the criteria.
    settings
        Norms, model and variant.

    Notes
    -----
    The bounds are the current ones at the full risks. They are no verdict: stopping as soon as
    they fall below a limit takes more than the stated risk. So no outcome word is among the
    figures. The figures are about the mean. A drift and the stabilisation period are removed only
    at the end of a run; until then `not_yet_removed` names them.

    """
    return _compute(part, limits, settings)[0]


def compute_run_figures(run: RunSeries, limits: Limits, settings: Settings) -> dict[str, Any]:
    """
    Return the figures of a run in progress, and what it lacks.

    Parameters
    ----------
    run
        Must hold at least one difference.
    limits
        Of the criteria.
    settings
        Norms, model, variant, risk and looks.

    Returns
    -------
    dict
        Those of `compute_figures`, and: `span_s`, the time from the first to the last analysed
        difference; `needed_s`, how much longer the run must be to decide at the risks of its end,
        other things being equal (0: no longer; inf: no length of such data decides; None: not
        known yet).

    Notes
    -----
    `needed_s` does not say which way the run will be decided. Its risks are those that all looks
    leave, so an end before the last look needs no more than it says.

    """
    figures, evidence = _compute(run, limits, settings)
    hours = decide(evidence, limits, risk_at_the_end(settings)).hours_needed
    needed_s = None if hours is None else max(0.0, hours * 3600.0 - run.span_s)
    return {**figures, 'span_s': run.span_s, 'needed_s': needed_s}


def _compute(part: RunSeries | Rolling, limits: Limits,
             settings: Settings) -> tuple[dict[str, Any], Evidence]:
    """Return the figures and the evidence that they rest on."""
    moments = part.moments()
    center = _center(moments, settings)
    printed = _apply_gk_so_far(part, limits, settings)
    evidence = gather_evidence(
        part.cells(), n_plus=part.count_outside(center, limits.count_limit_deg),
        n_plus_plus=part.count_outside(center, limits.tightened_count_limit_deg),
        span_s=part.span_s, mean_deg=moments.mean_deg,
        offset_u_deg=settings.installation_offset_u_deg,
        slowest_s=slowest_error_s(settings.risk))
    now = decide(evidence, limits, settings.risk)
    return {
        **name_moments(moments),
        'limit_deg2': limits.limit_deg2, 'tightened_limit_deg2': limits.tightened_limit_deg2,
        'n_plus': printed.counts.n_plus, 'n_plus_plus': printed.counts.n_plus_plus,
        'allowed': printed.counts.allowed,
        'total_error_low_deg': printed.total.low_deg, 'total_error_up_deg': printed.total.up_deg,
        **{key: getattr(now, key) for key in (
            'nu', 'f', 'slow_allowance_deg2', 'lower_bound_deg2', 'upper_bound_deg2',
            'acceptance_limit_deg2', 'rejection_limit_deg2', 'sigma_ts_lower_deg',
            'sigma_ts_upper_deg', 'bias_u_deg')},
        'not_yet_removed': ' '.join(_list_not_yet_removed(settings)) or None}, evidence


def _list_not_yet_removed(settings: Settings) -> list[str]:
    return [name for name, is_due in (('drift', settings.drift_order != 0),
                                      ('stabilization', settings.runs.stabilization_s == 'auto'))
            if is_due]
