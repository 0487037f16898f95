# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""ROS for the nodes: message types, parameters, quality of service, processes."""

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'batches': ('take_all', 'Unwatched'),
    'message_types': ('HEADING_TYPES', 'PAIRS_TYPES', 'STATUS_TYPES', 'TEXT_TYPES',
                      'TRUTH_TYPES'),
    'parameters': ('declare', 'make_overrides', 'OVERRIDES', 'resolve_topic'),
    'process': ('end', 'run', 'spin_nodes', 'Stop'),
    'qos': ('NOTE', 'STATUS'),
    'remapping': ('published_names',),
    'steady_timer': ('every',),
})
