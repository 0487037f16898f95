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

"""Early verdicts: a few looks, at doubling times, that share the risk of one verdict."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Sequence

import numpy as np

from heading_intercompare.core.declared_figures import figure
from heading_intercompare.core.declared_settings import SettingsError
from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.settings import Risk, Settings

from .coverage import least_duration_s


@dataclass(frozen=True, slots=True)
class Look:
    """
    A time at which a run in progress may be decided.

    Attributes
    ----------
    index
        Number of the look, from 0; the last look is the planned end of the run.
    span_ns
        Time from the first difference to the look, nanoseconds.
    risk
        This look's share of both risks.

    """

    index: int
    span_ns: int
    risk: Risk


@dataclass(frozen=True, slots=True)
class LookVerdict:
    """The result of a look at a run in progress; keys of the JSON."""

    look: int = figure('number of the look, from 1')
    looks: int = figure('looks planned')
    span_s: float = figure('time since the first difference')
    outcome: Outcome = figure('outcome at the look')
    reason: str = figure('why, as for a run', '`not_confirmed` if only an earlier look accepted')
    validity_effect: str = figure('gravest effect of a finding at that time', '`holds`, '
                                  '`doubtful` or `void`', default='holds')
    headline: str = figure('look in one line', default='')

    def __str__(self) -> str:
        return (f'look {self.look} of {self.looks}, {self.span_s:.1f} s after the first '
                f'difference: {self.outcome}')


def find_rejection(looks: Sequence[LookVerdict]) -> LookVerdict | None:
    """Return the first look that rejected; None if none did."""
    return next((look for look in looks if look.outcome is Outcome.NON_COMPLIANT), None)


def find_standing(looks: Sequence[LookVerdict]) -> LookVerdict | None:
    """
    Return the result that stands after the looks taken so far.

    Returns
    -------
    LookVerdict or None
        The first look that rejected. Otherwise, if any look accepted, the last one; if that does
        not confirm the acceptance, its reason is 'not_confirmed'. None while no look has decided.

    """
    rejected = find_rejection(looks)
    if rejected is not None:
        return rejected
    if not any(look.outcome is Outcome.COMPLIANT for look in looks):
        return None
    last = looks[-1]
    if last.outcome is Outcome.COMPLIANT:
        return last
    return replace(last, reason='not_confirmed')


class Looks:
    """
    The looks at one run, each taken once.

    Parameters
    ----------
    plan_s
        Planned length of the run, seconds, greater than 0.
    looks
        Number of looks, at least 2: at plan, plan/2, plan/4, ... Looks earlier than the least
        duration of a run are dropped.
    risk
        Risk to share. The last look gets half of each alpha, the earlier looks share the other
        half equally. A single look gets all of it.

    Attributes
    ----------
    plan : tuple of Look
        All looks, first to last.
    taken : int
        Number of looks taken.

    Raises
    ------
    SettingsError
        If the plan or the number of looks is out of range, or a risk is too small to share.

    Notes
    -----
    The probability that any look decides wrongly is at most the sum of the shares, whatever the
    dependence between looks (Bonferroni). Do not look more often, or at the full risk each time:
    a rule of 5 % applied every minute for ten hours accepts at the limit in more than a quarter
    of all runs.

    References
    ----------
    E.14 of ``docs/risk.md``.

    Examples
    --------
    >>> looks = Looks(3600.0, 7, Risk())
    >>> [look.span_ns // 10 ** 9 for look in looks.plan]
    [900, 1800, 3600]
    >>> [look.risk.alpha_consumer for look in looks.plan]
    [0.0125, 0.0125, 0.025]
    >>> [look.index for look in looks.take_due(2000.0)], looks.take_due(3000.0)
    ([0, 1], [])

    """

    def __init__(self, plan_s: float, looks: int, risk: Risk) -> None:
        if not plan_s > 0.0:
            raise SettingsError(f'sequential.plan_s = {plan_s!r}: must be greater than 0')
        if looks < 2:
            raise SettingsError(f'sequential.looks = {looks!r}: must be at least 2')
        plan_ns = round(plan_s * 1e9)
        least_ns = round(least_duration_s(risk) * 1e9)
        spans = [plan_ns >> (looks - 1 - k) for k in range(looks)]
        spans = [span for span in spans[:-1] if span >= least_ns] + spans[-1:]
        early, last = (_share(risk, 2 * (len(spans) - 1)), _share(risk, 2)) \
            if len(spans) > 1 else (risk, risk)
        self.plan = tuple(Look(k, span, last if k == len(spans) - 1 else early)
                          for k, span in enumerate(spans))
        self.taken = 0

    @property
    def next_span_ns(self) -> int | None:
        """Span of the next look, nanoseconds; None if only the planned end of the run is left."""
        early = self.plan[:-1]
        return early[self.taken].span_ns if self.taken < len(early) else None

    def take_due(self, span_s: float) -> list[Look]:
        """
        Take the looks that a run of this length has reached.

        Parameters
        ----------
        span_s
            Time since the first difference of the run, seconds.

        Returns
        -------
        list of Look
            Looks not taken before, first to last; each is returned once.

        """
        return self._take_reached(round(span_s * 1e9))

    def _take_reached(self, span_ns: int) -> list[Look]:
        start = self.taken
        while self.taken < len(self.plan) and self.plan[self.taken].span_ns <= span_ns:
            self.taken += 1
        return list(self.plan[start:self.taken])

    def cuts(self, start_ns: int, stamp_ns: np.ndarray) -> list[tuple[int, Look]]:
        """
        Take the looks that fall into a chunk, and say where.

        Parameters
        ----------
        start_ns
            Stamp of the first difference of the run, nanoseconds.
        stamp_ns : ndarray of int64, shape (n,)
            Stamps of the chunk, increasing.

        Returns
        -------
        list of (int, Look)
            Number of samples of the chunk that belong to the look: up to and including the first
            one that reaches its time. So a look sees the same samples, however they are chunked.

        """
        if not len(stamp_ns):
            return []
        reached = self._take_reached(int(stamp_ns[-1]) - start_ns)
        return [(int(np.searchsorted(stamp_ns, start_ns + look.span_ns)) + 1, look)
                for look in reached]


def risk_at_the_end(settings: Settings) -> Risk:
    """Return the risks of the verdict at the end of a run; with a plan, those of the last look."""
    plan, risk = settings.sequential, settings.risk
    if plan.plan_s is None:
        return risk
    return Looks(plan.plan_s, plan.looks, risk).plan[-1].risk


def _share(risk: Risk, parts: int) -> Risk:
    for name in ('alpha_consumer', 'alpha_producer'):
        if getattr(risk, name) / parts < 1e-6:
            raise SettingsError(f'risk.{name} = {getattr(risk, name)!r}: too small to share '
                                f'among the looks; must be at least {parts}e-06')
    return replace(risk, alpha_consumer=risk.alpha_consumer / parts,
                   alpha_producer=risk.alpha_producer / parts)
