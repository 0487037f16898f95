# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Recovery of damaged bags: their intact records go into a new bag."""

from typing import TYPE_CHECKING

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'recover_bag': ('recover', 'Recovered'),
})

if TYPE_CHECKING:
    # The same names for type checkers, by ``make docs``.
    from .recover_bag import recover as recover, Recovered as Recovered
