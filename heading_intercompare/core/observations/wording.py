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

"""What observations say about a TS, in words."""

from __future__ import annotations

from heading_intercompare.core.outcome import Outcome

from .systematic_error import SystematicError

__all__ = ['explain_outcome', 'explain_scatter']

_OUTCOMES = {Outcome.COMPLIANT: 'COMPLIANT', Outcome.NON_COMPLIANT: 'NON-COMPLIANT',
             Outcome.INDETERMINATE: 'INDETERMINATE'}


def explain_outcome(found: SystematicError) -> str:
    """
    Return the outcome with its reason in a line.

    Examples
    --------
    >>> explain_outcome(SystematicError(1, Outcome.INDETERMINATE, 'insufficient_data', 0.1))
    'INDETERMINATE: 1 observation with a TS reading; at least 2 are needed'

    """
    return f'{_OUTCOMES[found.outcome]}: {_REASONS[found.reason](found)}'


def _why_insufficient(found: SystematicError) -> str:
    count = 'no observation' if not found.n else f'{found.n} observation'
    return f'{count} with a TS reading; at least 2 are needed'


def _why_no_norm(found: SystematicError) -> str:
    return ('no norm of the systematic error is given: set norms.systematic_max_deg, or '
            'norms.preset (see the command norms)')


def _why_compliant(found: SystematicError) -> str:
    return (f'the systematic error is at most {found.high_deg:.3f} deg, within the norm of '
            f'{found.norm_deg:.3f} deg')


def _why_broken(found: SystematicError) -> str:
    return (f'the systematic error is at least {found.low_deg:.3f} deg, above the norm of '
            f'{found.norm_deg:.3f} deg')


def _why_void(found: SystematicError) -> str:
    return (f'C - O is {found.correction_deg:.1f} deg, beyond detectors.mean_max_deg: a bearing '
            'the wrong way round, a magnetic one, or the wrong side; check the observations')


def _why_outliers(found: SystematicError) -> str:
    return ('without the observations marked ? the outcome would differ: find out what they are, '
            'or observe more')


def _bounds(found: SystematicError) -> str:
    return (f'the error lies between {found.low_deg:.3f} and {found.high_deg:.3f} deg, the norm '
            f'is {found.norm_deg:.3f} deg')


def _why_shared(found: SystematicError) -> str:
    return (f'{_bounds(found)}; what all observations share is too uncertain, and more of them do '
            'not help: a better survey does')


def _why_few(found: SystematicError) -> str:
    said = _bounds(found)
    if found.n_needed is not None:
        said += f'; {found.n_needed} such observations would show compliance'
    return said


_REASONS = {
    'insufficient_data': _why_insufficient, 'no_norm': _why_no_norm,
    'bound_within_norm': _why_compliant, 'bound_above_norm': _why_broken,
    'void.mean_difference': _why_void, 'outliers_decide': _why_outliers,
    'reference_limited': _why_shared, 'data_limited': _why_few}


def explain_scatter(found: SystematicError) -> str:
    """
    Return what the scatter says about the norm of the standard deviation; '' for n < 2.

    Notes
    -----
    Observations never certify a standard deviation. Their own errors are in the scatter, and the
    chi-square bounds hold only for errors that differ from one observation to the next.

    """
    if found.std_high_deg is None:
        return ''
    said = (f'cannot decide: the standard deviation. By chi-square with {found.n - 1} degrees of '
            f'freedom it lies between {found.std_low_deg:.3f} and {found.std_high_deg:.3f} deg')
    if found.std_norm_deg is not None and found.std_high_deg > found.std_norm_deg:
        said += f', so it may be above its norm of {found.std_norm_deg:.3f} deg'
    return (f'{said}. The errors of the observations are in it, and TS errors that last from one '
            'observation to the next are not. Use analyze with a reference sensor.')
