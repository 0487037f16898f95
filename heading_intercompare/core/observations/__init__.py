# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Observations of the true heading as a reference: corrections, their budget, the decision."""

from typing import TYPE_CHECKING

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'budget': ('Budget', 'Component', 'make_budget'),
    'corrections': ('Corrections', 'find_corrections', 'Observations'),
    'sight_lines': ('bearing_between', 'bearing_uncertainty', 'line_bearing', 'quay_angle'),
    'systematic_error': ('judge_corrections', 'SystematicError'),
})

if TYPE_CHECKING:
    # The same names for type checkers, by ``make docs``.
    from .budget import Budget as Budget, Component as Component, make_budget as make_budget
    from .corrections import (
        Corrections as Corrections,
        find_corrections as find_corrections,
        Observations as Observations,
    )
    from .sight_lines import (
        bearing_between as bearing_between,
        bearing_uncertainty as bearing_uncertainty,
        line_bearing as line_bearing,
        quay_angle as quay_angle,
    )
    from .systematic_error import (
        judge_corrections as judge_corrections,
        SystematicError as SystematicError,
    )
