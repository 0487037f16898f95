# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Runs: where they begin and end, and the data kept of each."""

from typing import TYPE_CHECKING

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'growing_columns': ('Keep',),
    'live_figures': ('compute_figures',),
    'rolling_window': ('Rolling',),
    'run_cutter': ('RunCutter',),
    'run_series': ('RunSeries',),
})

if TYPE_CHECKING:
    # The same names for type checkers, by ``make docs``.
    from .growing_columns import Keep as Keep
    from .live_figures import compute_figures as compute_figures
    from .rolling_window import Rolling as Rolling
    from .run_cutter import RunCutter as RunCutter
    from .run_series import RunSeries as RunSeries
