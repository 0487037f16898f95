# Copyright 2026 The heading_intercompare authors
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.

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
