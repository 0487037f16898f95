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

"""The figures of one pair of sensors: moments, bounds, skew and validity of all its runs."""

from __future__ import annotations

from dataclasses import dataclass
import math
from typing import Sequence

from heading_intercompare.core.declared_figures import figure
from heading_intercompare.core.sensor_conditions.convention import CONVENTION
from heading_intercompare.core.sensor_conditions.mean_difference import MEAN_DIFFERENCE
from heading_intercompare.core.sensor_conditions.same_source import SAME_SOURCE
from heading_intercompare.core.statistics.variance_uncertainty import (
    lower_bound,
    pool,
    Spread,
    upper_bound,
)
from heading_intercompare.core.validity.condition import DOUBTFUL, gravest, VOID
from heading_intercompare.core.verdict.spread_of_run import spread_of_run
from heading_intercompare.core.verdict.verdict_document import RunVerdict

#: A mean or a convention beyond what any norm explains: the pair differs, whatever its variance.
_GROSS = (CONVENTION.name, MEAN_DIFFERENCE.name)


@dataclass(frozen=True, slots=True, kw_only=True)
class PairFigures:
    """The figures of one pair of sensors; keys of the JSON. A missing figure is None."""

    first: str = figure('first sensor', 'the difference is first − second')
    second: str = figure('second sensor')
    of_reference: bool = figure('the second is the reference', 'then all pairs of readings are '
                                'judged; otherwise two pairs a second')
    runs: int = figure('runs')
    n: int = figure('differences analysed in them')
    mean_deg: float | None = figure('mean difference', 'of all runs, installation angles removed')
    std_deg: float | None = figure('standard deviation about the mean of each run')
    variance_deg2: float | None = figure('common variance of the runs', u='u_deg2')
    u_deg2: float | None = figure('standard uncertainty of the variance')
    lower_bound_deg2: float | None = figure('lower bound of the variance', "at the vote's risk")
    upper_bound_deg2: float | None = figure(
        'upper bound of the variance', "at the consumer's risk")
    limit_deg2: float = figure('largest variance that the norms of both explain')
    differs: bool | None = figure('a run shows more than that', 'null if no run can tell')
    gross: str = figure('what no norm explains, in words', 'such as another convention')
    skew_s: float | None = figure('latency or clock offset: age of the data of the first',
                                  'of the run that determines it best', u='skew_u_s')
    skew_u_s: float | None = figure('standard uncertainty of the offset')
    first_factor: float | None = figure('factor of interpolation in the noise of the first')
    second_factor: float | None = figure('factor of interpolation in the noise of the second')
    one_source: bool = figure('a run shows that both come from one source')
    validity_effect: str = figure('gravest effect in any run', '`holds`, `doubtful` or `void`')
    findings: tuple[str, ...] = figure('findings that are doubtful or void, in words')

    @property
    def names(self) -> tuple[str, str]:
        """Return the names of both sensors."""
        return self.first, self.second

    @property
    def share(self) -> float | None:
        """Return the standard deviation as a share of what the norms of both explain."""
        if self.variance_deg2 is None or not self.limit_deg2:
            return None
        return math.sqrt(self.variance_deg2 / self.limit_deg2)


def describe_pair(names: tuple[str, str], runs: Sequence[RunVerdict], limit_deg2: float, *,
                  of_reference: bool, risk: float, consumer: float) -> PairFigures:
    """
    Return the figures of a pair.

    Parameters
    ----------
    names
        Names of the sensors.
    runs
        Its judged runs; may be empty. A verdict read from JSON gives the same figures.
    limit_deg2
        Largest variance that the norms of both explain.
    of_reference
        Whether the second sensor is the reference.
    risk
        Risk that two sound sensors differ, for all runs of the pair together.
    consumer
        Risk of the upper bound.

    """
    findings = [f for run in runs for f in run.validity if f.effect in (DOUBTFUL, VOID)]
    gross = [f.words for f in findings if f.condition in _GROSS and f.effect == VOID]
    spreads = [spread for run in runs if (spread := spread_of_run(run)) is not None]
    beyond = any(lower_bound(spread, risk / len(spreads)) > limit_deg2 for spread in spreads)
    n = sum(run.n for run in runs)
    means = [run.n / n * run.mean_deg for run in runs if run.mean_deg is not None]
    return PairFigures(
        first=names[0], second=names[1], of_reference=of_reference, runs=len(runs), n=n,
        mean_deg=math.fsum(means) if means else None, **_pool(spreads, risk, consumer),
        limit_deg2=limit_deg2, differs=bool(beyond or gross) if spreads or gross else None,
        gross=gross[0] if gross else '', **_find_skew(runs),
        first_factor=_average(n, [(run.n, run.pairing.ts_variance_factor) for run in runs]),
        second_factor=_average(n, [(run.n, run.pairing.rs_variance_factor) for run in runs]),
        one_source=any(f.condition == SAME_SOURCE.name and f.effect == VOID for f in findings),
        validity_effect=gravest(run.validity_effect for run in runs),
        findings=tuple(dict.fromkeys(f.words for f in findings)))


def _pool(spreads: Sequence[Spread], risk: float, consumer: float) -> dict[str, float | None]:
    """Return the figures of the variance that all runs share."""
    names = 'std_deg', 'variance_deg2', 'u_deg2', 'lower_bound_deg2', 'upper_bound_deg2'
    if not spreads:
        return dict.fromkeys(names)
    whole = pool(spreads)
    return dict(zip(names, (math.sqrt(whole.d_deg2), whole.d_deg2, whole.s_deg2,
                            lower_bound(whole, risk), upper_bound(whole, consumer))))


def _find_skew(runs: Sequence[RunVerdict]) -> dict[str, float | None]:
    """Return the time skew of the run that determines it best."""
    skews = [(estimate.u_s, estimate.skew_s) for run in runs
             if (estimate := run.skew.estimate).well_determined and estimate.u_s is not None]
    u_s, skew_s = min(skews, key=lambda of_run: of_run[0], default=(None, None))
    return {'skew_s': skew_s, 'skew_u_s': u_s}


def _average(n: int, parts: Sequence[tuple[int, float | None]]) -> float | None:
    """Return the average of values that weigh by their numbers; None without any."""
    shares = [count / n * value for count, value in parts if value is not None and n]
    return math.fsum(shares) if shares else None
