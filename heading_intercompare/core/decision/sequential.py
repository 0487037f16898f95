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
import math
from typing import Sequence

import numpy as np

from heading_intercompare.core.declared_figures import figure
from heading_intercompare.core.declared_settings import SettingsError
from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.settings import Risk, Settings

from .coverage import least_duration_s, UNSTATED_LEAST_S


@dataclass(frozen=True, slots=True)
class Look:
    """
    A time at which a run in progress may be decided.

    Attributes
    ----------
    index
        Number of the look, from 0; the last look of a plan in seconds is the end of the run.
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
    looks: int = figure('looks planned, with the end of the run')
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
        Planned length of the run, seconds, greater than 0; or 'open'.
    looks
        Number of looks, at least 2, the end of the run among them. Of a plan in seconds they are
        at plan, plan/2, plan/4, ..., and those earlier than the least duration of a run are
        dropped. Of an open plan they are at 1, 2, 4, ... times the least duration, and the end is
        whenever it comes.
    risk
        Risk to share. The looks before the end share half of each alpha equally. The end of a
        plan in seconds has the other half, and all if no look comes before it; that of an open
        plan has all that the looks taken left.

    Attributes
    ----------
    plan : tuple of Look
        All looks, first to last; the end is one of them only if it is planned.
    is_planned : bool
        Whether the end of the run is planned.
    number : int
        Number of looks, with the end.
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
    of all runs. An open plan keeps this for an end that does not depend on the data, and for one
    right after a look that decided.

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
    >>> looks = Looks('open', 4, Risk())
    >>> [look.span_ns // 10 ** 9 for look in looks.plan]
    [600, 1200, 2400]
    >>> [looks.risk_at_the_end(span_s).alpha_consumer for span_s in (599.0, 1200.0, 5000.0)]
    [0.05, 0.03333333333333333, 0.025]

    """

    def __init__(self, plan_s: float | str, looks: int, risk: Risk) -> None:
        if looks < 2:
            raise SettingsError(f'sequential.looks = {looks!r}: must be at least 2')
        least_ns = round(least_duration_s(risk) * 1e9)
        self.is_planned = not isinstance(plan_s, str)
        if isinstance(plan_s, str):
            # Without a least length the looks begin where they would if none were stated.
            first_ns = least_ns or round(UNSTATED_LEAST_S * 1e9)
            spans = [first_ns << k for k in range(looks - 1)]
        else:
            spans = _plan_spans(plan_s, looks, least_ns)
        self.number = len(spans) + (not self.is_planned)
        # Each early look has one of these parts of the risks; the end has what is left.
        self._parts = 2 * (self.number - 1)
        _check_parts(risk, self._parts)
        self.plan = tuple(
            Look(k, span, _divide(risk, self._parts if k < self.number - 1
                                  else self._divisor_at_the_end(k)))
            for k, span in enumerate(spans))
        self._risk, self.taken = risk, 0

    def _divisor_at_the_end(self, n_taken: int) -> float:
        """Return by what the risks are divided at the end, after this many looks."""
        return self._parts / (self._parts - n_taken) if self._parts else 1.0

    def risk_at_the_end(self, span_s: float) -> Risk:
        """
        Return the risks at the end of a run.

        Parameters
        ----------
        span_s
            Time from the first to the last difference of the run, seconds.

        """
        span_ns = math.inf if self.is_planned else span_s * 1e9
        n_taken = sum(look.span_ns <= span_ns for look in self.plan[:self.number - 1])
        return _divide(self._risk, self._divisor_at_the_end(n_taken))

    @property
    def next_span_ns(self) -> int | None:
        """Span of the next look, nanoseconds; None if only the end of the run is left."""
        return self.plan[self.taken].span_ns if self.taken < self.number - 1 else None

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


def risk_at_the_end(settings: Settings, span_s: float = math.inf) -> Risk:
    """
    Return the risks of the verdict at the end of a run: what its looks leave of them.

    Parameters
    ----------
    settings
        Uses the risks and the looks.
    span_s
        Time from the first to the last difference of the run, seconds; by default it is so long
        that all looks were taken.

    """
    plan, risk = settings.sequential, settings.risk
    if plan.plan_s is None:
        return risk
    return Looks(plan.plan_s, plan.looks, risk).risk_at_the_end(span_s)


def _plan_spans(plan_s: float, looks: int, least_ns: int) -> list[int]:
    """Return the spans of the looks of a plan in seconds, nanoseconds; the last is its end."""
    if not plan_s > 0.0:
        raise SettingsError(f'sequential.plan_s = {plan_s!r}: must be greater than 0')
    plan_ns = round(plan_s * 1e9)
    spans = [plan_ns >> (looks - 1 - k) for k in range(looks)]
    return [span for span in spans[:-1] if span >= least_ns] + spans[-1:]


def _check_parts(risk: Risk, parts: int) -> None:
    """Raise SettingsError if a risk is too small for its parts."""
    for name in ('alpha_consumer', 'alpha_producer'):
        if parts and getattr(risk, name) / parts < 1e-6:
            raise SettingsError(f'risk.{name} = {getattr(risk, name)!r}: too small to share '
                                f'among the looks; must be at least {parts}e-06, or '
                                'sequential.plan_s must be none')


def _divide(risk: Risk, divisor: float) -> Risk:
    """Return a part of both risks."""
    return replace(risk, alpha_consumer=risk.alpha_consumer / divisor,
                   alpha_producer=risk.alpha_producer / divisor)
