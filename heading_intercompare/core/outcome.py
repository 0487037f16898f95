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

"""The three outcomes, and how they combine."""

from __future__ import annotations

from enum import Enum
from typing import Iterable


class Outcome(str, Enum):
    """The norm is met, the data cannot tell, or it is broken: from the best to the worst."""

    COMPLIANT = 'compliant'
    INDETERMINATE = 'indeterminate'
    NON_COMPLIANT = 'non_compliant'

    def __str__(self) -> str:
        return self.value

    @property
    def words(self) -> str:
        """Return the outcome as it stands in a sentence."""
        return self.value.replace('_', '-')


def worst(outcomes: Iterable[Outcome]) -> Outcome:
    """
    Combine outcomes of criteria or runs.

    Parameters
    ----------
    outcomes
        In any order.

    Returns
    -------
    Outcome
        Non-compliant if any is, compliant if all are, otherwise indeterminate. No outcomes at
        all give indeterminate.

    References
    ----------
    GK, several runs: the worst one decides.

    Examples
    --------
    >>> worst([Outcome.COMPLIANT, Outcome.INDETERMINATE]).value
    'indeterminate'

    """
    outcomes = list(outcomes)
    if Outcome.NON_COMPLIANT in outcomes:
        return Outcome.NON_COMPLIANT
    if outcomes and all(o is Outcome.COMPLIANT for o in outcomes):
        return Outcome.COMPLIANT
    return Outcome.INDETERMINATE
