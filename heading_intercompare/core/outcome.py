# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The three outcomes, and how they combine."""

from __future__ import annotations

from enum import Enum
from typing import Iterable

__all__ = ['Outcome', 'worst']


class Outcome(str, Enum):
    """The norm is met, is broken, or the data cannot tell."""

    COMPLIANT = 'compliant'
    INDETERMINATE = 'indeterminate'
    NON_COMPLIANT = 'non_compliant'

    def __str__(self) -> str:
        return self.value


def worst(outcomes: Iterable[Outcome]) -> Outcome:
    """
    Combine outcomes of criteria or runs.

    Parameters
    ----------
    outcomes : iterable of Outcome
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
