# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Pairs and ensembles as comma-separated values."""

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'ensembles_csv': ('EnsemblesCsvWriter',),
    'pairs_csv': ('PairsCsvWriter', 'read_pairs_csv'),
})
