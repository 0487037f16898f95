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

"""The decision rule in words, its risks and its scope; remarks on the uncertainty."""

from __future__ import annotations

from typing import Sequence

from heading_intercompare.core.decision.norm_presets import PRESETS, sigma_max_deg
from heading_intercompare.core.decision.sequential import Looks
from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.settings import Pairing, Settings
from heading_intercompare.core.validity.condition import is_doubtful, VOID
from heading_intercompare.core.verdict.verdict_document import RunVerdict, Verdict
from heading_intercompare.core.verdict.vocabulary import law_words
from heading_intercompare.report.formatting import interval, number, outcome, value

from .defaults import is_default, mark_default

Rows = list[tuple[str, str]]

_MET = {Outcome.COMPLIANT: 'met', Outcome.NON_COMPLIANT: 'not met',
        Outcome.INDETERMINATE: 'not decided; at the stated risks the data support neither '
                               '"met" nor "not met"'}


def describe_norms(settings: Settings) -> Rows:
    """Return the norms and the method as pairs of name and value."""
    norms = settings.norms
    ts_law, rs_law = law_words(settings.model)
    rows = [('norm of the TS standard deviation, sigma_max [deg]',
             number(sigma_max_deg(norms, settings.model))),
            ('norm of the RS standard deviation, sigma_ref_max [deg]',
             number(norms.sigma_ref_max_deg)),
            ('actual RS standard deviation, if known [deg]',
             number(norms.sigma_ref_deg)),
            ('bounds of M = sigma_ref / sigma_ref_max, as set [1]',
             mark_default(interval(norms.m_low, norms.m_up), settings, 'norms.m_low',
                          'norms.m_up')),
            ('norm of the total error at P [deg]',
             number(norms.total_error_max_deg)),
            ('confidence probability P [1]', mark_default(
                number(norms.probability), settings, 'norms.probability')),
            ('coverage factor by rule', mark_default(
                value(norms.k_rule), settings, 'norms.k_rule')),
            ('error laws', mark_default(f'TS {ts_law}, RS {rs_law} (model {settings.model})',
                                        settings, 'model')),
            ('variant of GK Table I', mark_default(
                value(settings.variant), settings, 'variant')),
            ('pairing', mark_default(_pairing(settings.pairing), settings, *(
                f'pairing.{name}' for name in (
                    'method', 'auto_s', 'kernel', 'max_gap_s', 'tolerance_s'))))]
    name = norms.preset
    if name in PRESETS:
        preset = PRESETS[name]
        rows[:0] = [('published norm', f'{name}: {preset.title}'), ('it requires', preset.content),
                    ('status of its text here', preset.status)]
        if preset.secant:
            rows.insert(3, ('latitude [deg]', number(norms.latitude_deg)))
    return rows


def _pairing(rule: Pairing) -> str:
    method = rule.method
    if method == 'nearest':
        return f'mutual nearest stamps, lag at most {number(rule.tolerance_s)} s'
    onto_ts, onto_rs = 'RS interpolated to the TS stamp', 'TS interpolated to the RS stamp'
    chosen = (f'{onto_rs} if the stamps of the first {number(rule.auto_s)} s show a slow RS, '
              f'otherwise {onto_ts}')
    words = {'interpolate': onto_ts, 'interpolate_ts': onto_rs, 'auto': chosen}[method]
    kernel = 'by the line between two' if rule.kernel == 'line' else 'by up to eight readings'
    gap = ('at most 1.5 usual steps apart' if rule.max_gap_s == 'auto'
           else f'at most {number(rule.longest_gap_s)} s apart')
    return f'{words}, {kernel}; readings {gap}'


def state_conformity(verdict: Verdict, gk: bool = False) -> Rows:
    """
    Return the statement of conformity as pairs of name and value.

    It has what ISO/IEC 17025:2017, 7.8.6, asks for: the decision rule, the results covered, and
    whether the specification is met; with `gk` also the outcome by GK as printed.
    """
    settings, runs = verdict.settings, verdict.runs
    consumer, producer = (
        mark_default(number(risk), settings, name) for risk, name in (
            (settings.risk.alpha_consumer, 'risk.alpha_consumer'),
            (settings.risk.alpha_producer, 'risk.alpha_producer')))
    m = len(runs)
    share = settings.risk.count_share
    reject = ('The counts of extreme differences can also reject, if the lower bound of their '
              f"rate exceeds 1 - P. A share of {number(share)} of the producer's risk goes to "
              'them, the rest to L.')
    if settings.norms.total_error_max_deg is not None:
        reject += (' The specification is found met only if the total error by GK (7) is '
                   'within its norm too.')
    return [
        ('decision rule',
         'Guarded and non-binary. A run is compliant if the upper bound U of the variance of '
         'the differences is at most A = sigma_max² + M_low² sigma_ref_max². It is '
         'non-compliant if its lower bound L exceeds R = sigma_max² + M_up² sigma_ref_max². '
         f'Otherwise it is indeterminate. {reject} U and L allow for the correlation of the '
         'errors in time. In A, sigma_max² is multiplied by the factor by which interpolation '
         'reduces the noise variance of the TS, and M_low² by that of the RS.'),
        ('several runs', _several(settings, m)),
        ("consumer's risk [1]", f'{consumer}, nominal: the largest probability that a TS just at '
                                'its norm is found compliant, if the assumptions hold.'
         + _describe_looks(settings)),
        ("producer's risk [1]", f'{producer}, nominal: the largest probability that a TS just at '
                                'its norm is found non-compliant, if the assumptions hold.'),
        ('results covered', _covered(runs)),
        ('specification', 'sigma_max of the TS: ' + _MET[verdict.outcome] + _doubts(verdict)),
        ('in one line', verdict.headline),
        *([] if not gk or verdict.validity_effect == VOID else [
            ('outcome by GK as printed',
             f'{outcome(verdict.paper_outcome)} (no allowance for the sampling error)')])]


def _describe_looks(settings: Settings) -> str:
    """Return how looks share the risks; nothing without looks."""
    plan_s, n = settings.sequential.plan_s, settings.sequential.looks
    if plan_s is None:
        return ''
    if not isinstance(plan_s, str):
        return f' The risks are shared among {n} looks of a run planned for {number(plan_s)} s.'
    first_s = Looks(plan_s, n, settings.risk).plan[0].span_ns / 1e9
    return (f' Half of the risks is shared among {n - 1} looks at the run in progress, at '
            f'{number(first_s)} s and at doubling times; the end of the run has what they left.')


def _several(settings: Settings, m: int) -> str:
    producer = number(settings.risk.alpha_producer)
    if settings.campaign.rule == 'sensor':
        return ('The runs are judged as one sensor: U and L are bounds of the variance that they '
                'share. No single run rejects.')
    return ('The worst run decides. All runs must comply. A single run rejects the TS if it does '
            f"so at the producer's risk divided by the number of runs, {producer} / {m or 'm'}"
            + (f' = {number(settings.risk.alpha_producer / m, 3)}.' if m else '.'))


def _doubts(verdict: Verdict) -> str:
    if is_doubtful(verdict.outcome, verdict.validity_effect):
        return ', but doubtful: see the validity of the comparison'
    return ''


def _covered(runs: Sequence[RunVerdict]) -> str:
    if not runs:
        return 'none'
    which = 'run 1' if len(runs) == 1 else f'runs 1 to {len(runs)}'
    return f'{which}, {sum(run.n for run in runs)} differences'


def describe_uncertainty(settings: Settings) -> list[str]:
    """Return remarks on the sources of uncertainty that the budget of a run cannot show."""
    reference = ('This range sets the width of the dead zone, and more data cannot narrow it.'
                 if settings.norms.sigma_ref_deg is None
                 else 'The verdict is no better than this figure.')
    skew = ('no latency of the TS was stated, so none was removed'
            if is_default(settings, 'alignment.skew_s') else
            f'a known latency of the TS of {number(settings.alignment.skew_s)} s was removed')
    return [
        f'Reference: its standard deviation is taken from the settings. {reference}',
        f'Timing: {skew}. A latency adds '
        'latency times rate of turn to the difference: 0.1 s at 1 deg/s add 0.1 deg.',
        'Resolution: rounding to a step q adds q²/12 to the variance of each sensor. This is not '
        'subtracted.',
        'The installation angle contributes to the mean difference, not to the variance.',
        'The comparison cannot see a systematic error common to both sensors; GK assumes that '
        'the RS has none. Positively correlated errors of TS and RS make the TS look better than '
        'it is.']
