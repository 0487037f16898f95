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

"""The first page: the verdict, what it rests on and covers, its validity, what would decide."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Sequence

from heading_intercompare.core.decision.coverage import Coverage, coverage_of, span_words
from heading_intercompare.core.decision.norm_presets import sigma_max_deg
from heading_intercompare.core.diagnostics.assumptions import VIOLATED
from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.validity.condition import DOUBTFUL, VOID
from heading_intercompare.core.verdict.conclusion import campaign_words, explain
from heading_intercompare.core.verdict.headline import OUTCOME_WORDS
from heading_intercompare.core.verdict.run_gravity import count_compliant, gravity_of
from heading_intercompare.core.verdict.verdict_document import RunVerdict, Verdict
from heading_intercompare.core.verdict.vocabulary import NO_RUN
from heading_intercompare.report.formatting import (
    bounds,
    number,
    outcome,
    rounded,
    with_uncertainty,
    with_unit,
)

from .holding import find_worst, upper_bound_holds, worth_of
from .run_list import MANY

#: A letter tells the outcomes apart in black and white and for the colour-blind.
SIGNS = {Outcome.COMPLIANT: '✓', Outcome.NON_COMPLIANT: '✗', Outcome.INDETERMINATE: '?'}
_MEANS = {
    Outcome.COMPLIANT: 'The tested sensor meets its norm.',
    Outcome.NON_COMPLIANT: 'The tested sensor does not meet its norm.',
    Outcome.INDETERMINATE: 'It is open whether the tested sensor meets its norm.',
}
_MOST_RUNS = 8


@dataclass(frozen=True, slots=True)
class FirstPage:
    """
    The first page in words.

    Attributes
    ----------
    kind
        The outcome as the name of a style; 'void' or 'doubtful' replace it.
    sign, word, means, headline
        The outcome as a sign, a word, a sentence, and in the one line of the verdict.
    facts
        What the verdict rests on and covers, its validity, what would decide, and the date of
        issue; an empty value is to be filled in by hand.
    runs
        A line for each run, if there are several.

    """

    kind: str
    sign: str
    word: str
    means: str
    headline: str
    facts: Sequence[tuple[str, str]]
    runs: Sequence[str]


def compose_first_page(verdict: Verdict, gk: bool = False,
                       signed: str | None = None) -> FirstPage:
    """Return what the first page says, with the outcome by GK as printed if `gk`."""
    void = verdict.validity_effect == VOID and verdict.outcome is Outcome.INDETERMINATE
    doubtful = verdict.validity_effect == DOUBTFUL
    means = _MEANS[verdict.outcome]
    if void:
        means = 'The comparison says nothing about the tested sensor.'
    facts = [('norms', _norms(verdict.settings)), ('rests on', _rest_on(verdict.runs)),
             ('measured', _measured(verdict)), ('covers', _covered(verdict)),
             ('validity', _validity(verdict)), ('why', _why(verdict))]
    if gk and not void:
        facts.append(('GK as printed', f'{outcome(verdict.paper_outcome)}; that rule makes no '
                      'allowance for the sampling error, and does not decide here'))
    facts.append(('electronic signature', tell_signature(signed)))
    facts.append(('date of issue', verdict.settings.trial.issue_date or ''))
    return FirstPage(
        kind='void' if void else verdict.outcome.value.replace('_', '-'),
        sign=SIGNS[verdict.outcome],
        word=OUTCOME_WORDS[verdict.outcome] + (
            ', VOID' if void else ', DOUBTFUL' if doubtful else ''),
        means=means, headline=verdict.headline, facts=facts, runs=_list_runs(verdict))


def tell_signature(signed: str | None) -> str:
    """Return who signed the file of the verdict, and that it is unchanged, or that nobody did."""
    return 'not signed' if signed is None else f'the verdict is {signed}'


def _norms(settings: Settings) -> str:
    largest_deg = number(sigma_max_deg(settings.norms, settings.model))
    return (f'standard deviation of the TS at most {with_unit(largest_deg, "deg")}, of the RS at '
            f'most {with_unit(number(settings.norms.sigma_ref_max_deg), "deg")}')


def _rest_on(runs: Sequence[RunVerdict]) -> str:
    if not runs:
        return NO_RUN
    count = '1 run' if len(runs) == 1 else f'{len(runs)} runs'
    text = (f'{count} of {span_words(sum(run.coverage.span_s for run in runs))} analysed, '
            f'{sum(run.n for run in runs)} differences TS - RS')
    counts = [worth_of(run) for run in runs if run.n]
    worth = sum(count for count in counts if count is not None)
    if None in counts:
        where = f' for {counts.count(None)} of {len(runs)} runs' if len(runs) > 1 else ''
        return f'{text}; how many independent ones they are worth is unknown{where}'
    return (f'{text}, worth {rounded(worth, worth)} independent ones for the variance' if worth
            else text)


def _measured(verdict: Verdict) -> str:
    """Return the figures of the run, or of the run with the largest variance."""
    run = find_worst(verdict)
    if run is None:
        return 'nothing: too few differences'
    guarded = run.guarded
    words = [f'mean difference {_mean(run)}',
             f'standard deviation of the differences '
             f'{with_unit(number(run.std_deg, 3), "deg")}']
    if upper_bound_holds(run) and guarded.upper_bound_deg2 is not None:
        variance = bounds(guarded.lower_bound_deg2, guarded.upper_bound_deg2)
        words.append(f'variance, at the stated risks, {variance} deg², '
                     f'to be at most {number(guarded.acceptance_limit_deg2, 3)} deg²')
    where = f'run {run.run}, with the largest variance: ' if len(verdict.runs) > 1 else ''
    return where + '; '.join(words)


def _mean(run: RunVerdict) -> str:
    return with_unit(with_uncertainty(run.mean_deg, run.guarded.bias_u_deg), 'deg')


def _covered(verdict: Verdict) -> str:
    coverage = _coverage(verdict)
    if coverage is None:
        return 'nothing'
    if verdict.outcome is Outcome.NON_COMPLIANT:
        return 'the sensor as it was: a norm that is broken is broken, however long the record'
    if verdict.outcome is Outcome.INDETERMINATE:
        return 'nothing, because the verdict is open'
    return f'it holds {coverage.words}, and for the sea, place and manoeuvres of its runs'


def _validity(verdict: Verdict) -> str:
    """Return the conditions that are violated, each with the runs in which it is."""
    runs = verdict.runs
    places: dict[tuple[str, str], list[tuple[int, str]]] = {}
    for run in runs:
        for finding in run.validity:
            if finding.effect in (VOID, DOUBTFUL):
                places.setdefault((finding.effect, finding.condition), []).append(
                    (run.run, finding.words))
    conditions = [f'{finding.effect.upper()}: {finding.words}'
                  for finding in verdict.campaign.validity or ()
                  if finding.effect in (VOID, DOUBTFUL)]
    for (effect, _), where in places.items():
        first, words = where[0]
        more = f' and {len(where) - 1} more' if len(where) > 1 else ''
        conditions.append(f'{effect.upper()}: {words}'
                          + (f' (run {first}{more})' if len(runs) > 1 else ''))
    if conditions:
        return '; '.join(conditions)
    violated = sorted({a.id for run in runs for a in run.assumptions if a.state == VIOLATED})
    if violated:
        listed = ', '.join(f'({key})' for key in violated)
        return f'no condition decides; the data refute {listed} of GK, which does not decide'
    return 'no condition of the comparison is violated' if runs else 'not examined'


def _why(verdict: Verdict) -> str:
    if len(verdict.runs) == 1 and verdict.campaign.rule == 'every_run':
        return explain(verdict.runs[0])
    return campaign_words(verdict.campaign, verdict.runs, _coverage(verdict))


def _coverage(verdict: Verdict) -> Coverage | None:
    """Return the coverage of all runs together, by the rule of the campaign."""
    shared, risk = verdict.campaign.sensor, verdict.settings.risk
    if not verdict.runs:
        return None
    if verdict.campaign.rule != 'sensor':
        return min((run.coverage for run in verdict.runs), key=lambda coverage: coverage.span_s)
    if shared is None:
        return None
    return coverage_of(shared.span_s, risk, apart_s=None if shared.between_upper_bound_deg2 is None
                       else shared.apart_s, scopes=[
                           run.coverage.scope for run in verdict.runs
                           if run.coverage.scope is not None])


def _list_runs(verdict: Verdict) -> list[str]:
    if len(verdict.runs) < 2:
        return []
    runs = sorted(verdict.runs, key=gravity_of)
    if verdict.campaign.rule == 'sensor':
        # No run decides alone, so what it alone would need says nothing.
        lines = [f'run {run.run}: {run.n} differences in {span_words(run.coverage.span_s)}, mean '
                 f'{_mean(run)}, standard deviation {with_unit(number(run.std_deg, 3), "deg")}'
                 for run in runs[:_MOST_RUNS]]
    else:
        if len(runs) > MANY:
            runs = [run for run in runs if run.outcome is not Outcome.COMPLIANT]
        lines = [count_compliant(verdict.runs),
                 *(f'run {run.run} alone: {run.headline}' for run in runs[:_MOST_RUNS])]
    if len(runs) > _MOST_RUNS:
        lines.append(f'and {len(runs) - _MOST_RUNS} more, see the runs')
    return lines
