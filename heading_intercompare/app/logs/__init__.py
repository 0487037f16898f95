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

"""The logs of sensors: their import, and their judging without a bag between."""

from typing import TYPE_CHECKING

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'antenna_logs': ('describe_baseline', 'import_antennas'),
    'log_import': ('import_log', 'ImportedLog'),
    'log_motion': ('find_motion', 'FoundMotion'),
    'trial_logs': ('find_logs', 'judge_logs'),
})

if TYPE_CHECKING:
    # The same names for type checkers, by ``make docs``.
    from .antenna_logs import (
        describe_baseline as describe_baseline,
        import_antennas as import_antennas,
    )
    from .log_import import import_log as import_log, ImportedLog as ImportedLog
    from .log_motion import find_motion as find_motion, FoundMotion as FoundMotion
    from .trial_logs import find_logs as find_logs, judge_logs as judge_logs
