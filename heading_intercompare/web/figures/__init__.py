# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""What is computed from readings and pairs for the page: a sensor's state, and the trend."""

from typing import TYPE_CHECKING

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'stream_watch': ('SensorView', 'StreamWatch'),
    'trend': ('Trend', 'TrendColumn'),
})

if TYPE_CHECKING:
    # The same names for type checkers, by ``make docs``.
    from .stream_watch import SensorView as SensorView, StreamWatch as StreamWatch
    from .trend import Trend as Trend, TrendColumn as TrendColumn
