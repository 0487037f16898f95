# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The gimballed AHRS: platform, computer, modes, and what it puts out."""

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'condition': ('describe_condition',),
    'modes': ('AhrsStatus',),
    'output': ('AhrsOutput',),
})
