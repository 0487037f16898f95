# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Messages to bytes and back."""

from typing import TYPE_CHECKING

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'cdr': ('decode', 'encode'),
    'fields': ('full_name',),
    'heading_messages': ('decode_headings', 'encode_imu', 'HEADING_TYPES', 'IMU'),
    'schemas': ('layout_problem', 'Schema', 'schema_of'),
})

if TYPE_CHECKING:
    # The same names for type checkers, by ``make docs``.
    from .cdr import decode as decode, encode as encode
    from .fields import full_name as full_name
    from .heading_messages import (
        decode_headings as decode_headings,
        encode_imu as encode_imu,
        HEADING_TYPES as HEADING_TYPES,
        IMU as IMU,
    )
    from .schemas import layout_problem as layout_problem, Schema as Schema, schema_of as schema_of
