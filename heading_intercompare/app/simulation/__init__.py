# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Simulated trials: recorded voyages to repeat, traces for figures, and many seeds."""

from typing import TYPE_CHECKING

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'seeds': ('repeat_trial', 'Repeated', 'SeedResult'),
    'trial_traces': ('TrialTraces',),
    'voyage': ('read_voyage', 'Voyage'),
})

if TYPE_CHECKING:
    # The same names for type checkers, by ``make docs``.
    from .seeds import repeat_trial as repeat_trial, Repeated as Repeated, SeedResult as SeedResult
    from .trial_traces import TrialTraces as TrialTraces
    from .voyage import read_voyage as read_voyage, Voyage as Voyage
