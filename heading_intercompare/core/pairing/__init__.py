# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Headings of two sensors to pairs and differences, every reading accounted for."""

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'difference': ('subtract',),
    'direction': ('typical_step_ns',),
    'ensembles': ('Ensembles', 'Ensembling'),
    'ledger': ('Ledger', 'LedgerKey', 'LedgerSegment', 'REASONS'),
    'pairer': ('pair', 'Pairer'),
    'pending_readings': ('is_rising',),
})
