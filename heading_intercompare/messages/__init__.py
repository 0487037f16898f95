# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""
Messages of ROS 2 to bytes and back, for bags and for nodes; no ROS needed.

Headings and pairs are whole chunks in columns (`heading_messages`); the others come one by one
(`cdr`).
"""

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'byte_columns': ('join_messages', 'split_rows'),
    'cdr': ('decode', 'encode'),
    'errors': ('MessageError',),
    'fields': ('full_name',),
    'heading_messages': ('decode_headings', 'encode_imu', 'encode_pairs', 'HEADING_TYPES',
                         'imu_messages', 'IMU', 'pair_messages', 'PAIRS_TYPE', 'read_headings',
                         'read_pairs'),
    'ledger_messages': ('decode_ledger', 'encode_ledger'),
    'marks': ('decode_marks', 'encode_mark', 'MARKER_TOPIC', 'MARKS'),
    'schemas': ('layout_problem', 'Schema', 'schema_of'),
    'stamps': ('encode_clock',),
    'status_messages': ('encode_figures', 'encode_statuses', 'ERROR', 'OK', 'Status',
                        'STATUS_TYPE', 'WARN'),
    'texts': ('decode_text', 'encode_text', 'TEXT_TYPE'),
    'verdict_messages': ('encode_verdict', 'OUTCOME_LEVELS', 'verdict_level'),
})
