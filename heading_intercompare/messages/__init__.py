# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""
ROS 2 messages to bytes and back, for bags and nodes; no ROS needed.

Headings and pairs are converted as whole chunks in columns (`heading_messages`), other messages
one by one (`cdr`).
"""

from typing import TYPE_CHECKING

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'byte_columns': ('join_messages', 'split_rows'),
    'cdr': ('decode', 'encode'),
    'errors': ('MessageError',),
    'fields': ('full_name',),
    'heading_messages': ('decode_headings', 'encode_imu', 'encode_pairs', 'HEADING_TYPES',
                         'IMU', 'imu_messages', 'pair_messages', 'PAIRS_TYPE', 'read_attitude',
                         'read_headings', 'read_pairs'),
    'ledger_messages': ('decode_ledger', 'decode_losses', 'encode_ledger', 'encode_losses',
                        'LOST_AS', 'lost_topic'),
    'marks': ('decode_marks', 'encode_mark', 'MARKER_TOPIC', 'MARKS'),
    'schemas': ('layout_problem', 'Schema', 'schema_of'),
    'stamps': ('encode_clock',),
    'status_messages': ('encode_figures', 'encode_statuses', 'ERROR', 'OK', 'Status',
                        'STATUS_TYPE', 'WARN'),
    'texts': ('decode_text', 'encode_text', 'TEXT_TYPE'),
    'verdict_messages': ('encode_verdict', 'OUTCOME_LEVELS', 'verdict_level'),
})

if TYPE_CHECKING:
    # The same names for type checkers, by ``make docs``.
    from .byte_columns import join_messages as join_messages, split_rows as split_rows
    from .cdr import decode as decode, encode as encode
    from .errors import MessageError as MessageError
    from .fields import full_name as full_name
    from .heading_messages import (
        decode_headings as decode_headings,
        encode_imu as encode_imu,
        encode_pairs as encode_pairs,
        HEADING_TYPES as HEADING_TYPES,
        IMU as IMU,
        imu_messages as imu_messages,
        pair_messages as pair_messages,
        PAIRS_TYPE as PAIRS_TYPE,
        read_attitude as read_attitude,
        read_headings as read_headings,
        read_pairs as read_pairs,
    )
    from .ledger_messages import (
        decode_ledger as decode_ledger,
        decode_losses as decode_losses,
        encode_ledger as encode_ledger,
        encode_losses as encode_losses,
        LOST_AS as LOST_AS,
        lost_topic as lost_topic,
    )
    from .marks import (
        decode_marks as decode_marks,
        encode_mark as encode_mark,
        MARKER_TOPIC as MARKER_TOPIC,
        MARKS as MARKS,
    )
    from .schemas import layout_problem as layout_problem, Schema as Schema, schema_of as schema_of
    from .stamps import encode_clock as encode_clock
    from .status_messages import (
        encode_figures as encode_figures,
        encode_statuses as encode_statuses,
        ERROR as ERROR,
        OK as OK,
        Status as Status,
        STATUS_TYPE as STATUS_TYPE,
        WARN as WARN,
    )
    from .texts import (
        decode_text as decode_text,
        encode_text as encode_text,
        TEXT_TYPE as TEXT_TYPE,
    )
    from .verdict_messages import (
        encode_verdict as encode_verdict,
        OUTCOME_LEVELS as OUTCOME_LEVELS,
        verdict_level as verdict_level,
    )
