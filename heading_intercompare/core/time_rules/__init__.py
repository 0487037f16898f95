# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Times that a person states: cuts by the clock, and stretches to take out."""

from typing import TYPE_CHECKING

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'clock_cuts': ('ClockCuts',),
    'exclusions': ('Exclusion', 'find_excluded', 'read_exclusions'),
})
if TYPE_CHECKING:
    # The same names for type checkers, by ``make docs``.
    from .clock_cuts import ClockCuts as ClockCuts
    from .exclusions import (
        Exclusion as Exclusion,
        find_excluded as find_excluded,
        read_exclusions as read_exclusions,
    )
