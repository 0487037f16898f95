# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The platform with its instruments, the computer with its laws, and the loop of both."""

from typing import TYPE_CHECKING

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'computer': ('Computer',),
    'instruments': ('Instruments',),
    'platform': ('Platform',),
})

if TYPE_CHECKING:
    # The same names for type checkers, by ``make docs``.
    from .computer import Computer as Computer
    from .instruments import Instruments as Instruments
    from .platform import Platform as Platform
