# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The work of running nodes: take messages, publish, watch, report."""

from typing import TYPE_CHECKING

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'health': ('Health',),
    'intake': ('Intake',),
    'note_publisher': ('publish_note',),
    'publishing': ('Allowance', 'Audience', 'await_acknowledgement'),
    'raw_subscription': ('subscribe',),
    'recorded_topics': ('make_intakes', 'report_files', 'text_of'),
    'source_thread': ('Reading',),
})

if TYPE_CHECKING:
    # The same names for type checkers, by ``make docs``.
    from .health import Health as Health
    from .intake import Intake as Intake
    from .note_publisher import publish_note as publish_note
    from .publishing import (
        Allowance as Allowance,
        Audience as Audience,
        await_acknowledgement as await_acknowledgement,
    )
    from .raw_subscription import subscribe as subscribe
    from .recorded_topics import (
        make_intakes as make_intakes,
        report_files as report_files,
        text_of as text_of,
    )
    from .source_thread import Reading as Reading
