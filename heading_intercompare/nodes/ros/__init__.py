# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""ROS for the nodes: messages, parameters, quality of service, processes."""

from typing import TYPE_CHECKING

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
                        'marker_message', 'MARKS', 'marks_from', 'OK', 'status', 'status_array',
                        'WARN'),
    'steady_timer': ('every',),
    'verdict_messages': ('OUTCOME_LEVELS', 'report_message', 'verdict_level', 'verdict_message'),
})

if TYPE_CHECKING:
    # The same names for type checkers, by ``make docs``.
    from .batches import take_all as take_all, Unwatched as Unwatched
    from .message_stamps import clock_message as clock_message
    from .messages import (
        heading_messages as heading_messages,
        HEADING_TYPES as HEADING_TYPES,
        headings_from as headings_from,
        pair_messages as pair_messages,
        pairs_from as pairs_from,
        PAIRS_TYPES as PAIRS_TYPES,
    )
    from .parameters import (
        declare as declare,
        make_overrides as make_overrides,
        OVERRIDES as OVERRIDES,
        resolve_topic as resolve_topic,
    )
    from .process import end as end, run as run, spin_nodes as spin_nodes, Stop as Stop
    from .qos import NOTE as NOTE, STATUS as STATUS
    from .remapping import published_names as published_names
    from .status_messages import (
        ERROR as ERROR,
        figures_message as figures_message,
        ledger_from as ledger_from,
        ledger_message as ledger_message,
        marker_message as marker_message,
        MARKS as MARKS,
        marks_from as marks_from,
        OK as OK,
        status as status,
        status_array as status_array,
        WARN as WARN,
    )
    from .steady_timer import every as every
    from .verdict_messages import (
        OUTCOME_LEVELS as OUTCOME_LEVELS,
        report_message as report_message,
        verdict_level as verdict_level,
        verdict_message as verdict_message,
    )
