# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Settings that a person writes as rows of text, such as the sensors of a ship."""

from typing import TYPE_CHECKING

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'sensor_table': ('find_reference', 'read_sensors', 'Sensor'),
    'settings_rows': ('read_rows',),
})
if TYPE_CHECKING:
    # The same names for type checkers, by ``make docs``.
    from .sensor_table import (
        find_reference as find_reference,
        read_sensors as read_sensors,
        Sensor as Sensor,
    )
    from .settings_rows import read_rows as read_rows
