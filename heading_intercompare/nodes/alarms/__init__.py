# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The alarms of the nodes: detectors of core on live data, one topic, and acknowledgement."""

from typing import TYPE_CHECKING

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'alarm_panel': ('AlarmPanel',),
    'comparison_alarms': ('ComparisonAlarms',),
    'sentence_alarms': ('SentenceAlarms',),
    'stream_alarms': ('StreamAlarms',),
})

if TYPE_CHECKING:
    # The same names for type checkers, by ``make docs``.
    from .alarm_panel import AlarmPanel as AlarmPanel
    from .comparison_alarms import ComparisonAlarms as ComparisonAlarms
    from .sentence_alarms import SentenceAlarms as SentenceAlarms
    from .stream_alarms import StreamAlarms as StreamAlarms
