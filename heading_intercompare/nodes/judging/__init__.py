# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The work of the node that judges: follow one synchronizer, keep the run, report, log."""

from typing import TYPE_CHECKING

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'pair_intake': ('PairIntake',),
    'reporting': ('Reporting',),
    'run_log': ('RunLog',),
    'trial_journal': ('TrialJournal',),
})

if TYPE_CHECKING:
    # The same names for type checkers, by ``make docs``.
    from .pair_intake import PairIntake as PairIntake
    from .reporting import Reporting as Reporting
    from .run_log import RunLog as RunLog
    from .trial_journal import TrialJournal as TrialJournal
