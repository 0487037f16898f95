# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Alarms while it happens: the detectors on the newest data, and states after MSC.302(87)."""

from typing import TYPE_CHECKING

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'alarm': ('Alarm', 'AlarmState', 'Priority', 'Rule', 'Sign'),
    'alarm_table': ('AlarmTable',),
    'comparison_watch': ('COMPARISON_RULES', 'ComparisonWatch'),
    'motion_watch': ('MOTION_RULES', 'MotionWatch'),
    'sentence_watch': ('SENTENCE_RULES', 'SentenceWatch'),
    'stream_watch': ('STREAM_RULES', 'StreamWatch'),
})

if TYPE_CHECKING:
    # The same names for type checkers, by ``make docs``.
    from .alarm import (
        Alarm as Alarm,
        AlarmState as AlarmState,
        Priority as Priority,
        Rule as Rule,
        Sign as Sign,
    )
    from .alarm_table import AlarmTable as AlarmTable
    from .comparison_watch import (
        COMPARISON_RULES as COMPARISON_RULES,
        ComparisonWatch as ComparisonWatch,
    )
    from .motion_watch import MOTION_RULES as MOTION_RULES, MotionWatch as MotionWatch
    from .sentence_watch import SENTENCE_RULES as SENTENCE_RULES, SentenceWatch as SentenceWatch
    from .stream_watch import STREAM_RULES as STREAM_RULES, StreamWatch as StreamWatch
