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

"""What would decide an open run, in words: how long to measure, or why no length helps."""

from __future__ import annotations

import math

from heading_intercompare.core.settings import Risk
from heading_intercompare.core.statistics.cells import LEAST_CELLS

from .campaign import LEAST_RUNS, LEAST_TIMES_OF_MEANS, Together
from .coverage import Coverage, least_apart_s, span_words
from .guarded import Guarded

_YEAR_H = 8766.0

_BETWEEN = ('no length decides while the variance stays between the limits; better knowledge of '
            'sigma_ref does')

_OPEN_BY_VARIANCE = ('slow_errors_not_resolved', 'data_limited', 'reference_limited')

_UNSTATED_APART_S = least_apart_s(Risk())

_NO_LENGTH = {
    'reference_limited': 'no length helps',
    'total_error_not_within_norm':
        'no length helps, because GK (7) makes no allowance for it; a smaller mean difference or '
        'a better known RS does',
    'outliers_decide': 'find their cause; a longer run helps only if they do not recur',
}


_CHANCES = (
    (12.0, ((0.6, (0.67, 0.78, 0.85)), (0.8, (0.45, 0.71, 0.83)), (1.0, (0.22, 0.58, 0.77)))),
    (30.0, ((0.6, (0.43, 0.63, 0.75)), (0.8, (0.22, 0.54, 0.72)), (1.0, (0.03, 0.34, 0.68)))),
    (math.inf, ((0.6, (0.25, 0.54, 0.70)), (0.8, (0.09, 0.37, 0.62)), (1.0, (0.01, 0.18, 0.51)))))
"""
Measured chances that a run which a slow part leaves open is certified at 2, 4, 8 times its length.

Rows: up to which ratio R (S.8), that is how far the slow part stands out. In a row: up to which
standard deviation, over the root of the acceptance limit. From ``docs/risk.md``.
"""


def describe_need(reason: str, guarded: Guarded, coverage: Coverage, *, n: int,
                  drift_left_deg2: float | None, drifts: bool | None,
                  warm_up_s: float = 0.0) -> str:
    """
    Say what would decide an open run, the cheapest first.

    Parameters
    ----------
    reason
        Reason for the outcome of the run.
    guarded
        The decision on its variance.
    coverage
        Holds the length of the run and the least length that may comply.
    n
        Number of differences.
    drift_left_deg2
        Upper bound of the variance of the drift that is not removed, square degrees.
    drifts
        Whether the slope of the differences is significant; None if unknown.
    warm_up_s
        Length of a warm-up that was found and not left out, seconds; 0 if there is none.

    Returns
    -------
    str
        What the same record lacks; then the length of a run that would decide, from its start, or
        why no length does. Empty for other reasons.

    Notes
    -----
    The allowance for a slow part falls as the record grows past it. How fast depends on how far
    that part stands out, so the lengths have chances that were measured. The bound of a drift
    that is not significant is uncertainty, which falls with the length.

    """
    first = []
    if reason in _OPEN_BY_VARIANCE and warm_up_s > 0.0:
        first.append(f'a warm-up of {span_words(warm_up_s)} was found: runs.stabilization_s=auto '
                     'leaves it out')
    if reason in _OPEN_BY_VARIANCE and guarded.m_low_needed is not None:
        first.append('this record certifies if the RS is known to have at least '
                     f'{math.ceil(100.0 * guarded.m_low_needed) / 100.0:.2f} of its norm '
                     '(norms.m_low)')
    need = _describe_length(reason, guarded, coverage, n, drift_left_deg2, drifts)
    return '; '.join([*first, need] if need else first)


def _describe_length(reason: str, guarded: Guarded, coverage: Coverage, n: int,
                     drift_left_deg2: float | None, drifts: bool | None) -> str:
    if reason.startswith('void.'):
        return 'no longer record of this kind helps: remove the cause and measure again'
    if reason in _NO_LENGTH:
        return _NO_LENGTH[reason]
    if reason == 'insufficient_data':
        return _describe_more_data(coverage, n)
    if reason == 'drift_left_in':
        return _describe_drift(guarded, coverage, drift_left_deg2, drifts)
    hours = guarded.hours_needed
    is_known = hours is not None and math.isfinite(hours)
    if reason == 'slow_errors_not_resolved':
        return _describe_slow(guarded, coverage)
    if reason == 'insufficient_duration':
        least = _measure(coverage.least_duration_s)
        if coverage.stated_s:
            least = f'{_several(coverage)}, or {least}'
        if hours is None or not is_known:
            return f'{least}, but {_describe_no_length(guarded)}'
        if hours * 3600.0 <= coverage.least_duration_s * (1.0 + 1e-9):
            return least
        return f'{least}, or {_in_all(hours * 3600.0)} if the errors stay as they are'
    if reason == 'data_limited':
        if hours is None or not is_known:
            return _describe_no_length(guarded)
        return (f'{_measure(max(hours * 3600.0, coverage.least_duration_s))} if the errors stay '
                'as they are')
    return ''


def describe_need_together(reason: str, together: Together | None,
                           coverage: Coverage | None) -> str:
    """
    Say what would decide several runs that are judged together.

    Parameters
    ----------
    reason
        Reason for the outcome of the campaign.
    together
        The variance that the runs share.
    coverage
        Coverage of the runs together.

    Returns
    -------
    str
        The total length of the runs that would decide, or why no length does; empty for other
        reasons.

    Notes
    -----
    The distance of the upper bound from the variance and its allowance falls at least with the
    root of the length, and so does that of the logarithm of the lower bound.

    """
    if reason in _NO_LENGTH and reason != 'outliers_decide':
        return _NO_LENGTH[reason]
    if together is None or coverage is None:
        return ''
    if reason == 'insufficient_duration':
        return _measure(coverage.least_duration_s)
    if reason == 'slow_errors_not_resolved':
        more = LEAST_RUNS - together.runs
        return (f'measure {more} more {"run" if more == 1 else "runs"} like these, further apart '
                f'than {span_words(coverage.stated_s or _UNSTATED_APART_S)}' if more > 0
                else f'{_measure(2.0 * together.span_s)}, or runs further apart than '
                f'{span_words(coverage.stated_s or _UNSTATED_APART_S)} (variant B)')
    if reason != 'data_limited':
        return ''
    d, slow = together.d_hat_deg2, together.slow_allowance_deg2
    if together.between_upper_bound_deg2 is not None:
        slow = 0.0
    room = together.acceptance_limit_deg2 - d - slow
    if room > 0.0:
        root = (together.upper_bound_deg2 - d - slow) / room
    elif d > together.rejection_limit_deg2:
        root = (math.log(d / together.lower_bound_deg2)
                / math.log(d / together.rejection_limit_deg2))
    else:
        return _BETWEEN
    return f'{_measure(max(1.0, root * root) * together.span_s)} if the errors stay as they are'


def _several(coverage: Coverage) -> str:
    """Return the advice of several short runs."""
    apart_s = coverage.stated_s or _UNSTATED_APART_S
    runs = ('five or more runs like this one' if coverage.stated_s is None else
            f'ten runs of {span_words(LEAST_TIMES_OF_MEANS * coverage.stated_s)}')
    return f'{runs}, further apart than {span_words(apart_s)}, with campaign.rule=sensor'


def _describe_slow(guarded: Guarded, coverage: Coverage) -> str:
    """Say what decides a run with a visible slow part: several runs, or lengths and chances."""
    if guarded.stated_times is not None and coverage.stated_s is not None:
        return (f'the errors are slower than the stated {span_words(coverage.stated_s)}: state '
                'what is true (risk.slowest_error_s), and plan again')
    d, ratio = guarded.d_hat_deg2, guarded.r_slow
    level = math.sqrt(d / guarded.acceptance_limit_deg2) if d is not None else 1.0
    by_level = next(row for most, row in _CHANCES if ratio is not None and ratio <= most
                    or most == math.inf)
    chances = next((of_level for most, of_level in by_level if level <= most), by_level[-1][1])
    likely = [(factor, chance) for factor, chance in zip((2, 4, 8), chances) if chance >= 0.5]
    lengths = ', or '.join(
        f'{_in_all(max(factor * coverage.span_s, coverage.least_duration_s))} '
        f'(certifies {100.0 * chance:.0f} of 100 such runs)' for factor, chance in likely[:2])
    return f'{_several(coverage)}, or measure {lengths}'


def _measure(span_s: float) -> str:
    return f'measure {_in_all(span_s)}'


def _in_all(span_s: float) -> str:
    """Return a length in words, rounded up, so that it suffices."""
    hours = span_s / 3600.0
    if hours > _YEAR_H:
        return f'{hours / _YEAR_H:.2g} years in all, which is not practicable,'
    if span_s >= 7200.0:
        return f'{math.ceil(hours * 10.0 - 1e-6) / 10.0:.1f} h in all'
    return (f'{span_words(math.ceil(span_s / 60.0 - 1e-6) * 60.0)} ' if span_s >= 120.0
            else f'{math.ceil(span_s - 1e-6)} s ') + f'({_short_hours(hours)} h) in all'


def _short_hours(hours: float) -> str:
    return f'{math.ceil(hours * 100.0 - 1e-6) / 100.0:.2f}'


def _describe_no_length(guarded: Guarded) -> str:
    d = guarded.d_hat_deg2
    if d is not None and guarded.acceptance_limit_deg2 < d <= guarded.rejection_limit_deg2:
        return _BETWEEN
    return 'no length decides while the errors stay as they are; five or more runs may'


def _describe_more_data(coverage: Coverage, n: int) -> str:
    if n >= LEAST_CELLS:
        return f'{_measure(coverage.least_duration_s)}, with readings spread evenly over the run'
    # The rate of the readings so far.
    by_rate_s = coverage.span_s * LEAST_CELLS / max(1, n - 1)
    needed_s = max(coverage.least_duration_s, by_rate_s)
    count = f'at least {LEAST_CELLS} differences'
    return f'{_measure(needed_s)}, with {count}' if needed_s > 0.0 else f'measure {count}'


def _describe_drift(guarded: Guarded, coverage: Coverage, left_deg2: float | None,
                    drifts: bool | None) -> str:
    remove = 'remove the drift (drift_order) if the norm allows it, or find its cause'
    if drifts is not False or left_deg2 is None or guarded.d_hat_deg2 is None:
        return f'no length helps, because a longer run drifts further: {remove}'
    room = guarded.acceptance_limit_deg2 - guarded.d_hat_deg2
    if not room > 0.0:
        return f'no length helps, because the variance reaches the limit: {remove}'
    return f'{_measure(max(1.0, left_deg2 / room) * coverage.span_s)}, or {remove}'
