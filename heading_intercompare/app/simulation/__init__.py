# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Simulated trials: the recorded voyage that a ship repeats."""

from typing import TYPE_CHECKING

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'voyage': ('read_voyage', 'Voyage'),
})

if TYPE_CHECKING:
    # The same names for type checkers, by ``make docs``.
    from .voyage import read_voyage as read_voyage, Voyage as Voyage
