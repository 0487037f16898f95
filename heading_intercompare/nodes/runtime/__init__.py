# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""What nodes do while they run: take, publish, watch, report."""

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'health': ('Health',),
    'intake': ('Intake',),
    'note_publisher': ('publish_note',),
    'publishing': ('all_acknowledged', 'Allowance', 'Audience'),
    'raw_subscription': ('subscribe',),
    'recorded_topics': ('make_intakes', 'report_files', 'text_of'),
    'reporting': ('Reporting',),
    'source_thread': ('Reading',),
})
