# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""A table of observations against the readings of one sensor: corrections and decision."""

from typing import TYPE_CHECKING

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'observation_table': ('ObservationTable', 'read_observation_table'),
    'observed_sensor': ('observe', 'Observed', 'Uncertainties'),
    'targets': ('parse_position', 'Target'),
})

if TYPE_CHECKING:
    # The same names for type checkers, by ``make docs``.
    from .observation_table import (
        ObservationTable as ObservationTable,
        read_observation_table as read_observation_table,
    )
    from .observed_sensor import (
        observe as observe,
        Observed as Observed,
        Uncertainties as Uncertainties,
    )
    from .targets import parse_position as parse_position, Target as Target
