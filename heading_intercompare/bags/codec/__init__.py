# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Messages to bytes and back."""

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'cdr': ('decode', 'encode'),
    'fields': ('full_name',),
    'heading_messages': ('decode_headings', 'encode_imu', 'HEADING_TYPES', 'IMU'),
    'schemas': ('layout_problem', 'Schema', 'schema_of'),
})
