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

"""The logbook: a row per judged run for years, and whether the sensor has changed since."""

from typing import TYPE_CHECKING

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'control_chart': ('Chart', 'make_chart'),
    'history': ('History', 'tell_histories'),
    'logbook_file': ('Logbook', 'LogbookBusy', 'LogbookError', 'merge_logbooks'),
    'run_row': ('make_rows', 'RunRow'),
    'service_change': ('compare_service', 'ServiceChange'),
})

if TYPE_CHECKING:
    # The same names for type checkers, by ``make docs``.
    from .control_chart import Chart as Chart, make_chart as make_chart
    from .history import History as History, tell_histories as tell_histories
    from .logbook_file import (
        Logbook as Logbook,
        LogbookBusy as LogbookBusy,
        LogbookError as LogbookError,
        merge_logbooks as merge_logbooks,
    )
    from .run_row import make_rows as make_rows, RunRow as RunRow
    from .service_change import compare_service as compare_service, ServiceChange as ServiceChange
