# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Runs: where they begin and end, and what is kept of them."""

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'growing_columns': ('Keep',),
    'live_figures': ('compute_figures',),
    'rolling_window': ('Rolling',),
    'run_cutter': ('RunCutter',),
    'run_series': ('RunSeries',),
})
