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

"""The verdict on several sensors of a ship, from recordings or logs."""

from typing import TYPE_CHECKING

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'sensors_analysis': ('analyze_sensors', 'judge_sensor_bags', 'judge_sensor_logs',
                         'SensorsJudgement'),
})
if TYPE_CHECKING:
    # The same names for type checkers, by ``make docs``.
    from .sensors_analysis import (
        analyze_sensors as analyze_sensors,
        judge_sensor_bags as judge_sensor_bags,
        judge_sensor_logs as judge_sensor_logs,
        SensorsJudgement as SensorsJudgement,
    )
