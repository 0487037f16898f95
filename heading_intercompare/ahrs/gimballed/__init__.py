# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The gimballed AHRS: platform, computer, modes and output."""

from typing import TYPE_CHECKING

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'condition': ('describe_condition',),
    'modes': ('AhrsStatus',),
    'output': ('AhrsOutput',),
})

if TYPE_CHECKING:
    # The same names for type checkers, by ``make docs``.
    from .condition import describe_condition as describe_condition
    from .modes import AhrsStatus as AhrsStatus
    from .output import AhrsOutput as AhrsOutput
