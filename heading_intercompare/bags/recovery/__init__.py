# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Damaged bags: what is sound of them into a new one."""

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'recover_bag': ('recover', 'Recovered'),
})
