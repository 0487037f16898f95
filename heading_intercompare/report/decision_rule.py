# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The decision rule in words, with its risks and what it covers; remarks on the uncertainty."""

from __future__ import annotations

from typing import Sequence

from heading_intercompare.core.decision.criteria import Limits
from heading_intercompare.core.decision.norm_presets import PRESETS, sigma_max_deg
from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.settings import Pairing, Settings
from heading_intercompare.core.verdict.validity import is_doubtful
from heading_intercompare.core.verdict.verdict_document import RunVerdict, Verdict

from .formatting import interval, number, outcome, value

__all__ = ['describe_norms', 'describe_uncertainty', 'state_conformity']

Rows = list[tuple[str, str]]

_MET = {Outcome.COMPLIANT: 'met', Outcome.NON_COMPLIANT: 'not met',
        Outcome.INDETERMINATE: 'not decided, neither met nor not met can be stated at the risks'}

_LAWS = {'N': 'normal', 'U': 'uniform'}


def describe_norms(settings: Settings) -> Rows:
    """Return the norms and the method, as names and values."""
    norms = settings.norms
    ts_law, rs_law = (_LAWS[letter] for letter in settings.model)
    rows = [('norm of the TS standard deviation, sigma_max [deg]',
             number(sigma_max_deg(norms, settings.model))),
            ('norm of the RS standard deviation, sigma_ref_max [deg]',
             number(norms.sigma_ref_max_deg)),
            ('actual RS standard deviation, if known [deg]',
             number(norms.sigma_ref_deg)),
            ('bounds of M = sigma_ref / sigma_ref_max, as set [1]',
             interval(norms.m_low, norms.m_up)),
            ('norm of the total error at P [deg]',
             number(norms.total_error_max_deg)),
            ('confidence probability P [1]', number(norms.probability)),
            ('coverage factor by rule', value(norms.k_rule)),
            ('error laws', f'TS {ts_law}, RS {rs_law} (model {settings.model})'),
            ('variant of GK Table I', value(settings.variant)),
            ('pairing', _pairing(settings.pairing))]
    name = norms.preset
    if name in PRESETS:
        preset = PRESETS[name]
        rows[:0] = [('published norm', f'{name}: {preset.title}'), ('it asks', preset.content),
                    ('status of its text here', preset.status)]
        if preset.secant:
            rows.insert(3, ('latitude [deg]', number(norms.latitude_deg)))
    return rows


def _pairing(rule: Pairing) -> str:
    method = rule.method
    if method == 'nearest':
        return f'mutual nearest stamps, lag at most {number(rule.tolerance_s)} s'
    onto_ts, onto_rs = 'RS interpolated to the TS stamp', 'TS interpolated to the RS stamp'
    chosen = (f'{onto_rs} where the RS is slow by the stamps of the first '
              f'{number(rule.auto_s)} s, else {onto_ts}')
    words = {'interpolate': onto_ts, 'interpolate_ts': onto_rs, 'auto': chosen}[method]
    return f'{words}; bracket at most {number(rule.max_gap_s)} s'


def state_conformity(verdict: Verdict) -> Rows:
    """
    Return the decision rule and what follows from it, as names and values.

    The statement follows ISO/IEC 17025:2017, 7.8.6: the rule, the results covered, the
    specification met or not.
    """
    settings, runs = verdict.settings, verdict.runs
    consumer = number(settings.risk.alpha_consumer)
    producer = number(settings.risk.alpha_producer)
    m = len(runs)
    share = settings.risk.count_share
    reject = ('The counts of extreme differences may reject too, if the lower bound of their '
              f"rate exceeds 1 - P; they take {number(share)} of the producer's risk, L the rest.")
    if settings.norms.total_error_max_deg is not None:
        reject += (' Unless the total error by GK (7) is within its norm, the specification is '
                   'not found met.')
    plan = settings.sequential.plan_s
    looks = '' if plan is None else (
        f' The risks are shared among {settings.sequential.looks} looks of a run planned for '
        f'{number(plan)} s.')
    return [
        ('decision rule',
         'Guarded and non-binary: a run is compliant if the upper bound U of the variance of '
         'the differences is at most A = sigma_max² + M_low² sigma_ref_max², non-compliant if '
         'its lower bound L is above R = sigma_max² + M_up² sigma_ref_max², else '
         f'indeterminate. {reject} U and L allow for the correlation of the errors in time. '
         'In A, sigma_max² and M_low² are multiplied by the factors by which interpolation '
         'shrinks the noise variance of TS and RS.'),
        ('several runs', _several(settings, m)),
        ("consumer's risk [1]", f'{consumer}, nominal: at most so often a TS just at its norm '
                                'is found compliant, if the assumptions hold.' + looks),
        ("producer's risk [1]", f'{producer}, nominal: at most so often a TS just at its norm '
                                'is found non-compliant, if the assumptions hold.'),
        ('results covered', _covered(runs)),
        ('specification', 'sigma_max of the TS: ' + _MET[verdict.outcome] + _doubts(verdict)),
        ('in one line', verdict.headline),
        ('the same by GK as printed',
         f'{outcome(verdict.paper_outcome)} (no allowance for the sampling error)')]


def _several(settings: Settings, m: int) -> str:
    producer = number(settings.risk.alpha_producer)
    if settings.campaign.rule == 'sensor':
        return ('The runs are judged as one sensor: U and L are bounds of the variance that they '
                'share. No single run rejects.')
    return ('The worst run decides. All must comply; one rejects the TS if it does so at the '
            f"producer's risk divided by the number of runs, {producer} / {m or 'm'}"
            + (f' = {number(settings.risk.alpha_producer / m, 3)}.' if m else '.'))


def _doubts(verdict: Verdict) -> str:
    if is_doubtful(verdict.outcome, verdict.validity_effect):
        return ', but doubtfully: see the validity of the comparison'
    return ''


def _covered(runs: Sequence[RunVerdict]) -> str:
    if not runs:
        return 'none'
    which = 'run 1' if len(runs) == 1 else f'runs 1 to {len(runs)}'
    return f'{which}, {sum(run.n for run in runs)} differences'


def describe_uncertainty(verdict: Verdict) -> list[str]:
    """Return remarks on what makes the result uncertain, with figures where there are."""
    settings = verdict.settings
    known = settings.norms.sigma_ref_deg
    if known is not None:
        reference = (f'RS: its standard deviation is taken as known, {number(known)} deg; the '
                     'verdict is no better than that figure.')
    else:
        ref = Limits.of(settings.norms, settings.model).sigma_ref_max_deg
        reference = ('RS: its standard deviation is known only to lie from '
                     f'{number(settings.norms.m_low * ref)} to '
                     f'{number(settings.norms.m_up * ref)} deg; this is the width of the dead '
                     'zone, and no more data can narrow it.')
    items = [reference]
    for run in verdict.runs:
        guarded = run.guarded
        items.append(
            f'Sampling, run {run.run}: {run.n} differences count as '
            f'{number(guarded.nu)} effective degrees of freedom; variance from '
            f'{number(guarded.lower_bound_deg2)} to {number(guarded.upper_bound_deg2)} '
            f'deg²; mean difference with standard uncertainty {number(guarded.bias_u_deg)} '
            'deg.')
    skew = settings.alignment.skew_s
    items += [
        'Installation: the angle removed has the standard uncertainty '
        f'{number(settings.installation_offset_u_deg)} deg; it is part of that of the mean '
        'difference, not of the variance.',
        f'Timing: a known latency of the TS of {number(skew)} s was removed. Any further one '
        'adds latency times rate of turn to the difference, '
        f'0.1 deg at 1 deg/s for 0.1 s.',
        'Resolution: rounding to a step q adds q²/12 to the variance of each sensor; it is not '
        'subtracted.',
        'A systematic error common to both sensors is not seen by the comparison; GK takes the '
        'RS for free of systematic error. Positively correlated errors of TS and RS make the TS '
        'look better than it is.']
    return items
