# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Pairs and ensembles as csv files."""

from typing import TYPE_CHECKING

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'ensembles_csv': ('EnsemblesCsvWriter',),
    'pairs_account': ('PairsAccount', 'read_account', 'write_account'),
    'pairs_csv': ('PairsCsv', 'PairsCsvWriter', 'read_pairs_csv'),
})

if TYPE_CHECKING:
    # The same names for type checkers, by ``make docs``.
    from .ensembles_csv import EnsemblesCsvWriter as EnsemblesCsvWriter
    from .pairs_account import (
        PairsAccount as PairsAccount,
        read_account as read_account,
        write_account as write_account,
    )
    from .pairs_csv import (
        PairsCsv as PairsCsv,
        PairsCsvWriter as PairsCsvWriter,
        read_pairs_csv as read_pairs_csv,
    )
