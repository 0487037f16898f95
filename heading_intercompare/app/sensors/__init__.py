# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
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
