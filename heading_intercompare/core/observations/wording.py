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

_OUTCOMES = {Outcome.COMPLIANT: 'COMPLIANT', Outcome.NON_COMPLIANT: 'NON-COMPLIANT',
             Outcome.INDETERMINATE: 'INDETERMINATE'}


def explain_outcome(error: SystematicError) -> str:
    """
    Return the outcome with its reason in a line.

    Examples
    --------
    >>> explain_outcome(SystematicError(1, Outcome.INDETERMINATE, 'insufficient_data', 0.1))
    'INDETERMINATE: 1 observation with a TS reading; at least 2 are needed'

    """
    return f'{_OUTCOMES[error.outcome]}: {_REASONS[error.reason](error)}'


def _why_insufficient(error: SystematicError) -> str:
    count = 'no observation' if not error.n else f'{error.n} observation'
    return f'{count} with a TS reading; at least 2 are needed'


def _why_no_norm(error: SystematicError) -> str:
    return ('no norm of the systematic error is given: set norms.systematic_max_deg, or '
            'norms.preset (see the command norms)')


def _why_compliant(error: SystematicError) -> str:
    return (f'the systematic error is at most {error.high_deg:.3f} deg, within the norm of '
            f'{error.norm_deg:.3f} deg')


def _why_broken(error: SystematicError) -> str:
    return (f'the systematic error is at least {error.low_deg:.3f} deg, above the norm of '
            f'{error.norm_deg:.3f} deg')


def _why_void(error: SystematicError) -> str:
    return (f'C - O is {error.correction_deg:.1f} deg, beyond detectors.mean_max_deg: a bearing '
            'the wrong way round, a magnetic one, or the wrong side; check the observations')


def _why_outliers(error: SystematicError) -> str:
    return ('without the observations marked ? the outcome would differ: find out what they are, '
            'or observe more')


def _bounds(error: SystematicError) -> str:
    return (f'the error lies between {error.low_deg:.3f} and {error.high_deg:.3f} deg, the norm '
            f'is {error.norm_deg:.3f} deg')


def _why_shared(error: SystematicError) -> str:
    return (f'{_bounds(error)}; what all observations share is too uncertain, and more of them do '
            'not help: a better survey does')


def _why_few(error: SystematicError) -> str:
    words = _bounds(error)
    if error.n_needed is not None:
        words += f'; {error.n_needed} such observations would show compliance'
    return words


_REASONS = {
    'insufficient_data': _why_insufficient, 'no_norm': _why_no_norm,
    'bound_within_norm': _why_compliant, 'bound_above_norm': _why_broken,
    'void.mean_difference': _why_void, 'outliers_decide': _why_outliers,
    'reference_limited': _why_shared, 'data_limited': _why_few}


def explain_scatter(error: SystematicError) -> str:
    """
    Return what the scatter says about the norm of the standard deviation; '' for n < 2.

    Notes
    -----
    Observations never certify a standard deviation. Their own errors are in the scatter, and the
    chi-square bounds hold only for errors that differ from one observation to the next.

    """
    if error.std_high_deg is None:
        return ''
    words = (f'cannot decide: the standard deviation. By chi-square with {error.n - 1} degrees of '
             f'freedom it lies between {error.std_low_deg:.3f} and {error.std_high_deg:.3f} deg')
    if error.std_norm_deg is not None and error.std_high_deg > error.std_norm_deg:
        words += f', so it may be above its norm of {error.std_norm_deg:.3f} deg'
    return (f'{words}. The errors of the observations are in it, and TS errors that last from one '
            'observation to the next are not. Use analyze with a reference sensor.')
