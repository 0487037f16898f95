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

"""The criteria (5), (6) and (7) of GK as printed, applied together to the figures of a run."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Callable

from heading_intercompare.core.outcome import Outcome, worst
from heading_intercompare.core.settings import Settings

from .criteria import (
    apply_count_criterion,
    apply_variance_criterion,
    CountCriterion,
    estimate_total_error,
    Limits,
    TotalError,
    VarianceCriterion,
)

__all__ = ['apply_gk', 'Printed']


@dataclass(frozen=True, slots=True)
class Printed:
    """
    Findings of the criteria as printed.

    Attributes
    ----------
    variance : VarianceCriterion
    counts : CountCriterion
    total : TotalError
    outcome : Outcome
        The worst of the three; the total error counts only if it has a norm.

    """

    variance: VarianceCriterion
    counts: CountCriterion
    total: TotalError
    outcome: Outcome


def apply_gk(n: int, mean_deg: float | None, variance_deg2: float | None,
             count: Callable[[float], int], limits: Limits, settings: Settings) -> Printed:
    """
    Apply the criteria of GK.

    Parameters
    ----------
    n : int
        Number of differences.
    mean_deg, variance_deg2 : float or None
        Their mean and variance; None for too few differences.
    count : callable
        ``count(limit_deg)`` returns the number of deviations above a limit.
    limits : Limits
        Of variance and counts.
    settings : Settings
        Uses norms and model.

    References
    ----------
    GK (5), (6), (7).

    """
    variance = apply_variance_criterion(variance_deg2, limits)
    printed = limits.as_printed
    counts = apply_count_criterion(n, count(printed.count_limit_deg),
                                   count(printed.tightened_count_limit_deg), printed)
    total = estimate_total_error(mean_deg, variance_deg2, limits, settings.norms, settings.model)
    outcomes = [variance.outcome, counts.outcome]
    if total.outcome is not None:
        outcomes.append(total.outcome)
    together = Outcome.INDETERMINATE if variance_deg2 is None else worst(outcomes)
    return Printed(variance, counts, total, together)
