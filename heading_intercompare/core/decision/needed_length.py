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

from heading_intercompare.core.statistics.cells import LEAST_CELLS
from heading_intercompare.core.statistics.variance_uncertainty import LEAST_TIMES

from .campaign import Together
from .coverage import Coverage, span_words
from .guarded import Guarded

__all__ = ['describe_need', 'describe_need_together']

_YEAR_H = 8766.0

_BETWEEN = ('no length decides while the variance stays between the limits; better knowledge of '
            'sigma_ref does')

_NO_LENGTH = {
    'reference_limited': 'no length helps',
    'total_error_not_within_norm':
        'no length helps, because GK (7) makes no allowance for it; a smaller mean difference or '
        'a better known RS does',
    'outliers_decide': 'find their cause; a longer run helps only if they do not recur',
}


def _longest_visible_s(span_s: float) -> float:
    """Return the length of a run that covers errors as slow as a record of this length."""
    return LEAST_TIMES * span_s


def describe_need(reason: str, guarded: Guarded, coverage: Coverage, *, n: int,
                  drift_left_deg2: float | None, drifts: bool | None) -> str:
    """
    Say what would decide an open run.

    Parameters
    ----------
    reason : str
        Reason for the outcome of the run.
    guarded : Guarded
        The decision on its variance.
    coverage : Coverage
        Holds the length of the run and the least length that may comply.
    n : int
        Number of differences.
    drift_left_deg2 : float or None
        Upper bound of the variance of the drift that is not removed, square degrees.
    drifts : bool or None
        Whether the slope of the differences is significant; None if unknown.

    Returns
    -------
    str
        The length of a run that would decide, from its start, or why no length does; empty for
        other reasons.

    Notes
    -----
    A slow part that fills the room below the acceptance limit gives no length by itself. It shows
    in the record, so it is no slower than the record, and a run twenty times as long covers it.
    The bound of a drift that is not significant is uncertainty, which falls with the length.

    """
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
        needed_s = hours * 3600.0 if hours is not None and is_known else _longest_visible_s(
            coverage.span_s)
        return f'{_measure(max(needed_s, coverage.least_duration_s))}, or at least five runs'
    if reason == 'insufficient_duration':
        least = _measure(coverage.least_duration_s)
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


def describe_need_together(reason: str, found: Together | None,
                           coverage: Coverage | None) -> str:
    """
    Say what would decide several runs that are judged together.

    Parameters
    ----------
    reason : str
        Reason for the outcome of the campaign.
    found : Together or None
        The variance that the runs share.
    coverage : Coverage or None
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
    if found is None or coverage is None:
        return ''
    if reason == 'insufficient_duration':
        return _measure(coverage.least_duration_s)
    if reason == 'slow_errors_not_resolved':
        return f'{_measure(_longest_visible_s(found.span_s))}, or at least five runs'
    if reason != 'data_limited':
        return ''
    d, slow = found.d_hat_deg2, found.slow_allowance_deg2
    if found.between_upper_bound_deg2 is not None:
        slow = 0.0
    room = found.acceptance_limit_deg2 - d - slow
    if room > 0.0:
        root = (found.upper_bound_deg2 - d - slow) / room
    elif d > found.rejection_limit_deg2:
        root = (math.log(d / found.lower_bound_deg2)
                / math.log(d / found.rejection_limit_deg2))
    else:
        return _BETWEEN
    return f'{_measure(max(1.0, root * root) * found.span_s)} if the errors stay as they are'


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
    return 'no length decides while the errors stay as they are; at least five runs may'


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
