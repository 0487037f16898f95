# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Signs that the pairs of a run compare nothing: one source, conventions, standstill."""

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'conventions': ('Convention', 'estimate_mean_difference', 'find_convention', 'MeanDifference'),
    'one_source': ('find_one_source', 'OneSource'),
    'outliers': ('find_outliers', 'Outliers'),
    'standstill': ('find_frozen', 'find_standstill', 'Frozen', 'Standstill'),
})
