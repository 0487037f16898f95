# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""What nodes do while they run: take, publish, watch, report."""

from typing import TYPE_CHECKING

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

if TYPE_CHECKING:
    # The same names for type checkers, by ``make docs``.
    from .health import Health as Health
    from .intake import Intake as Intake
    from .note_publisher import publish_note as publish_note
    from .publishing import (
        all_acknowledged as all_acknowledged,
        Allowance as Allowance,
        Audience as Audience,
    )
    from .raw_subscription import subscribe as subscribe
    from .recorded_topics import (
        make_intakes as make_intakes,
        report_files as report_files,
        text_of as text_of,
    )
    from .reporting import Reporting as Reporting
    from .source_thread import Reading as Reading
