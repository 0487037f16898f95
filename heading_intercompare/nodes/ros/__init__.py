# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""ROS for the nodes: messages, parameters, quality of service, processes."""

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'batches': ('take_all', 'Unwatched'),
    'message_stamps': ('clock_message',),
    'messages': ('heading_messages', 'HEADING_TYPES', 'headings_from', 'pair_messages',
                 'pairs_from', 'PAIRS_TYPES'),
    'parameters': ('declare', 'make_overrides', 'OVERRIDES', 'resolve_topic'),
    'process': ('end', 'run', 'spin_nodes', 'Stop'),
    'qos': ('NOTE', 'STATUS'),
    'remapping': ('published_names',),
    'status_messages': ('ERROR', 'figures_message', 'ledger_from', 'ledger_message',
                        'marker_message', 'MARKS', 'marks_from', 'OK', 'OUTCOME_LEVELS',
                        'report_message', 'run_table', 'status', 'status_array', 'verdict_level',
                        'verdict_message', 'WARN'),
    'steady_timer': ('every',),
})
